"""A renderer in a process of its own, seen from the run: started, asked, timed, stopped, and its log kept.

Its process leads a session of its own, so that Ctrl-C reaches the run alone, which then ends it with everything that
it has started. All temporary files go to one folder, which goes with the process. See ``limits.py``.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import IO, Self

import msgspec
import numpy as np

from comparisons.renderers import limits
from comparisons.renderers.config import ConfigError
from comparisons.renderers.entry import Entry
from comparisons.renderers.finite import check_finite
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
from comparisons.renderers.protocol import (
    Hits,
    Images,
    RendererError,
    RendererFailed,
    RendererTimeout,
    Unsupported,
)
from comparisons.renderers.registry import resolve
from scenes import Scene

LOG_LINES = 20
_LOG_KEPT = 100_000
"""Bytes at the end of a log that are ever read."""

_LEAVE = 5.0
"""Seconds that a process may still live without its standard output."""

# -P: a folder named `scenes` in the user's working directory must not be taken for ours
WORKER = (sys.executable, "-P", "-m", "comparisons.renderers.worker")
"""The command that runs a worker; the renderer's name follows, and what is known of it."""

# every worker is one processor's work; libraries that would take more are told
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


class RendererProcess:
    """One renderer in its own process. Not for use by two threads at once.

    Attributes:
        name: the renderer's full name.
        version: of the renderer, as it says itself.
        closed: whether it has been ended and forgotten.
    """

    def __init__(self, name: str, started: Callable[[RendererProcess], None] = lambda process: None) -> None:
        """Start it and wait until it is ready.

        Args:
            name: of the renderer.
            started: called before it is ready, by whom may want to end it before.

        Raises:
            RendererFailed: it can't be started, or says why it can't be loaded.
            RendererTimeout: it was not ready in time.
        """
        try:
            entry = resolve(name)
        except ConfigError as error:
            raise RendererFailed(str(error)) from None
        self.name, self._memory, self.closed = name, entry.memory or limits.default_memory(), False
        self._folder = tempfile.mkdtemp(prefix="lightproof-")
        # appending: the worker writes at the end, also of what has been cut; without a name nobody can take it away
        self._log: IO[bytes] = Path(self._folder, "log").open("a+b", buffering=0)
        Path(self._folder, "log").unlink()
        try:
            self._process = self._start(name, entry)
        except OSError as error:
            self._forget()
            hint = f"; {entry.install}" if entry.install and isinstance(error, FileNotFoundError) else ""
            failed = RendererFailed(f"its process can't be started: {error}{hint}")
            failed.at_start = True
            raise failed from None
        try:
            started(self)
            reply, _ = self._reply(entry.start_timeout)
            if not isinstance(reply, Ready):
                said = f"said {reply} where it should have been ready"
                raise RendererFailed(reply.message if isinstance(reply, Failed) else said, self.log())
        except RendererError as error:
            error.at_start = True
            self.close()
            raise
        except BaseException:
            self.close()
            raise
        self.version = reply.version

    def _start(self, name: str, entry: Entry) -> subprocess.Popen[bytes]:
        environment = {**os.environ, **_ONE_THREAD, "TMPDIR": self._folder, limits.MARK: self._folder}
        if entry.worker:  # its environment is not ours
            command, folder = list(entry.worker), entry.folder or None
            for ours in ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV"):
                environment.pop(ours, None)
        else:
            command, folder = [*WORKER, name, msgspec.json.encode(entry).decode()], None
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            env=environment,
            cwd=folder,
            start_new_session=True,
        )
        # where memory runs out all the same, the kernel takes a renderer, not the run
        with suppress(OSError):
            Path(f"/proc/{process.pid}/oom_score_adj").write_text("1000")
        return process

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
        reply, image = self._reply(timeout, request, scene)
        if isinstance(reply, Refused):
            raise Unsupported(reply.feature)
        if isinstance(reply, Failed):
            raise RendererFailed(reply.message, self.log())
        if image is None:
            raise RendererFailed(f"said {reply} where an image was expected", self.log())
        return image

    def _reply(
        self, timeout: float, request: Request | None = None, scene: Scene | None = None
    ) -> tuple[Reply, Images | None]:
        """What it says to a request, or without one."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        with limits.Watch(self._process.pid, timeout, self._memory, self.kill, self._trim_log) as watch:
            try:
                if request is not None and scene is not None:  # who does not read may keep us waiting as well
                    send_request(self._process.stdin, request, scene)
                return receive_reply(self._process.stdout)
            except msgspec.DecodeError as error:
                how: RendererError = RendererFailed(f"its process said something that is no reply: {error}")
            except (EOFError, BrokenPipeError):
                how = self._gone()
        if watch.verdict == "time":
            how = RendererTimeout(f"no answer within {timeout:.0f} s; it was stopped")
        elif watch.verdict == "memory":
            allowed = limits.size(self._memory)
            how = RendererFailed(f"took more than {allowed} of memory, its limit; it was stopped")
        how.log = self.log()
        raise how

    def _gone(self) -> RendererError:
        try:
            status = self._process.wait(_LEAVE)
        except subprocess.TimeoutExpired:
            return RendererFailed("its process closed its standard output, and said no more")
        how = f"was killed by signal {-status}" if status < 0 else f"ended with status {status}"
        return RendererFailed(f"its process {how}")

    def log(self) -> list[str]:
        """The last lines that the process printed."""
        return self._end_of_log().decode(errors="replace").splitlines()[-LOG_LINES:]

    def _end_of_log(self) -> bytes:
        """Read without moving the place at which the process writes, since the file is open once for both."""
        file = self._log.fileno()
        return os.pread(file, _LOG_KEPT, max(0, os.fstat(file).st_size - _LOG_KEPT))

    def _trim_log(self) -> None:
        """Let go of all but its end: what prints without end must not fill the disk."""
        file = self._log.fileno()
        if os.fstat(file).st_size > 100 * _LOG_KEPT:
            end = self._end_of_log()
            os.ftruncate(file, 0)
            os.write(file, end)

    def kill(self) -> None:
        """End the process at once, and all it has started; whoever waits for its answer is told that it has gone."""
        if not self.closed:
            limits.end_all(self._process.pid, self._folder)

    def close(self) -> None:
        """End the process, and forget its log and its temporary files."""
        self.kill()
        self.closed = True
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                with suppress(BrokenPipeError):  # a request that the process did not live to read
                    stream.close()
        self._forget()

    def _forget(self) -> None:
        self._log.close()
        shutil.rmtree(self._folder, ignore_errors=True)

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
    check_finite(image, "returned", [f"bounce {k}" for k in bounces])


def check_total(image: Images, scene: Scene) -> None:
    """Refuse what is no image of the whole sum.

    Raises:
        RendererFailed: its shape is another, or a value is not finite.
    """
    if image.shape != scene.shape:
        raise RendererFailed(
            f"returned a total of shape {image.shape}, expected {scene.shape}: (height, width, channels)"
        )
    check_finite(image[None], "returned", ["the total"])
