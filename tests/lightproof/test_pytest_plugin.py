"""The plugin as a test suite meets it: pytest in a process of its own, in a folder that knows nothing of ours."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Sequence
from importlib.metadata import entry_points
from pathlib import Path
from typing import NamedTuple

import pytest
from junitparser import JUnitXml, TestCase

from lightproof.pytest_host import folder_names
from scenes import library

# the latter: an installation in place that is older than the entry point
PLUGIN = "lightproof" if entry_points(group="pytest11", name="lightproof") else "lightproof.pytest_plugin"
# without hypothesis, which none of these suites uses, and which takes half a second of each to import
PYTEST = [sys.executable, "-m", "pytest", "-p", PLUGIN, "-p", "no:hypothesispytest"]
ENVIRONMENT = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}


class Run(NamedTuple):
    """What became of it."""

    folder: Path
    status: int
    text: str

    @property
    def tests(self) -> dict[str, TestCase]:
        """From the JUnit file."""
        return {
            test.name: test for suite in JUnitXml.fromfile(str(self.folder / "junit.xml")) for test in suite
        }


def run(folder: Path, *arguments: str, files: dict[str, str] | None = None) -> Run:
    for name, text in (files or {}).items():
        (folder / name).write_text(text)
    done = subprocess.run(
        [*PYTEST, *arguments], cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=300
    )
    return Run(folder, done.returncode, done.stdout + done.stderr)


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


@pytest.fixture(scope="module")
def suite(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Of a project whose warnings are errors."""
    return run(
        tmp_path_factory.mktemp("suite"),
        *("-W", "error", "-ra", "--junitxml=junit.xml", "--basetemp=temporary"),
        files={"renderers.py": RENDERERS, "test_own.py": TESTS},
    )


def message(test: TestCase) -> str:
    [result] = test.result
    return str(result.text or result.message)


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


def test_what_agrees_leaves_nothing(suite: Run) -> None:
    left = {path.parents[1].name for path in (suite.folder / "temporary").rglob("results.json")}
    wrong = {"test_brighter[a/b]", "test_noisy", "test_not_skipped", "test_broken"}
    assert left == {name for test in wrong for name in list(folder_names(f"test_own.py::{test}"))[1:]}


def test_the_message_is_plain_and_shows_none_of_our_own_code(suite: Run) -> None:
    assert "\x1b" not in suite.text
    # a traceback is of the test alone
    assert set(re.findall(r"^(\S+\.py):\d+: ", suite.text, re.MULTILINE)) == {"test_own.py"}


def test_inconclusive_says_what_is_needed(suite: Run) -> None:
    text = message(suite.tests["test_noisy"])
    assert "inconclusive, which is not a pass" in text
    assert "The budget of 0.5 s was used up" in text
    assert re.search(
        r"A renderer without bias should pass with a budget of \d+ s, or with a tolerance of \d+ %", text
    )


def test_unsupported_is_skipped_or_fails_as_the_test_says(suite: Run) -> None:
    for name in ("test_skipped", "test_not_skipped"):
        assert "furnace-box × WithoutBoxes: unsupported, boxes" in message(suite.tests[name])


def test_an_exception_is_shown_with_the_renderer_s_own_lines(suite: Run) -> None:
    text = message(suite.tests["test_broken"])
    assert "furnace-box × Broken: error, RuntimeError: out of texture memory" in text
    assert 'raise RuntimeError("out of texture memory")' in text


def test_a_mistake_is_shown_where_it_was_made(suite: Run) -> None:
    text = message(suite.tests["test_mistaken"])
    assert "no case is called 'furnace-bax': did you mean furnace-box" in text
    assert "def look_up" not in text


# ---- cases as tests

OWN_CASE = '''
from dataclasses import replace
from scenes import Formula, library

def dim():
    """An answer that is 3 % too low from bounce 2 on, so that whoever is right fails."""
    box = library.case("furnace-box")
    def evaluate(scene, bounces):
        images = box.answer.truth(scene, bounces).mean.copy()
        images[2:] *= 0.97
        return images
    return replace(box, name="dim", answer=Formula(evaluate, "wrong on purpose"), bounces=2)

def sphere():
    """The case of that name, of whose bounce 1 in Mitsuba a deviation is declared, without the later ones."""
    return replace(library.case("furnace-sphere"), bounces=1)
'''


@pytest.fixture(scope="module")
def cases(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Mitsuba on two workers: a declared deviation, a light that it lacks, an answer that is wrong."""
    names = ["own.py:sphere", "harmonics-on-sphere", "own.py:dim"]
    return run(
        tmp_path_factory.mktemp("cases"),
        "--lightproof-renderer=mitsuba",
        *(f"--lightproof-case={name}" for name in names),
        *("--lightproof-size=8x8", "--lightproof-report=reports", "-n2", "-ra", "--junitxml=junit.xml"),
        files={"own.py": OWN_CASE, "test_other.py": "def test_other(): assert False"},
    )


def test_every_case_is_a_test_on_any_worker(cases: Run) -> None:
    outcomes = {name: [type(result).__name__ for result in test.result] for name, test in cases.tests.items()}
    assert outcomes == {
        "furnace-sphere[mitsuba]": [],
        "harmonics-on-sphere[mitsuba]": ["Skipped"],
        "dim[mitsuba]": ["Failure"],
    }
    assert {test.classname for test in cases.tests.values()} == {"lightproof"}
    assert "spherical_harmonics light" in message(cases.tests["harmonics-on-sphere[mitsuba]"])
    assert cases.status == 1


def test_a_case_that_fails_shows_the_table_and_no_traceback(cases: Run) -> None:
    text = message(cases.tests["dim[mitsuba]"])
    assert re.search(r"dim × mitsuba: Bounce 2 is (2\.|3\.).* % high", text)
    assert re.search(r"^ *dim .*\bmitsuba\b.* fail$|^ *dim +mitsuba +fail ", text, re.MULTILINE)
    assert ".py" not in text
    assert re.search(r"^FAILED lightproof::dim\[mitsuba\]", cases.text, re.MULTILINE)


def test_a_known_deviation_passes_and_is_named(cases: Run) -> None:
    _, _, end = cases.text.partition("lightproof: known deviations")
    assert re.match(r" =+\nfurnace-sphere × mitsuba: Bounce 1 is 1\.\d+ % high .* as declared: known", end)


def test_the_reports_are_kept_where_one_asks_for_them(cases: Run) -> None:
    found = {str(path.relative_to(cases.folder / "reports")) for path in cases.folder.rglob("report.html")}
    assert found == {
        "lightproof/furnace-sphere[mitsuba]/furnace-sphere/report.html",
        "lightproof/harmonics-on-sphere[mitsuba]/harmonics-on-sphere/report.html",
        "lightproof/dim[mitsuba]/dim/report.html",
    }


OTHER = {"test_other.py": "def test_other(): pass"}
IN_CONFIGURATION = {
    **OTHER,
    "pytest.ini": "[pytest]\naddopts = --lightproof-renderer=reference --lightproof-case=furnace-box",
}
BOX = ["--lightproof-renderer=reference", "--lightproof-case=furnace-box"]


@pytest.mark.parametrize(
    ("arguments", "files", "expected"),
    [
        (BOX, OTHER, ["lightproof::furnace-box[reference]"]),
        ([*BOX, "."], OTHER, ["test_other.py::test_other", "lightproof::furnace-box[reference]"]),
        ([], IN_CONFIGURATION, ["test_other.py::test_other", "lightproof::furnace-box[reference]"]),
        (
            [
                "--lightproof-renderer=reference:nee",
                "--lightproof-renderer=mitsuba",
                "--lightproof-few",
                "-k",
                "sphere and mitsuba",
            ],
            OTHER,
            ["lightproof::furnace-sphere[mitsuba]", "lightproof::integrating-sphere[mitsuba]"],
        ),
        (
            ["--lightproof-renderer=mitsuba", "--lightproof-few", "lightproof::integrating-sphere[mitsuba]"],
            OTHER,
            ["lightproof::integrating-sphere[mitsuba]"],
        ),
        ([], OTHER, ["test_other.py::test_other"]),
    ],
    ids=["alone", "beside a path", "in the configuration", "-k", "by node id", "not asked for"],
)  # fmt: skip
def test_what_is_collected(
    tmp_path: Path, arguments: Sequence[str], files: dict[str, str], expected: list[str]
) -> None:
    found = run(tmp_path, "--collect-only", "-q", *arguments, files=files)
    assert found.status == 0
    assert [line for line in found.text.splitlines() if "::" in line] == expected


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], f"cases: {len(library.CASES)}, --lightproof-few takes 4"),
        (["--lightproof-few"], "cases: 4"),
        (["--lightproof-case=furnace-box"], "cases: 1"),
    ],
    ids=["all", "few", "one"],
)
def test_the_head_of_the_run_says_how_many_cases(tmp_path: Path, arguments: Sequence[str], said: str) -> None:
    found = run(tmp_path, "--collect-only", "--lightproof-renderer=reference", *arguments)
    assert f"lightproof: {said}" in found.text.splitlines()


def test_x_stops_at_the_first_that_fails_and_lf_takes_it_up(tmp_path: Path) -> None:
    """The answer is wrong by 3 %, and 1 % is soon seen."""
    tolerances = ["--lightproof-tolerance=1%", "--lightproof-tile-tolerance=20%", "--lightproof-size=8x8"]
    renderers = ["--lightproof-renderer=reference:nee", "--lightproof-renderer=reference"]
    asked = [*renderers, "--lightproof-case=own.py:dim"]
    found = run(tmp_path, *asked, *tolerances, "-x", files={"own.py": OWN_CASE})
    assert "collected 2 items" in found.text
    assert re.search(r"^=+ 1 failed in ", found.text, re.MULTILINE)
    assert "dim × reference:nee: Bounce 2 is 3." in found.text
    again = run(tmp_path, *asked, "--lf", "--collect-only", "-q")
    assert again.text.startswith("lightproof::dim[reference:nee]\n\n1/2 tests collected")


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--lightproof-renderer=mitsubishi"], "no renderer is called 'mitsubishi': did you mean mitsuba"),
        (
            ["--lightproof-renderer=mitsuba", "--lightproof-case=furnace-bax"],
            "--lightproof-case: no case is called 'furnace-bax': did you mean furnace-box",
        ),
        (["--lightproof-renderer=mitsuba", "--lightproof-size=8"], "--lightproof-size: '8': expected WIDTHxHEIGHT"),
        (["--lightproof-few"], "--lightproof-few: say of which renderer, --lightproof-renderer NAME"),
        (["--lightproof-budget=0"], "--lightproof-budget: expected seconds above 0, found 0"),
        ([*BOX, "lightproof::furnace-bax[reference]"], "did you mean furnace-box[reference]"),
    ],
)  # fmt: skip
def test_wrong_usage_is_explained(tmp_path: Path, arguments: list[str], complaint: str) -> None:
    found = run(tmp_path, *arguments)
    assert found.status == pytest.ExitCode.USAGE_ERROR
    assert complaint in found.text
    assert "Traceback" not in found.text


def test_help_teaches_the_options(tmp_path: Path) -> None:
    _, _, section = run(tmp_path, "--help").text.partition("\nlightproof: ")
    for option in ("renderer", "case", "few", "size", "tolerance", "tile-tolerance", "budget", "report"):
        assert re.search(rf"^  --lightproof-{option}\b", section, re.MULTILINE), option


# ---- those who don't use it

UNUSED = """
import sys

def test_nothing_is_loaded():
    heavy = {"numpy", "scenes", "reference_tracer", "comparisons", "reports", "typer", "rich"}
    assert not heavy & set(sys.modules)
"""


def test_whoever_does_not_use_it_loads_nothing(tmp_path: Path) -> None:
    found = run(tmp_path, "-q", files={"test_unused.py": UNUSED})
    assert (found.status, "1 passed" in found.text) == (0, True), found.text


# ---- names of folders


def test_node_ids_as_folders() -> None:
    assert list(folder_names("tests/test_a.py::Test::test_b[x-1]")) == [
        "tests",
        "test_a.py",
        "Test",
        "test_b[x-1]",
    ]


@pytest.mark.parametrize(
    "hostile", ["../../etc/test_a.py::t", "a.py::t[" + "x" * 300 + "]", "a.py::t[<\x00é>]"]
)
def test_hostile_node_ids_stay_inside_and_apart(hostile: str) -> None:
    names = list(folder_names(hostile))
    assert all(re.fullmatch(r"[\w.,=+\[\]-]+", name, re.ASCII) and len(name) < 120 for name in names)
    assert not {"..", ".", ""} & set(names)
    assert names != list(folder_names(hostile + "?"))
