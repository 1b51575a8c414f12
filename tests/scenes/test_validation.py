"""Bad input is refused with the path and the value of the field, the same from Python as from JSON."""

from __future__ import annotations

import json
import math
import pickle
import re
from typing import Any, NamedTuple

import msgspec
import pytest

from scenes import AreaLight, Lambertian, Pinhole, PolarRange, Quad, Scene, SceneError, Sphere, Surface

GREY = Lambertian((0.5, 0.5, 0.5))
LIGHT = AreaLight((1.0, 2.0, 3.0), PolarRange(10.0, 45.0))
GOOD = Scene(
    (
        Surface("floor", Quad((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), GREY),
        Surface("lamp", Sphere((0.0, 0.0, 3.0), 0.5), GREY, LIGHT),
    ),
    Pinhole((0.0, -4.0, 1.0), (0.0, 0.0, 1.0), (0.0, 0.0, 1.0), 45.0, 8, 6),
)
QUAD, BALL = "surfaces[0].shape", "surfaces[1].shape"
ALBEDO, LAMP, ZONE = "surfaces[0].material", "surfaces[1].emission", "surfaces[1].emission.polar_range"
NAN, INF = math.nan, math.inf


class Bad(NamedTuple):
    """A value that some field of the good scene can't have.

    Attributes:
        parent, field: where it stands.
        value: what is put there.
        index: the component that is wrong, where it is one.
    """

    parent: str
    field: str
    value: Any
    index: int | None = None

    @property
    def tail(self) -> str:
        return self.field if self.index is None else f"{self.field}[{self.index}]"

    @property
    def found(self) -> Any:
        return self.value if self.index is None else self.value[self.index]


BAD = [
    Bad(QUAD, "edge_v", [2.0, 0.0, 0.0]),
    Bad(QUAD, "edge_v", [-1.0, 1e-10, 0.0]),
    Bad(QUAD, "edge_v", [0.0, 0.0, 0.0]),
    Bad(QUAD, "edge_v", [0.0, 1.0]),
    Bad(QUAD, "edge_u", [1.0, NAN, 0.0], 1),
    Bad(QUAD, "corner", [0.0, 0.0, -INF], 2),
    Bad(QUAD, "corner", ["0", 0.0, 0.0], 0),
    Bad(QUAD, "corner", "origin"),
    Bad(BALL, "center", [INF, 0.0, 0.0], 0),
    Bad(BALL, "radius", 0.0),
    Bad(BALL, "radius", -1.0),
    Bad(BALL, "radius", NAN),
    Bad(BALL, "radius", INF),
    Bad(BALL, "radius", "1"),
    Bad(BALL, "radius", None),
    Bad(BALL, "radius", True),
    Bad(BALL, "radius", 10**400),
    Bad(BALL, "inward", 1),
    Bad(ALBEDO, "albedo", [-0.1, 0.5, 0.5], 0),
    Bad(ALBEDO, "albedo", [0.5, 1.001, 0.5], 1),
    Bad(ALBEDO, "albedo", [0.5, 0.5, NAN], 2),
    Bad(ALBEDO, "albedo", [0.5, INF, 0.5], 1),
    Bad(ALBEDO, "albedo", [0.5, 10**400, 0.5], 1),
    Bad(ALBEDO, "albedo", [0.5, True, 0.5], 1),
    Bad(ALBEDO, "albedo", ["a", 0.5, 0.5], 0),
    Bad(ALBEDO, "albedo", []),
    Bad(ALBEDO, "albedo", 0.5),
    Bad(ALBEDO, "albedo", "grey"),
    Bad(LAMP, "radiance", [1.0, -1e-9, 1.0], 1),
    Bad(LAMP, "radiance", [1.0, 1.0, NAN], 2),
    Bad(LAMP, "radiance", [INF, 1.0, 1.0], 0),
    Bad(LAMP, "radiance", []),
    Bad(LAMP, "polar_range", 45.0),
    Bad(ZONE, "low", -1.0),
    Bad(ZONE, "low", NAN),
    Bad(ZONE, "low", "10"),
    Bad(ZONE, "high", 10.0),  # equal to low
    Bad(ZONE, "high", 5.0),  # below low
    Bad(ZONE, "high", 180.5),
    Bad(ZONE, "high", INF),
    Bad(ZONE, "axis", [0.0, 0.0, 0.0]),
    Bad(ZONE, "axis", [0.0, NAN, 1.0], 1),
    Bad("sensor", "origin", [0.0, INF, 0.0], 1),
    Bad("sensor", "target", [0.0, -4.0, 1.0]),  # the origin
    Bad("sensor", "up", [0.0, 2.0, 0.0]),  # parallel to the view
    Bad("sensor", "up", [0.0, -2.0, 1e-12]),  # as good as parallel
    Bad("sensor", "up", [0.0, 0.0, 0.0]),
    Bad("sensor", "fov", 0.0),
    Bad("sensor", "fov", 180.0),
    Bad("sensor", "fov", -30.0),
    Bad("sensor", "fov", NAN),
    Bad("sensor", "fov", "wide"),
    Bad("sensor", "width", 0),
    Bad("sensor", "height", -3),
    Bad("sensor", "width", 2.5),
    Bad("sensor", "height", "64"),
    Bad("sensor", "height", True),
    Bad("surfaces[0]", "name", ""),
    Bad("surfaces[0]", "name", 7),
    Bad("surfaces[0]", "shape", None),
    Bad("surfaces[0]", "material", "white"),
    Bad("surfaces[0]", "emission", 1.0),
    Bad("", "sensor", None),
]


def part(parent: str) -> Any:
    """The piece of the good scene at a path such as ``surfaces[0].shape``."""
    found: Any = GOOD
    for key, index in re.findall(r"(\w+)(?:\[(\d+)\])?", parent):
        found = getattr(found, key)[int(index)] if index else getattr(found, key)
    return found


def document(**changes: Any) -> dict[str, Any]:
    """The good scene as a JSON document, with fields changed: ``{"surfaces[0].shape.radius": 0}``."""
    root = json.loads(GOOD.to_json())
    for place, value in changes.items():
        *parents, last = [key or int(index) for key, index in re.findall(r"(\w+)|\[(\d+)\]", place)]
        inner = root
        for key in parents:
            inner = inner[key]
        inner[last] = value
    return root


def refusal(content: dict[str, Any]) -> SceneError:
    with pytest.raises(SceneError) as caught:
        Scene.from_json(json.dumps(content))
    return caught.value


def tuples(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


@pytest.mark.parametrize("bad", BAD, ids=lambda bad: f"{bad.parent}.{bad.tail}={bad.found!r}"[:60])
def test_the_same_from_python_and_from_json(bad: Bad) -> None:
    owner = part(bad.parent)
    with pytest.raises(SceneError) as caught:
        msgspec.structs.replace(owner, **{bad.field: bad.value})
    assert caught.value.path == f"{type(owner).__name__}.{bad.tail}"
    assert repr(tuples(caught.value.found)) == repr(tuples(bad.found))

    prefix = f"{bad.parent}." if bad.parent else ""
    error = refusal(document(**{prefix + bad.field: bad.value}))
    assert error.path == prefix + bad.tail
    assert repr(tuples(error.found)) == repr(tuples(bad.found))


def test_every_message_says_path_value_and_expectation() -> None:
    error = refusal(document(**{"surfaces[0].material.albedo": [0.5, 0.5, -3]}))
    assert str(error) == "surfaces[0].material.albedo[2] = -3.0: expected a number in [0, 1]"


def test_names_are_unique() -> None:
    error = refusal(document(**{"surfaces[1].name": "floor"}))
    assert (error.path, error.found) == ("surfaces[1].name", "floor")


def test_something_must_emit() -> None:
    dark = document(**{"surfaces[1].emission": None})
    assert refusal(dark).path == "surfaces"
    assert refusal(dark).found == ["floor", "lamp"]
    assert refusal(document(**{"surfaces[1].emission.radiance": [0, 0, 0]})).path == "surfaces"
    assert refusal(document(surfaces=[])).path == "surfaces"


def test_channels_agree() -> None:
    error = refusal(document(**{"surfaces[1].emission.radiance": [1.0]}))
    assert (error.path, error.found) == ("surfaces[1].emission.radiance", (1.0,))
    one = {"surfaces[1].emission.radiance": [1.0], "surfaces[1].material.albedo": [0.5]}
    error = refusal(document(**one))
    assert (error.path, error.found) == ("surfaces[1].material.albedo", (0.5,))


def test_a_quad_has_no_polar_angles() -> None:
    error = refusal(document(**{"surfaces[0].emission": json.loads(msgspec.json.encode(LIGHT))}))
    assert (error.path, error.found) == ("surfaces[0].emission.polar_range", LIGHT.polar_range)


def test_a_scene_holds_surfaces() -> None:
    with pytest.raises(SceneError, match=r"Scene\.surfaces\[1\] = 'lamp': expected a Surface"):
        Scene((GOOD.surfaces[0], "lamp"), GOOD.sensor)


@pytest.mark.parametrize("parent", sorted({bad.parent for bad in BAD}))
@pytest.mark.parametrize("name", ["colour", "a.b", "a[0]", ""])
def test_unknown_fields(parent: str, name: str) -> None:
    content = document()
    inner: Any = content
    for key, index in re.findall(r"(\w+)|\[(\d+)\]", parent):
        inner = inner[key or int(index)]
    inner[name] = "red"
    error = refusal(content)
    assert error.path == f"{parent}.{name}".removeprefix(".")
    assert error.found == "red"


@pytest.mark.parametrize("name", ["fov", "type"])
def test_missing_fields(name: str) -> None:
    content = document()
    del content["sensor"][name]
    error = refusal(content)
    assert (error.path, error.found) == ("sensor", content["sensor"])
    assert error.expected == f"an object with the field {name}"


def test_unknown_types() -> None:
    error = refusal(document(**{"surfaces[0].shape.type": "cube"}))
    assert (error.path, error.found) == ("surfaces[0].shape.type", "cube")


@pytest.mark.parametrize("content", ["", "{", "not JSON", b"\xff\xfe\x00", "[" * 100_000], ids=range(5))
def test_what_is_no_json(content: str | bytes) -> None:
    with pytest.raises(SceneError, match=r"^scene = .*expected JSON"):
        Scene.from_json(content)


@pytest.mark.parametrize("content", ["[]", "null", "3", '"scene"'])
def test_json_that_is_no_object(content: str) -> None:
    with pytest.raises(SceneError) as caught:
        Scene.from_json(content)
    assert (caught.value.path, caught.value.found) == ("scene", json.loads(content))


def test_the_error_survives_the_way_out_of_a_process() -> None:
    error = pickle.loads(pickle.dumps(SceneError("Sphere.radius", 0.0, "a number > 0")))
    assert str(error) == "Sphere.radius = 0.0: expected a number > 0"
