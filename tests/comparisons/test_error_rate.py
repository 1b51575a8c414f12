"""Whole comparisons against a renderer that is a random number generator: how often is the verdict wrong?

The bias lies exactly at the limit of the tolerance, where a wrong verdict is likeliest. Looks, bounces that are
decided at different looks, and the Bonferroni family all take part; only the process and the rendering do not.
"""

from __future__ import annotations

import itertools
from concurrent.futures import Future
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import stats

from comparisons import sequential
from comparisons.comparison import Comparing
from comparisons.results import Comparison
from comparisons.settings import Settings
from scenes import Scene, Tolerance, library

RUNS, ALPHA, TOLERANCE = 200, 0.05, 0.02
BUDGET = 700
"""Ticks: about three looks."""

CASE = replace(
    library.case("furnace-sphere"),
    scene=library.case("furnace-sphere").scene.resized(2, 2),
    bounces=2,
    tiles=(2, 2),
    tolerance=Tolerance(image=(TOLERANCE,), tile=(TOLERANCE,)),
)


class Noise:
    """A crew of one: the truth × (1 + bias), and normal noise of 3 % for a sample."""

    jobs = 1

    def __init__(self, bias: float, run: int) -> None:
        self._bias, self._rng = bias, np.random.default_rng(run)

    def version(self, name: str) -> str:
        return "0"

    def dismiss(self, name: str) -> None:
        pass

    def render(
        self, name: str, scene: Scene, bounces: Any, spp: int, seed: int, timeout: float
    ) -> Future[Any]:
        truth = 0.5 ** np.asarray(bounces, dtype=float)[:, None, None, None]
        noise = self._rng.normal(1 + self._bias, 0.03, (len(bounces), *scene.shape))
        future: Future[Any] = Future()
        future.set_result(truth * noise)
        return future


def comparisons(bias: float, observer: Any, monkeypatch: pytest.MonkeyPatch) -> list[Comparison]:
    """Of many runs; a clock that counts how often it is asked stands in for the time."""
    truth = CASE.answer.truth(CASE.scene, CASE.bounces)
    assert truth is not None
    monkeypatch.setattr(sequential, "MOST_SPP", 1)
    found = []
    for run in range(RUNS):
        crew: Any = Noise(bias, run)
        clock = SimpleNamespace(monotonic=itertools.count().__next__)
        monkeypatch.setattr(sequential, "time", clock)
        comparison = Comparing(CASE, "reference", truth, Settings(alpha=ALPHA, budget=BUDGET), crew, observer)
        found.append(comparison.run(folder=None))
    return found


def count(found: list[Comparison], verdict: str) -> int:
    return sum(comparison.verdict == verdict for comparison in found)


def most(rate: float) -> float:
    """More wrong verdicts than this come about once in 10⁶ test runs, if their rate is ``rate``."""
    return float(stats.binom.isf(1e-6, RUNS, rate))


def test_a_bias_at_the_limit_seldom_fails_and_seldom_passes(
    observer: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = comparisons(TOLERANCE, observer, monkeypatch)
    assert np.median([len(comparison.looks) for comparison in found]) >= 3
    assert count(found, "fail") <= most(ALPHA)
    assert count(found, "pass") <= most(ALPHA)


def test_no_bias_passes_and_a_large_one_fails(observer: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    assert count(comparisons(0.0, observer, monkeypatch), "pass") >= RUNS - most(ALPHA)
    assert count(comparisons(3 * TOLERANCE, observer, monkeypatch), "fail") == RUNS
