"""Times of several sides, taken in turn, so that whatever else the machine does meets all of them alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Progress = Callable[[str], None]
Clock = Literal["wall", "cpu"]

ONE_CORE = 1.1
"""CPU time over wall-clock time that is still one core, clocks being what they are."""


class NotOneCoreError(RuntimeError):
    """A side has used more than one core."""


class Stopwatch:
    """Seconds per side, run after run, and that each side has kept to one core."""

    def __init__(self) -> None:
        self._runs: dict[str, list[tuple[float, float]]] = {}

    def __call__(self, name: str, work: Callable[[], Any]) -> Any:
        """Do some work of a side; what it returns."""
        wall, cpu = time.perf_counter(), time.process_time()
        result = work()
        taken = time.perf_counter() - wall, time.process_time() - cpu
        self._runs.setdefault(name, []).append(taken)
        return result

    def seconds(self, name: str, clock: Clock = "wall") -> Array:
        """Of each run of a side, ``(runs,)``, on the wall or of the CPU."""
        return np.array(self._runs[name])[:, get_args(Clock).index(clock)]

    def check(self) -> None:
        """Refuse times of a side that was not on one core.

        Raises:
            NotOneCoreError: naming the side.
        """
        for name in self._runs:
            cores = self.seconds(name, "cpu").sum() / self.seconds(name).sum()
            if cores > ONE_CORE:
                raise NotOneCoreError(
                    f"{name} kept {cores:.2f} cores busy; expected one: set its threads to 1"
                )


def interleaved(
    sides: Mapping[str, Callable[[int], Any]],
    repetitions: int,
    progress: Progress = lambda message: None,
    clock: Clock = "wall",
) -> dict[str, Array]:
    """Time the sides in turn.

    Each has one run that is not counted, with caches and lazy imports still cold. From one repetition to the
    next the order is turned around, so that none always comes after the same other one.

    Args:
        sides: what to run, by name; called with the number of the repetition, as a seed.
        repetitions: how many runs of each count.
        progress: told what goes on.
        clock: whose seconds.

    Returns:
        Seconds of each run, ``(repetitions,)``.

    Raises:
        NotOneCoreError: a side has used more than one core.
    """
    for work in sides.values():
        work(repetitions)
    stopwatch = Stopwatch()
    for repetition in range(repetitions):
        progress(f"repetition {repetition + 1} of {repetitions}")
        for name in in_turn(list(sides), repetition):
            stopwatch(name, partial(sides[name], repetition))
    stopwatch.check()
    return {name: stopwatch.seconds(name, clock) for name in sides}


def in_turn(names: list[str], repetition: int) -> list[str]:
    """Their order: backwards in every other repetition."""
    return names[::-1] if repetition % 2 else names
