"""Each metric against numbers computed by hand, or by a few lines of its paper's formula."""

from __future__ import annotations

from importlib.util import find_spec

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from comparisons.metrics import (
    delta_e,
    hdr_flip,
    image_metrics,
    partial_sum_metrics,
    rel_mse,
    term_metrics,
)

Array = NDArray[np.float64]

needs_flip = pytest.mark.skipif(find_spec("flip_evaluator") is None, reason="no FLIP beyond Python 3.13")


@pytest.fixture
def both() -> tuple[Array, Array]:
    """A truth and an image, three bounces of 16 × 16 pixels; only bounce 1 differs, by 10 %."""
    truth = np.random.default_rng(1).random((3, 16, 16, 3))
    image = truth.copy()
    image[1] *= 1.1
    return image, truth


def test_metrics_are_of_the_partial_sums(both: tuple[Array, Array]) -> None:
    image, truth = both
    first, second, third = partial_sum_metrics(image, truth)
    assert (first.nrmse, first.psnr, first.ssim) == (0, None, pytest.approx(1))
    error = np.sqrt(np.mean((0.1 * truth[1]) ** 2)) / np.sqrt(np.mean((truth[0] + truth[1]) ** 2))
    assert second.nrmse == pytest.approx(error)
    total = truth.sum(axis=0)
    assert third.psnr == pytest.approx(-10 * np.log10(np.mean((0.1 * truth[1]) ** 2) / total.max() ** 2))
    assert second.ssim is not None
    assert second.ssim < 1


def test_metrics_are_of_the_terms(both: tuple[Array, Array]) -> None:
    zeroth, first, second = term_metrics(*both)
    assert [m.bounces for m in (zeroth, first, second)] == [0, 1, 2]
    assert first.nrmse == pytest.approx(0.1)
    for equal in (zeroth, second):
        assert equal.rmse == 0


@needs_flip
def test_equal_images(both: tuple[Array, Array]) -> None:
    _, truth = both
    found = image_metrics(2, truth[0], truth[0])
    assert (found.bounces, found.rmse, found.nrmse, found.rel_mse, found.flip) == (2, 0, 0, 0, 0)
    assert found.delta_e == 0
    assert found.psnr is None
    assert found.ssim == pytest.approx(1)


def test_two_pixels_by_hand() -> None:
    """Mean 2, so ε = 0.04: ((2 − 1)² / (1 + 0.04) + 0) / 2; squared error 1/2 of a mean square of 5, a peak of 3."""
    truth, image = np.array([1.0, 3.0]).reshape(1, 2, 1), np.array([2.0, 3.0]).reshape(1, 2, 1)
    found = image_metrics(0, image, truth)
    assert found.rel_mse == pytest.approx(1 / 1.04 / 2)
    assert found.rmse == pytest.approx(0.5**0.5)
    assert found.nrmse == pytest.approx(0.1**0.5)
    assert found.psnr == pytest.approx(10 * np.log10(9 / 0.5))


def test_rel_mse_knows_no_unit(both: tuple[Array, Array]) -> None:
    image, truth = both
    assert rel_mse(1e-6 * image, 1e-6 * truth) == pytest.approx(rel_mse(image, truth))


def test_ssim_of_a_single_window() -> None:
    """Of 7 × 7 pixels there is one window, and its statistics are those of the image."""
    rng = np.random.default_rng(2)
    t = rng.random((7, 7))
    x = t + 0.2 * rng.random((7, 7))
    c1, c2 = (0.01 * t.max()) ** 2, (0.03 * t.max()) ** 2
    covariance = np.cov(x.ravel(), t.ravel())
    expected = (2 * x.mean() * t.mean() + c1) * (2 * covariance[0, 1] + c2)
    expected /= (x.mean() ** 2 + t.mean() ** 2 + c1) * (covariance[0, 0] + covariance[1, 1] + c2)
    assert image_metrics(0, x[..., None], t[..., None]).ssim == pytest.approx(expected)


@needs_flip
@pytest.mark.parametrize("factor", [1.1, 0.9, 0.5, 0.05])
def test_flip_of_two_greys(factor: float) -> None:
    """Uniform greys have no features and nothing to filter: the paper's formula leaves the lightness.

    The one exposure puts the truth where ACES gives 0.85. With ΔL the difference of CIE lightnesses, e = ΔL^0.7 is
    mapped to 0 … 0.95 below 0.4 of the largest possible one, 41.28 (blue against green), and to 0.95 … 1 above.
    """

    def aces(x: float) -> float:
        return 0.36 * x * (2.51 * x + 0.05) / (0.36 * 2.43 * x**2 + 0.6 * 0.59 * x + 0.14)

    def lightness(y: float) -> float:
        return 116 * float(np.cbrt(y)) - 16

    white = 2.1188723
    assert aces(white) == pytest.approx(0.85)
    error, largest = abs(lightness(aces(white)) - lightness(min(aces(factor * white), 1))) ** 0.7, 41.276
    knee = 0.4 * largest
    expected = error / knee * 0.95 if error < knee else 0.95 + 0.05 * (error - knee) / (largest - knee)
    found = hdr_flip(np.full((16, 16, 3), 0.3), np.full((16, 16, 3), 0.3 * factor))
    assert found == pytest.approx(expected, rel=2e-3)  # its white is rounded differently from ours


@needs_flip
def test_flip_takes_the_truth_as_the_reference() -> None:
    """As FLIP by itself, whose automatic exposures are ours where all pixels are lit."""
    import flip_evaluator

    rng = np.random.default_rng(3)
    truth = rng.random((24, 24, 3)) + 0.01
    image = truth * rng.choice([0.5, 4.0], (24, 24, 1))
    pair = truth.astype(np.float32), image.astype(np.float32)
    _, expected, _ = flip_evaluator.evaluate(*pair, "HDR", applyMagma=False)
    _, swapped, _ = flip_evaluator.evaluate(*pair[::-1], "HDR", applyMagma=False)
    assert hdr_flip(truth, image) == pytest.approx(expected, rel=1e-4)
    assert abs(swapped - expected) > 0.01 * expected
    assert hdr_flip(1e-9 * truth, 1e-9 * image) == pytest.approx(expected, rel=1e-4)


@needs_flip
def test_flip_survives_what_ends_its_own_process() -> None:
    """A black truth, one with a few lit pixels, negative light, values beyond 32 bits."""
    black, lit = np.zeros((8, 8, 3)), np.zeros((8, 8, 3))
    lit[3, 4] = 1e-8
    assert hdr_flip(black, black + 1) is None
    assert hdr_flip(lit, lit) == 0
    assert hdr_flip(lit, black) == pytest.approx(hdr_flip(lit, black - 1) or 0)
    assert (hdr_flip(black + 1, black + 1e60) or 0) > 0.1


def test_delta_e_of_two_greys() -> None:
    """ΔE₀₀ of greys is ΔL / S_L with S_L = 1 + 0.015 (L̄ − 50)² / √(20 + (L̄ − 50)²), L = 116 ∛Y − 16."""
    truth, image = np.full((2, 2, 3), 0.005), np.full((2, 2, 3), 0.010)
    low, high = (116 * y ** (1 / 3) - 16 for y in (0.18, 0.36))
    off = ((low + high) / 2 - 50) ** 2
    expected = (high - low) / (1 + 0.015 * off / np.sqrt(20 + off))
    assert delta_e(image, truth) == pytest.approx(expected, rel=1e-3)


def test_delta_e_clips_at_the_screen() -> None:
    """Two lamps brighter than white show the same; the exposure is that of the median."""
    truth = np.full((3, 3, 3), 0.18)
    image = truth.copy()
    truth[0, 0], image[0, 0] = 5.0, 9.0
    assert delta_e(image, truth) == 0
    image[0, 1, 0] *= 1.1
    assert (delta_e(image, truth) or 0) > 0.1


def test_small_and_black_images_have_none() -> None:
    [small] = partial_sum_metrics(np.ones((1, 6, 16, 3)), np.full((1, 6, 16, 3), 2.0))
    assert small.ssim is None
    assert small.nrmse == pytest.approx(0.5)
    [black] = partial_sum_metrics(np.ones((1, 8, 8, 3)), np.zeros((1, 8, 8, 3)))
    values = msgspec.structs.asdict(black)
    assert (values.pop("bounces"), values.pop("rmse")) == (0, 1)
    assert set(values.values()) == {None}


@pytest.mark.parametrize("channels", [1, 38])
def test_colour_metrics_need_three_channels(channels: int) -> None:
    truth = np.ones((8, 8, channels))
    found = image_metrics(0, 2 * truth, truth)
    assert (found.flip, found.delta_e) == (None, None)
    assert found.nrmse == pytest.approx(1)
    assert found.ssim is not None
