"""Throughput of worker processes: as many renders each, whether one works or several."""

from __future__ import annotations

import multiprocessing
import os
import time
from concurrent.futures import ProcessPoolExecutor
from types import TracebackType
from typing import Self

from benchmarks.sides import ours

RENDERS = 4
"""By each worker, one after the other: the slower of two workers counts, and longer work evens out chance."""

_PATIENCE = 120.0
"""Seconds to wait for all workers to take part: they start one after the other."""


class UnevenError(RuntimeError):
    """One worker took what was meant for another."""


class Workers:
    """Processes that are up and warm. A context manager: leaving it ends them."""

    def __init__(self, count: int, spp: int) -> None:
        self.count, self._spp = count, spp
        self._pool = ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn"))

    def seconds(self, seed: int) -> float:
        """Wall-clock time until each worker has done its renders.

        Raises:
            UnevenError: time and again, a worker was so late that another one took its renders.
        """
        give_up = time.perf_counter() + _PATIENCE
        while (start := time.perf_counter()) < give_up:
            tasks = [self._pool.submit(_render, self._spp, self.count * seed + i) for i in range(self.count)]
            workers = {task.result() for task in tasks}
            if len(workers) == self.count:
                return time.perf_counter() - start
        raise UnevenError(
            f"for {_PATIENCE:g} s, fewer than {self.count} workers took part at a time; expected all: render longer"
        )

    def __enter__(self) -> Self:
        self.seconds(0)  # starts them, imports, renders
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._pool.shutdown(cancel_futures=True)


def _render(spp: int, seed: int) -> int:
    """Render some times; which process that was."""
    for i in range(RENDERS):
        ours(spp)(RENDERS * seed + i)
    return os.getpid()
