"""The formats that a scene can be written in."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Protocol

from scenes.formats.export import UNKNOWN, Export, Source
from scenes.formats.gltf import gltf
from scenes.formats.mitsuba_xml import mitsuba_xml
from scenes.formats.pbrt_v4 import pbrt_v4
from scenes.scene import Scene


class Exporter(Protocol):
    """Writes scenes in one format."""

    def __call__(self, scene: Scene, name: str = "scene", source: Source = UNKNOWN) -> Export:
        """The files.

        Args:
            scene: the scene.
            name: what the names of further files begin with.
            source: where the scene comes from, for the header.

        Raises:
            UnsupportedFeatureError: naming what the format lacks, or means differently.
        """


def scene_json(scene: Scene, name: str = "scene", source: Source = UNKNOWN) -> Export:
    """The scene as this project's own JSON, which has everything, and nothing else: no header."""
    return Export(scene.to_json())


EXPORTERS: Mapping[str, Exporter] = MappingProxyType(
    {"json": scene_json, "mitsuba-xml": mitsuba_xml, "pbrt-v4": pbrt_v4, "gltf": gltf}
)
"""By the name of the format."""

SUFFIXES: Mapping[str, str] = MappingProxyType(
    {"json": ".json", "mitsuba-xml": ".xml", "pbrt-v4": ".pbrt", "gltf": ".gltf"}
)
