"""Faults of the series, held out: what a walk counts, and when it stops."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Fault, Plant
from comparisons.faults.planting import Replacement, in_tracer
from comparisons.faults.throughput import ended, late, spare
from reference_tracer.bsdfs.bsdf import BSDFSample
from reference_tracer.points import Points
from reference_tracer.random_walk import RandomWalk
from reference_tracer.samplers import Block
from reference_tracer.sensing import Film

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

LEAST = 0.05
"""Throughput of walks that are worth going on."""

MOST_SPECULAR = 2
"""Reflections and refractions by smooth surfaces that a walk may have."""

FURTHER = 6
"""Bounces beyond the last one that was asked for, where some of them do not count."""


class _Followed:
    """The walks of a block, followed from one vertex to the next.

    It stands in for the walk's BSDF, and its ``numbers`` for those of the block: the numbers of a sample are drawn
    just before it, and tell which walks it belongs to.

    Attributes:
        throughput: of each walk, ``(channels, walks)``.
        specular: how many delta lobes each walk has chosen, ``(walks,)``.
    """

    def __init__(self, walk: RandomWalk, block: Block, change: Change) -> None:
        walks = block.position.shape[1]
        self._bsdf: Any = walk.bsdf
        self._draw, self._change = block.numbers, change
        self._lanes = np.arange(walks)
        self.throughput = np.ones((walk.scene.channels, walks))
        self.specular = np.zeros(walks, dtype=np.intp)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._bsdf, name)

    def numbers(self, dimensions: int, lanes: Indices) -> Array:
        """Those of the block."""
        self._lanes = lanes
        return self._draw(dimensions, lanes)

    def sample(self, points: Points, wo: Array, u: Array) -> BSDFSample:
        """As that of the BSDF, changed."""
        sample: BSDFSample = self._bsdf.sample(points, wo, u)
        self.specular[self._lanes] += np.isinf(sample.pdf)
        sample = self._change(self, self._lanes, sample)
        self.throughput[:, self._lanes] *= sample.weight
        return sample


Change = Callable[[_Followed, Indices, BSDFSample], BSDFSample]
"""What becomes of the samples of some walks."""


def _as_it_is(followed: _Followed, lanes: Indices, sample: BSDFSample) -> BSDFSample:
    return sample


class _Renumbered:
    """A film on which bounces at smooth surfaces do not count."""

    def __init__(self, film: Film, followed: _Followed, last: int) -> None:
        self._film, self._followed, self._last = film, followed, last

    def __getattr__(self, name: str) -> Any:
        return getattr(self._film, name)

    def add(self, bounce: int, lanes: Indices, radiance: Array) -> None:
        """Add radiance to an earlier bounce than it belongs to."""
        counted = bounce - self._followed.specular[lanes]
        for k in np.unique(counted):
            if k <= self._last:
                here = np.flatnonzero(counted == k)
                self._film.add(int(k), lanes[here], radiance[:, here])


def _following(change: Change, renumbered: bool = False) -> Plant:
    def made_of(walk: Callable[[RandomWalk, Block, int | None, Film], None]) -> Any:
        def substitute(self: Any, block: Block, bounces: int | None, film: Any) -> None:
            plain = self.bsdf
            self.bsdf = followed = _Followed(self, block, change)
            if renumbered and bounces is not None:
                film, bounces = _Renumbered(film, followed, bounces), bounces + FURTHER
            try:
                walk(self, Block(block.position, followed.numbers), bounces, film)
            finally:
                self.bsdf = plain

        return substitute

    return in_tracer(Replacement(RandomWalk, "__call__", made_of))


def _no_faint_walks(followed: _Followed, lanes: Indices, sample: BSDFSample) -> BSDFSample:
    return ended(sample, (followed.throughput[:, lanes] * sample.weight).max(axis=0) < LEAST)


def _not_too_specular(followed: _Followed, lanes: Indices, sample: BSDFSample) -> BSDFSample:
    return ended(sample, np.isinf(sample.pdf) & (followed.specular[lanes] > MOST_SPECULAR))


def _in_sixteen_bits(followed: _Followed, lanes: Indices, sample: BSDFSample) -> BSDFSample:
    """Eight bits of mantissa are kept, the first of them implied."""
    before = followed.throughput[:, lanes]
    mantissa, exponent = np.frexp(before * sample.weight)
    after = np.ldexp(np.floor(mantissa * 256) / 256, exponent)
    return replace(sample, weight=np.divide(after, before, out=np.zeros_like(before), where=before > 0))


def _reweighted_twice(sample: BSDFSample, u: Array) -> BSDFSample:
    q = np.clip(sample.weight.max(axis=0), 0.1, 0.95)
    return ended(sample, spare(u) >= q, 1 / q**2)


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="mirrors-not-counted",
        operator="series",
        what="reflection and refraction by smooth surfaces are no bounces: what they show is found one bounce early",
        plant=_following(_as_it_is, renumbered=True),
        happened=("https://github.com/DassaultSystemes-Technology/dspbr-pt/issues/6",),
    ),
    Fault(
        name="roulette-reweighted-twice",
        operator="series",
        what="from bounce 3 on walks end by chance, and those that go on are divided by its probability twice",
        plant=late(3, _reweighted_twice),
        happened=("https://github.com/MARMOTatZJU/GAMES101-HW/issues/2",),
    ),
    Fault(
        name="faint-walks-ended",
        operator="series",
        what="walks whose throughput is below 0.05 in every channel end, and nothing makes up for them",
        plant=_following(_no_faint_walks),
    ),
    Fault(
        name="two-specular-bounces",
        operator="series",
        what="walks end at the third mirror or boundary of glass, though more bounces were asked for",
        plant=_following(_not_too_specular),
    ),
    Fault(
        name="throughput-in-sixteen-bits",
        operator="series",
        what="the throughput is cut off to eight bits of mantissa at every reflection",
        plant=_following(_in_sixteen_bits),
    ),
)
