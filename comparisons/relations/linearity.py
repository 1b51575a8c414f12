"""Linearity: s times the emission is s times every term, Tᵏ(sE) = s TᵏE.

A renderer that clamps bright samples, or stops walks by how much light they carry, is linear no more.
"""

from __future__ import annotations

from collections.abc import Sequence

from comparisons.relations.relation import Equal, Part, Relation
from scenes import Scene
from scenes.variations import brighter

FACTOR = 100.0


def _claims(scene: Scene, bounces: int, renderer: str) -> Sequence[Equal]:
    return [Equal((Part(brighter(scene, FACTOR)),), (Part(scene, weight=lambda k: FACTOR),))]


LINEARITY = Relation(
    name="linearity",
    operator="T",
    statement=f"Tᵏ(sE) = s TᵏE, s = {FACTOR:g}",
    blind_to="a wrong factor, and whatever else does not depend on how bright the scene is",
    claims=_claims,
    scenes=("room", "lights"),
)
