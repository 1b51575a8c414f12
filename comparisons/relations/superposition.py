"""Superposition: the image of all emitters is the sum of the images of each alone.

(I − T)⁻¹ is linear, so with E = E₁ + … + Eₘ every term is TᵏE = TᵏE₁ + … + TᵏEₘ. A renderer picks emitters at
random, with probabilities that have to cancel; where one is alone they are all 1.
"""

from __future__ import annotations

from collections.abc import Sequence

from comparisons.relations.relation import Equal, NotApplicableError, Part, Relation
from scenes import Scene
from scenes.variations import emitters, with_emitters

MOST_PARTS = 4
"""Emitters are grouped into so many parts: each takes a render of its own."""


def _claims(scene: Scene, bounces: int, renderer: str) -> Sequence[Equal]:
    names = emitters(scene)
    if len(names) < 2:
        raise NotApplicableError(f"nothing emits but {names[0]}; superposition takes two emitters")
    parts = [names[i::MOST_PARTS] for i in range(min(len(names), MOST_PARTS))]
    return [Equal((Part(scene),), tuple(Part(with_emitters(scene, part)) for part in parts))]


SUPERPOSITION = Relation(
    name="superposition",
    operator="E",
    statement="Tᵏ(E₁ + E₂ + …) = TᵏE₁ + TᵏE₂ + …",
    blind_to="an emitter that is wrong in the same way whether it is alone or not",
    claims=_claims,
    scenes=("room", "lights"),
    cheap=True,
)
