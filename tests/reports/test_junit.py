"""junit.xml as a CI server reads it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import pytest
from junitparser import Error, Failure, JUnitXml, Skipped

from comparisons.results import Results
from reports import junit


def by_name(results: Results, folder: Path) -> dict[tuple[str, str], Any]:
    xml = JUnitXml.fromfile(str(junit.write(results, folder)))
    return {(test.classname, test.name): test for suite in xml for test in suite}


@pytest.fixture
def tests(results: Results, tmp_path: Path) -> dict[tuple[str, str], Any]:
    return by_name(results, tmp_path)


def test_one_suite_per_case_and_the_counts(results: Results, tmp_path: Path) -> None:
    xml = JUnitXml.fromfile(str(junit.write(results, tmp_path)))
    assert [suite.name for suite in xml] == [
        "cornell_box",
        "furnace",
        "sphere <script>alert(1)</script>",
        "spectral",
        "glass",
    ]
    assert (xml.tests, xml.failures, xml.errors, xml.skipped) == (17, 2, 2, 1)
    assert xml.time == pytest.approx(6 * 12.5, rel=1e-3)


def test_a_failure_carries_its_numbers(tests: dict[tuple[str, str], Any]) -> None:
    [result] = tests["furnace.mitsuba", "bounce 1"].result
    assert isinstance(result, Failure)
    assert result.message == "Bounce 1 is 3.1 % high (interval +2.80 to +3.40 %, tolerance ±1.0 %): fail."
    assert "a second note" in result.text
    [in_tile] = tests["furnace.mitsuba", "bounce 2"].result
    assert in_tile.message.startswith("Bounce 2 in tile row 1, column 2 (channel R) is 12 % high")


def test_inconclusive_is_never_a_pass(tests: dict[tuple[str, str], Any]) -> None:
    [result] = tests["sphere <script>alert(1)</script>.reference", "bounce 1"].result
    assert isinstance(result, Error)
    assert result.type == "inconclusive"


def test_pass_and_known_pass(tests: dict[tuple[str, str], Any]) -> None:
    assert tests["cornell_box.mitsuba", "bounce 6"].is_passed
    known = tests["spectral.pyrender", "bounce 1"]
    assert known.is_passed
    assert "Known deviation, confirmed: rounding" in known.system_out
    assert "vanished" in tests["spectral.pyrender", "bounce 0"].system_out


def test_unsupported_is_skipped_and_a_crash_is_an_error(tests: dict[tuple[str, str], Any]) -> None:
    [skipped] = tests["glass.pyrender", "all bounces"].result
    assert isinstance(skipped, Skipped)
    assert "no dielectric materials" in skipped.message
    [error] = tests["furnace.broken", "all bounces"].result
    assert isinstance(error, Error)
    assert error.type == "renderer"
    assert "red bell" in error.text
    assert "]]> <script>alert(1)</script> & more" in error.text


@pytest.mark.parametrize("verdict", ["pass", "known", "fail", "inconclusive"])
def test_a_verdict_that_no_bounce_carries_is_never_green(
    results: Results, tmp_path: Path, verdict: Any
) -> None:
    empty = msgspec.structs.replace(results.comparisons[0], verdict=verdict, bounces=[])
    [test] = by_name(msgspec.structs.replace(results, comparisons=[empty]), tmp_path).values()
    assert not test.is_passed


def test_a_suite_per_relation_and_a_test_per_claim(with_relations: Results, tmp_path: Path) -> None:
    found = by_name(with_relations, tmp_path)
    assert found["superposition.mitsuba", "room"].is_passed
    [failure] = found["reciprocity.mitsuba", "room, 25° and 50°"].result
    assert isinstance(failure, Failure)
    assert failure.message.startswith("In bounce 1 the first side is 4.0 % above the second")
    [undecided] = found["linearity.mitsuba", "room"].result
    assert (type(undecided), undecided.type) == (Error, "inconclusive")
    assert "the budget was used up" in undecided.text
    known = found["rotation.mitsuba", "room"]
    assert known.is_passed
    assert "as declared: known. Known deviation, confirmed: the ray offset" in known.system_out
    [skipped] = found["homogeneity.mitsuba", "room"].result
    assert isinstance(skipped, Skipped)
    [crash] = found["scaling.mitsuba", "room"].result
    assert (type(crash), crash.type) == (Error, "renderer")
    xml = JUnitXml.fromfile(str(tmp_path / "junit.xml"))
    assert "relation seeds" in [suite.name for suite in xml]
    assert (xml.tests, xml.failures, xml.errors, xml.skipped) == (17 + 7, 2 + 2, 2 + 2, 1 + 1)
