"""``lightproof list``: what it tells people and programs."""

from __future__ import annotations

import json
import re
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import pytest

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("command.py"))))
invoke = shared.invoke


def test_lists_for_people_and_programs() -> None:
    for what, name in (
        ("cases", "furnace-box"),
        ("renderers", "mitsuba:scalar_rgb"),
        ("relations", "superposition"),
    ):
        rows = json.loads(invoke("list", what, "--json").output)
        assert name in [row["name"] for row in rows]
        assert name in invoke("list", what).output


def test_the_list_says_what_a_case_needs() -> None:
    rows = {row["name"]: row for row in json.loads(invoke("list", "cases", "--json").output)}
    sphere = rows["integrating-sphere"]
    assert sphere["features"] == ["sphere", "inward", "lambertian", "area", "polar_range", "pinhole"]
    assert {"family", "bounces", "truth"} <= sphere.keys()
    assert "polar_range" in invoke("list", "cases").output


def test_renderers_of_ones_own_are_listed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where they are, whether they are there, how to get them, and what they support."""
    command = """["./mine", "{scene}", "{spp}", "{seed}", "{output}"]"""
    keys = f"command = {command}\nscene = 'gltf'\nimages = 'total'\ninstall = 'make mine'"
    (tmp_path / "lightproof.toml").write_text(f"[renderers.mine]\n{keys}\nversion = '2.0'")
    monkeypatch.chdir(tmp_path)
    rows = {row["name"]: row for row in json.loads(invoke("list", "renderers", "--json").output)}
    mine = rows["mine"]
    assert (mine["version"], mine["installed"], mine["install"]) == (None, False, "make mine")
    assert re.search("mine .*not installed: make mine", invoke("list", "renderers").output)
    assert mine["supports"]["images"] == ["bounce 0", "total"]
    assert rows["reference:mis"]["installed"]
    assert rows["reference:mis"]["supports"]["sensors"][0] == "pinhole"
    (tmp_path / "mine").write_text("#!/bin/sh")
    (tmp_path / "mine").chmod(0o755)
    rows = {row["name"]: row for row in json.loads(invoke("list", "renderers", "--json").output)}
    assert (rows["mine"]["version"], rows["mine"]["installed"]) == ("2.0", True)
    shown = invoke("list", "renderers").output
    assert re.search("mine .*2.0", shown)
    assert re.search(r"^mine\n +shapes: quad, mesh", shown, re.MULTILINE)


def test_in_a_pipe_no_line_is_longer_than_what_it_says() -> None:
    for what in ("renderers", "relations"):
        assert max(map(len, invoke("list", what).output.splitlines())) < 1000
