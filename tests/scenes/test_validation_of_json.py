"""JSON that is no scene is refused in words that help whoever has written it: a type, a field, a line."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import pytest

from scenes import Scene, SceneError

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("good_scenes.py"))))
document, refusal = shared.document, shared.refusal


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
    assert error.expected == "one of quad, disk, sphere, ellipsoid, mesh"
    error = refusal(document(**{"sensor.type": "perspective"}))
    assert error.expected == "one of pinhole, thin_lens, orthographic, radiance_meter, irradiance_meter"


def test_unknown_fields_are_shown_those_of_their_type() -> None:
    error = refusal(document(**{"surfaces[0].material.reflectance": [0.5]}))
    assert error.expected == "no field of that name; there are albedo"
    error = refusal(document(**{"sensor.focal_length": 35.0}))
    assert error.expected == "no field of that name; there are origin, target, up, fov, width, height"


@pytest.mark.parametrize("content", ["", "{", "not JSON", b"\xff\xfe\x00", "[" * 100_000], ids=range(5))
def test_what_is_no_json(content: str | bytes) -> None:
    with pytest.raises(SceneError, match=r"^scene = .*expected JSON"):
        Scene.from_json(content)


def test_the_line_that_is_no_json_is_shown() -> None:
    with pytest.raises(SceneError, match=r"^scene = '\"lights\": \]': expected JSON .*line 3") as caught:
        Scene.from_json('{\n  "surfaces": [],\n  "lights": ]\n}')
    assert caught.value.found == '"lights": ]'


def test_types_are_said_in_words() -> None:
    error = refusal(document(**{"surfaces[0].material.albedo": 0.5}))
    assert error.expected == "an object or a list, such as [0.5, 0.5, 0.5]"
    error = refusal(document(**{"sensor.width": "16"}))
    assert error.expected == "a whole number"


@pytest.mark.parametrize("content", ["[]", "null", "3", '"scene"'])
def test_json_that_is_no_object(content: str) -> None:
    with pytest.raises(SceneError) as caught:
        Scene.from_json(content)
    assert (caught.value.path, caught.value.found) == ("scene", json.loads(content))


def test_the_error_survives_the_way_out_of_a_process() -> None:
    error = pickle.loads(pickle.dumps(SceneError("Sphere.radius", 0.0, "a number > 0")))
    assert str(error) == "Sphere.radius = 0.0: expected a number > 0"
