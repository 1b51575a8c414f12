from __future__ import annotations

import pytest

from scenes import (
    AreaLight,
    Blend,
    Checkerboard,
    Dielectric,
    Lambertian,
    Mesh,
    PointLight,
    PolarRange,
    Quad,
    RadianceMeter,
    Scene,
    Sphere,
    Surface,
    library,
)
from scenes.features import features


def test_each_part_is_named_once() -> None:
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    chequers = Lambertian(Checkerboard((0.5,), (0.1,)))
    scene = Scene(
        (
            Surface(
                "a", Mesh(corners, [(0, 1, 2)], normals=[(0, 0, 1)] * 3), Lambertian((0.5,)), two_sided=True
            ),
            Surface("b", Sphere((0, 0, 5), 1, inward=True), Blend(chequers, Dielectric(1.5), 0.5)),
            Surface("c", Sphere((0, 9, 5), 1), chequers, AreaLight((1,), PolarRange(0, 30), ((1,), (2,)))),
            Surface("d", Quad((0, 0, -1), (1, 0, 0), (0, 1, 0)), chequers, AreaLight((0,))),
        ),
        RadianceMeter((0, 0, 3), (0, 0, -1)),
        (PointLight((0, 0, 2), (1,)), PointLight((0, 0, 2.5), (1,))),
    )
    assert features(scene) == (
        "mesh",
        "shading normals",
        "sphere",
        "inward",
        "quad",
        "lambertian",
        "blend",
        "checkerboard texture",
        "dielectric",
        "two_sided",
        "area",
        "polar_range",
        "angular_profile",
        "point",
        "radiance_meter",
        "1 channel",
    )


@pytest.mark.parametrize("name", library.CASES)
def test_every_case_has_some(name: str) -> None:
    scene = library.case(name).scene
    assert scene.sensor.__struct_config__.tag in features(scene)
