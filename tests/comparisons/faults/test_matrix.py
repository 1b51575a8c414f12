"""Rows of the matrix: a gross fault, a sound variant, and what they add up to."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from comparisons.faults import FAULTS, SOUND_VARIANTS, held_out, trial
from comparisons.faults.matrix import Row, Summary, concluded, row, rows, tuned_on
from comparisons.faults.suite import QUICK, THOROUGH
from comparisons.faults.trial import Seen
from scenes import library


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two cases instead of all."""
    monkeypatch.setattr(trial, "QUICK", ("furnace-sphere", "quad-over-plane"))
    monkeypatch.setattr(trial, "THOROUGH", ())


def test_a_fault_is_caught_by_the_first_case_that_fails(few: None) -> None:
    found = row("lamps-invisible")
    assert (found.caught_by, found.verdict, found.bounce) == ("furnace-sphere", "fail", 0)
    assert found.bias == pytest.approx(-1)
    assert found.diagnosis is not None
    assert (found.diagnosis.suspect, found.right) == ("E", True)


def test_what_these_cases_do_not_show_is_not_caught_and_says_how_near_it_came(few: None) -> None:
    found = row("spot-smooth")
    assert (found.caught_by, found.diagnosis) == ("", None)
    assert " bounce " in found.nearest
    assert "detectable from" in found.nearest


def test_a_sound_variant_is_not_failed(few: None) -> None:
    found = row("single-precision")
    assert (found.operator, found.caught_by, found.cases) == (None, "", 1)


def test_a_row_can_be_concluded_again_from_what_was_kept(few: None, tmp_path: Path) -> None:
    found = row("lamps-invisible", keep=tmp_path)
    kept = msgspec.json.decode((tmp_path / "lamps-invisible.json").read_bytes(), type=Seen)
    assert concluded(FAULTS["lamps-invisible"], kept) == found


def test_rows_come_from_processes_of_their_own() -> None:
    [found] = rows(["seed-ignored"], jobs=1)
    assert (found.verdict, found.right) == ("error", True)


def made(name: str, operator: str | None, caught_by: str = "", unseen: str = "") -> Row:
    return Row(name=name, what="", operator=operator, seconds=1, cases=1, caught_by=caught_by, unseen=unseen)  # type: ignore[arg-type]


def test_a_missed_fault_and_a_failed_variant_break_the_promise() -> None:
    good = [made("a", "E", "case"), made("b", "G", unseen="no case has glass"), made("c", None)]
    assert Summary.of(good, 3.0).kept
    assert not Summary.of([*good, made("d", "R")], 3.0).kept
    assert not Summary.of([*good, made("e", None, "case")], 3.0).kept


@pytest.mark.parametrize(
    ("bias", "size"),
    [(-1.0, "-100 %"), (307.0, "+31,000 %"), (-0.996, "-100 %"), (0.0213, "+2.1 %"), (None, "")],
)
def test_a_bias_is_told_in_digits(bias: float | None, size: str) -> None:
    assert msgspec.structs.replace(made("a", "E", "case"), bias=bias).size == size


def test_the_catalogue_is_as_large_as_promised() -> None:
    assert len(FAULTS) >= 60
    assert {fault.operator for fault in FAULTS.values()} == {
        *("E", "G", "R"),
        *("series", "estimator", "sensor", "sampler"),
    }
    assert len([name for name in FAULTS if not tuned_on(name)]) == len(held_out.FAULTS) >= 40
    assert not set(FAULTS) & set(SOUND_VARIANTS)


def test_the_suite_is_of_the_library() -> None:
    assert len({*QUICK, *THOROUGH}) == len(QUICK) + len(THOROUGH)
    assert {*QUICK, *THOROUGH} <= set(library.CASES)
