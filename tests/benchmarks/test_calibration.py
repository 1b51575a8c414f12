"""The calibration is tested on statistics that are wrong on purpose: it must see them."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.calibration import mitsuba, simulated
from benchmarks.calibration.limits import Limit
from benchmarks.calibration.noise import SHAPES
from benchmarks.calibration.rates import Rate
from comparisons.statistics import intervals, skewness
from comparisons.statistics.moments import Moments
from lightproof.parameters import percents

RUNS = 60


@pytest.mark.parametrize("name", list(SHAPES))
def test_noise_has_mean_one(name: str) -> None:
    drawn = SHAPES[name](np.random.default_rng(1), (400_000,))
    assert abs(drawn.mean() - 1) < 5 * drawn.std() / np.sqrt(drawn.size)


def test_intervals_that_know_nothing_of_tails_are_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    noise = SHAPES["Pareto, tail index 3"]
    sound = simulated.verdicts(noise, 0.0, 0.0, 1e-2, RUNS)
    assert Rate("", sound.failed, RUNS, 0.0, 1e-2).kept

    def none(moments: Moments) -> tuple[np.ndarray, np.ndarray]:
        return np.zeros_like(moments.mean), np.zeros_like(moments.mean)

    monkeypatch.setattr(skewness, "both_ways", none)
    monkeypatch.setattr(intervals, "SHARE", 0.0)
    wrong = simulated.verdicts(noise, 0.0, 0.0, 1e-2, RUNS)
    assert not Rate("", wrong.failed, RUNS, 0.0, 1e-2).kept


def test_a_rate_is_held_against_the_binomial_bound() -> None:
    assert Rate("", 28, 2_000, 0.0, 0.01).kept  # 20 are expected, 28 or fewer come with 95 %
    assert not Rate("", 29, 2_000, 0.0, 0.01).kept
    assert not Rate("", 40, 2_000, 0.0, 0.01).kept
    assert Rate("", 90, 100, 0.85, 0.95).kept
    assert not Rate("", 60, 100, 0.85, 0.95).kept
    assert not Rate("", 100, 100, 0.85, 0.95).kept
    assert Rate("", 27, 2_000, 0.0, 0.01).shown == ("1.35% (27 of 2000)", "≤ 1.0%")


def test_a_limit_is_the_most() -> None:
    assert Limit("", 0.0019, 0.002, "%").kept
    assert not Limit("", 91.0, 90.0, "s").kept
    assert Limit("", 0.0019, 0.002, "%").shown == ("0.19 %", "≤ 0.2 %")


def test_the_command_takes_the_tolerances_that_say_where_samples_go() -> None:
    assert percents(mitsuba.TOLERANCES, "--tolerance") == pytest.approx(mitsuba.RESOLUTIONS)
    assert percents(mitsuba.TILE_TOLERANCE, "--tile-tolerance") == (0.99,)
