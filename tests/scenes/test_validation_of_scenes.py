"""Parts of a scene that may be right by themselves and don't go together: the path and the value of one are told."""

from __future__ import annotations

import json
import re
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest

from scenes import Scene, SceneError

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("good_scenes.py"))))
BLEND, CHECKS, DIRECTIONAL, GOOD = shared.BLEND, shared.CHECKS, shared.DIRECTIONAL, shared.GOOD
LIGHT, MAP, MESH, METAL, METER = shared.LIGHT, shared.MAP, shared.MESH, shared.METAL, shared.METER
MIRROR, ORIGIN, POINT, RICH, ROUGH = shared.MIRROR, shared.ORIGIN, shared.POINT, shared.RICH, shared.ROUGH
SPOT, TEXTURE, X = shared.SPOT, shared.TEXTURE, shared.X
document, refusal = shared.document, shared.refusal


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
    assert error.expected == "3 channels, as surfaces[0].material.albedo has"


@pytest.mark.parametrize(
    ("place", "value", "found"),
    [
        (f"{CHECKS}.albedo", [0.5], None),  # what comes first sets the number: the next one is wrong
        (f"{TEXTURE}.albedo.image.pixels", [[[0.25]]], "image.pixels[0][0]"),
        (f"{MIRROR}.reflectance", [0.5], "reflectance"),
        (METAL, {"type": "conductor", "eta": [1.0], "k": [2.0]}, "eta"),
        (ROUGH, {"type": "rough_conductor", "eta": [1.0], "k": [2.0], "alpha": 0.5}, "eta"),
        (f"{BLEND}.first.reflectance", [0.5], "second.first.albedo"),
        (f"{POINT}.intensity", [1.0], "intensity"),
        (f"{SPOT}.intensity", [1.0], "intensity"),
        (f"{DIRECTIONAL}.irradiance", [1.0], "irradiance"),
        (f"{MAP}.image.pixels", [[[0.25]]], "image.pixels[0][0]"),
        (MAP, {"type": "constant", "radiance": [1.0]}, "radiance"),
        (MAP, {"type": "spherical_harmonics", "coefficients": [[1.0]]}, "coefficients[0]"),
    ],
)
def test_channels_agree_in_every_type(place: str, value: Any, found: str | None) -> None:
    error = refusal(document(RICH, **{place: value}))
    if found is None:
        assert error.path == f"{TEXTURE}.albedo.image.pixels[0][0]"
        assert error.expected == f"1 channels, as {CHECKS}.albedo has"
    else:
        part = re.match(r"(surfaces\[\d\]\.material|lights\[\d\])", place)
        assert part is not None
        assert error.path.startswith(part[1])
        assert error.path.endswith(found)
        assert len(error.found) in (1, 3)


def test_one_environment() -> None:
    error = refusal(document(METER, lights=[{"type": "constant", "radiance": [1.0, 1.0, 1.0]}] * 2))
    assert (error.path, error.expected) == ("lights[1]", "no second environment")


def test_a_texture_needs_coordinates() -> None:
    error = refusal(document(RICH, **{f"{MESH}.uv": None}))
    assert (error.path, error.found) == ("surfaces[2].shape.uv", None)


def test_a_texture_does_not_amplify() -> None:
    error = refusal(
        document(RICH, **{f"{TEXTURE}.albedo.image.pixels": [[[0.5, 1.0, 0.5], [0.5, 0.5, 2.0]]]})
    )
    assert (error.path, error.found) == (f"{TEXTURE}.albedo.image.pixels[0][1][2]", 2.0)


@pytest.mark.parametrize("corner", [[0.5, 0.0, 0.0], [0.5, 1e-10, 0.0]])
def test_a_triangle_without_an_area(corner: list[float]) -> None:
    error = refusal(document(RICH, **{f"{MESH}.vertices": [ORIGIN, X, corner, (1.0, 1.0, 0.0)]}))
    assert (error.path, error.found) == (f"{MESH}.triangles[0]", (ORIGIN, X, tuple(corner)))


def test_a_quad_has_no_polar_angles() -> None:
    error = refusal(document(**{"surfaces[0].emission": json.loads(msgspec.json.encode(LIGHT))}))
    assert (error.path, error.found) == ("surfaces[0].emission.polar_range", LIGHT.polar_range)


def test_a_scene_holds_surfaces() -> None:
    with pytest.raises(SceneError, match=r"Scene\.surfaces\[1\] = 'lamp': expected a Surface"):
        Scene((GOOD.surfaces[0], "lamp"), GOOD.sensor)
