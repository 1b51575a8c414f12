from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from comparisons.statistics.intervals import alpha_of_look, biases, denominators
from comparisons.statistics.moments import Moments


def moments(replicates: np.ndarray) -> Moments:
    mean = replicates.mean(axis=0)
    return Moments(len(replicates), mean, ((replicates - mean) ** 2).sum(axis=0))


def test_looks_spend_no_more_than_alpha() -> None:
    spent = sum(alpha_of_look(0.01, look) for look in range(1, 10_000))
    assert spent <= 0.01
    assert alpha_of_look(0.01, 1) == 0.005


def test_denominators() -> None:
    # whole image and two tiles; bounces: ordinary, dark tile, all dark
    truth = np.array([[1.0, 0.5, 0.0], [1.5, 1.0, 0.0], [0.5, 0.001, 0.0]])[..., None]
    expected = np.array([[1.0, 0.5, 1.5], [1.5, 1.0, 1.5], [0.5, 0.025, 1.5]])[..., None]
    np.testing.assert_allclose(denominators(truth), expected)
    assert (denominators(np.zeros((2, 3, 1))) == 1).all()


def test_the_interval_is_the_textbook_one_where_the_truth_is_exact() -> None:
    replicates = np.random.default_rng(1).normal(2.0, 0.3, (40, 1, 1, 1))
    found = biases(moments(replicates), np.full((1, 1, 1), 2.0), np.zeros((1, 1, 1)), alpha=0.05)
    low, high = stats.t.interval(0.95, 39, loc=replicates.mean(), scale=replicates.std(ddof=1) / np.sqrt(40))
    np.testing.assert_allclose(found.bias - found.own, low / 2 - 1)
    np.testing.assert_allclose(found.bias + found.own, high / 2 - 1)


def test_the_truth_s_noise_counts() -> None:
    replicates = np.random.default_rng(1).normal(1.0, 0.3, (40, 1, 1, 1))
    truth = np.ones((1, 1, 1))
    exact, noisy = (biases(moments(replicates), truth, e * truth, 0.05) for e in (0.0, 0.1))
    s, g = replicates.std(ddof=1) / np.sqrt(40), replicates.mean()
    np.testing.assert_allclose(noisy.error, np.hypot(s, 0.1 * g))
    assert (noisy.own > exact.own).all()


# 3,000 simulated comparisons of 32 replicates; the share of misses must be binomial about its nominal value,
# within limits that a right interval leaves once in a million
_RUNS, _REPLICATES = 3_000, 32


def _misses(alpha: float, sigma_factor: float = 1.0, regions: int = 1) -> tuple[int, int]:
    rng = np.random.default_rng(20)
    own = simultaneous = 0
    for _ in range(_RUNS):
        replicates = rng.normal(1.0, 0.2, (_REPLICATES, regions, 1, 1))
        m = moments(replicates)
        m = Moments(m.count, m.mean, m.m2 * sigma_factor**2)
        found = biases(m, np.ones((regions, 1, 1)), np.zeros((regions, 1, 1)), alpha)
        own += bool(abs(found.bias[0, 0, 0]) > found.own[0, 0, 0])
        simultaneous += bool((np.abs(found.bias) > found.simultaneous).any())
    return own, simultaneous


def test_own_intervals_cover_as_they_say() -> None:
    low, high = stats.binom.interval(1 - 1e-6, _RUNS, 0.05)
    assert low <= _misses(0.05)[0] <= high


def test_too_narrow_intervals_would_be_noticed() -> None:
    _, high = stats.binom.interval(1 - 1e-6, _RUNS, 0.05)
    assert _misses(0.05, sigma_factor=0.8)[0] > high


def test_simultaneous_intervals_miss_in_no_region_more_often_than_alpha() -> None:
    _, high = stats.binom.interval(1 - 1e-6, _RUNS, 0.05)
    assert _misses(0.05, regions=17)[1] <= high


@pytest.mark.parametrize("tolerance", [0.0, 0.05])
def test_a_bias_of_the_detectable_size_fails_with_90_percent(tolerance: float) -> None:
    """The q in ``resolution`` is one run's own, so the power is that of a typical run: 85 to 95 %."""
    rng, shape = np.random.default_rng(4), (17, 6, 3)
    sigma, alpha = 0.1, 1e-3
    q = stats.t.isf(alpha / 2 / np.prod(shape), _REPLICATES - 1)
    detectable = tolerance + (q + stats.norm.ppf(0.9)) * sigma / np.sqrt(_REPLICATES)
    caught = 0
    for _ in range(1000):
        replicates = rng.normal(1.0, sigma, (_REPLICATES, *shape))
        replicates[:, 0, 2, 1] += detectable
        found = biases(moments(replicates), np.ones(shape), np.zeros(shape), alpha)
        caught += bool(found.outside(np.full((17, 1, 1), tolerance))[0, 2, 1])
    assert 0.85 <= caught / 1000 <= 0.95
