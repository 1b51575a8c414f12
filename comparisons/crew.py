"""A crew of renderer processes: requests go in as to any executor, futures come out.

Each request runs in a process that has the renderer loaded; processes are kept between requests, and one that
failed is replaced by the next request that needs it.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from types import TracebackType
from typing import Self

from comparisons.renderers import Hits, Images, RendererFailed, Unsupported
from comparisons.renderers.process import RendererProcess
from scenes import Scene


class Crew:
    """At most ``jobs`` renderer processes at work. A context manager: leaving it ends them all."""

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs
        self._pool = ThreadPoolExecutor(jobs)  # one thread waits for each process
        self._lock = threading.Lock()
        self._idle: list[RendererProcess] = []
        self._busy: set[RendererProcess] = set()
        self._closed = False

    def render(
        self, name: str, scene: Scene, bounces: Sequence[int], spp: int, seed: int, timeout: float
    ) -> Future[Images]:
        """Ask for one image; the future raises what ``RendererProcess.render`` raises."""
        asked = tuple(bounces)
        return self._pool.submit(
            self._ask, name, lambda process: process.render(scene, asked, spp, seed, timeout)
        )

    def total(self, name: str, scene: Scene, spp: int, seed: int, timeout: float) -> Future[Images]:
        """Ask for one sum of all bounces, ``(1, height, width, channels)``.

        The future raises what ``RendererProcess.total`` raises.
        """
        return self._pool.submit(
            self._ask, name, lambda process: process.total(scene, spp, seed, timeout)[None]
        )

    def first_hits(self, name: str, scene: Scene, timeout: float) -> Future[Hits]:
        """Ask what its rays meet first; the future raises what ``RendererProcess.first_hits`` raises."""
        return self._pool.submit(self._ask, name, lambda process: process.first_hits(scene, timeout))

    def version(self, name: str) -> str:
        """Of the renderer, which is loaded for that.

        Raises:
            RendererFailed: it can't be loaded.
        """
        process = self._take(name)
        self._give_back(process)
        return process.version

    def dismiss(self, name: str) -> None:
        """End the processes of a renderer that is not needed any more, whatever they are doing."""
        with self._lock:
            for process in self._busy:
                if process.name == name:
                    process.kill()
            ours = [process for process in self._idle if process.name == name]
            self._idle = [process for process in self._idle if process.name != name]
        for process in ours:
            process.close()

    def _ask(self, name: str, question: Callable[[RendererProcess], Images]) -> Images:
        process = self._take(name)
        try:
            image = question(process)
        except Unsupported:
            self._give_back(process)
            raise
        except BaseException:
            with self._lock:
                self._busy.discard(process)
            process.close()
            raise
        self._give_back(process)
        return image

    def _take(self, name: str) -> RendererProcess:
        with self._lock:
            process = next((idle for idle in self._idle if idle.name == name), None)
            if process is not None:
                self._idle.remove(process)
                self._busy.add(process)
                return process
        try:  # known to the crew before it is ready, so that it can be ended on its way
            return RendererProcess(name, started=self._begun)
        except BaseException:
            with self._lock:
                self._busy = {process for process in self._busy if not process.closed}
            raise

    def _begun(self, process: RendererProcess) -> None:
        with self._lock:
            if not self._closed:
                self._busy.add(process)
                return
        raise RendererFailed("the run was ended before it could begin")

    def _give_back(self, process: RendererProcess) -> None:
        with self._lock:
            self._busy.discard(process)
            self._idle.append(process)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._lock:
            self._closed = True
            for process in self._busy:
                process.kill()
        self._pool.shutdown(wait=True, cancel_futures=True)
        for process in [*self._idle, *self._busy]:
            process.close()
