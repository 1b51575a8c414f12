"""The assertion as a function, in any Python program: what it takes, what it returns, what it refuses."""

from __future__ import annotations

import unittest
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lightproof
from comparisons.renderers import Images, Unsupported
from lightproof import assertion
from reports import REPORT_FILE
from scenes import Scene, UnknownNameError, library

CASE = library.case("furnace-box")


class Right:
    """The truth with normal noise, 5 % for a sample of a pixel."""

    factor = 1.0

    def version(self) -> str:
        return "1"

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        shape = (len(bounces), *scene.shape)
        noise = np.random.default_rng(seed).normal(self.factor, 0.05 / np.sqrt(spp), shape)
        if scene.surfaces != CASE.scene.surfaces:
            return noise  # asked whether it heeds its seed
        truth = CASE.answer.truth(scene, max(bounces))
        assert truth is not None
        return truth.mean[list(bounces)] * noise


class Brighter(Right):
    factor = 1.03


class Refusing(Right):
    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        raise Unsupported("boxes")


@pytest.fixture(autouse=True)
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """No pytest in sight, and a temporary folder to look into."""
    monkeypatch.setattr(assertion, "_running_test", lambda: None)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path


def match(renderer: Any, case: Any = CASE, **arguments: Any) -> Any:
    return lightproof.assert_bounces_match(renderer, case, **{"size": (8, 8), "budget": 30.0} | arguments)


def test_what_agrees_is_returned_and_leaves_nothing(temporary: Path) -> None:
    found = match(Right(), tolerance=(0.003, "0.4%"), tile_tolerance=0.03, bounces=2, alpha=1e-4)
    assert (found.verdict, found.renderer, found.case, found.alpha) == ("pass", "Right", "furnace-box", 1e-4)
    assert [(b.tolerance, b.tile_tolerance) for b in found.bounces] == [(0.003, 0.03)] + [(0.004, 0.03)] * 2
    assert (found.width, found.height) == (8, 8)
    assert list(temporary.iterdir()) == []


def test_what_does_not_agree_raises_with_the_comparison_and_its_report() -> None:
    with pytest.raises(lightproof.VerdictError, match=r"Bounce 0 is .* high") as raised:
        match(Brighter(), bounces=1)
    assert isinstance(raised.value, AssertionError)
    assert raised.value.comparison.verdict == "fail"
    assert str(raised.value).endswith(f"Report: {raised.value.report}")
    assert "Brighter" in raised.value.report.read_text()


def test_a_folder_of_one_s_own_stays_and_holds_the_last_comparison(tmp_path: Path) -> None:
    folder = tmp_path / "mine"
    with pytest.raises(lightproof.VerdictError):
        match(Brighter(), report=folder, bounces=1)
    match(Right(), report=str(folder), bounces=1)
    page = (folder / REPORT_FILE).read_text()
    assert "Right" in page
    assert "Brighter" not in page
    assert not list((folder / "images").rglob("Brighter.exr"))


def test_a_seed_is_what_the_samples_depend_on() -> None:
    """The first image comes from it alone; how many follow depends on the time."""
    first: dict[int, int] = {}

    class Recording(Right):
        def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
            if scene.surfaces == CASE.scene.surfaces:
                first.setdefault(chosen, seed)
            return super().render(scene, bounces, spp, seed)

    for chosen in (1, 2):
        match(Recording(), bounces=0, seed=chosen)
    assert first[1] != first[2]


def test_the_case_may_be_a_name_or_in_a_file(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(
        "from dataclasses import replace\nfrom scenes import library\n\n"
        "def box():\n    return replace(library.case('furnace-box'), name='mine')\n"
    )
    assert match(Right(), "furnace-box", bounces=0).case == "furnace-box"
    assert match(Right(), f"{tmp_path / 'mine.py'}:box", bounces=0).case == "mine"


def test_unsupported_skips_wherever_it_runs_unless_it_must_not() -> None:
    with pytest.raises(unittest.SkipTest, match="furnace-box × Refusing: unsupported, boxes"):
        match(Refusing())
    with pytest.raises(lightproof.VerdictError, match="unsupported, boxes"):
        match(Refusing(), unsupported="fail")


@pytest.mark.parametrize(
    ("wrong", "error", "message"),
    [
        ({"renderer": "mitsubishi"}, UnknownNameError, "no renderer is called 'mitsubishi': did you mean mitsuba"),
        ({"renderer": Right}, TypeError, "expected an object, found the class Right: Right()?"),
        ({"renderer": object()}, TypeError, "found a object without version and render"),
        ({"case": "furnace-bax"}, UnknownNameError, "no case is called 'furnace-bax': did you mean furnace-box"),
        ({"case": "no.py:case"}, ValueError, "no.py: there is no such file"),
        ({"case": library.CASES["furnace-box"]}, TypeError, "found a function: call it"),
        ({"case": replace(CASE, name="a/b")}, ValueError, "the name 'a/b' has other characters"),
        ({"tolerance": 0}, ValueError, "tolerance: '0': expected a share above 0"),
        ({"tile_tolerance": "wide"}, ValueError, "tile_tolerance: 'wide': expected a share above 0"),
        ({"bounces": -1}, ValueError, "bounces: expected a number from 0 to 1e+06, found -1"),
        ({"size": (8, 0)}, ValueError, "size: '8x0': expected WIDTHxHEIGHT"),
        ({"budget": float("nan")}, ValueError, "budget: expected a number from 0.001 to 1e+06, found nan"),
        ({"alpha": 0.0}, ValueError, "alpha: expected a number from 1e-12 to 0.5, found 0.0"),
        ({"seed": -1}, ValueError, "seed: expected a number from 0"),
        ({"case": "glass-slab", "bounces": 99}, ValueError, "bounces: 99: the answer of glass-slab holds"),
        ({"report": Path(__file__, "folder")}, ValueError, "report: "),
        ({"unsupported": "ignore"}, ValueError, "unsupported: expected 'skip' or 'fail', found 'ignore'"),
    ],
)  # fmt: skip
def test_what_can_t_be_is_refused_before_anything_is_rendered(
    temporary: Path, wrong: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error) as raised:
        match(**{"renderer": Right()} | wrong)
    assert message in str(raised.value)
    assert list(temporary.iterdir()) == []


def test_the_package_has_what_it_says_and_nothing_else() -> None:
    assert {name for name in lightproof.__all__ if getattr(lightproof, name) is not None} == {
        "VerdictError",
        "__version__",
        "assert_bounces_match",
    }
    with pytest.raises(AttributeError, match="module 'lightproof' has no attribute 'prove'"):
        lightproof.prove  # noqa: B018
