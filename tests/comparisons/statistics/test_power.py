"""A stated resolution is put to the test: one run states it, another run has exactly that bias."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from comparisons.statistics.intervals import Biases, Means, biases
from comparisons.statistics.moments import Moments
from comparisons.statistics.power import resolution

RUNS, REGIONS = 1_000, 17
OTHERS, ALPHA = 18, 1e-3
Noise = Callable[[np.random.Generator, tuple[int, ...]], np.ndarray]


def normal(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    return rng.normal(1.0, 0.1, shape)


def skewed(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    return rng.gamma(4.0, 0.25, shape)  # skewness 1


def found_in(replicates: np.ndarray) -> Biases:
    one = np.ones(replicates.shape[1:])
    return biases(Means.of(Moments.of_all(replicates)), Means.known(one, 0 * one), one, ALPHA, OTHERS)


@pytest.mark.parametrize("noise", [normal, skewed])
@pytest.mark.parametrize("replicates", [32, 128])
def test_a_bias_of_the_stated_size_is_failed_with_90_percent(noise: Noise, replicates: int) -> None:
    """In the direction that is harder to see: below the truth, where the tail is above."""
    rng, shape, tolerance = np.random.default_rng(4), (replicates, REGIONS, 1), 0.02
    caught = 0
    for _ in range(RUNS):
        stated = tolerance + found_in(noise(rng, shape)).resolution[1, 0]
        found = found_in(noise(rng, shape) - stated)
        caught += bool(found.simultaneous.outside(np.full((REGIONS, 1), tolerance))[1, 0])
    assert 0.85 <= caught / RUNS <= 0.95  # 3 standard errors of the count are 0.03


def of_normal_noise(w: float, freedom: float) -> float:
    w_, zero, nu = (np.full((1, 1), x) for x in (w, 0.0, freedom))
    return float(resolution([w_, w_], [zero, zero], 1 / (2 * nu), nu)[0, 0])


def test_with_many_replicates_it_is_the_textbook_s() -> None:
    assert of_normal_noise(5.0, 1e6) == pytest.approx(5.0 + 1.2816, abs=1e-3)


def test_too_few_replicates_resolve_next_to_nothing() -> None:
    assert of_normal_noise(60.0, 1.0) > 10 * 60.0
    assert np.isinf(of_normal_noise(60.0, 0.5))


def test_without_noise_everything_is_resolved() -> None:
    assert (found_in(np.ones((32, REGIONS, 1))).resolution == 0).all()
