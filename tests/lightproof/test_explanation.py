"""What an undecided comparison is told to need, held against what then decides it."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from comparisons import campaign, sequential
from comparisons.results import Comparison
from comparisons.settings import Settings
from lightproof.explanation import needed
from scenes import Scene, Tolerance, library

RUNS, TOLERANCE = 10, 0.02
BUDGET = 300.0
"""Ticks of a clock that counts how often it is asked: some 150 replicates."""

CASE = replace(
    library.case("furnace-sphere"),
    scene=library.case("furnace-sphere").scene.resized(2, 2),
    bounces=1,
    tiles=(2, 2),
    tolerance=Tolerance(image=(TOLERANCE,), tile=(2 * TOLERANCE,)),
)


class Noise:
    """The truth × (1 + bias), with normal noise for each pixel."""

    def __init__(self, bias: float, noise: float, run: int) -> None:
        self._bias, self._noise, self._run = bias, noise, run

    def version(self) -> str:
        return "0"

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Any:
        truth = 0.5 ** np.asarray(bounces, dtype=float)[:, None, None, None]
        rng = np.random.default_rng((self._run, seed))
        return truth * rng.normal(1 + self._bias, self._noise, (len(bounces), *scene.shape))


class Silent:
    def started(self, case: str, renderer: str) -> None: ...
    def progressed(self, share: float, message: str) -> None: ...
    def finished(self, comparison: Comparison) -> None: ...


@pytest.fixture
def compare(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """``compare(renderer, **settings)``"""
    monkeypatch.setattr(sequential, "MOST_SPP", 1)

    def run(renderer: Noise, **settings: Any) -> Comparison:
        monkeypatch.setattr(sequential, "time", SimpleNamespace(monotonic=itertools.count().__next__))
        chosen = Settings(**{"budget": BUDGET} | settings)
        [comparison] = campaign.run([CASE], [renderer], chosen, tmp_path, Silent())
        return comparison

    return run


def numbers(sentence: str) -> list[float]:
    return [float(text) for text in re.findall(r"\d+(?:\.\d+)?", sentence)]


def test_what_a_right_renderer_is_said_to_need_lets_it_pass(compare: Any) -> None:
    """Each forecast is tried with samples that it was not made from; the interval's own power is 90 %."""
    passed = {"budget": 0, "tolerance": 0}
    for run in range(RUNS):
        first, again = compare(Noise(0.0, 0.2, run)), Noise(0.0, 0.2, RUNS + run)
        assert first.verdict == "inconclusive"
        budget, image, tile = numbers(needed(first))
        assert BUDGET < budget < 20 * BUDGET
        assert TOLERANCE < image / 100 < 5 * TOLERANCE
        passed["budget"] += compare(again, budget=budget).verdict == "pass"
        loose = compare(again, tolerance=(image / 100,), tile_tolerance=(tile / 100,))
        passed["tolerance"] += loose.verdict == "pass"
    assert min(passed.values()) >= 0.8 * RUNS


def test_a_bias_near_the_tolerance_is_not_said_to_need_time(compare: Any) -> None:
    first, again = (compare(Noise(0.9 * TOLERANCE, 0.02, run)) for run in range(2))
    assert first.verdict == again.verdict == "inconclusive"
    assert "would have passed by now" in needed(first)
    image, tile = numbers(needed(first))
    loose = compare(Noise(0.9 * TOLERANCE, 0.02, 2), tolerance=(image / 100,), tile_tolerance=(tile / 100,))
    assert loose.verdict == "pass"


def test_few_replicates_allow_no_forecast_but_time(compare: Any) -> None:
    first = compare(Noise(0.0, 0.001, 0), budget=30)
    assert (first.verdict, first.replicates < 32) == ("inconclusive", True)
    [budget] = numbers(needed(first))
    assert compare(Noise(0.0, 0.001, 1), budget=budget).verdict == "pass"


def test_nothing_is_needed_where_all_is_decided(compare: Any) -> None:
    assert needed(compare(Noise(0.0, 0.001, 0))) == ""
