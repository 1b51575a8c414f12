"""Replicates of a claim: both sides rendered once, with seeds of their own.

Replicate r is the pair (Aᵣ, Bᵣ), where A and B are the two sides. All renders in it are independent, so the mean of
A − B is 0 if the claim holds, and its variance is the sum of those of both means (Welch). A side of several renders
is noisy as their sum is.

The pair travels as one image, the channels of A before those of B, so that ``Sampler`` takes it like any other.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import fields, replace
from typing import Any, Protocol

import numpy as np

from comparisons.relations.relation import Equal, Part
from comparisons.renderers import Hits, Images
from comparisons.sequential import Renders
from comparisons.statistics.moments import Moments
from scenes import Scene

SEEDS_APART = 2**24
"""From one part of a claim to the next: far more than there are replicates."""


class Crew(Renders, Protocol):
    """Who renders, and what else it is asked; see ``comparisons.crew.Crew``."""

    def total(self, name: str, scene: Scene, spp: int, seed: int, timeout: float) -> Future[Images]:
        """The sum of all bounces."""

    def first_hits(self, name: str, scene: Scene, timeout: float) -> Future[Hits]:
        """What its rays meet first."""

    def version(self, name: str) -> str:
        """Of the renderer."""

    def dismiss(self, name: str) -> None:
        """Ends its processes."""


class Pairs:
    """Renders pairs; to a ``Sampler`` it is a crew."""

    def __init__(self, claim: Equal, crew: Crew, seed: int) -> None:
        """``seed``: that of replicate 0."""
        self.jobs, self._crew, self._seed = crew.jobs, crew, seed
        self._parts = [(1, part) for part in claim.first] + [(-1, part) for part in claim.second]

    def render(
        self, name: str, scene: Scene, bounces: Sequence[int], spp: int, seed: int, timeout: float
    ) -> Future[Images]:
        """One replicate, ``(bounces, height, width, 2 · channels)``; of ``scene`` the parts have their own."""
        futures, added = [], []
        for number, (sign, part) in enumerate(self._parts):
            if asked := tuple(part.asked(bounces)):
                of_part = seed + number * SEEDS_APART
                if part.first_seed is not None:
                    of_part = part.first_seed + seed - self._seed
                who, own_spp = part.renderer or name, part.spp(spp)
                futures.append(self._crew.render(who, part.scene, asked, own_spp, of_part, timeout))
                added.append((sign, part, asked))

        def paired(images: Sequence[Images]) -> Images:
            sides = {1: np.zeros(1), -1: np.zeros(1)}
            for (sign, part, asked), image in zip(added, images, strict=True):
                sides[sign] = sides[sign] + _rows(part, asked, bounces, image)
            first, second = np.broadcast_arrays(sides[1], sides[-1])
            return np.concatenate([first, second], axis=-1)

        return _all_of(futures, paired)


def _rows(part: Part, asked: Sequence[int], wanted: Sequence[int], image: Images) -> Images:
    """The part's share of each bounce that is wanted."""
    viewed = part.view(image)
    rows = np.zeros((len(wanted), *viewed.shape[1:]))
    for row, k in enumerate(wanted):
        if k in asked:
            rows[row] = part.weight(k) * viewed[asked.index(k)]
    return rows


def _all_of(
    futures: Sequence[Future[Images]], combine: Callable[[Sequence[Images]], Images]
) -> Future[Images]:
    """The future of what is made of all these; the first error is its error."""
    whole: Future[Images] = Future()
    lock, missing = threading.Lock(), len(futures)

    def done(_: Future[Images]) -> None:
        nonlocal missing
        with lock:
            missing -= 1
            if missing or not whole.set_running_or_notify_cancel():
                return
        try:
            whole.set_result(combine([future.result() for future in futures]))
        except BaseException as error:
            whole.set_exception(error)

    for future in futures:
        future.add_done_callback(done)
    return whole


def split(pairs: Moments) -> tuple[Moments, Moments]:
    """The moments of A and those of B."""
    channels = pairs.mean.shape[-1] // 2
    return _channels(pairs, slice(channels)), _channels(pairs, slice(channels, None))


def _channels(moments: Moments, which: slice) -> Moments:
    values = {field.name: getattr(moments, field.name) for field in fields(moments)}
    arrays: dict[str, Any] = {
        name: value[..., which] for name, value in values.items() if isinstance(value, np.ndarray)
    }
    return replace(moments, **arrays)
