"""Variations of a scene: some of its emitters alone, all of them brighter, every surface darker.

Each leaves G as it is: shapes and sensor stay.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, TypeVar

import msgspec
import numpy as np

from scenes.lights import Light, emits
from scenes.materials import Blend, Lambertian, Material, Mirror
from scenes.scene import Scene
from scenes.validation import SceneError

Part = TypeVar("Part", bound=msgspec.Struct)

_NUMBERS = ("albedo", "even", "odd", "reflectance", "radiance", "intensity", "irradiance")
_TABLES = ("coefficients", "pixels")
_replace = msgspec.structs.replace


def emitters(scene: Scene) -> list[str]:
    """Names of what emits: surfaces by their own name, then the others, as ``lights[0]``."""
    lights = [f"lights[{i}]" for i, light in enumerate(scene.lights) if emits(light)]
    return [surface.name for surface in scene.surfaces if surface.emits] + lights


def with_emitters(scene: Scene, names: Collection[str]) -> Scene:
    """The scene in which only these emit; surfaces stay where they are, dark.

    Args:
        scene: whatever emits there.
        names: as in ``emitters``, at least one of them.
    """
    return _replace(
        scene,
        surfaces=tuple(s if s.name in names else _replace(s, emission=None) for s in scene.surfaces),
        lights=tuple(light for i, light in enumerate(scene.lights) if f"lights[{i}]" in names),
    )


def lit_by(scene: Scene, light: Light) -> Scene:
    """The scene in which nothing but this light emits."""
    return _replace(
        scene, surfaces=tuple(_replace(s, emission=None) for s in scene.surfaces), lights=(light,)
    )


def brighter(scene: Scene, factor: float) -> Scene:
    """The scene with factor × the emission of everything."""
    surfaces = tuple(
        s if s.emission is None else _replace(s, emission=_scaled(s.emission, factor)) for s in scene.surfaces
    )
    return _replace(scene, surfaces=surfaces, lights=tuple(_scaled(light, factor) for light in scene.lights))


def darker(scene: Scene, factor: float) -> Scene:
    """The scene with factor × every reflectance: R becomes factor · R, so TᵏE becomes factorᵏ · TᵏE.

    Raises:
        SceneError: a material has no reflectance to scale, since Fresnel's equations say how much it reflects.
    """
    surfaces = tuple(
        _replace(s, material=_darker(s.material, factor, f"surfaces[{i}].material"))
        for i, s in enumerate(scene.surfaces)
    )
    return _replace(scene, surfaces=surfaces)


def black(scene: Scene) -> Scene:
    """The scene in which nothing reflects: R = 0, so that E is all its light; any material can be that."""
    none = Lambertian((0.0,) * scene.channels)
    return _replace(scene, surfaces=tuple(_replace(s, material=none) for s in scene.surfaces))


def _darker(material: Material, factor: float, place: str) -> Material:
    match material:
        case Lambertian() | Mirror():
            return _scaled(material, factor)
        case Blend():
            first, second = (
                _darker(getattr(material, part), factor, f"{place}.{part}") for part in ("first", "second")
            )
            return _replace(material, first=first, second=second)
        case _:
            expected = "a material with an albedo or a reflectance that can be scaled"
            raise SceneError(place, type(material).__name__, expected)


def _scaled(part: Part, factor: float) -> Part:
    """A light or a material with all its numbers per channel multiplied."""
    changes: dict[str, Any] = {}
    for field in part.__struct_fields__:
        value = getattr(part, field)
        if field in _NUMBERS and isinstance(value, tuple):
            changes[field] = tuple(factor * number for number in value)
        elif field in _TABLES:
            changes[field] = (factor * np.array(value)).tolist()
        elif isinstance(value, msgspec.Struct):
            changes[field] = _scaled(value, factor)
    return _replace(part, **changes)
