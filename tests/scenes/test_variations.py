"""Variations of scenes: what changes, and that nothing else does."""

from __future__ import annotations

import msgspec
import pytest

from scenes import (
    AreaLight,
    Blend,
    Checkerboard,
    Conductor,
    ConstantEnvironment,
    Dielectric,
    DirectionalLight,
    EnvironmentMap,
    Image,
    ImageTexture,
    Lambertian,
    Mirror,
    Pinhole,
    PointLight,
    PolarRange,
    Scene,
    SceneError,
    Sphere,
    SphericalHarmonicsEnvironment,
    SpotLight,
    Surface,
)
from scenes.channels import with_channels
from scenes.variations import brighter, darker, emitters, lit_by, with_emitters

CAP = AreaLight((1.0, 2.0), PolarRange(0, 30))
POINT, SPOT = PointLight((9, 0, 0), (1.0, 3.0)), SpotLight((0, 9, 0), (0, 1, 0), (5.0, 7.0), 30, 20)
SUN, SKY = DirectionalLight((0, 1, 0), (2.0, 4.0)), ConstantEnvironment((0.5, 0.25))
VIEW = Pinhole((0, 0, 9), (0, 0, 0), (0, 1, 0), 30, 4, 4)


def ball(name: str, x: float, material: object = None, emission: AreaLight | None = None) -> Surface:
    return Surface(name, Sphere((x, 0, 0), 0.4), material or Lambertian((0.5, 0.4)), emission)


SCENE = Scene(
    (ball("lamp", 0, emission=CAP), ball("dark", 1), ball("off", 2, emission=AreaLight((0.0, 0.0)))),
    VIEW,
    (POINT, SPOT, SUN, SKY),
)


def test_emitters_by_name() -> None:
    assert emitters(SCENE) == ["lamp", "lights[0]", "lights[1]", "lights[2]", "lights[3]"]


@pytest.mark.parametrize("name", emitters(SCENE))
def test_each_alone_and_everything_where_it_was(name: str) -> None:
    alone = with_emitters(SCENE, [name])
    assert emitters(alone) == ["lamp" if name == "lamp" else "lights[0]"]
    assert [s.shape for s in alone.surfaces] == [s.shape for s in SCENE.surfaces]
    assert [s.material for s in alone.surfaces] == [s.material for s in SCENE.surfaces]
    assert alone.sensor == SCENE.sensor


def test_all_of_them_are_the_scene() -> None:
    assert with_emitters(SCENE, [*emitters(SCENE), "off"]) == SCENE


def test_lit_by_another_light() -> None:
    lit = lit_by(SCENE, SUN)
    assert lit.lights == (SUN,)
    assert all(surface.emission is None for surface in lit.surfaces)


def test_brighter_takes_every_emission_and_nothing_else() -> None:
    twice = brighter(SCENE, 2.0)
    lamp, *lights = twice.surfaces[0].emission, *twice.lights
    assert lamp == AreaLight((2.0, 4.0), PolarRange(0, 30))
    assert [getattr(light, "intensity", None) for light in lights[:2]] == [(2.0, 6.0), (10.0, 14.0)]
    assert (lights[2].irradiance, lights[3].radiance) == ((4.0, 8.0), (1.0, 0.5))
    assert [s.material for s in twice.surfaces] == [s.material for s in SCENE.surfaces]
    assert (lights[1].cutoff, lights[1].beam, lights[1].position) == (30, 20, (0, 9, 0))


@pytest.mark.parametrize(
    "sky",
    [EnvironmentMap(Image([[[1.0, 2.0]], [[3.0, 4.0]]])), SphericalHarmonicsEnvironment([[1.0, 2.0]])],
    ids=["map", "harmonics"],
)
def test_brighter_environments(sky: EnvironmentMap | SphericalHarmonicsEnvironment) -> None:
    [twice] = brighter(Scene((ball("b", 0),), VIEW, (sky,)), 2.0).lights
    if isinstance(twice, EnvironmentMap):
        assert twice.image.array.tolist() == [[[2.0, 4.0]], [[6.0, 8.0]]]
    else:
        assert twice == SphericalHarmonicsEnvironment([[2.0, 4.0]])
    assert twice.axes == sky.axes


def test_darker_takes_albedos_textures_mirrors_and_blends() -> None:
    checks = Lambertian(Checkerboard((0.8, 0.6), (0.4, 0.2), 3, 2))
    image = Lambertian(ImageTexture(Image([[[0.5, 1.0]]]), "nearest"))
    blend = Blend(checks, Blend(Mirror((1.0, 0.5)), Lambertian((0.3, 0.1)), 0.2), 0.7)
    scene = Scene((ball("a", 0, image), ball("b", 1, blend)), VIEW, (POINT,))
    a, b = (surface.material for surface in darker(scene, 0.5).surfaces)
    assert a == Lambertian(ImageTexture(Image([[[0.25, 0.5]]]), "nearest"))
    assert b == Blend(
        Lambertian(Checkerboard((0.4, 0.3), (0.2, 0.1), 3, 2)),
        Blend(Mirror((0.5, 0.25)), Lambertian((0.15, 0.05)), 0.2),
        0.7,
    )
    assert darker(scene, 0.5).lights == (POINT,)


@pytest.mark.parametrize("material", [Dielectric(), Conductor((1.0, 1.0), (2.0, 2.0))])
def test_what_has_no_reflectance_is_refused_by_name(material: object) -> None:
    blend = Blend(Lambertian((0.5, 0.5)), material, 0.5)  # type: ignore[arg-type]
    for part, place in ((material, "material"), (blend, "material.second")):
        with pytest.raises(SceneError, match=rf"surfaces\[1\]\.{place} = '{type(material).__name__}'"):
            darker(Scene((ball("a", 0), ball("b", 1, part)), VIEW, (POINT,)), 0.5)


def test_channels_permuted_and_back() -> None:
    swapped = with_channels(SCENE, (1, 0))
    assert swapped.lights[0] == msgspec.structs.replace(POINT, intensity=(3.0, 1.0))
    assert swapped.surfaces[0].material == Lambertian((0.4, 0.5))
    assert with_channels(swapped, (1, 0)) == SCENE
    assert with_channels(SCENE, (1,)).channels == 1
