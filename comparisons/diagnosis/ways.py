"""Other ways of the same renderer to look for the same light, beside the one that failed.

    chance       a walk finds emission on its way
    next event   lamps are looked at from every point
    numbers      as before, with other random numbers

What they have in common, and what sets them apart: rays, BSDFs and emission are shared by all of them, densities of
lamps, shadow rays and weights are not. Where the failed one weighs the first two, that neither alone is wrong tells
that the weights are.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from comparisons.diagnosis import tables
from comparisons.diagnosis.clue import Clue, Weights
from comparisons.diagnosis.views import (
    begins_late,
    direct_fails,
    e_fails,
    names,
    only_lamps,
    only_where_hidden,
    passed,
    some,
)
from comparisons.renderers import canonical
from comparisons.results import BounceResult, Comparison

Way = Literal["chance", "next event", "numbers"]
Agreement = Literal["alike", "right", "unlike"]

WAYS: Mapping[str, Way] = {
    "reference:bsdf": "chance",
    "reference:nee": "next event",
    "reference:mis:sobol": "numbers",
}
"""Which of them a renderer of this full name is, beside the ``WEIGHTED`` one that has failed."""

WEIGHTED = "reference:mis"

_ERRORS = 4.0
"""Standard errors apart, from which on two biases are not the same."""

_ALIKE, _SMALL = 0.1, 0.001
"""And how far apart they may be, of the larger one and by themselves."""


@dataclass(frozen=True)
class Heard:
    """What one way says of the cases that failed.

    Attributes:
        alike: it is wrong by as much.
        right: it is right.
        unlike: it is wrong, by something else.
    """

    alike: list[str] = field(default_factory=list)
    right: list[str] = field(default_factory=list)
    unlike: list[str] = field(default_factory=list)


def other_ways(renderer: str) -> tuple[str, ...]:
    """Their names, if the renderer of this name has any."""
    return tuple(WAYS) if canonical(renderer) == WEIGHTED else ()


def heard(comparisons: Sequence[Comparison], others: Sequence[Comparison]) -> dict[Way, Heard]:
    """What each way says; those that say nothing are left out.

    Of light that nothing is drawn for all ways are the same, so it tells nothing that they are alike there.

    Args:
        comparisons: of the renderer that failed.
        others: of its other ways, by their full names.
    """
    failed = {c.case: c for c in comparisons if c.verdict == "fail"}
    found: dict[Way, Heard] = {}
    for other in others:
        if other.case in failed and other.renderer in WAYS:
            nothing_drawn = not tables.DRAWN & set(other.features)
            for agreement in _agreement(failed[other.case], other):
                if not (nothing_drawn and agreement == "alike"):
                    getattr(found.setdefault(WAYS[other.renderer], Heard()), agreement).append(other.case)
    return found


def later_by_one(others: Sequence[Comparison]) -> list[str]:
    """Cases of which next event's bounce k + 1 is off by what chance's bounce k is, from k = 1 on.

    Next event looks at lamps from every point, and so needs one ray less to reach them than chance does: what rays
    lose on their way from point to point, it loses one bounce later.
    """
    by_way = {
        way: {other.case: other for other in others if WAYS.get(other.renderer) == way}
        for way in ("chance", "next event")
    }
    found = []
    for name in by_way["chance"].keys() & by_way["next event"].keys():
        chance, next_event = by_way["chance"][name].bounces[1:], by_way["next event"][name].bounces[1:]
        if len(chance) < 3 or not _wrong(chance[0]) or _wrong(next_event[0]):
            continue
        pairs = list(zip(chance, next_event[1:], strict=False))
        if all(_of_bounce(early, late) in ("alike", None) for early, late in pairs) and _wrong(
            next_event[-1]
        ):
            found.append(name)
    return sorted(found)


def _wrong(bounce: BounceResult) -> bool:
    """Whether it has a bias that is no noise, however small."""
    return abs(bounce.bias) > _ERRORS * bounce.standard_error and abs(bounce.bias) > _SMALL


def _agreement(failed: Comparison, other: Comparison) -> Iterator[Agreement]:
    """Of the first wrong bounce that tells."""
    for bounce in failed.bounces:
        if bounce.verdict == "fail":
            same = next((b for b in other.bounces if b.bounce == bounce.bounce), None)
            if same is not None and (agreement := _of_bounce(bounce, same)):
                yield agreement
                return


def _of_bounce(wrong: BounceResult, other: BounceResult) -> Agreement | None:
    if wrong.decided_by == "tile":
        return {"fail": "alike", "pass": "right"}.get(other.verdict)  # type: ignore[return-value]
    theirs = next((c for c in other.channels if c.channel == wrong.channel), None)
    bias, error = (theirs.bias, theirs.standard_error) if theirs else (other.bias, other.standard_error)
    noise = _ERRORS * float(np.hypot(wrong.standard_error, error))
    if abs(wrong.bias - bias) <= noise + _ALIKE * abs(wrong.bias) + _SMALL:
        # an interval that holds both the same bias and none tells nothing
        return "alike" if abs(bias) > _ERRORS * error and other.verdict == "fail" else None
    if abs(bias) <= _ERRORS * error + _SMALL:
        return "right"
    return "unlike"


# ---- what it speaks for


def clues_of_ways(comparisons: Sequence[Comparison], others: Sequence[Comparison]) -> Iterator[Clue]:
    """What the failed cases look like to other ways of the same renderer."""
    said = heard(comparisons, others)
    chance, next_event, numbers = (said.get(way, Heard()) for way in ("chance", "next event", "numbers"))
    yield from _of_numbers(numbers)
    if chance.right and next_event.right and not (chance.alike or next_event.alike):
        text = f"by chance alone and by next event alone it is right ({some(chance.right)})"
        yield Clue(text, {"estimator": 7})
    elif chance.right and not chance.alike:
        yield from _of_next_event(comparisons, chance.right, bool(next_event.alike or next_event.unlike))
    elif next_event.right and not next_event.alike:
        yield from _of_chance(comparisons, next_event.right)
    elif chance.alike and next_event.alike:
        yield from _of_both(comparisons, chance.alike)
    if lost := later_by_one(others):
        text = f"what chance finds at bounce k is off by as much as what next event finds at k + 1 ({some(lost)})"
        yield Clue(f"{text}: rays that go on are lost", {"G": 4, "R": 1, "series": -2})


def _of_numbers(heard: Heard) -> Iterator[Clue]:
    """What other random numbers make of it."""
    if heard.right and not heard.alike:
        yield Clue(f"with other random numbers it is right ({some(heard.right)})", {"sampler": 10})
    elif heard.unlike:
        text = f"with other random numbers it is wrong by something else ({some(heard.unlike)})"
        yield Clue(text, {"sampler": 1, "sensor": 1.5})
    elif heard.alike:
        yield Clue(f"with other random numbers it is the same ({some(heard.alike)})", {"sampler": -2})


def _of_both(comparisons: Sequence[Comparison], alike: Sequence[str]) -> Iterator[Clue]:
    """What is as wrong where lamps are found as where they are looked at."""
    text = f"by chance alone and by next event alone it is as wrong ({some(alike)})"
    yield Clue(text, {"estimator": -4, "sampler": -1})
    if any(tables.DELTA & set(c.features) and direct_fails(c) for c in comparisons):
        yield Clue(
            "so is light of points and directions, which nothing is drawn for", {"R": 1.5, "sensor": 1}
        )
    elif only_lamps(comparisons) and not begins_late([c for c in comparisons if c.verdict == "fail"]):
        text = "only lamps shine wrongly, however they are found, and neither points nor directions"
        yield Clue(text, {"E": 4 if any(e_fails(c) for c in comparisons) else 2})


def _of_next_event(
    comparisons: Sequence[Comparison], right: Sequence[str], wrong_alone: bool
) -> Iterator[Clue]:
    """What is wrong where lamps are looked at, by that alone or beside chance, and right where they are found."""
    failed = [c for c in comparisons if c.verdict == "fail"]
    direct = [c.bounces[1].bias for c in failed if direct_fails(c)]
    bright = bool(direct) and min(direct) > 0
    text = f"found by chance, the light is right ({some(right)})"
    if begins_late(failed):
        yield Clue(f"{text}, and by next event wrong from a later bounce on", {"series": 2})
    elif wrong_alone and all(tables.SPECIAL & set(c.features) for c in failed):
        yield Clue(f"{text}, and by next event wrong, on these materials alone: their f", {"R": 4})
    elif all(tables.FAR & set(c.features) and "area" not in c.features for c in failed):
        open_sky = [
            c for c in passed(comparisons) if tables.FAR & set(c.features) and c.case not in tables.OCCLUDED
        ]
        if tables.OCCLUDED.issuperset(c.case for c in failed) and open_sky:
            yield Clue(f"{text}, and only a sky is wrong that something hides", {"G": 6})
        elif bright:
            text = f"{text}, and only what comes from infinitely far is too bright: its density"
            yield Clue(text, {"estimator": 4.5, "E": -2})
        else:
            yield Clue(
                f"{text}, and only what comes from infinitely far is wrong, not all of it too bright",
                {"E": 3},
            )
    elif all(tables.STRETCHED & set(c.features) for c in failed):
        yield Clue(f"{text}, and only lamps that were stretched are wrong: their area", {"E": 5.5, "G": -4})
    elif only_where_hidden(comparisons):
        yield Clue(f"{text}, and only what stands in its way makes it wrong", {"G": 6, "R": -2})
    elif any({"point", "spot"} & set(c.features) and direct_fails(c) for c in failed):
        weights: Weights = {"estimator": 4, "G": -1} if bright else {"G": 5}
        text = f"{text}, and that of points is {'too bright, as all is' if bright else 'wrong too'}"
        yield Clue(text, weights)
    else:
        yield Clue(text, {"estimator": 3.5, "G": 1, "R": -3, "sensor": -3, "series": -2})
        shadows = [c for c in passed(comparisons) if tables.DELTA & set(c.features)]
        if len(shadows) >= 2:
            text = (
                f"the way to points and directions, where nothing is drawn, is free ({some(names(shadows))})"
            )
            yield Clue(text, {"estimator": 2.5, "G": -2})


def _of_chance(comparisons: Sequence[Comparison], right: Sequence[str]) -> Iterator[Clue]:
    """What is wrong where lamps are found, and right where they are looked at."""
    failed = [c for c in comparisons if c.verdict == "fail"]
    text = f"by next event alone the light is right ({some(right)})"
    if begins_late(failed):
        yield Clue(f"{text}, and by chance wrong from a later bounce on", {"series": 2})
    elif all(tables.SPECIAL & set(c.features) for c in failed):
        yield Clue(text, {"R": 3})
    elif all(tables.STRETCHED & set(c.features) for c in failed):
        yield Clue(f"{text}, and by chance wrong on shapes that were stretched", {"G": 5})
    else:  # chance alone knows of no density of lamps, and of no weight
        yield Clue(text, {"G": 2.5, "R": 1.5, "sampler": 1, "estimator": -1, "sensor": -1})
