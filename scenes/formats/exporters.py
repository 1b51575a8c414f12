"""The formats that a scene can be written in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from scenes.formats.export import Export
from scenes.formats.gltf import gltf
from scenes.formats.mitsuba_xml import mitsuba_xml
from scenes.formats.pbrt_v4 import pbrt_v4
from scenes.scene import Scene


def scene_json(scene: Scene, name: str = "scene") -> Export:
    """The scene as this project's own JSON, which has everything."""
    return Export(scene.to_json())


EXPORTERS: Mapping[str, Callable[[Scene, str], Export]] = MappingProxyType(
    {"json": scene_json, "mitsuba-xml": mitsuba_xml, "pbrt-v4": pbrt_v4, "gltf": gltf}
)
"""By the name of the format: (scene, what the names of further files begin with) → files."""

SUFFIXES: Mapping[str, str] = MappingProxyType(
    {"json": ".json", "mitsuba-xml": ".xml", "pbrt-v4": ".pbrt", "gltf": ".gltf"}
)
