"""Faults that another scene is rendered than the one that was asked for: in every surface, material or light of it.

Any renderer can have them; they are what goes wrong where a scene is exported.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Plant
from comparisons.faults.planting import of_scene
from scenes import AreaLight, Blend, Checkerboard, Image, ImageTexture, Lambertian, Scene, Surface

Array = NDArray[np.float64]
replace = msgspec.structs.replace


def of_surfaces(change: Callable[[Surface], Surface]) -> Plant:
    """Every surface is another one."""
    return of_scene(lambda scene: _with_surfaces(scene, change))


def of_area_lights(change: Callable[[AreaLight], AreaLight]) -> Plant:
    """Surfaces emit in another way."""

    def changed(surface: Surface) -> Surface:
        return replace(surface, emission=change(surface.emission)) if surface.emission else surface

    return of_surfaces(changed)


def of_lights(*kinds: type, change: Callable[[Any], Any]) -> Plant:
    """The lights of these types that are no surfaces are others."""

    def changed(scene: Scene) -> Scene:
        lights = tuple(change(light) if isinstance(light, kinds) else light for light in scene.lights)
        return replace(scene, lights=lights)

    return of_scene(changed)


def of_materials(*kinds: type, change: Callable[[Any], Any]) -> Plant:
    """The materials of these types are others, in blends as well."""

    def changed(material: Any) -> Any:
        if isinstance(material, Blend):
            material = replace(material, first=changed(material.first), second=changed(material.second))
        return change(material) if isinstance(material, kinds) else material

    return of_surfaces(lambda surface: replace(surface, material=changed(surface.material)))


def of_albedos(change: Callable[[Array], Array]) -> Plant:
    """Albedos are others, those in textures as well; the last axis has the channels."""

    def numbers(values: Any) -> Any:
        return change(np.array(values)).tolist()

    def changed(material: Lambertian) -> Lambertian:
        match material.albedo:
            case Checkerboard(even=even, odd=odd):
                return Lambertian(replace(material.albedo, even=numbers(even), odd=numbers(odd)))
            case ImageTexture(image=image):
                return Lambertian(replace(material.albedo, image=Image(numbers(image.pixels))))
            case albedo:
                return Lambertian(numbers(albedo))

    return of_materials(Lambertian, change=changed)


def _with_surfaces(scene: Scene, change: Callable[[Surface], Surface]) -> Scene:
    return replace(scene, surfaces=tuple(change(surface) for surface in scene.surfaces))
