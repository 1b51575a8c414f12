"""The command in this process, small scenes for it, and what it says as text that can be searched."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from lightproof.cli import app
from scenes import Scene


def invoke(*arguments: str | Path) -> Any:
    return CliRunner().invoke(app, [str(a) for a in arguments])


def validate(tmp_path: Path, *arguments: str, jobs: int = 1) -> Any:
    return invoke("validate", *arguments, "--size", "16x16", "--jobs", str(jobs), "--out", tmp_path / "out")


def small(scene: Scene) -> Scene:
    return scene.resized(8, 8)


def flat(text: str) -> str:
    """Without the frames and line breaks that depend on the width of the terminal."""
    return " ".join(text.translate(str.maketrans("│╭╮╰╯─", "      ")).split())


def unbroken(text: str) -> str:
    """Without any blanks: a long path may be broken anywhere."""
    return "".join(flat(text).split())
