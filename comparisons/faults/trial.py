"""A trial: a planted fault, or a sound variant, put to the suite of cases.

The cases come one after the other, as they would to somebody who knows nothing of the fault. Into the first that fail
there is an inquiry, and more cases follow until the diagnosis is sure, or there are none left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from time import monotonic

from msgspec import Struct

from comparisons import campaign, relations
from comparisons.diagnosis import diagnose, inquiry
from comparisons.diagnosis.ways import WAYS, heard
from comparisons.faults import FAULTS, SOUND_VARIANTS
from comparisons.faults.deviation import deviations
from comparisons.faults.fault import Fault, Sound
from comparisons.faults.planting import Named
from comparisons.faults.suite import QUICK, THOROUGH, case
from comparisons.relations import RELATIONS, STAGES, Subject, Task
from comparisons.renderers import Renderer, create
from comparisons.results import Comparison, RelationResult
from comparisons.settings import Settings, Silent

TRACER = "reference"
"""What faults are planted in."""

BUDGET, LONG_BUDGET, FIRST_LOOK = 1.2, 8.0, 0.1
"""Seconds per case; and of those that were left open, where nothing has failed."""

INQUIRY = Settings(budget=0.6, first_look=0.1, total=False)
"""How to ask again about the first cases that fail."""

LEAST_CASES = 5
"""Cases before a diagnosis ends a row: they have lamps and points, with what hides them and without."""

CASES_AFTER, MOST_AFTER = 3, 8
"""Further ones after the first that fails, at least, since one failure alone looks like whatever that case is about;
and at most."""


class Seen(Struct, frozen=True, kw_only=True):
    """All that was seen of one renderer.

    Attributes:
        comparisons: in the order of the cases.
        relations, others: what inquiries found; see ``diagnosis.inquiry``.
        seconds: since the start, when each comparison was done.
    """

    comparisons: list[Comparison] = []
    relations: list[RelationResult] = []
    others: list[Comparison] = []
    seconds: list[float] = []


def seen(entry: Fault | Sound, seed: int = 0) -> Seen:
    """What the first relation and the cases say of it, until that is clear.

    Where no quick case fails, the thorough ones follow; where none of these does either, those that were left open
    are given more time.
    """
    renderer = Named(entry.plant(create(TRACER)), entry.name)
    ways = [Named(entry.plant(create(way)), way) for way in WAYS]
    found, start = Seen(relations=_first_hits(renderer, seed)), monotonic()

    def run(names: Sequence[str], budget: float) -> None:
        settings = Settings(budget=budget, seed=seed, first_look=FIRST_LOOK, total=False)
        for comparison in campaign.run(map(case, names), [renderer], settings, None, Silent()):
            found.comparisons.append(comparison)
            found.seconds.append(monotonic() - start)
            if comparison.verdict == "fail":
                _inquire(comparison, renderer, ways, replace(INQUIRY, seed=seed), found)
            if isinstance(entry, Fault) and _clear(found):
                return

    run(_quick(entry), BUDGET)
    if isinstance(entry, Fault) and not entry.unseen and caught(found) is None:
        run(THOROUGH, BUDGET)
    if isinstance(entry, Fault) and not entry.unseen and caught(found) is None:
        left_open = [c for c in found.comparisons if c.verdict == "inconclusive"]
        run([c.case for c in sorted(left_open, key=_suspicion, reverse=True)], LONG_BUDGET)
    return found


def _quick(entry: Fault | Sound) -> Sequence[str]:
    """All quick cases for a fault that some case must see; every fourth one for what none may fail, in turn."""
    if isinstance(entry, Fault) and not entry.unseen:
        return QUICK
    catalogue = FAULTS if isinstance(entry, Fault) else SOUND_VARIANTS
    return QUICK[list(catalogue).index(entry.name) % 4 :: 4]


def _inquire(
    failed: Comparison,
    renderer: Renderer,
    ways: Sequence[Renderer],
    settings: Settings,
    found: Seen,
) -> None:
    """Add what is found out about a case that failed: first hits of each, the rest until the ways have spoken."""
    asked = len({c.case for c in found.others})
    spoken = heard(found.comparisons, found.others).keys() >= {"chance", "next event"}
    answers, others = inquiry.inquire(
        case(failed.case),
        failed,
        renderer,
        ways if asked < inquiry.CASES and not spoken else (),
        settings,
        thoroughly=asked == 0,
    )
    found.relations.extend(answers)
    found.others.extend(others)


def _first_hits(renderer: Renderer, seed: int) -> list[RelationResult]:
    relation = RELATIONS["first-hits"]
    tasks = [Task(relation, Subject(name, STAGES[name]())) for name in relation.scenes]
    return list(relations.run(tasks, [renderer], Settings(seed=seed), Silent()))


def _clear(found: Seen) -> bool:
    """Whether further cases would hardly change what is said of it."""
    first = caught(found)
    if first is None:
        return False
    if first >= len(QUICK) + len(THOROUGH):  # it took a second run, and nothing that is seen at once is left
        return True
    if len(found.comparisons) < max(LEAST_CASES, first + 1 + CASES_AFTER):
        return False
    late = first >= len(QUICK) or len(found.comparisons) >= max(LEAST_CASES, first + 1 + MOST_AFTER)
    return late or diagnose(found.comparisons, found.relations, found.others).suspect is not None


def _suspicion(comparison: Comparison) -> float:
    """How near it came to being a fail."""
    return max((deviation.clearness for deviation in deviations(comparison)), default=0.0)


def caught(found: Seen) -> int | None:
    """The first case that failed."""
    wrong = (i for i, one in enumerate(found.comparisons) if one.verdict in ("fail", "error"))
    return next(wrong, None)
