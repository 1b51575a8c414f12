"""A renderer in a process of its own, seen from the run: started, asked, timed, stopped, and its log kept."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Sequence
from contextlib import suppress
from types import TracebackType
from typing import Self

import msgspec
import numpy as np

from comparisons.renderers.messages import (
    Failed,
    FirstHits,
    Ready,
    Refused,
    Render,
    Reply,
    Request,
    Total,
    receive_reply,
    send_request,
)
from comparisons.renderers.protocol import Hits, Images, RendererFailed, RendererTimeout, Unsupported
from scenes import Scene

START_TIMEOUT = 120.0
"""Seconds for a renderer to import its packages."""

LOG_LINES = 20

# -P: a folder named `scenes` in the user's working directory must not be taken for ours
WORKER = (sys.executable, "-P", "-m", "comparisons.renderers.worker")
"""The command that runs a worker; the renderer's name follows."""

# every worker is one processor's work; libraries that would take more are told
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


class RendererProcess:
    """One renderer in its own process. Not for use by two threads at once.

    Attributes:
        name: the renderer's full name.
        version: of the renderer, as it says itself.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        # without a name: nothing is left behind; appending: the worker writes at the end wherever we read
        self._log = tempfile.TemporaryFile("a+b")
        try:
            self._process = subprocess.Popen(
                [*WORKER, name],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._log,
                env={**os.environ, **_ONE_THREAD},
            )
        except OSError as error:
            self._log.close()
            raise RendererFailed(f"its process can't be started: {error}") from None
        try:
            reply, _ = self._reply(START_TIMEOUT)
            if not isinstance(reply, Ready):
                raise RendererFailed(
                    reply.message if isinstance(reply, Failed) else f"said {reply}", self.log()
                )
        except BaseException:
            self.close()
            raise
        self.version = reply.version

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int, timeout: float) -> Images:
        """Render in the process; see ``protocol.Renderer``.

        Raises:
            Unsupported: naming the feature that is missing.
            RendererTimeout: no answer in ``timeout`` seconds.
            RendererFailed: it raised, crashed, or returned an image of the wrong shape or with a value that
                is not finite.
        """
        image = self._ask(Render(list(bounces), spp, seed), scene, timeout)
        check_image(image, bounces, scene)
        return image

    def total(self, scene: Scene, spp: int, seed: int, timeout: float) -> Images:
        """The sum of all bounces, ``(height, width, channels)``; see ``protocol.RendersTotal``.

        Raises:
            Unsupported: it makes none, or a feature of the scene is missing.
            RendererTimeout, RendererFailed: as above.
        """
        image = self._ask(Total(spp, seed), scene, timeout)
        check_total(image, scene)
        return image

    def first_hits(self, scene: Scene, timeout: float) -> Hits:
        """What its rays meet first; see ``protocol.SeesFirstHits``.

        Raises:
            Unsupported: it can't tell, or a feature of the scene is missing.
            RendererTimeout, RendererFailed: as above.
        """
        hits = self._ask(FirstHits(), scene, timeout)
        check_hits(hits, scene)
        return hits

    def _ask(self, request: Request, scene: Scene, timeout: float) -> Images:
        assert self._process.stdin is not None
        try:
            send_request(self._process.stdin, request, scene)
        except BrokenPipeError:
            raise self._gone() from None
        reply, image = self._reply(timeout)
        if isinstance(reply, Refused):
            raise Unsupported(reply.feature)
        if isinstance(reply, Failed):
            raise RendererFailed(reply.message, self.log())
        if image is None:
            raise RendererFailed(f"said {reply} where an image was expected", self.log())
        return image

    def _reply(self, timeout: float) -> tuple[Reply, Images | None]:
        assert self._process.stdout is not None
        expired = threading.Event()

        def stop() -> None:
            expired.set()
            self._process.kill()

        timer = threading.Timer(timeout, stop)
        timer.start()
        try:
            return receive_reply(self._process.stdout)
        except msgspec.DecodeError as error:
            raise RendererFailed(
                f"its process said something that is no reply: {error}", self.log()
            ) from None
        except EOFError:
            if expired.is_set():
                raise RendererTimeout(
                    f"no answer within {timeout:.0f} s; it was stopped", self.log()
                ) from None
            raise self._gone() from None
        finally:
            timer.cancel()

    def _gone(self) -> RendererFailed:
        status = self._process.wait()
        how = f"was killed by signal {-status}" if status < 0 else f"ended with status {status}"
        return RendererFailed(f"its process {how}", self.log())

    def log(self) -> list[str]:
        """The last lines that the process printed."""
        self._log.seek(0, os.SEEK_END)
        self._log.seek(max(0, self._log.tell() - 100_000))
        return self._log.read().decode(errors="replace").splitlines()[-LOG_LINES:]

    def kill(self) -> None:
        """End the process at once; whoever waits for its answer is told that it has gone."""
        self._process.kill()

    def close(self) -> None:
        """End the process and forget its log."""
        self.kill()
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout, self._log):
            if stream is not None:
                with suppress(BrokenPipeError):  # a request that the process did not live to read
                    stream.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def check_hits(hits: Hits, scene: Scene) -> None:
    """Refuse what is no answer to what the rays of the scene's sensor meet.

    Raises:
        RendererFailed: its shape is another, or a value is not a number.
    """
    shape = (5, scene.sensor.height * scene.sensor.width)
    if hits.shape != shape or np.isnan(hits).any():
        raise RendererFailed(f"returned hits of shape {hits.shape}, expected {shape}, all of them numbers")


def check_image(image: Images, bounces: Sequence[int], scene: Scene) -> None:
    """Refuse what is no image of these bounces of the scene.

    Raises:
        RendererFailed: its shape is another, or a value is not finite.
    """
    shape = (len(bounces), *scene.shape)
    if image.shape != shape:
        raise RendererFailed(
            f"returned an image of shape {image.shape}, expected {shape}: (bounces, height, width, channels)"
        )
    _check_finite(image, [f"bounce {k}" for k in bounces])


def check_total(image: Images, scene: Scene) -> None:
    """Refuse what is no image of the whole sum.

    Raises:
        RendererFailed: its shape is another, or a value is not finite.
    """
    if image.shape != scene.shape:
        raise RendererFailed(
            f"returned a total of shape {image.shape}, expected {scene.shape}: (height, width, channels)"
        )
    _check_finite(image[None], ["the total"])


def _check_finite(images: Images, names: Sequence[str]) -> None:
    wrong = ~np.isfinite(images).all(axis=-1)
    if wrong.any():
        i, y, x = np.argwhere(wrong)[0]
        raise RendererFailed(
            f"returned {wrong.sum()} of {wrong.size} pixels that are not finite (NaN or infinite), the first in "
            f"{names[i]}, row {y}, column {x}"
        )
