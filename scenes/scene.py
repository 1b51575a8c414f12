"""A scene: surfaces, lights and a sensor. Frozen, validated, JSON in and out."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path
from typing import Any, get_args

import msgspec

from scenes.channels import check_channels
from scenes.coincidence import check_coincidence
from scenes.images import Image
from scenes.lights import Emission, Environment, Light, PolarRange, emits
from scenes.materials import Material, Texture
from scenes.sensor import Sensor
from scenes.shapes import Shape
from scenes.surfaces import Surface
from scenes.validation import SceneError, instance, path


class Scene(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """What is rendered.

    Attributes:
        surfaces: their names are unique.
        sensor: where the image is taken.
        lights: what emits without being a surface; at most one of them is an environment.

    At least one surface or light emits; all have the same number of channels.
    """

    surfaces: tuple[Surface, ...]
    sensor: Sensor
    lights: tuple[Light, ...] = ()

    def __post_init__(self) -> None:
        instance(self, "sensor", Sensor, "a sensor")
        self._check_parts()
        names: set[str] = set()
        for i, surface in enumerate(self.surfaces):
            if surface.name in names:
                raise SceneError(
                    path(self, f"surfaces[{i}].name"), surface.name, "a name no other surface has"
                )
            names.add(surface.name)
        environments = [i for i, light in enumerate(self.lights) if isinstance(light, Environment)]
        if len(environments) > 1:
            place = f"lights[{environments[1]}]"
            raise SceneError(path(self, place), self.lights[environments[1]], "no second environment")
        if not any(s.emits for s in self.surfaces) and not any(map(emits, self.lights)):
            found = [*sorted(names), *(type(light).__name__ for light in self.lights)]
            raise SceneError(path(self, "surfaces"), found, "at least one surface or light with emission > 0")
        check_coincidence(self.surfaces)

    def _check_parts(self) -> None:
        """Freeze surfaces and lights; refuse what is none, and parts whose channels differ."""
        for field, kind, expected in (("surfaces", Surface, "a Surface"), ("lights", Light, "a light")):
            if not isinstance(getattr(self, field), list | tuple):
                raise SceneError(path(self, field), getattr(self, field), f"a list of {field}")
            parts = tuple(getattr(self, field))
            msgspec.structs.force_setattr(self, field, parts)
            for i, part in enumerate(parts):
                if not isinstance(part, kind):
                    raise SceneError(path(self, f"{field}[{i}]"), part, expected)
        check_channels(
            (path(self, f"{field}[{i}]"), part)
            for field in ("surfaces", "lights")
            for i, part in enumerate(getattr(self, field))
        )

    @property
    def channels(self) -> int:
        """How many channels radiance has in this scene."""
        # there is one: something emits, and emission has channels
        return next(part.channels for part in (*self.surfaces, *self.lights) if part.channels is not None)

    @property
    def environment(self) -> Environment | None:
        """What is seen where no surface is; None for black."""
        return next((light for light in self.lights if isinstance(light, Environment)), None)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Of one image: (height, width, channels)."""
        return self.sensor.height, self.sensor.width, self.channels

    def resized(self, width: int, height: int) -> Scene:
        """The same scene seen through more or fewer pixels; ``fov`` stays that of the smaller axis.

        Raises:
            SceneError: the sensor is a meter, which has one pixel, and more are asked for.
        """
        return msgspec.structs.replace(
            self, sensor=msgspec.structs.replace(self.sensor, width=width, height=height)
        )

    def to_json(self) -> bytes:
        """The scene as JSON, indented."""
        return msgspec.json.format(msgspec.json.encode(self), indent=2) + b"\n"

    @property
    def sha256(self) -> str:
        """The SHA-256 of ``to_json``, in hexadecimal: whether a file belongs to this scene."""
        return hashlib.sha256(self.to_json()).hexdigest()

    @classmethod
    def from_json(cls, content: bytes | str) -> Scene:
        """Read a scene.

        Raises:
            SceneError: no JSON, a field of the wrong type, or a value that can't be; with the field's path.
        """
        try:
            # the standard reader lets NaN and Infinity pass, so that the checks can say where they stand
            document = json.loads(content)
        except json.JSONDecodeError as error:
            line = error.doc.splitlines()[error.lineno - 1 : error.lineno]
            raise SceneError("scene", "".join(line).strip(), f"JSON ({error})") from None
        except (ValueError, RecursionError) as error:
            raise SceneError("scene", content[:40], f"JSON ({error})") from None
        if isinstance(document, dict) and isinstance(document.get("$schema"), str):
            del document["$schema"]  # by which editors know what to check
        try:
            return msgspec.convert(document, type=cls)
        except msgspec.ValidationError as error:
            raise _located(error, document) from None
        except RecursionError:
            raise SceneError("scene", content[:40], "blends in fewer levels") from None

    @classmethod
    def load(cls, file: Path | str) -> Scene:
        """Read a scene from a JSON file; see ``from_json``."""
        return cls.from_json(Path(file).read_bytes())


def _located(error: msgspec.ValidationError, document: object) -> SceneError:
    """The error with the path and the value of the field in the document that it speaks of."""
    message, _, place = str(error).partition(" - at `")
    parent = place.removeprefix("$").removeprefix(".").removesuffix("`")
    if isinstance(error.__cause__, SceneError):
        return error.__cause__.below(parent)
    if unknown := re.search("unknown field `(.*)`", message):
        place, owner = f"{parent}.{unknown[1]}".removeprefix("."), _at(document, parent)
        fields = ", ".join(_kind(parent, owner).__struct_fields__)
        return SceneError(place, owner[unknown[1]], f"no field of that name; there are {fields}")
    expected = _plain(message.removeprefix("Expected "), _at(document, parent))
    if missing := re.search("missing required field `(.*)`", message):
        expected = f"an object with the field {missing[1]}"
    elif message.startswith("Invalid value"):
        expected = "one of " + ", ".join(str(kind.__struct_config__.tag) for kind in _kinds(parent))
    return SceneError(parent or "scene", _at(document, parent), expected)


_NAMES = {
    "object": "an object",
    "array": "a list",
    "float": "a number",
    "int": "a whole number",
    "str": "a text",
    "bool": "true or false",
    "null": "null",
}
"""What a reader of JSON calls the types of msgspec."""


def _plain(expected: str, found: object) -> str:
    """The types msgspec names, in words; with an example where one number stands for a list of them."""
    match = re.fullmatch("`([a-z |]+)`, got `[a-z]+`", expected)
    if match is None or not set(match[1].split(" | ")) <= _NAMES.keys():
        return expected
    words = " or ".join(_NAMES[kind] for kind in match[1].split(" | "))
    alone = isinstance(found, int | float) and not isinstance(found, bool) and words.endswith("a list")
    return f"{words}, such as [{found}, {found}, {found}]" if alone else words


_PARTS: dict[str, Any] = {
    "surfaces": Surface,
    "shape": Shape,
    "material": Material,
    "first": Material,
    "second": Material,
    "albedo": Texture,
    "image": Image,
    "emission": Emission,
    "polar_range": PolarRange,
    "sensor": Sensor,
    "lights": Light,
}
"""What stands in a field of that name."""


def _kinds(place: str) -> tuple[type[msgspec.Struct], ...]:
    """What may stand at a path such as ``surfaces[3].material`` or ``surfaces[3].material.type``."""
    *_, last = [name for name in re.findall(r"[a-z_]+", place) if name != "type"] or ["scene"]
    kinds = _PARTS.get(last, Scene)
    return get_args(kinds) or (kinds,)


def _kind(place: str, found: dict[str, Any]) -> type[msgspec.Struct]:
    """Which of them it is: by its type where there are several."""
    kinds = _kinds(place)
    return next((kind for kind in kinds if kind.__struct_config__.tag == found.get("type")), kinds[0])


def _at(document: Any, place: str) -> Any:
    """The value at a path such as ``surfaces[3].material``."""
    for key, index in re.findall(r"([^.\[\]]+)|\[(\d+)\]", place):
        document = document[int(index)] if index else document[key]
    return document
