"""Runs in turn; what keeps more than one core busy is refused. The clocks are planted."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks import timing
from benchmarks.timing import NotOneCoreError, interleaved


class Clock:
    """Wall-clock and CPU time that pass when a side says so."""

    def __init__(self) -> None:
        self.wall = self.cpu = 0.0

    def work(self, wall: float, cpu: float) -> None:
        self.wall += wall
        self.cpu += cpu


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    planted = SimpleNamespace(perf_counter=lambda: clock.wall, process_time=lambda: clock.cpu)
    monkeypatch.setattr(timing, "time", planted)
    return clock


def test_sides_take_turns_and_the_first_run_of_each_does_not_count(clock: Clock) -> None:
    order = []

    def side(name: str, seconds: float) -> None:
        order.append(name)
        clock.work(seconds, seconds)

    first_of_all = 100.0
    times = interleaved(
        {
            "a": lambda repetition: side("a", first_of_all if repetition == 3 else 1.0 + repetition),
            "b": lambda repetition: side("b", 10.0),
        },
        3,
    )
    assert order == [*"ab", *"ab", *"ba", *"ab"]
    np.testing.assert_allclose(times["a"], [1, 2, 3])
    np.testing.assert_allclose(times["b"], [10, 10, 10])


def test_a_side_on_two_cores_is_refused(clock: Clock) -> None:
    sides = {"one": lambda _: clock.work(1.0, 1.0), "two": lambda _: clock.work(1.0, 1.9)}
    with pytest.raises(NotOneCoreError, match=r"two kept 1\.90 cores busy"):
        interleaved(sides, 2)


def test_a_side_that_waits_for_its_core_is_not(clock: Clock) -> None:
    assert len(interleaved({"waits": lambda _: clock.work(1.0, 0.5)}, 2)["waits"]) == 2


def test_the_clock_can_be_that_of_the_cpu(clock: Clock) -> None:
    times = interleaved({"waits": lambda repetition: clock.work(3.0, 1.0 + repetition)}, 2, clock="cpu")
    np.testing.assert_allclose(times["waits"], [1, 2])
