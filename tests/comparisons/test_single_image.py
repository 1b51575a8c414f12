"""One image against a case: real renders, planted faults, and what must not be believed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage, stats

from comparisons.renderers.process import RendererProcess
from comparisons.results import Comparison
from comparisons.single_image import TooSmallError, check
from scenes import Case, Tolerance, Truth, library
from scenes.formats.finished import Finished

Array = NDArray[np.float64]

# what is rendered for a module is rendered once
pytestmark = pytest.mark.xdist_group("single image")

FLOAT, HALF = 2.0**-24, 2.0**-11
ALPHA = 1e-3
BOX = replace(library.case("furnace-box"), bounces=3, tolerance=Tolerance(image=(0.005,), tile=(0.02,)))
ZONES = replace(library.case("sphere-zones"), bounces=3, tolerance=Tolerance(image=(0.005,), tile=(0.02,)))


def truth_of(case: Case) -> Truth:
    truth = case.answer.truth(case.scene, case.bounces)
    assert truth is not None
    return truth


def checked(case: Case, images: Array, truth: Truth | None = None, **changes: Any) -> Comparison:
    """A verdict on layers, or on a sum where there is one image."""
    finished = Finished(**{"images": images, "summed": len(images) == 1, "rounding": FLOAT} | changes)
    return check(case, truth or truth_of(case), "picture.exr", finished, ALPHA)


def noisy(images: Array, share: float, seed: int = 1) -> Array:
    return images * (1 + share * np.random.default_rng(seed).standard_normal(images.shape))


def flat(side: int, bounces: int = 0) -> tuple[Case, Truth]:
    """The furnace at another size."""
    case = replace(BOX, scene=BOX.scene.resized(side, side), bounces=bounces)
    return case, truth_of(case)


@pytest.fixture(scope="module", params=["mitsuba", "reference"])
def rendered(request: pytest.FixtureRequest) -> dict[str, Array]:
    """Bounces 0 to 3 of two cases, by real renderers."""
    with RendererProcess(request.param) as process:
        return {c.name: process.render(c.scene, range(4), 256, 1, timeout=300.0) for c in (BOX, ZONES)}


def test_a_real_render_passes_bounce_by_bounce(rendered: dict[str, Array]) -> None:
    comparison = checked(BOX, rendered["furnace-box"])
    assert comparison.verdict == "pass"
    assert [b.bounce for b in comparison.bounces] == [0, 1, 2, 3]
    assert [m.bounces for m in comparison.term_metrics] == [0, 1, 2, 3]
    assert comparison.single_image is not None
    assert not comparison.single_image.summed
    assert comparison.single_image.hints == []
    # each interval, at 99.9 %, holds no bias, and is neither empty nor wider than the tolerance
    for bounce in comparison.bounces[1:]:
        low, high = bounce.interval
        assert low < 0 < high
        assert 1e-5 < high - low < 0.01


def test_a_real_sum_passes(rendered: dict[str, Array]) -> None:
    comparison = checked(BOX, rendered["furnace-box"].sum(axis=0, keepdims=True))
    assert comparison.verdict == "pass"
    [bounce] = comparison.bounces
    assert bounce.bounce == 3
    assert [m.bounces for m in comparison.metrics] == [3]
    assert comparison.single_image is not None
    assert comparison.single_image.summed
    assert "Which bounce is wrong" in " ".join(comparison.single_image.limits)


def test_a_real_render_of_edges_and_zones_is_not_failed(rendered: dict[str, Array]) -> None:
    """Its lamp's edge is a few pixels of noise per tile, which may leave a tile open."""
    comparison = checked(ZONES, rendered["sphere-zones"].sum(axis=0, keepdims=True))
    assert comparison.verdict in ("pass", "inconclusive")
    [bounce] = comparison.bounces
    assert bounce.detectable_bias < 0.02


def test_the_size_of_a_real_fault_is_measured(rendered: dict[str, Array]) -> None:
    """Albedo × 1.01 makes bounce k of a furnace too bright by 1.01ᵏ − 1."""
    images = rendered["furnace-box"] * (1.01 ** np.arange(4))[:, None, None, None]
    comparison = checked(BOX, images)
    assert [b.verdict for b in comparison.bounces] == ["pass", "fail", "fail", "fail"]
    for bounce in comparison.bounces:
        low, high = bounce.interval
        assert low <= 1.01**bounce.bounce - 1 <= high


def test_one_percent_in_one_tile_is_found_where_power_suffices() -> None:
    """Noise of 2 % of a pixel is 0.125 % of a tile's mean: told apart from 0.25 % it is found, and its place."""
    case = replace(BOX, tolerance=Tolerance(image=(0.005,), tile=(0.0025,)))
    images = noisy(truth_of(case).mean.sum(axis=0, keepdims=True), 0.02)
    assert checked(case, images).verdict in ("pass", "inconclusive")
    images[:, 16:32, 32:48] *= 1.01
    comparison = checked(case, images)
    assert comparison.verdict == "fail"
    [bounce] = comparison.bounces
    assert bounce.decided_by == "tile"
    place = bounce.worst_tile.place
    assert (place.x0, place.x1, place.y0, place.y1) == (32, 48, 16, 32)
    assert bounce.worst_tile.bias == pytest.approx(0.01, abs=0.003)


def test_where_power_does_not_suffice_nothing_is_passed() -> None:
    """The same fault under noise of 30 %: neither found nor passed, and it says what it could have seen."""
    case = replace(BOX, tolerance=Tolerance(image=(0.005,), tile=(0.0025,)))
    images = noisy(truth_of(case).mean.sum(axis=0, keepdims=True), 0.3)
    images[:, 16:32, 32:48] *= 1.01
    comparison = checked(case, images)
    assert comparison.verdict == "inconclusive"
    assert comparison.bounces[0].worst_tile.detectable_bias > 0.01
    assert "a bias could have been detected from" in comparison.message


@pytest.mark.parametrize("sigma", [0.8, 1.5, 3.0])
def test_a_denoised_image_is_not_passed_as_precise(sigma: float) -> None:
    """Blurred noise of 10 %: a tile's mean is uncertain by 0.6 %, though its pixels scatter by 3 to 1 %."""
    case, truth = flat(64)
    case = replace(case, tolerance=Tolerance(image=(0.005,), tile=(0.01,)))
    for seed in range(5):
        noise = noisy(truth.mean, 0.1, seed) - truth.mean
        images = truth.mean + ndimage.gaussian_filter(noise, (0, sigma, sigma, 0), mode="wrap")
        naive = 3.3 * (images - truth.mean).std() / 16
        assert naive < 0.01
        comparison = checked(case, images, truth)
        assert comparison.verdict != "pass"
        assert comparison.single_image is not None
        [found] = comparison.single_image.noise
        assert found.reach != 0
        assert found.correlation > 20 * found.correlation_error
        assert any(
            "correlated" in limit or "vary smoothly" in limit for limit in comparison.single_image.limits
        )


def test_on_ones_word_a_smooth_bias_is_told_from_noise() -> None:
    """3 % too bright on one side, 3 % too dark on the other, under noise of 2 %: nothing of the sum is off."""
    case, truth = flat(64)
    case = replace(case, tolerance=Tolerance(image=(0.005,), tile=(0.01,)))
    images = noisy(truth.mean, 0.02) * np.linspace(0.97, 1.03, 64)[:, None]
    finished = Finished(images, False, FLOAT)
    found = check(case, truth, "x", finished, ALPHA)
    assert found.verdict == "inconclusive"
    assert found.single_image is not None
    assert found.single_image.noise[0].reach is None
    assert check(case, truth, "x", finished, ALPHA, independent=True).verdict == "fail"
    right = Finished(noisy(truth.mean, 0.02), False, FLOAT)
    assert check(case, truth, "x", right, ALPHA, independent=True).verdict == "pass"


def test_half_of_alpha_is_for_the_whole_image() -> None:
    """As in comparisons with replicates; q of α/2 over the q of α, each over the channels."""
    case, truth = flat(64)
    [bounce] = checked(case, noisy(truth.mean, 0.05), truth).bounces
    each = [ALPHA / 2 / len(bounce.channels), ALPHA]
    expected = np.divide(*stats.norm.isf(np.divide(each, 2)))
    for channel in bounce.channels:
        (low, high), (own_low, own_high) = channel.simultaneous_interval, channel.interval
        assert (high - low) / (own_high - own_low) == pytest.approx(expected, rel=0.01)


def test_how_often_a_right_image_fails() -> None:
    """Tolerance 0: 150 images under independent noise, α = 2 %, within the binomial 99.9 % bound."""
    case, truth = flat(32)
    case = replace(case, tolerance=Tolerance(image=(1e-12,), tile=(1e-12,)))
    failed = 0
    for seed in range(150):
        finished = Finished(noisy(truth.mean, 0.05, seed), False, FLOAT)
        failed += check(case, truth, "x", finished, 0.02).verdict == "fail"
    assert failed <= stats.binom.isf(1e-3, 150, 0.02)


def test_how_often_a_bias_at_the_tolerance_passes() -> None:
    """One tile exactly at its tolerance, α = 20 %: half of α lies on the inner side; 150 images."""
    case, truth = flat(32)
    case = replace(case, tolerance=Tolerance(image=(0.05,), tile=(0.06,)))
    passed = 0
    for seed in range(150):
        images = noisy(truth.mean, 0.02, seed)
        images[:, 8:16, 8:16] += 0.06 * truth.mean[:, 8:16, 8:16]
        passed += check(case, truth, "x", Finished(images, False, FLOAT), 0.2).verdict == "pass"
    assert passed <= stats.binom.isf(1e-3, 150, 0.1)


def test_the_truth_itself_passes_at_once() -> None:
    truth = truth_of(ZONES)
    for images in (truth.mean, truth.mean.sum(axis=0, keepdims=True)):
        rounded = images.astype(np.float16).astype(float)
        comparison = checked(ZONES, rounded, rounding=HALF)
        assert comparison.verdict == "pass"
        # half a unit in the last place, evenly distributed: 2⁻¹¹ / √3, times what α and the power ask for
        assert all(b.resolution < 2**-11 / 3**0.5 * 7 for b in comparison.bounces)


def test_a_constant_factor_without_noise_fails_with_a_hint() -> None:
    comparison = checked(ZONES, 1.02 * truth_of(ZONES).mean.sum(axis=0, keepdims=True))
    assert comparison.verdict == "fail"
    assert comparison.bounces[0].bias == pytest.approx(0.02)
    assert comparison.single_image is not None
    assert "divided by 1.02:" in comparison.single_image.hints[0]


def test_the_tolerance_of_a_sum() -> None:
    """Of a furnace of albedo ½ with 1 %, 2 % and 4 %: (1 · 1 + ½ · 2 + ¼ · 4) / (1 + ½ + ¼) %."""
    case = replace(BOX, bounces=2, tolerance=Tolerance(image=(0.01, 0.02, 0.04), tile=(0.1,)))
    means = truth_of(case).mean.mean(axis=(1, 2, 3))
    assert means[1:] / means[:-1] == pytest.approx(0.5, rel=0.05)
    expected = (means * [0.01, 0.02, 0.04]).sum() / means.sum()
    [bounce] = checked(case, truth_of(case).mean.sum(axis=0, keepdims=True)).bounces
    assert bounce.tolerance == pytest.approx(expected)
    assert bounce.tile_tolerance == pytest.approx(0.1)


def test_luminance_is_held_against_luminance() -> None:
    truth = truth_of(ZONES)
    y = (truth.mean @ [0.2126, 0.7152, 0.0722]).sum(axis=0)[None, ..., None]
    comparison = checked(ZONES, noisy(y, 0.01))
    assert comparison.verdict == "pass"
    assert comparison.channels == ["Y"]
    assert [c.channel for c in comparison.bounces[0].channels] == ["Y"]
    assert comparison.metrics[0].flip is None
    assert checked(ZONES, 1.02 * y).verdict == "fail"


def test_pixels_that_are_no_numbers_are_counted_and_located() -> None:
    images = truth_of(BOX).mean.copy()
    images[2, 7, 12, 1] = np.nan
    images[3, 7, 13] = np.inf
    comparison = checked(BOX, images)
    assert comparison.verdict == "error"
    assert comparison.message == (
        "2 of 16384 pixels are NaN or infinite, the first one at x = 12, y = 7 (row 0 is the top) of bounce 2"
    )
    assert comparison.bounces == []


def test_fireflies_are_reported_and_hide_no_verdict_of_tiles_without_them() -> None:
    case, truth = flat(64)
    images = noisy(truth.mean, 0.02)
    images[0, 40, 10] += 300.0
    comparison = checked(case, images, truth)
    assert comparison.verdict == "inconclusive"
    assert comparison.single_image is not None
    [found] = comparison.single_image.noise
    assert found.outliers == 1
    [firefly] = found.brightest_outliers
    assert (firefly.x, firefly.y, firefly.truth) == (10, 40, pytest.approx(1.0))
    assert firefly.value > 300
    assert any("outliers" in limit for limit in comparison.single_image.limits)


def test_negative_pixels_are_noted() -> None:
    images = truth_of(BOX).mean.sum(axis=0, keepdims=True)
    images[0, 3, 4, 0] = -0.25
    assert checked(BOX, images).notes == ["1 pixels are negative, down to -0.25."]


@pytest.mark.parametrize(("side", "grid"), [(16, (2, 2)), (24, (3, 3)), (40, (4, 4))])
def test_tiles_have_enough_pixels(side: int, grid: tuple[int, int]) -> None:
    case, truth = flat(side)
    assert checked(case, truth.mean, truth).tiles == grid


def test_an_image_too_small_is_refused() -> None:
    case, truth = flat(15)
    with pytest.raises(TooSmallError, match=r"has 15x15 pixels; their scatter tells the noise from 16x16 up"):
        checked(case, truth.mean, truth)
