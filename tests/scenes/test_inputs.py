"""Unusual input: dark scenes, NumPy's numbers, sizes beyond floats, deep nests, long lists."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from scenes import (
    ConstantEnvironment,
    Dielectric,
    DirectionalLight,
    Disk,
    Ellipsoid,
    EnvironmentMap,
    Image,
    Lambertian,
    Mesh,
    Pinhole,
    PointLight,
    Quad,
    RadianceMeter,
    Scene,
    SceneError,
    Sphere,
    SphericalHarmonicsEnvironment,
    Surface,
)

X, Y, Z, ORIGIN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
SQUARE = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 1.0, 0.0)]
METER, SKY = RadianceMeter(ORIGIN, Z), (ConstantEnvironment((0.1, 0.2, 0.3)),)


def test_glass_alone_is_dark() -> None:
    """No part of such a scene has channels at all."""
    glass = (Surface("glass", Sphere(ORIGIN, 1.0), Dielectric()),)
    with pytest.raises(
        SceneError, match=r"Scene\.surfaces = \['glass'\]: expected at least one surface or light"
    ):
        Scene(glass, METER)
    assert Scene(glass, METER, SKY).channels == 3


@pytest.mark.parametrize(
    "dark",
    [
        PointLight(X, (0.0,)),
        DirectionalLight(X, (0.0,)),
        ConstantEnvironment((0.0,)),
        EnvironmentMap(Image([[[0.0]]])),
        SphericalHarmonicsEnvironment([[0.0]]),
    ],
    ids=lambda light: type(light).__name__,
)
def test_some_light_must_emit(dark: Any) -> None:
    with pytest.raises(SceneError, match="emission > 0"):
        Scene((), METER, (dark,))
    assert Scene((), METER, (dark, PointLight(X, (1.0,)))).channels == 1


def test_triangles_with_the_same_numbers_are_not_the_same() -> None:
    """The coordinates x, y of both triangles are 0, 1, 2, in another order."""
    vertices = [(0, 1, 0), (1, 0, 0), (2, 2, 0), (0, 2, 1), (1, 0, 1), (2, 1, 1)]
    assert Mesh(vertices, [(0, 1, 2), (3, 4, 5)]).area == pytest.approx(3.0)


@pytest.mark.parametrize("size", [1e-320, 1e-200, 1e160, 1e300])
def test_sizes_beyond_floats_make_no_warning(size: float) -> None:
    x, y, z = (size, 0.0, 0.0), (0.0, size, 0.0), (0.0, 0.0, size)
    for make in (
        lambda: Quad(ORIGIN, x, y),
        lambda: Disk(ORIGIN, x, y),
        lambda: Ellipsoid(ORIGIN, x, y, z),
        lambda: Sphere(ORIGIN, size),
        lambda: Mesh([ORIGIN, x, y], [(0, 1, 2)]),
    ):
        with pytest.raises(SceneError):
            make()


@pytest.mark.parametrize("levels", [300, 990, 20_000])
def test_blends_in_many_levels(levels: int) -> None:
    glass = '{"type": "dielectric"}'
    blend = f'{{"type": "blend", "weight": 0.5, "first": {glass}, "second": ' * levels + glass + "}" * levels
    scene = Scene([Surface("glass", Sphere(ORIGIN, 1.0), Dielectric())], METER, SKY)
    content = re.sub(r'"material": {.*?}', f'"material": {blend}', scene.to_json().decode(), flags=re.DOTALL)
    if levels == 300:
        assert Scene.from_json(Scene.from_json(content).to_json()).channels == 3
    else:
        with pytest.raises(SceneError, match="scene = "):
            Scene.from_json(content)


def test_a_long_value_is_shortened() -> None:
    with pytest.raises(SceneError) as caught:
        Mesh(SQUARE, [(0, 1, 2)], uv=[(0.0, 0.0)] * 5000)
    message = str(caught.value)
    assert message.startswith("Mesh.uv = [(0.0, 0.0), ")
    assert message.endswith("(60000 characters): expected a list of 4")
    assert len(message) < 400


def test_numpy_goes_in_and_plain_numbers_come_out() -> None:
    mesh = Mesh(np.array(SQUARE, dtype=np.float32), np.array([[0, 1, 2], [1, 3, 2]], dtype=np.uint8))
    assert mesh == Mesh(SQUARE, [[0, 1, 2], [1, 3, 2]])
    assert hash(mesh) == hash(Mesh(SQUARE, [[0, 1, 2], [1, 3, 2]]))
    assert all(type(i) is int for triangle in mesh.triangles for i in triangle)
    camera = Pinhole(np.zeros(3), X, Y, np.float32(45), np.int64(8), np.int16(6))
    assert (type(camera.width), type(camera.height), type(camera.fov)) == (int, int, float)
    assert type(Sphere(ORIGIN, np.array(2.0)).radius) is float
    with pytest.raises(SceneError):
        Lambertian(np.array([[0.5]]))
    with pytest.raises(SceneError):
        Sphere(ORIGIN, np.bool_(True))
    with pytest.raises(SceneError):
        Sphere(ORIGIN, np.complex128(1 + 2j))
