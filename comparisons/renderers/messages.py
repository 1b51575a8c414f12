"""What the run and a worker process say to each other.

One line of JSON per message, both ways, over the worker's standard input and output. A request is followed by a
line with its scene; a ``Rendered`` by the image itself, or by what the rays have hit: float64, little-endian, C
order.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import IO

import msgspec
import numpy as np

from comparisons.renderers.protocol import Images
from scenes import Scene


class Render(msgspec.Struct, tag="render"):
    """A request: one image."""

    bounces: list[int]
    spp: int
    seed: int


class Total(msgspec.Struct, tag="total"):
    """A request: the sum of all bounces, with the renderer's own defaults."""

    spp: int
    seed: int


class FirstHits(msgspec.Struct, tag="first_hits"):
    """A request: what the rays through the centres of pixels meet first."""


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


Request = Render | Total | FirstHits
Reply = Ready | Rendered | Refused | Failed

_LONGEST = 1 << 20
"""Bytes of a line of a reply."""

_SHOWN = 100
"""Bytes of a line that is no reply, in the message that says so."""

_LARGEST = 1 << 36
"""Bytes of an image."""

_encoder = msgspec.json.Encoder()
_replies: msgspec.json.Decoder[Reply] = msgspec.json.Decoder(Reply)
_requests: msgspec.json.Decoder[Request] = msgspec.json.Decoder(Request)
# a scene comes some thousand times, and to read and check it takes as long as a sample of every pixel
_scene = lru_cache(maxsize=8)(msgspec.json.Decoder(Scene).decode)


def send_request(stream: IO[bytes], request: Request, scene: Scene) -> None:
    """Write a request, and the scene that it is about."""
    stream.write(_encoder.encode(request) + b"\n" + _encoder.encode(scene) + b"\n")
    stream.flush()


def receive_request(stream: IO[bytes]) -> tuple[Request, Scene] | None:
    """The next request with its scene, or None at the end of the stream."""
    line = stream.readline()
    return (_requests.decode(line), _scene(stream.readline())) if line else None


def send_reply(stream: IO[bytes], message: Reply, image: Images | None = None) -> None:
    """Write a reply, and the image that belongs to it."""
    stream.write(_encoder.encode(message) + b"\n")
    if image is not None:
        stream.write(np.ascontiguousarray(image, dtype="<f8").tobytes())
    stream.flush()


def receive_reply(stream: IO[bytes]) -> tuple[Reply, Images | None]:
    """The next reply, with its image.

    Raises:
        EOFError: the worker has gone, or went in the middle of a message.
        msgspec.DecodeError: what came is no reply.
    """
    line = stream.readline(_LONGEST)
    if len(line) == _LONGEST:
        raise msgspec.DecodeError(f"a line of more than {_LONGEST} bytes")
    if not line.endswith(b"\n"):
        raise EOFError
    try:
        reply = _replies.decode(line)
    except msgspec.DecodeError as error:
        shown = line[:_SHOWN].decode(errors="backslashreplace").rstrip()
        raise msgspec.DecodeError(
            f"{shown!r}: {error}; what else is printed belongs on the standard error"
        ) from None
    if not isinstance(reply, Rendered):
        return reply, None
    size = 8 * math.prod(reply.shape)
    if min(reply.shape, default=0) < 0 or size > _LARGEST:
        raise msgspec.DecodeError(f"an image of shape {reply.shape}")
    content = stream.read(size)
    if len(content) < size:
        raise EOFError
    return reply, np.frombuffer(content, dtype="<f8").reshape(reply.shape)
