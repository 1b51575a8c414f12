"""A whole validation: run it, write results.json, render the report."""

from __future__ import annotations

import os
import platform
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import reports
from comparisons import campaign, relations, results
from comparisons.diagnosis import diagnoses, inquiry
from comparisons.diagnosis.ways import other_ways
from comparisons.renderers import Renderer
from comparisons.results import Comparison, Provenance, RelationResult, Results, Verdict
from comparisons.sequential import first_seed
from comparisons.settings import Observer, Settings
from comparisons.verdict import overall
from scenes import Case

_PACKAGES = (
    "lightproof",
    "numpy",
    "scipy",
    "mitsuba",
    "OpenImageIO",
    "colour-science",
    "scikit-image",
    "flip-evaluator",
)

EXIT_STATUS: dict[Verdict, int] = {
    "pass": 0,
    "known": 0,
    "fail": 1,
    "error": 3,
    "inconclusive": 4,
    "unsupported": 5,
}
"""Of the command; 2 is wrong usage. ``unsupported`` counts only where nothing could be compared."""


def validate(
    cases: Sequence[Case],
    renderers: Sequence[str],
    settings: Settings,
    folder: Path,
    observer: Observer,
    tasks: Sequence[relations.Task] = (),
) -> Results:
    """Hold every case against every renderer, try the relations, and write the folder, report and all.

    Returns, raises: as ``compare``.
    """
    outcome = compare(cases, renderers, settings, folder, observer, tasks, why=True)
    reports.render(folder)
    return outcome


def compare(
    cases: Sequence[Case],
    renderers: Sequence[str | Renderer],
    settings: Settings,
    folder: Path,
    observer: Observer,
    tasks: Sequence[relations.Task] = (),
    why: bool = False,
) -> Results:
    """Hold every case against every renderer, try the relations, and write ``results.json`` and the images.

    Args:
        cases, renderers, settings, folder, observer: what, how, and where to; a renderer is a name, or an object of
            this process (``comparisons.in_process``).
        tasks: relations to try.
        why: ask again about what failed, which tells more of what is at fault (``comparisons.diagnosis.inquiry``).

    Returns:
        What ``results.json`` holds.

    Raises:
        UnknownNameError: there is no renderer of that name.
    """
    start, date = time.monotonic(), datetime.now(UTC)
    comparisons: list[Comparison] = []
    related: list[RelationResult] = []
    others: dict[str, list[Comparison]] = {}

    def write() -> Results:
        made = provenance(settings, date, time.monotonic() - start)
        found = diagnoses(comparisons, related, others)
        outcome = Results(provenance=made, comparisons=comparisons, relations=related, diagnoses=found)
        results.write(outcome, folder)
        return outcome

    for comparison in campaign.run(cases, renderers, settings, folder, observer):
        comparisons.append(comparison)
        write()  # after each, so that a run that is cut short keeps what it has found
    for result in relations.run(tasks, renderers, settings, observer):
        related.append(result)
        write()
    for name in [renderer for renderer in renderers if isinstance(renderer, str)] if why else ():
        for failed in [c for c in comparisons if (c.renderer, c.verdict) == (name, "fail")][: inquiry.CASES]:
            observer.started(f"{failed.case}, asked again", name)
            case = next(case for case in cases if case.name == failed.case)
            asked = replace(settings, budget=min(settings.budget, inquiry.BUDGET), total=False)
            answers, told = inquiry.inquire(case, failed, name, other_ways(name), asked)
            related.extend(answers)
            others.setdefault(name, []).extend(told)
            write()
    return write()


def exit_status(outcome: Results) -> int:
    """0 nothing wrong, 1 fail, 3 error, 4 inconclusive, 5 nothing could be compared; 1 before 3 before 4."""
    verdicts = [c.verdict for c in outcome.comparisons] + [r.verdict for r in outcome.relations]
    return EXIT_STATUS[overall(verdicts)]


def provenance(settings: Settings, date: datetime, seconds: float) -> Provenance:
    """What is needed to repeat a run that began at that date and took so long."""
    return Provenance(
        date=date.isoformat(timespec="seconds"),
        command_line=[Path(sys.argv[0]).name.replace("__main__.py", "lightproof"), *sys.argv[1:]],
        versions={"python": platform.python_version(), **{name: _version(name) for name in _PACKAGES}},
        platform=platform.platform(),
        processors=os.cpu_count() or 1,
        seed=settings.seed,
        seeds=f"replicate r = 0, 1, … has the seed {first_seed(settings.seed)} + r",
        budget=settings.budget,
        alpha=settings.alpha,
        jobs=settings.jobs,
        seconds=seconds,
    )


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
