"""Strategies: whichever way a renderer looks for light, the mean is the same.

Chance, next event, both with weights that sum to one, other samplers: each is an unbiased estimator of the same TᵏE.
Weights that don't sum to one, and a density that is not that of the samples, make them disagree.
"""

from __future__ import annotations

from collections.abc import Sequence

from comparisons.relations.relation import Equal, NotApplicableError, Part, Relation
from comparisons.renderers import strategies_of
from scenes import Scene


def _claims(scene: Scene, bounces: int, renderer: str) -> Sequence[Equal]:
    others = strategies_of(renderer)
    if not others:
        raise NotApplicableError(f"the adapter of {renderer} offers one strategy")
    return [Equal((Part(scene),), (Part(scene, renderer=other),), f"against {other}") for other in others]


STRATEGIES = Relation(
    name="strategies",
    operator="estimator",
    statement="TᵏE by one strategy = TᵏE by another",
    blind_to="what the strategies share: ray casting, BSDF values, emission",
    claims=_claims,
    scenes=("room",),
)
