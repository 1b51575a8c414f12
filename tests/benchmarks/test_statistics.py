"""Planted times and estimates: known ratios are found again, and intervals cover as often as they say."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from benchmarks.equal_error import regions
from benchmarks.statistics import Ratio, Trials, cost_ratio, median_ratio, variances


def noisy_pairs(rng: np.random.Generator, pairs: int, ratio: float) -> tuple[np.ndarray, np.ndarray]:
    """Times whose ratios have the median ``ratio``; the machine is slowed down for both alike, by far more."""
    machine = rng.lognormal(0, 2, pairs)
    return ratio * machine * rng.lognormal(0, 0.3, pairs), machine * rng.lognormal(0, 0.3, pairs)


def test_without_noise_the_ratio_is_exact() -> None:
    machine = np.array([1.0, 2.0, 8.0, 64.0, 4.0])
    assert median_ratio(3 * machine, machine) == Ratio(3.0, 3.0, 3.0)


def test_a_planted_ratio_is_recovered() -> None:
    found = median_ratio(*noisy_pairs(np.random.default_rng(0), 2001, 2.5))
    # the standard error of the median of n log-normal ratios is √(π / 2n) σ, σ = 0.3 √2
    assert found.value == pytest.approx(2.5, rel=4 * np.sqrt(np.pi / 2 / 2001) * 0.3 * np.sqrt(2))
    assert found.low < found.value < found.high < 1.1 * found.low


@pytest.mark.parametrize(("pairs", "covered"), [(5, 0.9375), (6, 0.96875), (9, 1 - 2 * 10 / 2**9)])
def test_the_interval_of_a_median_covers_as_often_as_it_says(pairs: int, covered: float) -> None:
    """For nine pairs it is from the second to the last but one: 1 − 2 (C(9, 0) + C(9, 1)) / 2⁹."""
    rng, runs = np.random.default_rng(1), 4000
    found = [median_ratio(*noisy_pairs(rng, pairs, 0.7)) for _ in range(runs)]
    hits = sum(ratio.low <= 0.7 <= ratio.high for ratio in found)
    assert stats.binomtest(hits, runs, covered).pvalue > 1e-4
    # so many runs tell an interval that is one order statistic off
    assert stats.binomtest(round((covered - 0.04) * runs), runs, covered).pvalue < 1e-4


def planted(rng: np.random.Generator, sigma: list[float], seconds: float, n: int = 64) -> Trials:
    """Trials of estimates with mean m and standard deviation σ m per bounce, m another in each bounce and channel."""
    means = np.array([[5.0, 0.5], [2.0, 0.01], [1.0, 3.0]])[:, None]
    noise = rng.normal(size=(n, 3, 4, 2)) * np.array(sigma)[:, None, None]
    return Trials(seconds * rng.lognormal(0, 0.01, n), means * (1 + noise))


def test_variances_are_those_of_numpy() -> None:
    x = planted(np.random.default_rng(2), [0.1, 0.2, 0.3], 1.0, n=10).estimates
    expected = (x.var(axis=0, ddof=1) / x.mean(axis=(0, 1 + 1)) [:, None] ** 2).mean(axis=(1, 2))  # fmt: skip
    assert variances(x, np.ones((1, 10)))[0] == pytest.approx(expected, rel=1e-12)


def test_the_variance_of_a_resample_is_that_of_its_trials() -> None:
    x = planted(np.random.default_rng(3), [0.1, 0.1, 0.1], 1.0, n=10).estimates
    counts = np.array([[2, 0, 1, 1, 3, 0, 1, 1, 1, 0]])
    scale = x.mean(axis=(0, 2))[:, None]
    expected = (np.repeat(x, counts[0], axis=0).var(axis=0, ddof=1) / scale**2).mean(axis=(1, 2))
    assert variances(x, counts.astype(float))[0] == pytest.approx(expected, rel=1e-12)


def test_the_geometric_mean_of_costs() -> None:
    """Times 6 : 2, variances 4 : 1, 1 : 1 and 16 : 1: costs 12, 3 and 48, whose geometric mean is 12."""
    rng = np.random.default_rng(4)
    theirs, ours = planted(rng, [0.2, 0.1, 0.4], 6.0, n=1000), planted(rng, [0.1, 0.1, 0.1], 2.0, n=1000)
    found = cost_ratio({"only": theirs}, ours)
    assert found.bounces == pytest.approx([12, 3, 48], rel=0.1)
    assert found.ratio.value == pytest.approx(np.prod(found.bounces) ** (1 / 3), rel=1e-12)
    assert found.ratio.value == pytest.approx(12, rel=0.05)
    assert found.ratio.low < 12 < found.ratio.high


def test_the_interval_of_a_cost_ratio_covers() -> None:
    """A percentile bootstrap of 64 trials is a little narrow: 95 % in name, some 93 % in fact; half would show."""
    rng, runs = np.random.default_rng(5), 120
    found = [
        cost_ratio(
            {"only": planted(rng, [0.2, 0.1, 0.1], 3.0)}, planted(rng, [0.1, 0.1, 0.1], 1.0), seed
        ).ratio
        for seed in range(runs)
    ]
    truth = 3 * 4 ** (1 / 3)
    assert sum(ratio.low <= truth <= ratio.high for ratio in found) >= 0.86 * runs
    assert all(ratio.high < 1.6 * ratio.low for ratio in found)


def test_their_best_way_counts() -> None:
    rng = np.random.default_rng(6)
    good, bad = planted(rng, [0.2, 0.2, 0.2], 1.0), planted(rng, [0.2, 0.2, 0.2], 2.0)
    found = cost_ratio({"bad": bad, "good": good}, planted(rng, [0.1, 0.1, 0.1], 1.0))
    assert found.way == "good"
    assert found.ratio.low < 4 < found.ratio.high


def test_too_few_trials_are_refused() -> None:
    few = planted(np.random.default_rng(7), [0.1, 0.1, 0.1], 1.0, n=7)
    with pytest.raises(ValueError, match="7 trials: expected at least 8"):
        cost_ratio({"only": few}, few)


def test_regions_are_means_over_tiles() -> None:
    images = np.random.default_rng(8).random((2, 3, 8, 8, 1))
    tiles = regions(images, 2)
    assert tiles.shape == (2, 2, 4, 1)
    assert tiles[1, 0, 1, 0] == pytest.approx(images[1, 1, :4, 4:, 0].mean())
    assert regions(images, 1)[..., 0, :] == pytest.approx(images[:, 1:].mean(axis=(2, 3)))
