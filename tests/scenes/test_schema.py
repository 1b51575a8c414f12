"""The published schema is that of the code; it takes every scene there is and refuses what is mistyped."""

from __future__ import annotations

import json
from typing import Any

import jsonschema
import msgspec
import pytest

from scenes import Scene, SceneError, library
from scenes.schema import SCHEMA_FILE, schema

SCHEMA = json.loads(SCHEMA_FILE.read_bytes())
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)  # that the schema is one, is asked once, below
BOX = json.loads(library.case("cornell-box").scene.to_json())


def validate(document: Any) -> None:
    VALIDATOR.validate(document)


def test_the_published_schema_is_up_to_date() -> None:
    assert json.loads(msgspec.json.encode(schema())) == SCHEMA, "run make schema"
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


@pytest.mark.parametrize("name", library.CASES)
def test_every_case_obeys_it(name: str) -> None:
    validate(json.loads(library.case(name).scene.to_json()))


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("surfaces", 0, "shap"), {}),
        (("surfaces", 0, "two_sided"), "yes"),
        (("surfaces", 0, "shape", "type"), "rectangle"),
        (("surfaces", 0, "shape", "corner"), [0, 0]),
        (("surfaces", 0, "material", "albedo"), "white"),
        (("surfaces", 0, "material", "colour"), [1, 1, 1]),
        (("surfaces", 0, "emission", "radiance"), [1, "2", 3]),
        (("sensor", "width"), 6.5),
        (("sensor", "type"), "perspective"),
        (("lights",), [{"type": "point", "position": [0, 0, 0], "power": [1, 1, 1]}]),
        (("camera",), {}),
    ],
)
def test_typos_are_refused(place: tuple[str | int, ...], value: Any) -> None:
    document = json.loads(json.dumps(BOX))
    validate(document)
    part = document
    for key in place[:-1]:
        part = part[key]
    part[place[-1]] = value
    with pytest.raises(jsonschema.ValidationError):
        validate(document)


def test_what_a_scene_may_leave_out_or_add() -> None:
    """The schema takes what reading takes."""
    document = json.loads(json.dumps(BOX))
    [lamp] = [surface for surface in document["surfaces"] if "emission" in surface]
    del lamp["emission"]["type"]
    document["$schema"] = "scene.schema.json"
    validate(document)
    assert Scene.from_json(json.dumps(document)) == library.case("cornell-box").scene
    document["$schema"] = 3
    with pytest.raises(jsonschema.ValidationError):
        validate(document)
    with pytest.raises(SceneError, match=r"\$schema = 3"):
        Scene.from_json(json.dumps(document))


@pytest.mark.parametrize("place", [("sensor",), ("surfaces",), ("surfaces", 0, "material")])
def test_what_is_missing_is_missed(place: tuple[str | int, ...]) -> None:
    document = json.loads(json.dumps(BOX))
    part = document
    for key in place[:-1]:
        part = part[key]
    del part[place[-1]]
    with pytest.raises(jsonschema.ValidationError):
        validate(document)
