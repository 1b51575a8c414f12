"""XYZ and RGB of radiance per wavelength, against the CIE's published chromaticities and against plain sums."""

from __future__ import annotations

import numpy as np
import pytest

from scenes.spectral import chromaticity, colour, illuminant, linear_srgb, to_rgb, to_xyz

VISIBLE = tuple(range(380, 781, 5))


def test_equal_energy_is_white_in_the_middle() -> None:
    xyz = to_xyz(np.ones((2, 3, len(VISIBLE))), VISIBLE)
    assert xyz.shape == (2, 3, 3)
    np.testing.assert_allclose(xyz[..., 1], 1, rtol=1e-12)
    np.testing.assert_allclose(chromaticity(xyz), np.full((2, 3, 2), 1 / 3), atol=5e-5)


@pytest.mark.parametrize(
    ("name", "x", "y"), [("A", 0.44758, 0.40745), ("D50", 0.34567, 0.35851), ("D65", 0.31272, 0.32903)]
)
def test_the_chromaticities_of_illuminants(name: str, x: float, y: float) -> None:
    """CIE 15:2018, table 3, at 5 nm and cut off at 780 nm."""
    found = chromaticity(to_xyz(illuminant(name, VISIBLE), VISIBLE))
    np.testing.assert_allclose(found, (x, y), atol=1e-4)


@pytest.mark.parametrize("step", [1, 5, 8])
def test_colour_science_s_own_integration_agrees(step: int) -> None:
    wavelengths, rng = tuple(range(404, 701, step)), np.random.default_rng(0)
    radiance = rng.random((2, 4, len(wavelengths)))
    shape = colour.SpectralShape(404, wavelengths[-1], step)
    cmfs = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape)
    expected = colour.msds_to_XYZ(radiance, cmfs=cmfs, method="Integration", shape=shape) / 100
    np.testing.assert_allclose(to_xyz(radiance, wavelengths), expected, rtol=1e-9)


def test_it_is_the_sum_over_the_matching_functions() -> None:
    wavelengths, rng = tuple(range(404, 701, 8)), np.random.default_rng(0)
    radiance = rng.random((4, len(wavelengths)))
    table = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    matching = np.array([table[float(nm)] for nm in wavelengths])
    np.testing.assert_allclose(
        to_xyz(radiance, wavelengths), radiance @ matching / matching[:, 1].sum(), rtol=1e-9
    )


@pytest.mark.parametrize("count", [2, 3, 5, 40, 400])
def test_any_number_of_steps(count: int) -> None:
    """And any wavelengths; at 555 nm the published x̄, ȳ, z̄ are 0.5121, 1, 0.0057."""
    wavelengths = np.linspace(400, 710, count)
    assert to_xyz(np.ones(count), wavelengths)[1] == pytest.approx(1)
    single = (555 - 1e-3, 555.0)
    found = to_xyz(np.array([0.0, 2.0]), single)
    np.testing.assert_allclose(found, np.array([0.5121, 1.0, 0.0057]), atol=2e-4)


def test_srgb() -> None:
    """D65's white is (1, 1, 1); the primaries of ITU-R BT.709 are pure; beyond the gamut it is negative."""
    white = np.array([0.3127, 0.3290, 0.3583]) / 0.3290
    np.testing.assert_allclose(to_rgb(white), [1, 1, 1], atol=2e-4)
    red = to_rgb(np.array([0.64, 0.33, 0.03]))
    assert red[0] > 1
    np.testing.assert_allclose(red[1:], 0, atol=1e-3)
    spectral_green = np.zeros(len(VISIBLE))
    spectral_green[VISIBLE.index(520)] = 1
    assert to_rgb(to_xyz(spectral_green, VISIBLE)).min() < 0


def test_daylight_is_white() -> None:
    white = linear_srgb(illuminant("D65", VISIBLE), VISIBLE)
    np.testing.assert_allclose(white / white[1], [1, 1, 1], atol=2e-3)


def test_what_is_not_finite_stays_so() -> None:
    radiance = np.ones((3, len(VISIBLE)))
    radiance[1, 7], radiance[2, 9] = np.nan, np.inf
    assert np.isfinite(linear_srgb(radiance, VISIBLE)).all(axis=-1).tolist() == [True, False, False]


def test_no_light_has_no_chromaticity() -> None:
    assert np.isnan(chromaticity(np.zeros(3))).all()


@pytest.mark.parametrize("wavelengths", [(400, 410, 430), (500, 490), (500,), (400, 400)])
def test_unequal_steps_are_refused(wavelengths: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="expected two or more, ascending in equal steps"):
        to_xyz(np.ones(len(wavelengths)), wavelengths)


def test_a_channel_too_few() -> None:
    with pytest.raises(ValueError, match="80 channels, expected one per wavelength: 81"):
        to_xyz(np.ones(80), VISIBLE)
