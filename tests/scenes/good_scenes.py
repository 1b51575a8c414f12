"""Scenes that hold every type there is, with nothing wrong in them, and how they are refused once something is.

Names such as QUAD and SPOT say where in these scenes a part stands.
"""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

from scenes import (
    AreaLight,
    Blend,
    Checkerboard,
    Conductor,
    ConstantEnvironment,
    Dielectric,
    DirectionalLight,
    Disk,
    Ellipsoid,
    EnvironmentMap,
    Image,
    ImageTexture,
    IrradianceMeter,
    Lambertian,
    Mesh,
    Mirror,
    Orthographic,
    Pinhole,
    PointLight,
    PolarRange,
    Quad,
    RadianceMeter,
    RoughConductor,
    RoughDielectric,
    Scene,
    SceneError,
    Sphere,
    SphericalHarmonicsEnvironment,
    SpotLight,
    Surface,
    ThinLens,
)

GREY = Lambertian((0.5, 0.5, 0.5))
LIGHT = AreaLight((1.0, 2.0, 3.0), PolarRange(10.0, 45.0))
GOOD = Scene(
    (
        Surface("floor", Quad((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), GREY),
        Surface("lamp", Sphere((0.0, 0.0, 3.0), 0.5), GREY, LIGHT),
    ),
    Pinhole((0.0, -4.0, 1.0), (0.0, 0.0, 1.0), (0.0, 0.0, 1.0), 45.0, 8, 6),
)

X, Y, Z, ORIGIN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
RGB, PIXELS = (0.1, 0.2, 0.3), Image([[[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]])
TRIANGLES = Mesh(
    [ORIGIN, X, Y, (1.0, 1.0, 0.0)], [[0, 1, 2], [1, 3, 2]], [Z] * 4, [[0, 0], [1, 0], [0, 1], [1, 1]]
)
RICH = Scene(
    (
        Surface("disk", Disk((0.0, 0.0, 1.0), X, Y), Lambertian(Checkerboard(RGB, RGB, 3, 4))),
        Surface("ellipsoid", Ellipsoid(ORIGIN, X, Y, Z), Dielectric()),
        Surface("mesh", TRIANGLES, Lambertian(ImageTexture(PIXELS)), two_sided=True),
        Surface("mirror", Sphere(X, 0.1), Mirror(RGB)),
        Surface("metal", Sphere(X, 0.2), Conductor(RGB, RGB)),
        Surface("rough", Sphere(X, 0.3), RoughConductor(RGB, RGB, 0.1)),
        Surface("frosted", Sphere(X, 0.4), RoughDielectric(0.1)),
        Surface("blend", Sphere(X, 0.5), Blend(Mirror(RGB), Blend(GREY, Dielectric(), 0.2), 0.3)),
    ),
    ThinLens(ORIGIN, X, Y, 45.0, 8, 6, 0.1, 2.0),
    (
        PointLight(X, RGB),
        SpotLight(X, Y, RGB, 45.0, 30.0),
        DirectionalLight(X, RGB),
        EnvironmentMap(PIXELS),
    ),
)
HARMONICS = Scene(
    (), IrradianceMeter(ORIGIN, Z), (SphericalHarmonicsEnvironment([[1.0], [0.0], [0.5], [0.0]]),)
)
CONSTANT = Scene((), Orthographic(ORIGIN, X, Y, 2.0, 8, 6), (ConstantEnvironment(RGB),))
METER = Scene((), RadianceMeter(ORIGIN, Z), (ConstantEnvironment(RGB),))

QUAD, BALL = "surfaces[0].shape", "surfaces[1].shape"
ALBEDO, LAMP, ZONE = "surfaces[0].material", "surfaces[1].emission", "surfaces[1].emission.polar_range"

DISK, ELLIPSOID, MESH = (f"surfaces[{i}].shape" for i in range(3))
CHECKS, GLASS, TEXTURE, MIRROR, METAL, ROUGH, FROSTED, BLEND = (f"surfaces[{i}].material" for i in range(8))
POINT, SPOT, DIRECTIONAL, MAP = (f"lights[{i}]" for i in range(4))


def document(good: Scene = GOOD, **changes: Any) -> dict[str, Any]:
    """A good scene as a JSON document, with fields changed: ``{"surfaces[0].shape.radius": 0}``."""
    root: dict[str, Any] = json.loads(good.to_json())
    for place, value in changes.items():
        *parents, last = [key or int(index) for key, index in re.findall(r"(\w+)|\[(\d+)\]", place)]
        inner: Any = root
        for key in parents:
            inner = inner[key]
        inner[last] = value
    return root


def refusal(content: dict[str, Any]) -> SceneError:
    with pytest.raises(SceneError) as caught:
        Scene.from_json(json.dumps(content))
    return caught.value
