"""What a walk carries from one bounce to the next, changed.

Sample k of a walk's BSDFs makes the direction that bounce k is found in by chance, and its weight is what the
throughput is multiplied by.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Plant
from comparisons.faults.planting import Replacement, in_tracer
from reference_tracer.bsdfs.bsdf import BSDFSample
from reference_tracer.points import Points
from reference_tracer.random_walk import RandomWalk
from reference_tracer.samplers import Block
from reference_tracer.sensing import Film

Array = NDArray[np.float64]

Change = Callable[[BSDFSample, Array], BSDFSample]
"""What becomes of a sample, given the numbers it was made from."""


class _Late:
    """A BSDF whose samples are changed from some bounce on.

    Attributes:
        made: how many times a walk has sampled it.
    """

    def __init__(self, bsdf: Any, first: int, change: Change) -> None:
        self._bsdf, self._first, self._change, self.made = bsdf, first, change, 0

    def __getattr__(self, name: str) -> Any:
        return getattr(self._bsdf, name)

    def sample(self, points: Points, wo: Array, u: Array) -> BSDFSample:
        """As that of the BSDF, changed."""
        self.made += 1
        sample: BSDFSample = self._bsdf.sample(points, wo, u)
        return self._change(sample, u) if self.made >= self._first else sample


def late(first: int, change: Change, *others: Replacement) -> Plant:
    """In each walk, directions that bounce ``first`` and later ones are found in are changed."""

    def made_of(walk: Callable[[RandomWalk, Block, int | None, Film], None]) -> Any:
        def substitute(self: RandomWalk, block: Block, bounces: int | None, film: Film) -> None:
            plain = self.bsdf
            self.bsdf = _Late(plain, first, change)
            try:
                walk(self, block, bounces, film)
            finally:
                self.bsdf = plain

        return substitute

    return in_tracer(Replacement(RandomWalk, "__call__", made_of), *others)


def spare(u: Array) -> Array:
    """One number in [0, 1) more for each lane: the low bits of one that is used by its high ones."""
    number: Array = u[0] * 2.0**22 % 1
    return number


def ended(sample: BSDFSample, ends: NDArray[np.bool_], factor: Array | float = 1.0) -> BSDFSample:
    """The sample, where some walks end, and the others are that many times as bright."""
    return replace(sample, weight=sample.weight * (factor * ~ends), pdf=np.where(ends, 0, sample.pdf))
