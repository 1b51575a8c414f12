"""A scene: surfaces and a sensor. Frozen, validated, JSON in and out."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import msgspec

from scenes.sensor import Sensor
from scenes.surfaces import Surface
from scenes.validation import SceneError, instance, path


class Scene(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What is rendered.

    Attributes:
        surfaces: at least one of them emits; names are unique; all have the same number of channels.
        sensor: where the image is taken.
    """

    surfaces: tuple[Surface, ...]
    sensor: Sensor

    def __post_init__(self) -> None:
        msgspec.structs.force_setattr(self, "surfaces", tuple(self.surfaces))
        names: set[str] = set()
        instance(self, "sensor", Sensor, "a sensor")
        for i, surface in enumerate(self.surfaces):
            if not isinstance(surface, Surface):
                raise SceneError(path(self, f"surfaces[{i}]"), surface, "a Surface")
            if surface.name in names:
                raise SceneError(
                    path(self, f"surfaces[{i}].name"), surface.name, "a name no other surface has"
                )
            names.add(surface.name)
            albedo = surface.material.albedo
            if len(albedo) != self.channels:
                expected = f"{self.channels} channels, as surfaces[0] has"
                raise SceneError(path(self, f"surfaces[{i}].material.albedo"), albedo, expected)
        if not any(surface.emits for surface in self.surfaces):
            raise SceneError(path(self, "surfaces"), sorted(names), "at least one surface with emission > 0")

    @property
    def channels(self) -> int:
        """How many channels radiance has in this scene."""
        return len(self.surfaces[0].material.albedo)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Of one image: (height, width, channels)."""
        return self.sensor.height, self.sensor.width, self.channels

    def resized(self, width: int, height: int) -> Scene:
        """The same scene seen through more or fewer pixels; ``fov`` stays that of the smaller axis."""
        return msgspec.structs.replace(
            self, sensor=msgspec.structs.replace(self.sensor, width=width, height=height)
        )

    def to_json(self) -> bytes:
        """The scene as JSON, indented."""
        return msgspec.json.format(msgspec.json.encode(self), indent=2) + b"\n"

    @classmethod
    def from_json(cls, content: bytes | str) -> Scene:
        """Read a scene.

        Raises:
            SceneError: no JSON, a field of the wrong type, or a value that can't be; with the field's path.
        """
        try:
            # the standard reader lets NaN and Infinity pass, so that the checks can say where they stand
            document = json.loads(content)
        except (ValueError, RecursionError) as error:
            raise SceneError("scene", content[:40], f"JSON ({error})") from None
        try:
            return msgspec.convert(document, type=cls)
        except msgspec.ValidationError as error:
            raise _located(error, document) from None

    @classmethod
    def load(cls, file: Path) -> Scene:
        """Read a scene from a JSON file; see ``from_json``."""
        return cls.from_json(file.read_bytes())


def _located(error: msgspec.ValidationError, document: object) -> SceneError:
    """The error with the path and the value of the field in the document that it speaks of."""
    message, _, place = str(error).partition(" - at `")
    parent = place.removeprefix("$").removeprefix(".").removesuffix("`")
    if isinstance(error.__cause__, SceneError):
        return error.__cause__.below(parent)
    if unknown := re.search("unknown field `(.*)`", message):
        place = f"{parent}.{unknown[1]}".removeprefix(".")
        return SceneError(place, _at(document, parent)[unknown[1]], "no field of that name")
    expected = message.removeprefix("Expected ")
    if missing := re.search("missing required field `(.*)`", message):
        expected = f"an object with the field {missing[1]}"
    elif message.startswith("Invalid value"):
        expected = "a type that exists"
    return SceneError(parent or "scene", _at(document, parent), expected)


def _at(document: Any, place: str) -> Any:
    """The value at a path such as ``surfaces[3].material``."""
    for key, index in re.findall(r"([^.\[\]]+)|\[(\d+)\]", place):
        document = document[int(index)] if index else document[key]
    return document
