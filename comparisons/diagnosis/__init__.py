"""What is most likely at fault in a renderer, from the pattern over bounces, cases and relations.

Clues (``clues.py``) speak for operators with weights, which add. The operator with the most is named if it leads the
next one clearly; if not, the diagnosis is that one can't tell, with the cheapest case that would tell more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from comparisons.diagnosis.clue import Clue
from comparisons.diagnosis.clues import clues, ignores_its_seed
from comparisons.results import Comparison, Diagnosis, Operator, RelationResult

__all__ = ["Diagnosis", "diagnose", "diagnoses"]

CLEAR = 1.5
"""Lead of the first operator over the second from which on it is named."""

LEAST = 2.5
"""Weight that it has at least."""

_NAMES: Mapping[Operator, str] = {
    "E": "E, emission",
    "G": "G, propagation: intersection or visibility",
    "R": "R, reflection: a BSDF",
    "series": "the series: which bounces are counted, and how often",
    "estimator": "the estimator: a density, a weight, or light found twice",
    "sensor": "the sensor, or what happens to the finished image",
    "sampler": "the sampler: the random numbers",
}

_TELLS: Mapping[Operator, Sequence[str]] = {
    "E": ("quad-over-plane", "point-over-plane", "furnace-convex"),
    "G": ("screened-lamp", "furnace-tiny", "triangle-over-plane"),
    "R": ("furnace-sphere", "furnace-channels", "furnace-convex"),
    "series": ("furnace-channels", "integrating-sphere", "furnace-bright"),
    "estimator": ("integrating-sphere", "hundred-tiles", "sphere-over-plane"),
    "sensor": ("screened-lamp", "sphere-zones", "cornell-box"),
    "sampler": ("integrating-sphere", "furnace-channels"),
}
"""Quick cases that show an operator by itself."""


def diagnoses(
    comparisons: Sequence[Comparison],
    relations: Sequence[RelationResult] = (),
    others: Mapping[str, Sequence[Comparison]] = MappingProxyType({}),
) -> list[Diagnosis]:
    """One for each renderer of which something failed, in the order of the results.

    Args:
        comparisons, relations: all results.
        others: by renderer, results of its other ways; see ``diagnose``.
    """
    results: list[Comparison | RelationResult] = [*comparisons, *relations]
    failed = dict.fromkeys(r.renderer for r in results if r.verdict == "fail" or ignores_its_seed(r))
    return [
        diagnose(
            [c for c in comparisons if c.renderer == renderer],
            [r for r in relations if r.renderer == renderer],
            others.get(renderer, ()),
        )
        for renderer in failed
    ]


def diagnose(
    comparisons: Sequence[Comparison],
    relations: Sequence[RelationResult] = (),
    others: Sequence[Comparison] = (),
) -> Diagnosis:
    """What is at fault.

    Args:
        comparisons, relations: all results of one renderer, of which at least one failed.
        others: results of its other ways to look for light (``ways``), by their full names.
    """
    found = clues(comparisons, relations, others)
    score: dict[Operator, float] = dict.fromkeys(_NAMES, 0.0)
    for clue in found:
        for operator, weight in clue.weights.items():
            score[operator] += weight
    first, second, *rest = sorted(score, key=lambda operator: -score[operator])
    clear = score[first] >= LEAST and score[first] - score[second] >= CLEAR
    leading = first if clear else None
    ranked = sorted(found, key=lambda clue: -clue.weights.get(first, 0.0))
    possible = [o for o in (first, second, *rest) if score[o] > 0 and score[first] - score[o] < CLEAR + 0.5]
    return Diagnosis(
        renderer=comparisons[0].renderer if comparisons else relations[0].renderer,
        suspect=leading,
        sentence=_sentence(leading, possible, ranked),
        evidence=[clue.text for clue in ranked],
        also_possible=[o for o in possible if o != leading],
        next_case="" if clear else _next_case(possible or [first], comparisons),
    )


def _sentence(suspect: Operator | None, possible: Sequence[Operator], ranked: Sequence[Clue]) -> str:
    if suspect is None:
        among = " or ".join(_NAMES[o].split(":")[0] for o in possible[:3]) or "anything"
        return f"Can't tell; it may be {among}" + (f": {ranked[0].text}." if ranked else ".")
    reasons = "; ".join(clue.text for clue in ranked[:2] if clue.weights.get(suspect, 0) > 0)
    end = "" if reasons.endswith("?") else "."  # a hint may ask
    return f"{_NAMES[suspect][0].upper()}{_NAMES[suspect][1:]}: {reasons}{end}"


def _next_case(possible: Sequence[Operator], comparisons: Sequence[Comparison]) -> str:
    """The first case that shows one of these by itself and was not run."""
    run = {c.case for c in comparisons}
    wanted = (name for i in range(3) for o in possible for name in _TELLS[o][i : i + 1])
    return next((name for name in wanted if name not in run), "")
