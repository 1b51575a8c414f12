"""The total in the page, in JUnit and in sentences."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest
from junitparser import Error, Failure, JUnitXml, Skipped
from rich.console import Console

import reports
from comparisons.results import BounceResult, Comparison, Results, TotalResult, write
from lightproof.terminal import show_verdicts
from reports import junit, wording

UNKNOWN = "total: the truth adds up bounces 0 to 3 <b>, all that its answer has"


@pytest.fixture
def totals(make_bounce: Callable[..., BounceResult]) -> list[list[TotalResult]]:
    def of(verdict: Any, bias: float, **changes: Any) -> TotalResult:
        result = make_bounce(40, verdict, bias, truth=2.0)
        return TotalResult(verdict=verdict, result=result, truth="bounces 0 to 40", **changes)

    return [
        [of("pass", 0.001, tail=2e-5)],
        [of("fail", -0.07)],
        [TotalResult(verdict="unsupported", message=UNKNOWN)],
        [TotalResult(verdict="error", message="total: exit code 3", log=["goodbye"])],
        [of("pass", 0.001, scale=0.5), of("inconclusive", 0.009)],
    ]


@pytest.fixture
def run(
    results: Results,
    totals: list[list[TotalResult]],
    make_comparison: Callable[..., Comparison],
    make_bounce: Callable[..., BounceResult],
    tmp_path: Path,
) -> Results:
    verdicts = ("pass", "fail", "pass", "error", "inconclusive")
    found = [
        make_comparison(f"case{i}", "mine", verdict, [make_bounce(0, "pass")], totals=of_case)
        for i, (verdict, of_case) in enumerate(zip(verdicts, totals, strict=True))
    ]
    changed = msgspec.structs.replace(results, comparisons=found)
    write(changed, tmp_path)
    return changed


def test_a_ci_server_sees_a_test_of_its_own(run: Results, tmp_path: Path) -> None:
    xml = JUnitXml.fromfile(str(junit.write(run, tmp_path)))
    tests = {(test.classname, test.name): test for suite in xml for test in suite}
    assert not tests["case0.mine", "total"].result
    [failed] = tests["case1.mine", "total"].result
    assert isinstance(failed, Failure)
    assert failed.message.startswith("The total, by the renderer's own defaults, is 7.0 % low (interval")
    [skipped] = tests["case2.mine", "total"].result
    assert isinstance(skipped, Skipped)
    [error] = tests["case3.mine", "total"].result
    assert isinstance(error, Error)
    assert "goodbye" in error.text
    assert not tests["case4.mine", "total (albedo × ½)"].result
    [undecided] = tests["case4.mine", "total"].result
    assert (type(undecided), undecided.type) == (Error, "inconclusive")
    assert len(tests) == 5 + 6  # no test beside them for the whole of a comparison


def test_sentences(run: Results) -> None:
    passed, failed, unknown, crashed, scaled = run.comparisons
    assert wording.finding(passed).startswith("The only bounce and the total agree with the exact truth")
    assert wording.finding(failed).startswith("The total, by the renderer's own defaults, is 7.0 % low")
    assert wording.finding(unknown).startswith("The only bounce agrees")
    assert "exit code 3: error" in wording.total_finding(crashed.totals[0])
    assert wording.finding(scaled).startswith("The total, by the renderer's own defaults, is undecided")


def test_the_table_has_a_column_for_each(run: Results) -> None:
    text = io.StringIO()
    show_verdicts(Console(file=text, width=300, no_color=True, highlight=False), run)
    head, *rows = [line for line in text.getvalue().splitlines() if line.strip()][:8]
    assert head.split()[-5:] == ["total", "total", "(albedo", "×", "½)"]
    assert "+0.10±0.30" in rows[1]
    assert "−7.00±0.30!" in rows[2]
    assert "unsupported" in rows[3]
    assert rows[5].split()[-2:] == ["+0.90±0.30?", "+0.10±0.30"]
    narrow = io.StringIO()
    show_verdicts(Console(file=narrow, width=60, no_color=True, highlight=False), run)
    assert "total (albedo × ½) +0.10±0.30" in narrow.getvalue()


def test_the_page(run: Results, tmp_path: Path) -> None:
    path, _ = reports.render(tmp_path)
    text = path.read_text()
    assert '<th scope="col">Total<small>own defaults</small></th>' in text
    assert '<th scope="col">Total (albedo × ½)<small>own defaults</small></th>' in text
    assert "Its truth adds up bounces 0 to 40." in text
    assert "What follows holds 0.0020 % at most" in text
    assert "all that its answer has" in text
    assert "<b>, all" not in text


@pytest.mark.browser
def test_in_a_browser(run: Results, tmp_path: Path, open_report: Any) -> None:
    path, _ = reports.render(tmp_path)
    page = open_report(path)
    assert page.locator("table.verdicts tbody tr").count() == 5
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
