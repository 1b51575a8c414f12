"""What the run and a worker process say to each other.

One line of JSON per message, both ways, over the worker's standard input and output. A ``Rendered`` is followed
by the image itself, or by what the rays have hit: float64, little-endian, C order.
"""

from __future__ import annotations

from typing import IO

import msgspec
import numpy as np

from comparisons.renderers.protocol import Images
from scenes import Scene


class Render(msgspec.Struct, tag="render"):
    """A request: one image."""

    scene: Scene
    bounces: list[int]
    spp: int
    seed: int


class FirstHits(msgspec.Struct, tag="first_hits"):
    """A request: what the rays through the centres of pixels meet first."""

    scene: Scene


class Ready(msgspec.Struct, tag="ready"):
    """The renderer is loaded."""

    version: str


class Rendered(msgspec.Struct, tag="rendered"):
    """The image follows, or the hits."""

    shape: tuple[int, ...]


class Refused(msgspec.Struct, tag="refused"):
    """The scene needs a feature that the renderer does not have."""

    feature: str


class Failed(msgspec.Struct, tag="failed"):
    """The renderer raised."""

    message: str


Request = Render | FirstHits
Reply = Ready | Rendered | Refused | Failed

_encoder = msgspec.json.Encoder()
_replies: msgspec.json.Decoder[Reply] = msgspec.json.Decoder(Reply)
_requests: msgspec.json.Decoder[Request] = msgspec.json.Decoder(Request)


def send(stream: IO[bytes], message: Request | Reply, image: Images | None = None) -> None:
    """Write a message, and the image that belongs to it."""
    stream.write(_encoder.encode(message) + b"\n")
    if image is not None:
        stream.write(np.ascontiguousarray(image, dtype="<f8").tobytes())
    stream.flush()


def receive_request(stream: IO[bytes]) -> Request | None:
    """The next request, or None at the end of the stream."""
    line = stream.readline()
    return _requests.decode(line) if line else None


def receive_reply(stream: IO[bytes]) -> tuple[Reply, Images | None]:
    """The next reply, with its image.

    Raises:
        EOFError: the worker has gone, or went in the middle of a message.
        msgspec.DecodeError: what came is no reply.
    """
    line = stream.readline()
    if not line.endswith(b"\n"):
        raise EOFError
    reply = _replies.decode(line)
    if not isinstance(reply, Rendered):
        return reply, None
    size = 8 * int(np.prod(reply.shape))
    content = stream.read(size)
    if len(content) < size:
        raise EOFError
    return reply, np.frombuffer(content, dtype="<f8").reshape(reply.shape)
