"""Noise from residuals: by hand, and by simulation with known noise, fixed seeds and stated power."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage, stats

from comparisons.statistics.residuals import Noise, noise, outliers

Array = NDArray[np.float64]
Generator = np.random.Generator


def windows(side: int, tiles: int) -> list[tuple[slice, slice]]:
    size = side // tiles
    ends = [slice(i * size, (i + 1) * size) for i in range(tiles)]
    return [(y, x) for y in ends for x in ends]


def truth_of(side: int) -> Array:
    y, x = np.mgrid[:side, :side] / side
    return (1 + 0.5 * np.sin(6 * x) * np.cos(5 * y))[..., None]


def estimate(residual: Array, tiles: int = 4) -> Noise:
    truth = np.broadcast_to(truth_of(len(residual)), residual.shape)
    return noise(residual, truth, truth, np.zeros_like(residual), windows(len(residual), tiles))


def means(residual: Array, tiles: int = 4) -> Array:
    inside = [residual[w].mean(axis=(0, 1)) for w in windows(len(residual), tiles)]
    return np.array([residual.mean(axis=(0, 1)), *inside])


def normal(rng: Generator, side: int) -> Array:
    return rng.standard_normal((side, side, 1))


def exponential(rng: Generator, side: int) -> Array:
    """Skewness 2, excess kurtosis 6."""
    return rng.exponential(size=(side, side, 1)) - 1


def uneven(rng: Generator, side: int) -> Array:
    """Independent, but some pixels are seven times as noisy as others."""
    return normal(rng, side) * np.exp(np.sin(np.arange(side) / 3))[:, None, None]


def channels(rng: Generator, side: int) -> Array:
    """Three that share most of their noise, as those of one path do."""
    return normal(rng, side) + 0.3 * rng.standard_normal((side, side, 3))


def blurred(sigma: float) -> Callable[[Generator, int], Array]:
    return lambda rng, side: ndimage.gaussian_filter(normal(rng, side), (sigma, sigma, 0), mode="wrap")


def test_a_checkerboard_by_hand() -> None:
    """±1 under a constant truth: only the mean is fitted, σ² = n / (n − 1), and g stays 1 where it would be below."""
    y, x = np.mgrid[:32, :32]
    residual = 0.1 * np.where((x + y) % 2, 1.0, -1.0)[..., None]
    constant = np.ones_like(residual)
    found = noise(residual, constant, constant, np.zeros_like(residual), windows(32, 2))
    assert (found.reach, found.inflation) == (0, 1)
    assert found.error[1:, 0] == pytest.approx(np.full(4, 0.1 * (256 / 255 / 256) ** 0.5))
    assert found.error[0, 0] == pytest.approx(0.1 * (256 / 255 / 1024) ** 0.5)
    assert found.skewness == pytest.approx(0)
    # of 16 × 16 pixels, Σ d d' is −1 per pair for the 4 · 16 · 15 beside each other, +1 for the 4 · 15² across
    # corners; σ² takes 255 / 256 off, and the fitted mean gives back 1 / 256 of each pair
    products = (255 / 256) * (4 * 225 - 4 * 240) + (4 * 225 + 4 * 240) / 256
    assert found.correlation[0] == pytest.approx(products / (8 * 256))


def test_a_bias_in_proportion_to_the_truth_is_no_noise() -> None:
    residual = 0.01 * normal(np.random.default_rng(1), 32)
    plain, biased = estimate(residual), estimate(residual + 0.05 * truth_of(32) - 0.02)
    assert biased.error == pytest.approx(plain.error)
    assert biased.reach == 0


def test_no_scatter_leaves_the_rounding() -> None:
    truth = truth_of(32)
    rounding = np.full_like(truth, 1e-3)
    for residual in (np.zeros_like(truth), 0.02 * truth, 1e-4 * truth**2):
        found = noise(residual, truth, truth, rounding, windows(32, 4))
        assert found.error[1:] == pytest.approx(1e-3, rel=1e-2)
        assert found.reach == 0
        # the whole is as uncertain as its tiles: they share it
        assert found.error[0] == pytest.approx(1e-3, rel=1e-2)
        assert found.half_width(1e-3) == pytest.approx(3.29e-3, rel=1e-2)


@pytest.mark.parametrize("shape", [normal, exponential, uneven, channels])
def test_how_often_intervals_miss(shape: Callable[[Generator, int], Array]) -> None:
    """Images of 16 tiles: own intervals at 5 %, simultaneous ones at 2 %, within the binomial 99.9 % bound."""
    rng, images, alpha = np.random.default_rng(2), 150 if shape is channels else 400, 0.02
    own, together = 0.0, 0
    for _ in range(images):
        residual = 0.1 * shape(rng, 32)
        found = estimate(residual)
        off = np.abs(means(residual))
        own += (off > found.half_width(0.05)).mean()
        together += (off > found.half_width(alpha / off.size)).any()
    assert together <= stats.binom.isf(1e-3, images, alpha)
    # tiles of channels that share their noise count once
    assert own <= stats.binom.isf(1e-3, 16 * images, 0.05) / 16
    if shape is normal:
        assert own >= stats.binom.ppf(1e-3, 16 * images, 0.05) / 16


def test_power_is_what_it_is_said_to_be() -> None:
    """A tile that is off by its half width and 1.28 standard errors is found in 90 % of 300 images."""
    rng, hits = np.random.default_rng(3), 0
    for _ in range(300):
        residual = 0.02 * normal(rng, 32)
        found = estimate(residual)
        half, error = found.half_width(1e-3 / 17)[6, 0], found.error[6, 0]
        y, x = windows(32, 4)[5]
        residual[y, x] += half + stats.norm.ppf(0.9) * error
        hits += bool(means(residual)[6, 0] > half)
    assert 0.85 <= hits / 300 <= 0.95
    # a constant in a tile is fitted, and changes no error
    assert estimate(residual).error[6] == pytest.approx(found.error[6])


@pytest.mark.parametrize(("sigma", "reaches"), [(0.5, {1, 2}), (1.0, {2, 4, None})])
def test_a_filter_widens_the_intervals(sigma: float, reaches: set[int | None]) -> None:
    """100 images of 64 × 64: the error is that of the tiles' means, which pixels alone would take for far smaller."""
    rng = np.random.default_rng(4)
    images = [blurred(sigma)(rng, 64) for _ in range(100)]
    found = [estimate(image) for image in images]
    assert {noise.reach for noise in found} <= reaches
    true = np.std([means(image)[1:] for image in images])
    assert np.mean([noise.error[1:] for noise in found]) == pytest.approx(true, rel=0.12)
    naive = np.mean([image.std() / 16 for image in images])
    assert naive < 0.75 * true


@pytest.mark.parametrize("sigma", [2.0, 4.0])
def test_what_is_smooth_is_left_to_the_scatter_of_tiles(sigma: float) -> None:
    """100 denoised images: hardly any interval of 99 % misses, though a pixel's scatter is a seventh of its noise."""
    rng, missed = np.random.default_rng(5), 0
    for _ in range(100):
        image = blurred(sigma)(rng, 64)
        found = estimate(image)
        assert found.reach is None
        assert found.freedom == pytest.approx(15)
        missed += (np.abs(means(image)) > found.half_width(0.01 / 17)).any()
    assert missed <= stats.binom.isf(1e-3, 100, 0.01)


def test_neighbours_that_repel_each_other_are_taken_for_independent() -> None:
    """Blue noise: the mean is better than pixels say, never worse."""
    rng = np.random.default_rng(6)
    white = normal(rng, 64)
    found = estimate(white - ndimage.uniform_filter(white, (3, 3, 1), mode="wrap"))
    assert (found.reach, found.inflation) == (0, 1)
    assert found.correlation[0] < -0.05


def test_outliers_are_found_and_count_everywhere() -> None:
    residual, truth = 0.01 * normal(np.random.default_rng(7), 32), np.ones((32, 32, 1))
    residual[3, 20] = residual[17, 9] = 5.0
    assert np.argwhere(outliers(residual, truth, truth, windows(32, 4))[..., 0]).tolist() == [
        [3, 20],
        [17, 9],
    ]
    found = noise(residual, truth, truth, np.zeros_like(truth), windows(32, 4))
    # 2 of 1024 pixels hold 5: a variance of 2 · 25 / 1024 per pixel, far more than the 0.0001 of the others
    assert found.error[1:] == pytest.approx((50 / 1024 / 64) ** 0.5, rel=0.01)
    # of a variance that hangs on two pixels: 2 (2 · 5²)² / (2 · 5⁴)
    assert found.freedom[1:] == pytest.approx(4, rel=0.05)


def test_a_lamp_in_the_wrong_place_is_no_outlier() -> None:
    truth = truth_of(32)
    residual = 0.01 * normal(np.random.default_rng(8), 32)
    residual[4:8, 4:8] = 5.0
    assert not outliers(residual, truth, truth, windows(32, 4)).any()


def test_a_soft_edge_has_no_outliers() -> None:
    """A lamp of 20 beside 0.1, blurred: a pixel beside it is far too bright, but not brighter than the lamp."""
    truth = np.full((32, 32, 1), 0.1)
    truth[:, 16:] = 20.0
    image = ndimage.gaussian_filter(truth, (0, 0.7, 0))
    assert not outliers(image - truth, truth, truth, windows(32, 4)).any()
