"""Time to equal standard error, bounce by bounce: cost = time × variance, over bounces 1 to 5.

Both sides render all bounces at equal spp, and the whole render is what is timed. Ours takes Sobol' points over
the whole image. Their error falls faster than n^−1/2, so the ratio depends on n: equal time would give the faster
side more points than equal spp does. Nothing is extrapolated.

Mitsuba's ways are the coupled depths of the adapter, and each of its stratifying samplers (``ldsampler`` is
biased). A few trials tell which of them are hopeless: with all spp in one call, depths don't share their paths,
and the difference of two sums has the noise of both.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchmarks.sides import BOUNCES, Mitsuba, Side, ours
from benchmarks.statistics import CostRatio, Trials, cost_ratio
from benchmarks.timing import Progress, Stopwatch, in_turn

Array = NDArray[np.float64]

COUPLED = "coupled independent"
SAMPLERS = ("stratified", "multijitter", "orthogonal")
HOPELESS = 10.0
"""Times the best cost in the few trials: over five bounces these can't be that far off."""

TILES = 8
"""Along each side of the image."""


def measure(spp: int, seeds: int, few: int, progress: Progress) -> tuple[CostRatio, CostRatio]:
    """Of the mean of the image, and of the means of its tiles."""
    mitsuba = Mitsuba()
    theirs = {COUPLED: mitsuba.coupled(spp)} | {name: mitsuba.stratified(spp, name) for name in SAMPLERS}
    theirs = _promising(theirs, few, progress)
    seconds, images = _trials({"ours": ours(spp, "sobol"), **theirs}, seeds, progress)

    def compare(tiles: int) -> CostRatio:
        trials = {name: Trials(seconds[name], regions(images[name], tiles)) for name in images}
        return cost_ratio({name: trials[name] for name in theirs}, trials["ours"])

    return compare(1), compare(TILES)


def regions(images: Array, tiles: int) -> Array:
    """Means over tiles × tiles regions of bounces 1 …, ``(trials, bounces, tiles², channels)``.

    Args:
        images: ``(trials, bounces + 1, height, width, channels)``.
        tiles: along each side; divides height and width.
    """
    trials, _, height, width, channels = images.shape
    grid: Array = images[:, 1:].reshape(trials, -1, tiles, height // tiles, tiles, width // tiles, channels)
    means: Array = grid.mean(axis=(3, 5)).reshape(trials, -1, tiles * tiles, channels)
    return means


def _promising(theirs: Mapping[str, Side], few: int, progress: Progress) -> dict[str, Side]:
    """Those whose cost, over all bounces, is not hopeless."""
    seconds, images = _trials(theirs, few, progress)
    cost = {}
    for name in theirs:
        image = regions(images[name], 1)
        variance = image.var(axis=0, ddof=1) / image.mean(axis=0) ** 2
        cost[name] = np.median(seconds[name]) * np.exp(np.log(variance.mean(axis=(1, 2))).mean())
    best = min(cost.values())
    for name in theirs:
        progress(f"Mitsuba, {name}: {cost[name] / best:.3g} × the least cost in {few} trials")
    return {name: side for name, side in theirs.items() if cost[name] <= HOPELESS * best}


def _trials(
    sides: Mapping[str, Side], seeds: int, progress: Progress
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Seconds and images of each side, one per seed, in turn; the first run of each is not counted."""
    for side in sides.values():
        side(seeds)
    stopwatch, images = Stopwatch(), {name: np.empty((seeds, BOUNCES + 1, 64, 64, 3)) for name in sides}
    for seed in range(seeds):
        progress(f"seed {seed + 1} of {seeds}")
        for name in in_turn(list(sides), seed):
            images[name][seed] = stopwatch(name, partial(sides[name], seed))
    stopwatch.check()
    return {name: stopwatch.seconds(name) for name in sides}, images
