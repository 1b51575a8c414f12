"""Scenes written for other renderers: in which format, into which file, and over nothing that is the user's."""

from __future__ import annotations

from pathlib import Path
from runpy import run_path
from types import SimpleNamespace
from typing import Any

import pytest

from scenes import Scene, library
from scenes.channels import single_channel

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("command.py"))))
flat, invoke, unbroken = shared.flat, shared.invoke, shared.unbroken


@pytest.mark.parametrize("suffix", ["json", "xml", "pbrt", "gltf"])
def test_the_suffix_says_the_format(suffix: str, tmp_path: Path) -> None:
    out = tmp_path / f"x.{suffix}"
    result = invoke("export", "furnace-box", "--channel", "1", "--size", "16x8", "--out", out)
    assert result.exit_code == 0, result.output
    if suffix == "json":
        assert Scene.load(out).shape == (8, 16, 1)
    else:  # where it comes from, and how many bounces the case asks for
        text = out.read_text()
        assert "furnace-box, 16x8 pixels, channel 1 of 0 to 2" in text
        scene = single_channel(library.case("furnace-box").scene.resized(16, 8), 1)
        assert scene.sha256 in text
        bounces = library.case("furnace-box").bounces
        said = {
            "xml": f'value="{bounces + 1}"',
            "pbrt": f'maxdepth" [ {bounces} ]',
            "gltf": f'"bounces": {bounces}',
        }
        assert said[suffix] in text


def test_export_refuses_what_a_format_lacks(tmp_path: Path) -> None:
    result = invoke("export", "furnace-sphere", "--format", "gltf", "--out", tmp_path / "x.gltf")
    assert result.exit_code == 5
    assert "gltf can't express this scene: sphere is a sphere: glTF has triangles only" in result.output
    assert not list(tmp_path.iterdir())


def test_one_channel_of_a_scene(tmp_path: Path) -> None:
    out = tmp_path / "x.json"
    assert invoke("export", "cornell-box", "--channel", "1", "--out", out).exit_code == 0
    assert Scene.load(out).channels == 1


def test_export_overwrites_what_it_wrote_and_nothing_else(tmp_path: Path) -> None:
    def export(*arguments: str | Path) -> Any:
        return invoke("export", "furnace-mesh", "--out", *arguments)

    xml, mesh = tmp_path / "x.xml", tmp_path / "x-0.ply"
    mesh.write_text("a mesh of my own")
    for _ in range(2):
        result = export(xml)
        assert result.exit_code == 2
        assert unbroken("x-0.ply is there already") in unbroken(result.output)
    assert [path.name for path in tmp_path.iterdir()] == ["x-0.ply"]
    assert mesh.read_text() == "a mesh of my own"
    mesh.unlink()
    assert export(xml).exit_code == 0
    assert export(xml, "--size", "4x4").exit_code == 0, "it is ours"
    xml.write_text("<scene/>")
    assert export(xml).exit_code == 2
    (tmp_path / "d.xml").mkdir()
    assert export(tmp_path / "d.xml").exit_code == 2


def test_a_scene_of_ones_own_is_not_overwritten(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    scene = Path("room.json")
    scene.write_bytes(library.case("furnace-box").scene.to_json())
    content = scene.read_bytes()
    assert invoke("export", scene).exit_code == 0, "the same again does no harm"
    result = invoke("export", scene, "--channel", "1")
    assert result.exit_code == 2
    assert "room.json is there already, and may be your own: give another name" in flat(result.output)
    assert scene.read_bytes() == content
