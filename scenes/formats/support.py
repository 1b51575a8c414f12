"""What each format can express: every kind of shape, material, light and sensor, tried in a small scene."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from typing import Any

import msgspec

from scenes.formats.export import UnsupportedFeatureError
from scenes.formats.exporters import EXPORTERS
from scenes.images import Image
from scenes.lights import (
    AreaLight,
    ConstantEnvironment,
    DirectionalLight,
    EnvironmentMap,
    PointLight,
    SphericalHarmonicsEnvironment,
    SpotLight,
)
from scenes.materials import (
    Blend,
    Checkerboard,
    Conductor,
    Dielectric,
    ImageTexture,
    Lambertian,
    Mirror,
    RoughConductor,
    RoughDielectric,
)
from scenes.scene import Scene
from scenes.sensor import IrradianceMeter, Orthographic, Pinhole, RadianceMeter, ThinLens
from scenes.shapes import Disk, Ellipsoid, Mesh, Quad, Sphere
from scenes.surfaces import Surface

_ONE, _HALF = (1.0, 1.0, 1.0), (0.5, 0.5, 0.5)
_UP, _VIEW = (0.0, 1.0, 0.0), ((0.0, 0.0, 3.0), (0.0, 0.0, 0.0))
_GREY = Lambertian(_HALF)
_PIXELS = Image(((_ONE, _HALF), (_HALF, _ONE)))
_LAMP = PointLight((0.0, 0.0, 2.0), _ONE)

_SHAPES = (
    Quad((-1.0, -1.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0)),
    Disk((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    Sphere((0.0, 0.0, 0.0), 1.0),
    Ellipsoid((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, 0.0, 1.0)),
    Mesh(((-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (0.0, 1.0, 0.0)), ((0, 1, 2),)),
)
_MATERIALS = (
    _GREY,
    Lambertian(Checkerboard(_ONE, _HALF)),
    Lambertian(ImageTexture(_PIXELS)),
    Mirror(_HALF),
    Dielectric(),
    Conductor(_ONE, _ONE),
    *(RoughConductor(_ONE, _ONE, 0.3, shadowing=s) for s in ("separable", "correlated")),
    *(RoughDielectric(0.3, shadowing=s) for s in ("separable", "correlated")),
    Blend(_GREY, Lambertian(_ONE), 0.5),
)
_LIGHTS = (
    AreaLight(_ONE),
    _LAMP,
    SpotLight((0.0, 0.0, 2.0), (0.0, 0.0, -1.0), _ONE, 30.0, 20.0),
    SpotLight((0.0, 0.0, 2.0), (0.0, 0.0, -1.0), _ONE, 30.0, 30.0),
    DirectionalLight((0.0, 0.0, -1.0), _ONE),
    ConstantEnvironment(_ONE),
    EnvironmentMap(_PIXELS),
    SphericalHarmonicsEnvironment((_ONE,)),
)
_SENSORS = (
    Pinhole(*_VIEW, _UP, 40.0, 4, 4),
    ThinLens(*_VIEW, _UP, 40.0, 4, 4, 0.1, 3.0),
    Orthographic(*_VIEW, _UP, 2.0, 4, 4),
    RadianceMeter((0.0, 0.0, 3.0), (0.0, 0.0, -1.0)),
    IrradianceMeter((0.0, 0.0, 3.0), (0.0, 0.0, -1.0)),
)


@lru_cache(maxsize=8)
def expressible(format: str) -> Mapping[str, tuple[str, ...]]:
    """What a format in ``EXPORTERS`` takes: ``shapes``, ``materials``, ``lights``, ``sensors``, named as in JSON.

    A kind counts if one of its simplest forms is taken; a scene may still hold a form that is not (an ellipse, a
    shading normal), and exporting it says so.
    """
    return {
        "shapes": _taken(format, ((shape, _scene(shape=shape)) for shape in _SHAPES)),
        "materials": _taken(format, ((material, _scene(material=material)) for material in _MATERIALS)),
        "lights": _taken(format, ((light, _scene(light=light)) for light in _LIGHTS)),
        "sensors": _taken(format, ((sensor, _scene(sensor=sensor)) for sensor in _SENSORS)),
    }


def _scene(
    shape: Any = _SHAPES[0], material: Any = _GREY, light: Any = _LAMP, sensor: Any = _SENSORS[0]
) -> Scene:
    emission, lights = (light, ()) if isinstance(light, AreaLight) else (None, (light,))
    return Scene((Surface("surface", shape, material, emission),), sensor, lights)


def _taken(format: str, tried: Iterable[tuple[msgspec.Struct, Scene]]) -> tuple[str, ...]:
    def names() -> Iterator[str]:
        for part, scene in tried:
            try:
                EXPORTERS[format](scene, "x")
            except UnsupportedFeatureError:
                continue
            yield _name(part)

    return tuple(dict.fromkeys(names()))


def _name(part: msgspec.Struct) -> str:
    if isinstance(part, Lambertian) and not isinstance(part.albedo, tuple):
        return f"{_name(part.albedo)} texture"
    return str(part.__struct_config__.tag)
