"""The bound of all later bounces: against series that are known, and where there is none."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace

from scenes import (
    AreaLight,
    Blend,
    Checkerboard,
    Conductor,
    Dielectric,
    DirectionalLight,
    Image,
    ImageTexture,
    IrradianceMeter,
    Lambertian,
    Material,
    Mirror,
    Pinhole,
    PointLight,
    Quad,
    Scene,
    SphericalHarmonicsEnvironment,
    Surface,
    library,
)
from scenes.lights import Light
from scenes.tail import brightest_emission, largest_albedo, tail_bound

CAMERA = Pinhole((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0, 4, 4)
FLOOR = Quad((-1.0, -1.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0))


def floor(material: Material, *lights: Light, emission: AreaLight | None = None) -> Scene:
    return Scene((Surface("floor", FLOOR, material, emission),), CAMERA, lights)


@pytest.mark.parametrize("last", [0, 1, 5, 40])
def test_in_a_furnace_the_bound_is_the_rest_of_the_series(last: int) -> None:
    """Constant radiance is the worst there is: nothing is lost but what is absorbed."""
    scene = library.case("furnace-box").scene  # E = 1, every albedo 0.5: TᵏE = 2⁻ᵏ
    np.testing.assert_allclose(tail_bound(scene, last), np.full(3, 0.5**last), rtol=1e-12)


@pytest.mark.parametrize(
    "name",
    [
        "furnace-cornell",
        "furnace-mirrors",
        "furnace-blend",
        "integrating-sphere",
        "sphere-flat-port",
        "mirror-lamps",
    ],
)
@pytest.mark.parametrize("last", [1, 4])
def test_no_pixel_has_more(name: str, last: int) -> None:
    case = library.case(name)
    scene = case.scene.resized(16, 16)
    rest = case.answer.truth(scene, 200).mean[last + 1 :].sum(axis=0)  # type: ignore[union-attr]
    assert (rest <= tail_bound(scene, last) * (1 + 1e-9)).all()


def test_directional_lights_begin_with_their_first_reflection() -> None:
    """TE is albedo / π times the irradiance, at most."""
    scene = floor(Lambertian((0.5,)), DirectionalLight((0.0, 0.0, -1.0), (np.pi,)))
    np.testing.assert_allclose(tail_bound(scene, 0), [0.5 / (1 - 0.5)])
    np.testing.assert_allclose(tail_bound(scene, 3), [0.5**4 / (1 - 0.5)])


@pytest.mark.parametrize(
    ("material", "expected"),
    [
        (Lambertian((0.2, 0.4)), (0.2, 0.4)),
        (Lambertian(Checkerboard((0.1, 0.6), (0.3, 0.2))), (0.3, 0.6)),
        (Lambertian(ImageTexture(Image((((0.1, 0.9), (0.7, 0.2)),)))), (0.7, 0.9)),
        (Mirror((0.5, 0.3)), (0.5, 0.3)),
        (Blend(Lambertian((0.2, 0.4)), Mirror((1.0, 0.8)), 0.25), (0.4, 0.5)),
        (Conductor((1.0, 1.0), (2.0, 2.0)), (1.0, 1.0)),
        (Blend(Lambertian((0.2, 0.4)), Dielectric(), 0.5), (0.6, 0.7)),
    ],
)
def test_the_largest_albedo(material: Material, expected: tuple[float, ...]) -> None:
    scene = floor(material, emission=AreaLight((1.0, 2.0)))
    np.testing.assert_allclose(largest_albedo(scene), expected)


@pytest.mark.parametrize(
    "scene",
    [
        floor(Conductor((1.0,), (2.0,)), emission=AreaLight((1.0,))),
        floor(Lambertian((1.0,)), emission=AreaLight((1.0,))),
        floor(Lambertian((0.5,)), PointLight((0.0, 0.0, 1.0), (1.0,))),
    ],
    ids=["metal", "albedo 1", "a point"],
)
def test_where_there_is_no_bound(scene: Scene) -> None:
    assert np.isinf(tail_bound(scene, 100)).all()


@pytest.mark.parametrize("lights", [(PointLight((0.0, 0.0, 1.0), (1.0,)),), ()])
def test_where_nothing_reflects_nothing_follows(lights: tuple[Light, ...]) -> None:
    scene = floor(Lambertian((0.0,)), *lights, emission=AreaLight((1.0,)))
    np.testing.assert_array_equal(tail_bound(scene, 0), [0.0])


def test_a_dark_channel_has_no_tail_whatever_the_albedo() -> None:
    scene = floor(Lambertian((1.0, 0.5)), emission=AreaLight((0.0, 1.0)))
    np.testing.assert_array_equal(tail_bound(scene, 2), [0.0, 0.25])


def test_an_irradiance_meter_adds_up_a_hemisphere() -> None:
    scene = library.case("furnace-box").scene
    meter = IrradianceMeter((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    np.testing.assert_allclose(tail_bound(replace(scene, sensor=meter), 2), np.pi * tail_bound(scene, 2))


def test_harmonics_are_nowhere_brighter() -> None:
    rng = np.random.default_rng(3)
    c = rng.normal(size=(9, 2)) * 0.1
    c[0] = 2.0
    sky = SphericalHarmonicsEnvironment(tuple(map(tuple, c.tolist())))
    d = rng.normal(size=(3, 20_000))
    x, y, z = d / np.linalg.norm(d, axis=0)
    a, b = np.sqrt(3 / (4 * np.pi)), np.sqrt(15 / (4 * np.pi))
    Y = [np.full_like(x, np.sqrt(1 / (4 * np.pi))), a * y, a * z, a * x, b * x * y, b * y * z,
         np.sqrt(5 / (16 * np.pi)) * (3 * z**2 - 1), b * x * z, b / 2 * (x**2 - y**2)]  # fmt: skip
    brightest = (c.T @ np.array(Y)).max(axis=1)
    bound = brightest_emission(floor(Lambertian((0.5, 0.5)), sky))
    assert (brightest <= bound).all()
    assert (bound < 2 * brightest).all()
