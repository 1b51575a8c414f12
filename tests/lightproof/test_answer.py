"""Answers of scenes of one's own: estimated by the command, and what an image must be to be one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec import structs
from typer.testing import CliRunner

from lightproof import cases
from lightproof.cli import app
from scenes import Scene, library
from scenes.formats import exr


def invoke(*arguments: Any) -> Any:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def flat(text: str) -> str:
    return " ".join(text.replace("│", " ").split())


def small(scene: Scene) -> Scene:
    return scene.resized(8, 8)


def test_an_answer_image_is_radiance(tmp_path: Path) -> None:
    """Below 0 only by rounding, or as far as its own standard error reaches."""
    scene, answer = tmp_path / "room.json", tmp_path / "room.exr"
    scene.write_bytes(small(library.case("furnace-box").scene).to_json())
    mean = np.ones((2, 8, 8, 3))
    mean[1, 2, 3, 0] = -0.25
    exr.write_bounces(answer, mean)
    with pytest.raises(
        cases.CaseError, match=r"-0\.25 in bounce 1, row 2, column 3, channel 0: expected finite"
    ):
        cases.from_answer(scene, answer)
    exr.write_bounces(answer, mean, np.full_like(mean, 0.02))
    with pytest.raises(cases.CaseError, match=r"-0\.25 with a standard error of 0\.02 in bounce 1"):
        cases.from_answer(scene, answer)
    exr.write_bounces(answer, mean, np.full_like(mean, 0.1))
    assert cases.from_answer(scene, answer).bounces == 1
    mean[1, 2, 3, 0] = -1e-7
    exr.write_bounces(answer, mean)
    assert cases.from_answer(scene, answer).bounces == 1
    for place in (0, 1):
        pair = [np.ones_like(mean), np.ones_like(mean)]
        pair[place][0, 0, 0, 1] = np.nan
        exr.write_bounces(answer, *pair)
        with pytest.raises(cases.CaseError, match="in bounce 0, row 0, column 0, channel 1"):
            cases.from_answer(scene, answer)


def test_the_answer_of_a_scene_is_estimated_with_its_error(tmp_path: Path) -> None:
    """In a furnace, whose answer is known: within the stated error, which is that of its pixels."""
    scene, answer = tmp_path / "room.json", tmp_path / "room.exr"
    scene.write_bytes(small(library.case("furnace-box").scene).to_json())
    options = ("--bounces", "2", "--spp", "64", "--jobs", "1", "--out", answer)
    result = invoke("answer", scene, *options)
    assert result.exit_code == 0, result.output
    assert "layers bounce0 to bounce2, estimated, with its standard error" in flat(result.output)
    mean, stderr = exr.read_bounces(answer)
    off = mean - np.array([1, 0.5, 0.25])[:, None, None, None]
    np.testing.assert_allclose(off[0], 0, atol=1e-6)
    for k in (1, 2):
        assert (stderr[k] > 0).all()
        assert 0.6 < np.sqrt((off[k] ** 2).mean() / (stderr[k] ** 2).mean()) < 1.6
    assert exr.read_attribute(answer, "lightproof:scene") == "room, 8x8 pixels"
    assert "64 batches of 1 spp" in exr.read_attribute(answer, "lightproof:source")
    assert cases.from_answer(scene, answer).answer.kind == "estimated"


def test_a_view_of_less_than_a_degree_is_warned_of(tmp_path: Path) -> None:
    """It is most likely meant in radians; the scene is rendered all the same."""
    scene, out = tmp_path / "room.json", tmp_path / "x.exr"
    room = small(library.case("furnace-box").scene)
    for fov, warned in ((0.698, True), (1.5, False)):
        scene.write_bytes(structs.replace(room, sensor=structs.replace(room.sensor, fov=fov)).to_json())
        result = invoke("render", scene, "--spp", "1", "--bounces", "0", "--out", out)
        assert result.exit_code == 0, result.output
        assert ("fov = 0.698 is in degrees; 40 if radians were meant" in flat(result.stderr)) is warned
