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
from comparisons.renderers import Images, RendererFailed, Unsupported, config, tables
from comparisons.renderers.process import RendererProcess
from comparisons.settings import Settings, Silent
from reference_tracer.random_walk import render
from scenes import AreaLight, Lambertian, Pinhole, Quad, Scene, Surface, library
from scenes.validation import Vector

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


def asymmetric() -> Scene:
    """A lamp above, two walls of different colours, one of them with its black back in view; nothing is level."""

    def quad(
        name: str, corner: Vector, u: Vector, v: Vector, *rgb: float, light: AreaLight | None = None
    ) -> Surface:
        return Surface(name, Quad(corner, u, v), Lambertian(rgb), light)

    surfaces = (
        quad(
            "lamp",
            (-0.6, 1.0, -0.7),
            (0.9, 0, 0),
            (0, 0.1, 0.8),
            0.3,
            0.2,
            0.4,
            light=AreaLight((2.0, 5.0, 9.0)),
        ),
        quad("floor", (-1.5, -1.0, 1.5), (3.0, 0, 0), (0, 0, -3.0), 0.8, 0.6, 0.3),
        quad("left", (-1.5, -1.0, 1.5), (0, 0, -3.0), (0, 1.2, 0), 0.9, 0.5, 0.2),
        quad("right", (1.2, -1.0, 0.4), (0, 0.6, 0), (0, 0, -1.0), 0.2, 0.5, 0.9),
    )
    return Scene(surfaces, Pinhole((2.4, 0.5, 3.2), (0.0, -0.2, -0.2), (0.15, 1.0, 0.0), 42.0, 12, 8))


def test_every_bounce_is_where_and_what_it_should_be(worker: RendererProcess) -> None:
    """Camera, rows, columns, sides, units, depth, channels: in blocks of pixels, against the reference tracer."""
    scene, bounces, replicates = asymmetric(), 2, 24

    def blocks(images: Images) -> Images:
        return images.reshape(bounces + 1, 4, 2, 6, 2, 3).mean(axis=(2, 4))

    def of(images: list[Images]) -> tuple[Images, Images]:
        found = np.array([blocks(image) for image in images])
        return found.mean(axis=0), found.std(axis=0, ddof=1) / np.sqrt(replicates)

    asked = range(bounces + 1)
    found, error = of([worker.render(scene, asked, 256, seed, timeout=60) for seed in range(replicates)])
    truth, its_error = of([render(scene, bounces, 256, seed) for seed in range(replicates)])

    def distance(other: Images) -> float:
        return float((np.abs(found - other) / (np.hypot(error, its_error) + 1e-6 * truth.max())).max())

    # 216 comparisons with 23 degrees of freedom: 6 is exceeded once in 1,000 sets of seeds
    assert distance(truth) < 6
    for wrong in (
        truth[:, ::-1],
        truth[:, :, ::-1],
        truth[..., ::-1],
        np.roll(truth, 1, axis=0),
        np.cumsum(truth, axis=0),
        0.5 * truth,
    ):
        assert distance(wrong) > 9


def test_without_uv_it_is_said_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "find_uv", lambda: None)
    monkeypatch.setenv("PATH", "")
    assert shutil.which("uv") is None
    with pytest.raises(RendererFailed, match="pip install uv"):
        RendererProcess("quads")
