"""What a renderer has to have for a scene: derived from its parts."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from scenes.materials import Blend, Lambertian, Material
from scenes.scene import Scene
from scenes.shapes import Ellipsoid, Mesh, Sphere
from scenes.surfaces import Surface


def features(scene: Scene) -> tuple[str, ...]:
    """Names as in JSON: of shapes, materials, textures, lights and the sensor, and what is special about them.

    In this order, each once: ``("quad", "lambertian", "area", "pinhole")``.
    """
    parts = [list(_shapes(s)) for s in scene.surfaces]
    parts += [list(_materials(s.material)) for s in scene.surfaces]
    parts += [["two_sided"] for s in scene.surfaces if s.two_sided]
    parts += [list(_emission(s)) for s in scene.surfaces if s.emits]
    parts += [[_tag(light)] for light in scene.lights]
    parts += [[_tag(scene.sensor)]]
    if scene.channels != 3:
        parts += [[f"{scene.channels} channel{'s' if scene.channels > 1 else ''}"]]
    return tuple(dict.fromkeys(name for names in parts for name in names))


def _tag(part: msgspec.Struct) -> str:
    return str(part.__struct_config__.tag)


def _shapes(surface: Surface) -> Iterator[str]:
    yield _tag(surface.shape)
    if isinstance(surface.shape, Sphere | Ellipsoid) and surface.shape.inward:
        yield "inward"
    if isinstance(surface.shape, Mesh) and surface.shape.normals is not None:
        yield "shading normals"


def _materials(material: Material) -> Iterator[str]:
    yield _tag(material)
    if isinstance(material, Blend):
        yield from _materials(material.first)
        yield from _materials(material.second)
    elif isinstance(material, Lambertian) and not isinstance(material.albedo, tuple):
        yield f"{_tag(material.albedo)} texture"


def _emission(surface: Surface) -> Iterator[str]:
    assert surface.emission is not None
    yield _tag(surface.emission)
    if surface.emission.polar_range is not None:
        yield "polar_range"
    if surface.emission.angular_profile is not None:
        yield "angular_profile"
