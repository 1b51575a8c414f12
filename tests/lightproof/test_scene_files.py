"""Scenes of one's own, as JSON files: written by a program or by hand."""

from __future__ import annotations

import json
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import jsonschema
import numpy as np
import pytest
from msgspec import structs

from scenes import Scene, library
from scenes.formats import exr
from scenes.schema import SCHEMA_FILE

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("command.py"))))
flat, invoke, small = shared.flat, shared.invoke, shared.small


def test_a_scene_as_json_renders(tmp_path: Path) -> None:
    scene, out = tmp_path / "my-scene.json", tmp_path / "x.exr"
    scene.write_bytes(small(library.case("furnace-box").scene).to_json())
    result = invoke("render", scene, "--renderer", "reference", "--spp", "2", "--out", out)
    assert result.exit_code == 0, result.output
    mean, _ = exr.read_bounces(out)
    assert mean.shape == (6, 8, 8, 3)
    assert (mean[0] == 1).all()
    assert mean[1].mean() == pytest.approx(0.5, rel=0.1)
    assert invoke("export", scene, "--format", "gltf", "--out", tmp_path / "x.gltf").exit_code == 0
    assert (tmp_path / "x.bin").exists()


BY_HAND = """{
  "surfaces": [
    {
      "name": "floor",
      "shape": {"type": "quad", "corner": [-2, 0, 2], "edge_u": [4, 0, 0], "edge_v": [0, 0, -4]},
      "material": {"type": "lambertian", "albedo": [0.5, 0.25, 0]}
    }
  ],
  "sensor": {
    "type": "pinhole", "origin": [0, 3, 0], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 40, "width": 4, "height": 3
  },
  "lights": [{"type": "directional", "direction": [0, -4, 3], "irradiance": [1, 2, 3]}]
}"""


def test_a_scene_written_by_hand_obeys_the_schema_and_renders(tmp_path: Path) -> None:
    """No program wrote it: whole numbers, fields that are left out. TE = (ρ/π) E⊥ cos θ, cos θ = 4/5."""
    jsonschema.validate(json.loads(BY_HAND), json.loads(SCHEMA_FILE.read_bytes()))
    scene, out = tmp_path / "by-hand.json", tmp_path / "x.exr"
    scene.write_text(BY_HAND)
    result = invoke("render", scene, "--renderer", "reference", "--spp", "2", "--bounces", "2", "--out", out)
    assert result.exit_code == 0, result.output
    mean, _ = exr.read_bounces(out)
    assert mean.shape == (3, 3, 4, 3)
    expected = np.array([0.5, 0.25, 0]) / np.pi * [1, 2, 3] * 0.8
    np.testing.assert_allclose(mean[1], np.broadcast_to(expected, (3, 4, 3)), rtol=1e-6)
    assert not mean[[0, 2]].any()
    jsonschema.validate(json.loads(Scene.load(scene).to_json()), json.loads(SCHEMA_FILE.read_bytes()))


def test_a_view_of_less_than_a_degree_is_warned_of(tmp_path: Path) -> None:
    """It is most likely meant in radians; the scene is rendered all the same."""
    scene, out = tmp_path / "room.json", tmp_path / "x.exr"
    room = small(library.case("furnace-box").scene)
    for fov, warned in ((0.698, True), (1.5, False)):
        scene.write_bytes(structs.replace(room, sensor=structs.replace(room.sensor, fov=fov)).to_json())
        result = invoke("render", scene, "--spp", "1", "--bounces", "0", "--out", out)
        assert result.exit_code == 0, result.output
        assert ("fov = 0.698 is in degrees; 40 if radians were meant" in flat(result.stderr)) is warned
