"""What a reader of verdicts must know besides: what became of declarations, and what the samples were like."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from comparisons.renderers import Entry
from comparisons.results import BounceResult, TotalResult
from comparisons.sequential import Sampler

_DOMINANT = 0.5
"""Share of a region's squared deviations from which on a single replicate is said to dominate."""


def notes(
    bounces: Sequence[BounceResult], sampler: Sampler, traits: Entry, totals: Sequence[TotalResult] = ()
) -> list[str]:
    """Sentences; none where there is nothing to say.

    Args:
        bounces, sampler: the results, and the samples behind them.
        traits: what is declared of the renderer.
        totals: of the same comparison.
    """
    positive = [b for b in bounces if b.bounce == 0 or not traits.differences]
    return [*_vanished(bounces, totals), *_dominated(bounces), *_negative(positive, sampler)]


def _vanished(bounces: Sequence[BounceResult], totals: Sequence[TotalResult]) -> list[str]:
    where = [f"Bounce {b.bounce}" for b in bounces if _is_gone(b)]
    if not any(b.known for b in bounces):  # else the total was only explained by them
        where += ["The total" for t in totals if t.result and _is_gone(t.result)]
    return [f"{what}: the declared deviation has vanished; remove its entry." for what in where]


def _is_gone(result: BounceResult) -> bool:
    return result.known is not None and result.known.state == "vanished"


def _dominated(bounces: Sequence[BounceResult]) -> list[str]:
    return [
        f"Bounce {b.bounce}: one of {b.replicates} replicates makes {b.dominance:.0%} of the spread of a region; "
        "what its interval says rests on that one"
        for b in bounces
        if b.dominance > _DOMINANT
    ]


def _negative(bounces: Sequence[BounceResult], sampler: Sampler) -> list[str]:
    found = []
    for b in bounces:
        lowest = sampler.pixels[b.bounce].lowest.min(axis=-1)
        # terms that are differences of sums are negative by rounding here and there
        negative = lowest < -1e-4 * b.denominator
        if negative.any():
            y, x = np.unravel_index(lowest.argmin(), lowest.shape)
            found.append(
                f"Bounce {b.bounce}: radiance is negative in {negative.sum()} pixels, down to {lowest.min():.3g} "
                f"in row {y}, column {x}; expected none"
            )
    return found
