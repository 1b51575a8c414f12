"""``junit.xml``: a suite per case, a test per renderer and bounce or total; a suite per relation, a test per claim.

JUnit knows four results, results.json six. None of the two extra ones may look like agreement:

=============  ===================================================================
pass           passed
known          passed, and says in ``system-out`` what is known
fail           ``failure``
inconclusive   ``error`` of type ``inconclusive``
error          ``error`` of type ``renderer``
unsupported    ``skipped``
=============  ===================================================================
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from junitparser import Error, Failure, JUnitXml, Skipped, TestCase, TestSuite

from comparisons.results import BounceResult, Comparison, RelationResult, Results, TotalResult
from reports import JUNIT_FILE, quantities, wording
from reports.plain import plain


def write(results: Results, folder: Path) -> Path:
    """Write ``junit.xml`` into the folder and return its path."""
    xml = JUnitXml("lightproof")
    for case in dict.fromkeys(comparison.case for comparison in results.comparisons):
        suite = TestSuite(plain(case))
        suite.timestamp = plain(results.provenance.date)
        for comparison in results.comparisons:
            if comparison.case == case:
                suite.add_testcases(_tests(comparison))
        xml.append(suite)
    for relation in dict.fromkeys(result.relation for result in results.relations):
        suite = TestSuite(plain(f"relation {relation}"))
        suite.timestamp = plain(results.provenance.date)
        suite.add_testcases([_claim(result) for result in results.relations if result.relation == relation])
        xml.append(suite)
    xml.update_statistics()
    path = folder / JUNIT_FILE
    xml.write(str(path), pretty=True)
    return path


def _tests(comparison: Comparison) -> list[Any]:
    """The tests of one comparison, which share its time evenly."""
    name = plain(f"{comparison.case}.{comparison.renderer}")
    tests = []
    for bounce in comparison.bounces:
        test = TestCase(wording.subject(comparison, bounce).removeprefix("The ").lower(), name)
        _judge_bounce(test, bounce, comparison)
        tests.append(test)
    for total in comparison.totals:
        test = TestCase(quantities.total_name(total), name)
        _judge_total(test, total, comparison)
        tests.append(test)
    # a verdict that no bounce carries still has to turn the run red, so it gets a test of its own
    covered = {"pass", "known"} if comparison.bounces else set()
    judged = {b.verdict for b in comparison.bounces} | {t.verdict for t in comparison.totals}
    if comparison.verdict not in covered | judged:
        test = TestCase("all bounces", name)
        _judge_whole(test, comparison)
        tests.append(test)
    for test in tests:
        test.time = round(comparison.seconds / len(tests), 3)
    return tests


def _judge_bounce(test: Any, bounce: BounceResult, comparison: Comparison) -> None:
    _judge(
        test, bounce, plain(wording.bounce_finding(bounce, wording.subject(comparison, bounce))), comparison
    )


def _judge(test: Any, bounce: BounceResult, message: str, comparison: Comparison) -> None:
    declared = _declared(bounce)
    if bounce.verdict == "fail":
        test.result = _with_text(Failure(message, "fail"), comparison, declared)
    elif bounce.verdict == "inconclusive":
        test.result = _with_text(Error(message, "inconclusive"), comparison, declared)
    elif declared:
        test.system_out = plain(f"{message} {declared}")


def _judge_total(test: Any, total: TotalResult, comparison: Comparison) -> None:
    if total.result is not None:
        _judge(test, total.result, plain(wording.total_finding(total)), comparison)
    elif total.verdict == "unsupported":
        test.result = Skipped(plain(total.message), "unsupported")
    else:
        error = Error(plain(total.message), "renderer")
        error.text = plain("\n".join(total.log))
        test.result = error


def _declared(bounce: BounceResult) -> str:
    """What was declared of a bounce, and what became of it; empty if nothing was."""
    known = bounce.known
    return f"Known deviation, {known.state}: {known.reason} {known.link}" if known else ""


def _judge_whole(test: Any, comparison: Comparison) -> None:
    message = plain(" ".join(filter(None, (wording.finding(comparison), comparison.message))))
    match comparison.verdict:
        case "unsupported":
            test.result = Skipped(message, "unsupported")
        case "fail":
            test.result = _with_text(Failure(message, "fail"), comparison)
        case "inconclusive":
            test.result = _with_text(Error(message, "inconclusive"), comparison)
        case "error":
            test.result = _with_text(Error(message, "renderer"), comparison)
        case "pass" | "known":
            test.result = Error("No bounce was compared, though the verdict says so.", "inconclusive")


def _claim(result: RelationResult) -> Any:
    """The test of one claim."""
    name = ", ".join(filter(None, (result.scene, result.claim)))
    test = TestCase(plain(name), plain(f"{result.relation}.{result.renderer}"), round(result.seconds, 3))
    message = plain(wording.relation_finding(result))
    match result.verdict:
        case "fail":
            test.result = Failure(message, "fail")
        case "inconclusive" | "error":
            test.result = Error(message, "renderer" if result.verdict == "error" else "inconclusive")
        case "unsupported":
            test.result = Skipped(message, "unsupported")
    declared = dict.fromkeys(_declared(bounce) for bounce in result.bounces)
    if test.result:
        lines = [result.statement, *declared, result.message, *result.notes, *result.log]
        test.result[0].text = plain("\n".join(filter(None, lines)))
    elif any(declared):
        test.system_out = plain(" ".join(filter(None, [message, *declared])))
    return test


def _with_text(result: Any, comparison: Comparison, declared: str = "") -> Any:
    """Add what a reader of the log needs next: what was declared, the message, the renderer's last lines."""
    lines = [declared, comparison.message, *comparison.notes, *comparison.log]
    result.text = plain("\n".join(filter(None, lines)))
    return result
