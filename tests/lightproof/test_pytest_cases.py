"""Cases as tests: a suite that asks the plugin for them, beside its own or alone."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import pytest

from scenes import library

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("pytest_run.py"))))
Run, message, run = shared.Run, shared.message, shared.run

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


one_run = pytest.mark.xdist_group("cases as tests")


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


@one_run
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


@one_run
def test_a_case_that_fails_shows_the_table_and_no_traceback(cases: Run) -> None:
    text = message(cases.tests["dim[mitsuba]"])
    assert re.search(r"dim × mitsuba: Bounce 2 is (2\.|3\.).* % high", text)
    assert re.search(r"^ *dim .*\bmitsuba\b.* fail$|^ *dim +mitsuba +fail ", text, re.MULTILINE)
    assert ".py" not in text
    assert re.search(r"^FAILED lightproof::dim\[mitsuba\]", cases.text, re.MULTILINE)


@one_run
def test_a_known_deviation_passes_and_is_named(cases: Run) -> None:
    _, _, end = cases.text.partition("lightproof: known deviations")
    assert re.match(r" =+\nfurnace-sphere × mitsuba: Bounce 1 is 1\.\d+ % high .* as declared: known", end)


@one_run
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
