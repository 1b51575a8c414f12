from __future__ import annotations

import numpy as np
from scipy import stats

from comparisons.statistics.intervals import (
    Biases,
    Means,
    Range,
    alpha_of_look,
    alpha_of_regions,
    biases,
    denominators,
)
from comparisons.statistics.moments import Moments


def test_looks_spend_no_more_than_alpha() -> None:
    spent = sum(alpha_of_look(0.01, look) for look in range(1, 10_000))
    assert spent <= 0.01
    assert alpha_of_look(0.01, 1) == 0.005


def test_regions_share_alpha_half_and_half() -> None:
    image, *tiles = alpha_of_regions(0.01, regions=17, others=18).ravel()
    assert image * 18 == 0.005
    np.testing.assert_allclose(tiles, 0.005 / 16 / 18)
    assert (
        alpha_of_regions(0.01, regions=1, others=5).sum() * 5 == 0.01
    )  # without tiles it is all the image's


def test_denominators() -> None:
    # whole image and two tiles; bounces: ordinary, dark tile, all dark
    truth = np.array([[1.0, 0.5, 0.0], [1.5, 1.0, 0.0], [0.5, 0.001, 0.0]])[..., None]
    expected = np.array([[1.0, 0.5, 1.5], [1.5, 1.0, 1.5], [0.5, 0.025, 1.5]])[..., None]
    np.testing.assert_allclose(denominators(truth), expected)
    assert (denominators(np.zeros((2, 3, 1))) == 1).all()


def found_in(replicates: np.ndarray, truth: float = 1.0, error: float = 0.0, alpha: float = 0.05) -> Biases:
    """Biases of replicates ``(count, regions, channels)`` against one truth everywhere."""
    full = np.full(replicates.shape[1:], truth)
    measured = Means.of(Moments.of_all(replicates))
    return biases(measured, Means.known(full, full * error), full, alpha, others=full[0].size)


def test_the_interval_is_the_textbook_one_where_the_truth_is_exact() -> None:
    replicates = np.random.default_rng(1).normal(2.0, 0.3, (20, 1, 1))
    replicates = np.concatenate([replicates, 4.0 - replicates])  # without any skewness
    found = found_in(replicates, truth=2.0)
    low, high = stats.t.interval(0.95, 39, loc=replicates.mean(), scale=replicates.std(ddof=1) / np.sqrt(40))
    np.testing.assert_allclose(found.own.low, low / 2 - 1)
    np.testing.assert_allclose(found.own.high, high / 2 - 1)


def test_two_noisy_sides_are_compared_as_welch_does() -> None:
    rng = np.random.default_rng(2)
    a, b = rng.normal(1.0, 0.3, (20, 1, 1)), rng.normal(1.0, 0.1, (10, 1, 1))
    a, b = np.concatenate([a, 2 - a]), np.concatenate([b, 2 - b])
    sides = [Means.of(Moments.of_all(x)) for x in (a, b)]
    found = biases(*sides, np.full((1, 1), 2.0), alpha=0.05, others=1)  # a fixed denominator: no ratio
    expected = stats.ttest_ind(a.ravel(), b.ravel(), equal_var=False)
    low, high = expected.confidence_interval(0.95)
    np.testing.assert_allclose([found.own.low[0, 0], found.own.high[0, 0]], [low / 2, high / 2], rtol=1e-9)
    np.testing.assert_allclose(found.p_value[0, 0], expected.pvalue, rtol=1e-9)


def test_the_truth_s_noise_counts() -> None:
    replicates = np.random.default_rng(1).normal(1.0, 0.3, (40, 1, 1))
    exact, noisy = (found_in(replicates, error=e) for e in (0.0, 0.1))
    s, g = replicates.std(ddof=1) / np.sqrt(40), replicates.mean()
    np.testing.assert_allclose(noisy.error, np.hypot(s, 0.1 * g))
    assert (width(noisy.own) > width(exact.own)).all()


def test_replicates_without_spread_have_intervals_without_width() -> None:
    found = found_in(np.full((32, 2, 3), 1.5))
    np.testing.assert_allclose(found.bias, 0.5)
    assert (width(found.own) == 0).all()
    assert (found.resolution == 0).all()
    assert (found.p_value == 1).all()


def test_a_tile_that_was_not_hit_has_a_share_of_the_noise_of_all() -> None:
    rng = np.random.default_rng(3)
    rare = 20.0 * (rng.random((32, 17, 1)) < 0.05)
    rare[:, 2] = 0.0  # one in five tiles is like that: nothing is wrong
    assert not found_in(rare, alpha=1e-3).simultaneous.outside(np.zeros((17, 1)))[2, 0]
    often = rng.exponential(1.0, (32, 17, 1))
    often[:, 2] = 0.0  # light is missing
    assert found_in(often, alpha=1e-3).simultaneous.outside(np.zeros((17, 1)))[2, 0]


def test_the_whole_image_keeps_its_own_noise() -> None:
    """That of the mean of sixteen tiles is a quarter of theirs, and no share of theirs makes it more."""
    tiles = np.random.default_rng(3).normal(1.0, 0.1, (200, 16, 1))
    found = found_in(np.concatenate([tiles.mean(axis=1, keepdims=True), tiles], axis=1))
    np.testing.assert_allclose(found.error[0], tiles.mean(axis=1).std(axis=0, ddof=1) / np.sqrt(200))


def test_a_tile_without_noise_that_is_right_needs_none() -> None:
    replicates = np.random.default_rng(3).exponential(1.0, (32, 5, 1))
    replicates[:, 2] = 1.0
    assert width(found_in(replicates).own)[2, 0] == 0


def width(limits: Range) -> np.ndarray:
    return limits.high - limits.low


# 3,000 simulated comparisons of 32 replicates; the share of misses must be binomial about its nominal value,
# within limits that a right interval leaves once in a million
_RUNS, _REPLICATES = 3_000, 32


def _misses(sigma_factor: float = 1.0, regions: int = 1) -> tuple[int, int]:
    """How many runs have an own interval of region 0, and any simultaneous one, that misses; alpha = 5 %."""
    rng = np.random.default_rng(20)
    own = simultaneous = 0
    for _ in range(_RUNS):
        found = found_in(rng.normal(1.0, 0.2, (_REPLICATES, regions, 1)))
        bias, reach = found.bias[0, 0], width(found.own)[0, 0] / 2
        own += bool(abs(bias) > reach * sigma_factor)
        simultaneous += bool(found.simultaneous.outside(np.zeros((1, 1))).any())
    return own, simultaneous


def test_own_intervals_cover_as_they_say() -> None:
    low, high = stats.binom.interval(1 - 1e-6, _RUNS, 0.05)
    assert low <= _misses()[0] <= high


def test_too_narrow_intervals_would_be_noticed() -> None:
    _, high = stats.binom.interval(1 - 1e-6, _RUNS, 0.05)
    assert _misses(sigma_factor=0.8)[0] > high


def test_simultaneous_intervals_miss_in_no_region_more_often_than_alpha() -> None:
    _, high = stats.binom.interval(1 - 1e-6, _RUNS, 0.05)
    assert _misses(regions=17)[1] <= high


def test_exactly_the_tolerance_is_not_outside_by_rounding() -> None:
    exact = Range(np.array([[-0.005 - 1e-16]]), np.array([[-0.005 - 1e-16]]))
    tolerance = np.array([[0.005]])
    assert not exact.outside(tolerance)
    assert exact.inside(tolerance)
    beyond = Range(np.array([[-0.0051]]), np.array([[-0.0051]]))
    assert beyond.outside(tolerance)
