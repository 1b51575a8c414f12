"""The assertion in the tests of a suite, the options of the plugin, and that those who don't use it load nothing."""

from __future__ import annotations

import re
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import pytest

from lightproof.pytest_host import folder_names

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("pytest_run.py"))))
Run, message, run = shared.Run, shared.message, shared.run


# ---- assertions in tests

RENDERERS = '''
"""Renderers of the tests' own: the truth with noise, 5 % for a sample of a pixel."""
from functools import cache
import numpy as np
from comparisons.renderers import Unsupported
from scenes import library

CASES = [library.case(name) for name in ("furnace-box", "integrating-sphere", "quad-over-plane", "cornell-box")]

@cache
def truth(name, width, height, last):
    case = library.case(name)
    return case.answer.truth(case.scene.resized(width, height), last).mean

class Right:
    noise = 0.05

    def version(self):
        return "1"

    def render(self, scene, bounces, spp, seed):
        case = next(case for case in CASES if case.scene.surfaces == scene.surfaces)
        means = truth(case.name, scene.sensor.width, scene.sensor.height, max(bounces))[bounces,]
        return means * np.random.default_rng(seed).normal(1, self.noise / spp**0.5, means.shape)

class Brighter(Right):
    def render(self, scene, bounces, spp, seed):
        factors = [1.03 if k == 2 else 1 for k in bounces]
        return super().render(scene, bounces, spp, seed) * np.reshape(factors, (-1, 1, 1, 1))

class Noisy(Right):
    noise = 50.0

    def render(self, scene, bounces, spp, seed):
        return super().render(scene, bounces, 1, seed)  # however many are asked for

class WithoutBoxes(Right):
    def render(self, scene, bounces, spp, seed):
        raise Unsupported("boxes")

class Broken(Right):
    def render(self, scene, bounces, spp, seed):
        raise RuntimeError("out of texture memory")
'''

TESTS = """
import renderers
import pytest
from lightproof import VerdictError, assert_bounces_match

SMALL = {"size": (8, 8), "bounces": 3, "budget": 30}

def test_right(lightproof):
    found = lightproof.assert_bounces_match(renderers.Right(), "furnace-box", tolerance="0.5%", **SMALL)
    assert [b.verdict for b in found.bounces] == ["pass"] * 4
    assert max(b.tolerance for b in found.bounces) == 0.005

def test_right_without_the_fixture():
    assert_bounces_match(renderers.Right(), "furnace-box", **SMALL)

@pytest.mark.parametrize("what", ["a/b"])
def test_brighter(lightproof, what):
    lightproof.assert_bounces_match(renderers.Right(), "furnace-box", **SMALL)
    lightproof.assert_bounces_match(renderers.Brighter(), "furnace-box", **SMALL)

def test_noisy(lightproof):
    lightproof.assert_bounces_match(renderers.Noisy(), "furnace-box", **{**SMALL, "budget": 0.5})

def test_skipped(lightproof):
    lightproof.assert_bounces_match(renderers.WithoutBoxes(), "furnace-box", **SMALL)

def test_not_skipped(lightproof):
    lightproof.assert_bounces_match(renderers.WithoutBoxes(), "furnace-box", unsupported="fail", **SMALL)

def test_broken(lightproof):
    lightproof.assert_bounces_match(renderers.Broken(), "furnace-box", **SMALL)

def test_mistaken(lightproof):
    lightproof.assert_bounces_match(renderers.Right(), "furnace-bax")
"""


one_run = pytest.mark.xdist_group("suite")


@pytest.fixture(scope="module")
def suite(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Of a project whose warnings are errors."""
    return run(
        tmp_path_factory.mktemp("suite"),
        *("-W", "error", "-ra", "--junitxml=junit.xml", "--basetemp=temporary"),
        files={"renderers.py": RENDERERS, "test_own.py": TESTS},
    )


@one_run
def test_outcomes(suite: Run) -> None:
    outcomes = {name: [type(result).__name__ for result in test.result] for name, test in suite.tests.items()}
    assert outcomes == {
        "test_right": [],
        "test_right_without_the_fixture": [],
        "test_brighter[a/b]": ["Failure"],
        "test_noisy": ["Failure"],
        "test_skipped": ["Skipped"],
        "test_not_skipped": ["Failure"],
        "test_broken": ["Failure"],
        "test_mistaken": ["Failure"],
    }


@one_run
def test_a_fail_prints_the_table_of_verdicts_and_leaves_the_report(suite: Run) -> None:
    text = message(suite.tests["test_brighter[a/b]"])
    assert re.search(r"furnace-box × Brighter: Bounce 2 is (2\.[89]|3\.[012])\d* % high \(.*\): fail\.", text)
    table = text[text.index("fail.") : text.index("Bias of the whole image in percent")]
    assert re.search(r"furnace-box .*\bBrighter\b.* fail\b", table)
    [marked] = re.findall(r"(\S+)±\S+!", table)
    assert float(marked) == pytest.approx(3.0, abs=0.1)
    [report] = re.findall(r"Report: (.*)", text)
    assert "Brighter" in Path(report).read_text()
    *folders, name = Path(report).relative_to(suite.folder / "temporary" / "lightproof").parts
    assert folders == [
        *folder_names("test_own.py::test_brighter[a/b]"),
        "furnace-box-2",
    ]  # its second of this case
    assert name == "report.html"


@one_run
def test_what_agrees_leaves_nothing(suite: Run) -> None:
    left = {path.parents[1].name for path in (suite.folder / "temporary").rglob("results.json")}
    wrong = {"test_brighter[a/b]", "test_noisy", "test_not_skipped", "test_broken"}
    assert left == {name for test in wrong for name in list(folder_names(f"test_own.py::{test}"))[1:]}


@one_run
def test_the_message_is_plain_and_shows_none_of_our_own_code(suite: Run) -> None:
    assert "\x1b" not in suite.text
    # a traceback is of the test alone
    assert set(re.findall(r"^(\S+\.py):\d+: ", suite.text, re.MULTILINE)) == {"test_own.py"}


@one_run
def test_inconclusive_says_what_is_needed(suite: Run) -> None:
    text = message(suite.tests["test_noisy"])
    assert "inconclusive, which is not a pass" in text
    assert "The budget of 0.5 s was used up" in text
    assert re.search(
        r"A renderer without bias should pass with a budget of \d+ s, or with a tolerance of \d+ %", text
    )


@one_run
def test_unsupported_is_skipped_or_fails_as_the_test_says(suite: Run) -> None:
    for name in ("test_skipped", "test_not_skipped"):
        assert "furnace-box × WithoutBoxes: unsupported, boxes" in message(suite.tests[name])


@one_run
def test_an_exception_is_shown_with_the_renderer_s_own_lines(suite: Run) -> None:
    text = message(suite.tests["test_broken"])
    assert "furnace-box × Broken: error, RuntimeError: out of texture memory" in text
    assert 'raise RuntimeError("out of texture memory")' in text


@one_run
def test_a_mistake_is_shown_where_it_was_made(suite: Run) -> None:
    text = message(suite.tests["test_mistaken"])
    assert "no case is called 'furnace-bax': did you mean furnace-box" in text
    assert "def look_up" not in text


# ---- its options, and those who don't use them


def test_help_teaches_the_options(tmp_path: Path) -> None:
    _, _, section = run(tmp_path, "--help").text.partition("\nlightproof: ")
    for option in ("renderer", "case", "few", "size", "tolerance", "tile-tolerance", "budget", "report"):
        assert re.search(rf"^  --lightproof-{option}\b", section, re.MULTILINE), option


UNUSED = """
import sys

def test_nothing_is_loaded():
    heavy = {"numpy", "scenes", "reference_tracer", "comparisons", "reports", "typer", "rich"}
    assert not heavy & set(sys.modules)
"""


def test_whoever_does_not_use_it_loads_nothing(tmp_path: Path) -> None:
    found = run(tmp_path, "-q", files={"test_unused.py": UNUSED})
    assert (found.status, "1 passed" in found.text) == (0, True), found.text
