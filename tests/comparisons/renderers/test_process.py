"""Real processes that crash, hang and say strange things."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from comparisons.renderers import RendererFailed, RendererTimeout, Unsupported
from comparisons.renderers.process import RendererProcess
from reference_tracer.random_walk import total
from scenes import Scene, library


@pytest.fixture
def scene() -> Scene:
    return library.case("furnace-box").scene.resized(8, 8)


@pytest.mark.parametrize(
    ("name", "error", "message"),
    [
        ("wrong:crash", RendererFailed, "its process was killed by signal 11"),
        ("wrong:leave", RendererFailed, "its process ended with status 7"),
        ("wrong:hang", RendererTimeout, "no answer within"),
        (
            "wrong:nan",
            RendererFailed,
            r"returned 2 of 256 pixels that are not finite \(.*\), the first in bounce 2, row 3, column 1",
        ),
        ("wrong:wrong-shape", RendererFailed, r"shape \(4, 7, 8, 3\), expected \(4, 8, 8, 3\)"),
        ("wrong:complain", RendererFailed, "RuntimeError: out of texture memory"),
        ("wrong:refuse", Unsupported, "spheres"),
    ],
)
def test_misbehaviour_is_told_apart(
    wrong: Any, scene: Scene, name: str, error: type[Exception], message: str, processes: Any
) -> None:
    def children() -> set[int]:
        return {process.pid for process in processes() if process.parent == os.getpid()}

    before, timeout = children(), 1.0 if name == "wrong:hang" else 60.0
    with RendererProcess(name) as renderer, pytest.raises(error, match=message):
        renderer.render(scene, bounces=range(4), spp=1, seed=0, timeout=timeout)
    assert children() <= before


def test_first_hits(scene: Scene) -> None:
    with RendererProcess("reference") as process:
        assert process.first_hits(scene, timeout=60).shape == (5, 64)


def test_first_hits_are_an_option(wrong: Any, scene: Scene) -> None:
    with RendererProcess("wrong:right") as process:
        with pytest.raises(Unsupported, match=r"first hits: its adapter has no first_hits\(scene\)"):
            process.first_hits(scene, timeout=60)
        assert process.render(scene, [0], 1, 0, timeout=60).shape == (1, 8, 8, 3)
        process._ask = lambda request, scene, timeout: np.zeros((5, 7))  # type: ignore[method-assign]
        with pytest.raises(RendererFailed, match=r"hits of shape \(5, 7\), expected \(5, 64\)"):
            process.first_hits(scene, timeout=60)


def test_a_crash_shows_the_end_of_the_log(wrong: Any, scene: Scene) -> None:
    with RendererProcess("wrong:crash") as process, pytest.raises(RendererFailed) as caught:
        process.render(scene, [0, 1], 1, 0, timeout=60)
    assert "about to crash" in caught.value.log


def test_an_exception_shows_its_traceback_and_the_process_goes_on(wrong: Any, scene: Scene) -> None:
    with RendererProcess("wrong:complain") as process:
        for _ in range(2):
            with pytest.raises(RendererFailed) as caught:
                process.render(scene, [0, 1], 1, 0, timeout=60)
        assert caught.value.log[-1] == "RuntimeError: out of texture memory"


def test_garbage_on_the_standard_output_joins_the_log(wrong: Any, scene: Scene) -> None:
    with RendererProcess("wrong:chatter") as chatty, RendererProcess("wrong:right") as quiet:
        images = [p.render(scene, [0, 1, 2], 4, 5, timeout=60) for p in (chatty, quiet)]
        assert "garbage from below" in chatty.log()
    np.testing.assert_array_equal(*images)


def test_a_missing_package_is_named(wrong: Any) -> None:
    with pytest.raises(RendererFailed, match="can't be loaded: No module named 'missing'") as caught:
        RendererProcess("wrong:missing")
    assert caught.value.log[-1] == "ModuleNotFoundError: No module named 'missing'"


def test_a_process_that_is_killed_between_two_requests(wrong: Any, scene: Scene) -> None:
    with RendererProcess("wrong:right") as process:
        process.kill()
        time.sleep(0.2)
        with pytest.raises(RendererFailed, match="killed by signal 9"):
            process.render(scene, [0, 1], 1, 0, timeout=60)


def test_a_folder_named_scenes_in_the_working_directory_is_not_ours(
    scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "scenes").mkdir()
    (tmp_path / "scenes" / "__init__.py").write_text("raise ImportError('the wrong one')")
    monkeypatch.chdir(tmp_path)
    with RendererProcess("reference") as process:
        assert process.render(scene, [0], 1, 0, timeout=60).shape == (1, 8, 8, 3)


def test_the_total_is_what_the_tracer_makes(scene: Scene) -> None:
    with RendererProcess("reference") as process:
        np.testing.assert_array_equal(process.total(scene, 2, 3, timeout=60), total(scene, 2, 3))


def test_the_total_is_an_option(wrong: Any, scene: Scene) -> None:
    with RendererProcess("wrong:right") as process:
        with pytest.raises(Unsupported, match=r"total: its adapter has no total\(scene, spp, seed\)"):
            process.total(scene, 1, 0, timeout=60)
        assert process.render(scene, [0], 1, 0, timeout=60).shape == (1, 8, 8, 3)


def test_mitsuba_adds_up_all_bounces() -> None:
    """Albedo 0.9: the first seven bounces, as many as come before its roulette, hold half of the light."""
    scene = library.case("furnace-channels").scene.resized(8, 8)
    with RendererProcess("mitsuba") as process:
        image = process.total(scene, 4096, 1, timeout=60).mean(axis=(0, 1))
    np.testing.assert_allclose(image, (10.0, 4.0, 0.625), rtol=0.01)
