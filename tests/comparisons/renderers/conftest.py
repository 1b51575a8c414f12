"""Mitsuba in this process, and renderers from a configuration of the test's own, which may leave nothing behind."""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from comparisons.renderers import config, limits
from comparisons.renderers.mitsuba import MitsubaRenderer
from comparisons.renderers.process import RendererProcess

PROGRAM = Path(__file__).with_name("program.py")

CALL = [sys.executable, str(PROGRAM), "{scene}", "--spp", "{spp}", "--seed", "{seed}", "-o", "{output}"]
"""A program that knows no depth, of which ``--bounces`` makes one that does."""


def toml(value: Any) -> str:
    """A value as TOML has it."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + "}"
    return json.dumps(value)


@pytest.fixture(scope="module")
def mitsuba() -> MitsubaRenderer:
    return MitsubaRenderer("scalar_rgb")


@pytest.fixture
def configured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., Path]]:
    """``configured(mine={…}, other={…})`` writes a configuration with these renderers, and works in its folder."""
    config._read.cache_clear()

    def write(**renderers: dict[str, Any]) -> Path:
        lines = []
        for name, table in renderers.items():
            lines += [f"[renderers.{name}]", *(f"{key} = {toml(value)}" for key, value in table.items()), ""]
        (tmp_path / config.FILE).write_text("\n".join(lines))
        monkeypatch.chdir(tmp_path)
        config._read.cache_clear()
        return tmp_path

    yield write
    config._read.cache_clear()


@pytest.fixture
def start(configured: Callable[..., Path], spotless: Any) -> Iterator[Callable[..., RendererProcess]]:
    """``start("--layers", "parts", images="layers")`` starts ``program.py`` by these arguments and keys."""
    started: list[RendererProcess] = []

    def starting(*arguments: str, **keys: Any) -> RendererProcess:
        depth = [] if keys.get("images") == "total" else ["--bounces", "{bounces}"]
        table = {"command": [*CALL, *depth, *arguments], "scene": "json", "images": "cumulative"}
        configured(mine=table | keys)
        started.append(RendererProcess("mine"))
        return started[-1]

    yield starting
    for process in started:
        process.close()


@pytest.fixture
def spotless(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], list[int]]]:
    """``spotless()`` tells which processes of this test are running; in the end none, and no file, may be left.

    All of them carry the name of a folder in the one that temporary files go to here.
    """
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))

    def running() -> list[int]:
        found = []
        for environment in Path("/proc").glob("[0-9]*/environ"):
            with suppress(OSError):
                if f"{limits.MARK}={folder}".encode() in environment.read_bytes():
                    found.append(int(environment.parent.name))
        return found

    yield running
    deadline = time.monotonic() + 10
    while (running() or any(folder.iterdir())) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not running()
    assert not list(folder.iterdir())
