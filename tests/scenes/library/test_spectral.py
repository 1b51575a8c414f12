"""Spectral cases: what must hold between wavelengths, whatever the geometry; and chromaticities."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest

from scenes import Case, Lambertian
from scenes.library import case, cornell_spectra
from scenes.spectral import chromaticity, to_rgb, to_xyz


def truth(found: Case) -> np.ndarray:
    answer = found.answer.truth(found.scene, found.bounces)
    assert answer is not None
    return answer.mean


@pytest.fixture(scope="module")
def cornell() -> Case:
    return case("cornell-box-spectral")


def test_the_spectra_are_those_that_were_published() -> None:
    """Ends, extremes and sums of the three columns; the lamp at its four wavelengths and between."""
    nm = cornell_spectra.WAVELENGTHS
    for color, first, last, low, high, total in (
        ("white", 0.343, 0.737, 0.343, 0.777, 54.923),
        ("green", 0.092, 0.159, 0.092, 0.481, 15.067),
        ("red", 0.040, 0.642, 0.040, 0.657, 18.464),
    ):
        values = cornell_spectra.reflectance(color, nm)
        assert len(values) == 76
        assert (values[0], values[-1], values.min(), values.max()) == (first, last, low, high)
        assert values.sum() == pytest.approx(total)
    np.testing.assert_allclose(
        cornell_spectra.emission((400, 450, 500, 600, 650, 700)), [0, 4, 8, 15.6, 17, 18.4]
    )


def test_the_walls_have_the_colours_that_mitsuba_3_gives_them() -> None:
    """Its RGB are these spectra in equal energy, taken to linear sRGB: by another program, to three digits."""
    nm = cornell_spectra.WAVELENGTHS
    known = {s.name: s.material.albedo for s in case("cornell-box").scene.surfaces}
    for color, wall in (("white", "floor"), ("green", "green-wall"), ("red", "red-wall")):
        rgb = to_rgb(to_xyz(cornell_spectra.reflectance(color, nm), nm))
        np.testing.assert_allclose(rgb, known[wall], atol=1e-3)


def test_every_channel_is_its_wavelength(cornell: Case) -> None:
    nm = cornell.wavelengths
    assert nm is not None
    assert cornell.scene.channels == len(nm) == 38
    walls = {s.name: s for s in cornell.scene.surfaces}
    for name, color in (("floor", "white"), ("lamp", "white"), ("green-wall", "green"), ("red-wall", "red")):
        material = walls[name].material
        assert isinstance(material, Lambertian)
        np.testing.assert_array_equal(material.albedo, cornell_spectra.reflectance(color, nm))
    np.testing.assert_array_equal(walls["lamp"].emission.radiance, cornell_spectra.emission(nm))


@pytest.mark.parametrize("bounce", [0, 1, 2, 3, 4, 5])
def test_each_bounce_is_a_polynomial_in_the_reflectances(cornell: Case, bounce: int) -> None:
    """TᵏE = e Σ c ρ_a ρ_b … over the k walls that light can meet: the c are geometry, shared by all wavelengths.

    38 wavelengths, at most 21 coefficients c per pixel, by least squares.
    """
    nm, image = cornell.wavelengths, truth(cornell)[bounce].reshape(-1, 38)
    assert nm is not None
    rho = [cornell_spectra.reflectance(color, nm) for color in ("white", "green", "red")]
    monomials = [
        np.prod([np.ones(38), *factors], axis=0) for factors in combinations_with_replacement(rho, bounce)
    ]
    basis = cornell_spectra.emission(nm)[:, None] * np.stack(monomials, axis=1)
    c, *_ = np.linalg.lstsq(basis, image.T, rcond=None)
    np.testing.assert_allclose(basis @ c, image.T, atol=3e-7 * image.max())


def test_one_pixel_s_direct_light_is_geometry_times_spectrum(cornell: Case) -> None:
    """The same pixel of the RGB box has the same geometry: TE / e ρ is one number."""
    rgb = case("cornell-box-empty")
    other = rgb.answer.truth(rgb.scene.resized(16, 16), 1)
    assert other is not None
    row, column = 14, 8
    walls = {s.name: s for s in rgb.scene.surfaces}
    three = other.mean[1, row, column] / np.multiply(
        walls["lamp"].emission.radiance, walls["floor"].material.albedo
    )
    walls = {s.name: s for s in cornell.scene.surfaces}
    many = truth(cornell)[1, row, column] / np.multiply(
        walls["lamp"].emission.radiance, walls["floor"].material.albedo
    )
    np.testing.assert_allclose(many, np.full(38, three.mean()), rtol=2e-6)
    np.testing.assert_allclose(three, three.mean(), rtol=2e-6)


def test_its_colours(cornell: Case) -> None:
    """Direct light is red beside the red wall and green beside the green one, and reddens bounce by bounce."""
    assert cornell.wavelengths is not None
    rgb = to_rgb(to_xyz(truth(cornell), cornell.wavelengths))
    left, right = rgb[1, 8, 0], rgb[1, 8, -1]
    assert left[0] > 3 * left[1]
    assert right[1] > 1.5 * right[0]
    x = chromaticity(to_xyz(truth(cornell), cornell.wavelengths).mean(axis=(1, 2)))[:, 0]
    assert (np.diff(x) > 0).all()


@pytest.mark.parametrize(
    ("name", "xy"), [("furnace-equal-energy", (1 / 3, 1 / 3)), ("furnace-d65", (0.31272, 0.32903))]
)
def test_every_bounce_has_the_chromaticity_of_the_illuminant(name: str, xy: tuple[float, float]) -> None:
    """To 2·10⁻⁴: sums in steps of 10 nm; among bounces to rounding."""
    found = case(name)
    assert found.wavelengths is not None
    xyz = to_xyz(truth(found), found.wavelengths)
    np.testing.assert_allclose(chromaticity(xyz), np.broadcast_to(xy, (6, 16, 16, 2)), atol=2e-4)
    np.testing.assert_allclose(
        chromaticity(xyz), np.broadcast_to(chromaticity(xyz[0, 0, 0]), (6, 16, 16, 2)), rtol=1e-12
    )
    rho = found.scene.surfaces[0].material.albedo[0]
    np.testing.assert_allclose(xyz[:, 0, 0, 1], xyz[0, 0, 0, 1] * rho ** np.arange(6), rtol=1e-12)
