"""A renderer without depth control: it makes totals, and no single bounce.

With every albedo times s its total is Σ sᵏ TᵏE. So it is held against that for several s (``total.SCALES``); s = 0
leaves E, which is bounce 0. To solve for the later bounces is hopeless: for five of them the condition is 4·10³.
So nothing is said of each by itself.
"""

from __future__ import annotations

import time
from pathlib import Path

from msgspec.structs import replace

from comparisons.crew import Crew
from comparisons.in_process import InProcess
from comparisons.known import declared
from comparisons.renderers import canonical, traits
from comparisons.results import Comparison, TotalResult
from comparisons.sequential import Sampler, first_seed
from comparisons.settings import Observer, Settings
from comparisons.shown import shown, write_truth
from comparisons.total import SCALES, Totalling, counted, said_of
from comparisons.verdict import overall
from comparisons.whole_sum import Series
from scenes import Case

_TRUTH = "truth-bounce0"


def by_totals(
    refused: Comparison,
    case: Case,
    series: Series,
    settings: Settings,
    crew: Crew,
    observer: Observer,
    guest: InProcess | None,
    folder: Path | None,
) -> Comparison:
    """Hold its totals against the sums, in equal parts of the budget.

    Args:
        refused: the comparison by bounces that came to nothing.
        case, series, settings, crew, observer, guest: as of ``Comparing``.
        folder: for images; None for none.
    """
    start, renderer = time.monotonic(), refused.renderer
    name = guest.name if guest else canonical(renderer)
    known = declared(list(settings.known), case.name, name, refused.renderer_version)

    def show(share: float) -> None:
        observer.progressed(share, "totals, with darker and darker surfaces")

    others = (1 + len(SCALES)) * case.scene.channels
    of = guest.traits if guest else traits(name)
    try:
        (dark, sampler), totals = _rows(
            Totalling(case, name, series, settings, crew, of, known, others, show)
        )
    finally:
        crew.dismiss(name)
    bounces = [dark.result] if dark.result else []
    verdicts = counted([dark, *totals])
    if not verdicts:  # nothing was compared, and each of them says why
        return replace(
            refused, message=next(t.message for t in (*totals[::-1], dark) if t.message), totals=totals
        )
    later = f"{refused.message}; no bounce from 1 on can be seen by itself"
    return replace(
        refused,
        verdict=overall(verdicts),
        seconds=time.monotonic() - start,
        spp=max((t.result.spp for t in totals if t.result), default=0),
        replicates=max((t.result.replicates for t in totals if t.result), default=0),
        bounces=bounces,
        totals=totals,
        message=said_of([dark, *totals]),
        log=[line for total in (dark, *totals) for line in total.log],
        notes=[later, *_unsaid(dark)],
        **(_seen(sampler, series, case, renderer, name, settings, folder) if bounces and sampler else {}),
    )


def _rows(work: Totalling) -> tuple[tuple[TotalResult, Sampler | None], list[TotalResult]]:
    """For s = 0, with the images behind it, and for all other s."""
    budget = work.settings.budget / (1 + len(SCALES))
    dark, sampler = work.row(0.0, budget)
    totals = list[TotalResult]()
    for scale in SCALES:
        if "error" not in counted([dark, *totals]):  # what has crashed or hung once will do so again
            totals.append(work.row(scale, budget)[0])
    return (dark, sampler), totals


def _unsaid(dark: TotalResult) -> list[str]:
    return [] if dark.result else [f"Bounce 0 by itself: {dark.message}"]


def _seen(
    sampler: Sampler,
    series: Series,
    case: Case,
    renderer: str,
    name: str,
    settings: Settings,
    folder: Path | None,
) -> dict[str, object]:
    """Images and metrics of bounce 0."""
    mean, error = sampler.pixels[0].mean[None], sampler.pixels[0].standard_error[None]
    made = f"{case.name}, {name}, black surfaces, first seed {first_seed(settings.seed)}"
    truth, errors = series.terms[:1], series.errors[:1]
    write_truth(folder, case, truth, errors, _TRUTH)
    return shown(folder, case, renderer, made, mean, error, truth, _TRUTH)
