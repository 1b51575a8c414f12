"""Faults of the series: which bounces are summed, how each is numbered, and what carries over from one to the next.

Those of depth and of sums can be planted in any renderer. Those of the throughput need the loop of the reference
tracer: sample k of a walk's BSDFs makes the direction that bounce k is found in by chance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Fault, Plant
from comparisons.faults.planting import Replacement, in_tracer, of_request
from comparisons.faults.throughput import ended, late, spare
from comparisons.renderers import Images, Renderer
from reference_tracer.bsdfs.bsdf import BSDFSample
from reference_tracer.points import Points
from reference_tracer.random_walk import RandomWalk
from reference_tracer.samplers import Block
from reference_tracer.sensing import Film
from scenes import Scene

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

# ---- which bounces an image holds


def _of_terms(change: Callable[[Images], Images]) -> Plant:
    """E, TE, T²E … up to one more than was asked for, ``(bounces, …)``, are changed, and then picked from."""

    def render(inner: Renderer, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        terms = inner.render(scene, range(max(bounces) + 2), spp, seed)
        return change(terms)[list(bounces)]

    return of_request(render)


def _differences_of_late_sums(terms: Images) -> Images:
    """Sums end a bounce late; a bounce is what one sum has more than the one before."""
    sums = np.cumsum(terms, axis=0)[1:]
    return np.diff(sums, axis=0, prepend=0)


def _differences_of_early_sums(terms: Images) -> Images:
    """Sums end a bounce early, and the first one is black."""
    return np.concatenate([np.zeros_like(terms[:1]), terms[:-1]])


def _only_the_last_lost(inner: Renderer, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    images = inner.render(scene, bounces, spp, seed)
    images[-1] = 0
    return images


def _scaled(factor: Callable[[int], float]) -> Plant:
    """Bounce k is that many times as bright."""

    def render(inner: Renderer, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        factors = np.array([factor(k) for k in bounces])
        images: Images = inner.render(scene, bounces, spp, seed) * factors[:, None, None, None]
        return images

    return of_request(render)


# ---- what the loop of a walk carries over


def _ended_by_chance(sample: BSDFSample, u: Array) -> BSDFSample:
    """A walk goes on with the probability of its brightest channel, and as if that had been sure."""
    return ended(sample, spare(u) >= sample.weight.max(axis=0))


def _weighted_by_another_channel(sample: BSDFSample, u: Array) -> BSDFSample:
    """The brightest channel decides whether a walk goes on, and the mean of the channels what it then counts."""
    kept = np.maximum(sample.weight.mean(axis=0), 1e-9)
    return ended(sample, spare(u) >= sample.weight.max(axis=0), 1 / np.minimum(kept, 1))


_GOES_ON = 0.8


def _ended_rightly(sample: BSDFSample, u: Array) -> BSDFSample:
    return ended(sample, spare(u) >= _GOES_ON, 1 / _GOES_ON)


def _thinned(next_event: Callable[..., tuple[Indices, Array]]) -> Any:
    """Next event, lost where the walk ends at the same vertex."""

    def substitute(self: Any, vertex: Points, wo: Array, u: Array) -> tuple[Indices, Array]:
        lanes, Ld = next_event(self, vertex, wo, u)
        if self.bsdf.made < 2:
            return lanes, Ld
        kept = np.flatnonzero(spare(u.take(lanes, axis=1)) < _GOES_ON)
        return lanes.take(kept), Ld.take(kept, axis=1)

    return substitute


def _not_updated(sample: BSDFSample, u: Array) -> BSDFSample:
    return replace(sample, weight=np.where(sample.pdf > 0, 1.0, sample.weight))


def _clamped(sample: BSDFSample, u: Array) -> BSDFSample:
    return replace(sample, weight=np.minimum(sample.weight, 1))


def _slightly_darker(sample: BSDFSample, u: Array) -> BSDFSample:
    return replace(sample, weight=0.995 * sample.weight)


class _Counted:
    """A ray caster that counts the rays of a walk."""

    def __init__(self, cast: Any, most: int) -> None:
        self._cast, self._left = cast, most

    def __getattr__(self, name: str) -> Any:
        return getattr(self._cast, name)

    def __call__(self, origin: Points, d: Array) -> Points:
        self._left -= 1
        points: Points = self._cast(origin, d)
        return points

    @property
    def beyond(self) -> bool:
        """Whether that was more than the most."""
        return self._left < 0


def _counting(walk: Callable[[RandomWalk, Block, int | None, Film], None]) -> Any:
    def substitute(self: Any, block: Block, bounces: int | None, film: Film) -> None:
        if bounces is None:  # there is no last ray
            walk(self, block, bounces, film)
            return
        plain = self.cast
        self.cast = _Counted(plain, most=bounces)
        try:
            walk(self, block, bounces, film)
        finally:
            self.cast = plain

    return substitute


def _not_by_the_last_ray(found: Callable[..., Array]) -> Any:
    def substitute(self: Any, previous: Points, vertex: Points, d: Array, pdf: Array) -> Array:
        return found(self, previous, vertex, d, pdf) * (not self.cast.beyond)

    return substitute


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="depth-counted-from-one",
        operator="series",
        what="what is called bounce k is Tᵏ⁺¹E, and E is in none",
        plant=_of_terms(lambda terms: terms[1:]),
    ),
    Fault(
        name="one-bounce-too-many",
        operator="series",
        what="sums end one bounce late: the first one is E + TE, and bounce k by their difference Tᵏ⁺¹E",
        plant=_of_terms(_differences_of_late_sums),
    ),
    Fault(
        name="one-bounce-too-few",
        operator="series",
        what="sums end one bounce early: bounce 0 is black, and bounce k is Tᵏ⁻¹E",
        plant=_of_terms(_differences_of_early_sums),
    ),
    Fault(
        name="sums-for-terms",
        operator="series",
        what="the image of bounce k is not cleared first: it holds E + TE + … + TᵏE",
        plant=_of_terms(lambda terms: np.cumsum(terms, axis=0)),
    ),
    Fault(
        name="last-bounce-lost",
        operator="series",
        what="walks end before the last bounce that was asked for: it is black",
        plant=of_request(_only_the_last_lost),
    ),
    Fault(
        name="last-ray-not-traced",
        operator="series",
        what="the last bounce lacks what the last ray would have found: it holds next event's share alone",
        plant=in_tracer(
            Replacement(RandomWalk, "__call__", _counting),
            Replacement(RandomWalk, "_found", _not_by_the_last_ray),
        ),
        happened=("https://github.com/mitsuba-renderer/mitsuba3/pull/1540",),
    ),
    Fault(
        name="roulette-not-reweighted",
        operator="series",
        what="from bounce 3 on walks end by chance, and those that go on are not made brighter for it",
        plant=late(3, _ended_by_chance),
        happened=("https://github.com/chunky-dev/chunky/issues/1018",),
    ),
    Fault(
        name="roulette-by-another-channel",
        operator="series",
        what="walks go on with the probability of their brightest channel, and are divided by the channels' mean",
        plant=late(3, _weighted_by_another_channel),
    ),
    Fault(
        name="roulette-takes-direct-light",
        operator="series",
        what="from bounce 3 on next event is only added where the walk goes on: a fifth of it is lost",
        plant=late(3, _ended_rightly, Replacement(RandomWalk, "_next_event", _thinned)),
        happened=("https://github.com/nvpro-samples/vk_raytrace/issues/13",),
    ),
    Fault(
        name="throughput-not-updated",
        operator="series",
        what="from the second reflection on, the throughput stays what it was after the first",
        plant=late(2, _not_updated),
    ),
    Fault(
        name="throughput-clamped-to-one",
        operator="series",
        what="no reflection or refraction may make a walk brighter: f cos / pdf is cut off at 1",
        plant=late(1, _clamped),
    ),
    Fault(
        name="throughput-loses-half-a-percent",
        operator="series",
        what="from bounce 4 on every reflection loses 0.5 %: 0.5 % of bounce 5, 1 % of bounce 6 …",
        plant=late(4, _slightly_darker),
    ),
    Fault(
        name="bounce-counted-twice",
        operator="series",
        what="T²E is added twice",
        plant=_scaled(lambda k: 2.0 if k == 2 else 1.0),
    ),
    Fault(
        name="third-bounce-low",
        operator="series",
        what="bounce 3 alone is 1 % low",
        plant=_scaled(lambda k: 0.99 if k == 3 else 1.0),
    ),
    Fault(
        name="late-bounces-low",
        operator="series",
        what="bounces from 4 on are 0.7 % low",
        plant=_scaled(lambda k: 0.993 if k >= 4 else 1.0),
    ),
    Fault(
        name="late-bounces-very-little-low",
        operator="series",
        what="bounces from 4 on are 0.5 % low",
        plant=_scaled(lambda k: 0.995 if k >= 4 else 1.0),
        unseen="no case's tolerance is less than 0.5 % of the whole image: what is off by as much may pass",
    ),
    Fault(
        name="direct-light-only",
        operator="series",
        what="nothing is reflected twice: bounces from 2 on are black",
        plant=_scaled(lambda k: float(k < 2)),
    ),
)
