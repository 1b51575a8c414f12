"""The worker in examples/worker, run by uv for real: its own NumPy, and what it renders is right."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from comparisons import campaign
from comparisons.renderers import RendererFailed, Unsupported, config, tables
from comparisons.renderers.process import RendererProcess
from comparisons.settings import Settings, Silent
from scenes import library

FOLDER = Path(__file__).parents[2] / "examples" / "worker"


@pytest.fixture(scope="session")
def environment() -> None:
    """Made by uv, which has to fetch packages the first time; without uv or a network there is nothing to test."""
    uv = tables.find_uv()
    made = uv and subprocess.run(
        [uv, "run", "--no-project", "--script", FOLDER / "quads.py"],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=600,
    )
    if not made or made.returncode:
        why = f"uv can't make the worker's environment: {made.stderr}" if made else "uv is not installed"
        pytest.fail(why) if os.environ.get("CI") == "true" else pytest.skip(why)


@pytest.fixture(autouse=True)
def in_the_folder(environment: None, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.chdir(FOLDER)
    config._read.cache_clear()
    yield
    config._read.cache_clear()


@pytest.fixture
def worker() -> Iterator[RendererProcess]:
    with RendererProcess("quads") as process:
        yield process


def test_it_has_a_numpy_of_its_own(worker: RendererProcess) -> None:
    """Which is older than ours, so none of our packages is in its environment."""
    assert worker.version == "1.0"
    worker.render(library.case("furnace-box").scene.resized(2, 2), [0], 1, 0, timeout=60)
    [said] = [found for line in worker.log() if (found := re.fullmatch(r"NumPy (\d+)\..*", line))]
    assert int(said[1]) < 2 <= int(np.__version__.split(".")[0])


def test_what_it_lacks_is_named(worker: RendererProcess) -> None:
    ball = library.case("furnace-sphere").scene.resized(2, 2)
    with pytest.raises(Unsupported, match="shape sphere"):
        worker.render(ball, [0], 1, 0, timeout=60)
    with pytest.raises(Unsupported, match="first_hits"):
        worker.first_hits(ball, timeout=60)


@pytest.mark.parametrize(("case", "bounces"), [("furnace-box", 2), ("facing-squares", 2)])
def test_its_bounces_are_right(case: str, bounces: int, tmp_path: Path) -> None:
    """E and ½ᵏ of a furnace; the light between two squares, which finite elements know."""
    settings = Settings(
        bounces=bounces, size=(16, 16), budget=60.0, tolerance=(0.05,), tile_tolerance=(0.5,), jobs=2
    )
    [found] = campaign.run([library.case(case)], ["quads"], settings, tmp_path, Silent())
    assert found.verdict == "pass", [(b.bounce, b.bias, b.interval) for b in found.bounces] or found.message


def test_without_uv_it_is_said_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "find_uv", lambda: None)
    monkeypatch.setenv("PATH", "")
    assert shutil.which("uv") is None
    with pytest.raises(RendererFailed, match="pip install uv"):
        RendererProcess("quads")
