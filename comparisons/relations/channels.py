"""Channels: permute them in all spectra and textures, and the image is permuted.

Every channel of L = E + TE + … has an equation of its own; none knows which one it is.
"""

from __future__ import annotations

from collections.abc import Sequence

from comparisons.relations.relation import Equal, NotApplicableError, Part, Relation
from scenes import Scene
from scenes.channels import with_channels


def _claims(scene: Scene, bounces: int, renderer: str) -> Sequence[Equal]:
    if scene.channels == 1:
        raise NotApplicableError("the scene has one channel")
    order = [*range(1, scene.channels), 0]
    return [
        Equal((Part(with_channels(scene, order)),), (Part(scene, view=lambda images: images[..., order]),))
    ]


CHANNELS = Relation(
    name="channels",
    operator="R",
    statement="channels permuted in emission and materials: the image permuted",
    blind_to="what is wrong in all channels alike; scenes without colour",
    claims=_claims,
    scenes=("room",),
)
