"""Answers: tolerances per bounce, formulas, and committed data at another resolution."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from scenes import Computed, Estimate, Scene, Tolerance
from scenes.formats import exr
from scenes.library import CASES, case

BOUNCES, SIZE = 3, 12


@pytest.fixture(scope="module")
def data() -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard error that single precision holds exactly."""
    rng = np.random.default_rng(3)
    mean, stderr = rng.random((2, BOUNCES + 1, SIZE, SIZE, 3)).astype(np.float32).astype(float)
    return mean, stderr


@pytest.fixture
def estimate(tmp_path: Path, data: tuple[np.ndarray, np.ndarray]) -> Estimate:
    path = tmp_path / "data.exr"
    exr.write_bounces(path, *data, {"lightproof:source": "made up"})
    return Estimate(str(path))


def scene(width: int, height: int) -> Scene:
    return case("cornell-box").scene.resized(width, height)


def test_the_data_as_they_are(estimate: Estimate, data: tuple[np.ndarray, np.ndarray]) -> None:
    truth = estimate.truth(scene(SIZE, SIZE), BOUNCES)
    assert truth is not None
    assert truth.bounces == BOUNCES
    np.testing.assert_array_equal(truth.mean, data[0])
    np.testing.assert_allclose(truth.stderr, data[1], rtol=1e-15)
    assert estimate.source == "made up"
    assert estimate.kind == "estimated"


@pytest.mark.parametrize("size", [1, 2, 3, 4, 6])
@pytest.mark.parametrize("bounces", [0, 2])
def test_a_coarse_pixel_is_the_mean_of_the_fine_ones(
    estimate: Estimate, data: tuple[np.ndarray, np.ndarray], size: int, bounces: int
) -> None:
    truth, step = estimate.truth(scene(size, size), bounces), SIZE // size
    assert truth is not None
    assert truth.mean.shape == truth.stderr.shape == (bounces + 1, size, size, 3)
    for k, row, column in np.ndindex(bounces + 1, size, size):
        block = np.s_[k, row * step : (row + 1) * step, column * step : (column + 1) * step]
        np.testing.assert_allclose(truth.mean[k, row, column], data[0][block].mean(axis=(0, 1)))
        # independent pixels: the error of their mean is that of their sum, √Σσ², divided by their number
        expected = np.sqrt((data[1][block] ** 2).sum(axis=(0, 1))) / step**2
        np.testing.assert_allclose(truth.stderr[k, row, column], expected)


@pytest.mark.parametrize(("width", "height"), [(5, 5), (24, 24), (12, 6), (6, 12), (8, 8), (13, 13)])
def test_no_answer_at_a_resolution_that_does_not_divide(estimate: Estimate, width: int, height: int) -> None:
    assert estimate.truth(scene(width, height), BOUNCES) is None


def test_no_answer_beyond_the_last_bounce(estimate: Estimate) -> None:
    assert estimate.truth(scene(6, 6), BOUNCES) is not None
    assert estimate.truth(scene(6, 6), BOUNCES + 1) is None


def test_computed_data_have_an_error_and_no_noise(
    tmp_path: Path, data: tuple[np.ndarray, np.ndarray]
) -> None:
    """And coarser pixels as estimates have them."""
    path = tmp_path / "data.exr"
    header = {"lightproof:source": "made up", "lightproof:error": "0 1.5e-06 0.25 1e-3"}
    exr.write_bounces(path, data[0], attributes=header)
    computed = Computed(str(path))
    truth = computed.truth(scene(4, 4), 2)
    assert truth is not None
    np.testing.assert_allclose(truth.mean, data[0][:3].reshape(3, 4, 3, 4, 3, 3).mean(axis=(2, 4)))
    assert not truth.stderr.any()
    assert computed.error == (0, 1.5e-6, 0.25, 1e-3)
    assert (computed.kind, computed.source) == ("computed", "made up")
    assert computed.truth(scene(5, 5), 2) is None


def test_a_tolerance_holds_beyond_its_last_entry() -> None:
    tolerance = Tolerance(image=(0.1, 0.2), tile=(0.3,))
    assert [tolerance.of_image(k) for k in range(4)] == [0.1, 0.2, 0.2, 0.2]
    assert [tolerance.of_tile(k) for k in range(3)] == [0.3] * 3


@pytest.mark.parametrize("name", CASES)
def test_every_case_answers_for_its_own_scene(name: str) -> None:
    found = case(name)
    truth = found.answer.truth(found.scene, found.bounces)
    assert truth is not None
    assert truth.mean.shape == truth.stderr.shape == (found.bounces + 1, *found.scene.shape)
    assert np.isfinite(truth.mean).all()
    assert (truth.mean >= 0).all()
    assert found.answer.source
    assert found.derivation
    assert found.blind_to
    assert truth.stderr.any() == (found.answer.kind == "estimated")


@pytest.mark.parametrize(
    ("wavelengths", "complaint"),
    [((400.0, 500.0), "3 channels, expected one per wavelength: 2"), ((400.0, 500.0, 700.0), "equal steps")],
)
def test_wavelengths_must_be_those_of_the_channels(wavelengths: tuple[float, ...], complaint: str) -> None:
    rgb = case("furnace-box")
    assert replace(rgb, wavelengths=(450.0, 550.0, 650.0)).wavelengths
    with pytest.raises(ValueError, match=complaint):
        replace(rgb, wavelengths=wavelengths)
