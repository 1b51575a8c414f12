"""Samples: the mean of an image depends neither on how many there are per pixel nor on the seed.

An estimator is unbiased whatever its number of samples. One that divides by the wrong number, reuses a sample or
stratifies wrongly is off by a share that falls with it; so few samples are held against four times as many.

The same seed gives the same image, in another process too; another seed gives another one; and all seeds have the
same mean: those from 0 on, which people use, and those far from there. That seeds differ is looked for on the scene
itself; where it has no noise of its own, as a furnace may, on a Cornell box.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from comparisons.relations.relation import (
    Claim,
    Equal,
    Exact,
    Part,
    Relation,
    Told,
    Witness,
)
from comparisons.renderers import Unsupported
from scenes import Scene, library

FEW = 4
"""Samples per pixel of one side; the other has four times as many."""

_SPP, _SEEDS = 4, (1, 2)
_NOISY = 16
"""Pixels along each side of the Cornell box."""


def _few_and_many(scene: Scene, bounces: int, renderer: str) -> Sequence[Claim]:
    return [Equal((Part(scene, spp=lambda spp: FEW),), (Part(scene, spp=lambda spp: 4 * FEW),))]


def _seeds(scene: Scene, bounces: int, renderer: str) -> Sequence[Claim]:
    wanted = range(bounces + 1)

    def look(renderer: Witness) -> Told:
        # the other seed in between, and another process: what either leaves behind must not matter
        first, other = (renderer.render(scene, wanted, _SPP, seed) for seed in _SEEDS)
        renderer.restart()
        again = renderer.render(scene, wanted, _SPP, _SEEDS[0])
        if not np.array_equal(first, again):
            differ = np.mean(first != again)
            return Told("fail", f"the same seed in another process: {differ:.0%} of all values differ")
        if not np.array_equal(first, other):
            return Told(
                "pass", f"seed {_SEEDS[0]} in two processes: the same image; seed {_SEEDS[1]}: another one"
            )
        return _told_by_a_noisy_scene(renderer)

    return [
        Exact(look, "same and different seeds"),
        Equal((Part(scene, first_seed=0),), (Part(scene),), "means of seeds"),
    ]


def _told_by_a_noisy_scene(renderer: Witness) -> Told:
    box = library.case("cornell-box").scene.resized(_NOISY, _NOISY)
    same = f"seeds {_SEEDS[0]} and {_SEEDS[1]} give the same image"
    try:
        first, other = (renderer.render(box, range(3), _SPP, seed) for seed in _SEEDS)
    except Unsupported as missing:
        return Told("inconclusive", f"{same}; a scene that has noise is not supported: {missing}")
    if np.array_equal(first, other):
        return Told("fail", f"{same}, of a Cornell box too: it takes no notice of its seed")
    return Told("pass", f"{same}, since the scene has no noise: of a Cornell box they differ")


SPP = Relation(
    name="spp",
    operator="estimator",
    statement=f"{FEW} and {4 * FEW} samples per pixel: the same mean",
    blind_to="a bias that does not depend on the number of samples",
    claims=_few_and_many,
    scenes=("room",),
)
SEEDS = Relation(
    name="seeds",
    operator="estimator",
    statement="the same seed: the same image; other seeds: other images, with the same mean",
    blind_to="a bias that all seeds share; seeds that are similar without being the same",
    claims=_seeds,
    scenes=("room",),
    of_noise=True,
)
