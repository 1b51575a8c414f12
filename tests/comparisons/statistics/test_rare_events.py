"""Dim regions where light comes in rare events: how often is light said to be missing that is not?"""

from __future__ import annotations

from functools import reduce
from operator import add

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from comparisons.regions import Regions
from comparisons.statistics import intervals
from comparisons.statistics.intervals import Means, biases, denominators
from comparisons.statistics.moments import Moments
from comparisons.statistics.rare_events import event_size, least_error

Array = NDArray[np.float64]

ALPHA, REPLICATES, RUNS = 1e-3, 32, 400
REGIONS = Regions.of(16, 16, (2, 2))
DIM = 1  # the tile of the first rows and columns
BRIGHT, RIM = 0.4, 0.02
"""Chance of an event in a sample: of every pixel of three tiles, and of three pixels of the dim one."""


def probabilities() -> Array:
    chance = np.full((16, 16, 1), BRIGHT)
    chance[:8, :8] = 0.0
    chance[:3, 0] = RIM
    return chance


def image(rng: np.random.Generator, spp: int, dim: float) -> Array:
    """Events that carry 2 in one of three cases, else 0.2; mean 0.8. ``dim`` scales the chance in the dim tile."""
    chance = probabilities()
    chance[:8, :8] *= dim
    events = rng.binomial(spp, chance)
    large = rng.binomial(events, 1 / 3)
    sum_of_light: Array = 2.0 * large + 0.2 * (events - large)
    return sum_of_light / spp


TRUTH = REGIONS.means(0.8 * probabilities()[None])[:, 0]


def fails(rng: np.random.Generator, spp: int = 1, dim: float = 1.0, aware: bool = True) -> bool:
    """Whether a run fails the dim tile, whose tolerance is 2 %."""
    images = [image(rng, spp, dim) for _ in range(REPLICATES)]
    pixels, regions = (
        reduce(add, map(Moments.of, of)) for of in (images, [REGIONS.means(i[None])[:, 0] for i in images])
    )
    least = least_error(event_size(pixels, spp), TRUTH, REGIONS.pixels() * spp * REPLICATES)
    denominator = denominators(TRUTH[:, None])[:, 0]
    found = biases(
        Means.of(regions),
        Means.known(TRUTH, np.zeros_like(TRUTH)),
        denominator,
        ALPHA,
        others=TRUTH[0].size,
        least_error=least if aware else 0.0,
    )
    return bool(found.simultaneous.outside(np.full((5, 1), 0.02))[DIM, 0])


def test_the_dim_tile_is_one_whose_light_can_be_missed() -> None:
    denominator = denominators(TRUTH[:, None])[:, 0]
    assert denominator[DIM, 0] == 0.05 * TRUTH[0, 0]
    assert 0.03 < TRUTH[DIM, 0] / denominator[DIM, 0] < 0.1


@pytest.mark.parametrize("spp", [1, 4])
def test_light_that_is_rare_is_not_said_to_be_missing(spp: int) -> None:
    rng = np.random.default_rng(7)
    wrong = sum(fails(rng, spp) for _ in range(RUNS))
    assert wrong <= stats.binom.isf(1e-6, RUNS, ALPHA)


def test_by_its_own_spread_it_would_be(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(intervals, "SHARE", 0.0)
    rng = np.random.default_rng(7)
    wrong = sum(fails(rng, aware=False) for _ in range(RUNS))
    assert wrong > RUNS / 20


@pytest.mark.parametrize("dim", [0.0, 3.0])
def test_light_that_is_missing_or_too_much_fails_all_the_same(dim: float) -> None:
    rng = np.random.default_rng(8)
    assert all(fails(rng, 2000, dim) for _ in range(20))


def test_events_of_one_size_have_it() -> None:
    rng, p, size = np.random.default_rng(9), 0.3, np.array([2.0, 0.5])
    for spp in (1, 8):
        draws = size * rng.binomial(spp, p, (500, 6, 6, 1)) / spp
        found = event_size(reduce(add, map(Moments.of, draws)), spp)
        np.testing.assert_allclose(found, size, rtol=0.02)


def test_rare_events_have_this_noise() -> None:
    """A mean of few events of two sizes: 20,000 replicates, whose spread is known to 2 %."""
    rng = np.random.default_rng(10)
    size = np.array([(4.0 + 2 * 0.04) / (2.0 + 2 * 0.2)])  # E S² / E S
    dim = np.array([REGIONS.means(image(rng, 1, 1.0)[None])[DIM, 0, 0] for _ in range(20_000)])
    expected = least_error(size, TRUTH, REGIONS.pixels())[DIM, 0]
    np.testing.assert_allclose(dim.std(), expected, rtol=0.05)


def test_bright_and_black_regions_keep_their_own() -> None:
    truth = np.array([[1.0], [1.9], [0.05], [0.0], [0.01]])
    least = least_error(np.array([2.0]), truth, np.full((5, 1), 50.0))
    np.testing.assert_allclose(least, [[0.0], [0.0], [0.0], [0.0], [np.sqrt(2 * 0.01 / 50)]])
    assert event_size(Moments.of_all(np.zeros((2, 1, 1, 1))), 1) == 0
