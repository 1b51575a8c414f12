"""Homogeneity: c times every reflectance is cᵏ times bounce k, since R is in TᵏE k times.

With R = cR₀ and T = RG, (cT₀)ᵏE = cᵏ T₀ᵏE. It counts the reflections in every term, whatever the geometry: a bounce
that has one more or less, or a part of its neighbour, has another power of c.

A material without a reflectance to scale (glass, metal) has no such c; scenes with one are refused by its name.
"""

from __future__ import annotations

from collections.abc import Sequence

from comparisons.relations.relation import Equal, Part, Relation
from scenes import Scene
from scenes.variations import darker

FACTOR = 0.5


def _claims(scene: Scene, bounces: int, renderer: str) -> Sequence[Equal]:
    return [Equal((Part(darker(scene, FACTOR)),), (Part(scene, weight=lambda k: FACTOR**k),))]


HOMOGENEITY = Relation(
    name="homogeneity",
    operator="R",
    statement=f"(cT)ᵏE = cᵏ TᵏE, c = {FACTOR:g} times every albedo and reflectance",
    blind_to="reflectances that are all wrong by one factor, and where reflected light goes",
    claims=_claims,
    scenes=("room", "cornell-box"),
    cheap=True,
)
