"""Partial sums: a render of n bounces is the sum of its terms, each rendered alone, with other seeds.

    E + TE + … + TⁿE  of one render   =   E of one + TE of another + … + TⁿE of one more

It is held term by term, which is stricter than the sum: there, a term too much in one bounce hides behind one too
little in the next. What a renderer makes of bounce k must not depend on which others it is asked for: a path that
ends one vertex early or late, or counts its last one twice, shows.
"""

from __future__ import annotations

from collections.abc import Sequence

from comparisons.relations.relation import Equal, Part, Relation
from scenes import Scene


def _claims(scene: Scene, bounces: int, renderer: str) -> Sequence[Equal]:
    def alone(k: int) -> Part:
        return Part(scene, asked=lambda wanted: [k] if k in wanted else [])

    together = Part(scene, asked=lambda wanted: range(bounces + 1))
    return [Equal((together,), tuple(alone(k) for k in range(bounces + 1)))]


PARTIAL_SUMS = Relation(
    name="partial-sums",
    operator="T",
    statement="TᵏE of a render of E … TⁿE = TᵏE of a render of TᵏE alone, k = 0 … n",
    blind_to="bounces that are all numbered wrongly in the same way",
    claims=_claims,
    scenes=("room",),
)
