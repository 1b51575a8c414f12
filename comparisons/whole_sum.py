"""The truth of the whole sum E + TE + T²E + …, and how far it is known.

A case answers bounce by bounce, up to some bounce n. What follows after n is

    next to nothing   where the answer goes on until it has died away. With B the sum of the last third of the bounces
                      0 … n and A that of the third before it, q = B / A, the rest of a geometric series is
                      B q / (1 − q); that much in every region, relative to the sum, is less than ``NEGLIGIBLE``, and
                      twice as much is taken for possible
    known             where the sum has a formula of its own, or that of all later bounces is data of the case
    bounded           else, by ``scenes.tail``, which holds for certain
    unknown           where there is no bound either

So the sum lies between Σ_{k ≤ n} TᵏE and that plus a tail, and a verdict must hold for every truth in between.

With every albedo times s, 0 ≤ s ≤ 1, the sum is Σ sᵏ TᵏE, of whose later bounces at most sⁿ⁺¹ is left.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from comparisons.regions import Regions
from comparisons.statistics.intervals import denominators
from scenes import Case, Formula, Truth
from scenes.tail import tail_bound

Array = NDArray[np.float64]

NEGLIGIBLE = 3e-5
"""Share of the sum, in every region, down to which bounces are summed: a small part of any tolerance."""

LEAST = 12
"""Bounces that are summed at least before they are said to have died away: two walls may hide light for a few."""

MOST = 1024
MOST_NUMBERS = 50_000_000
"""Bounces, and numbers in all their images, up to which a formula is asked for more."""


@dataclass(frozen=True)
class WholeSum:
    """What the sum is: between ``mean`` and ``mean + tail``, give or take the standard error.

    Attributes:
        mean, stderr, tail: ``(height, width, channels)``; the tail is inf where nothing bounds it.
        terms: means over the image of all that was added up, ``(bounces + 1, channels)``.
        last: the last bounce that was added up by itself.
        how: how it is known, as the end of a sentence.
    """

    mean: Array
    stderr: Array
    tail: Array
    terms: Array
    last: int
    how: str


@dataclass(frozen=True)
class Series:
    """All that is known of a case's bounces.

    Attributes:
        terms, errors: TᵏE for k ≤ n and its standard error, ``(n + 1, height, width, channels)``.
        later, later_error: the known sum of all bounces after n, ``(height, width, channels)``; 0 if none is known.
        bound: what further bounces hold at most in any pixel, ``(channels,)``.
        how: as of a sum.
    """

    terms: Array
    errors: Array
    later: Array
    later_error: Array
    bound: Array
    how: str

    @classmethod
    def of(cls, case: Case, truth: Truth) -> Series:
        """Of the case at its size.

        Args:
            case: with or without an end of its answer.
            truth: its answer for the bounces that a comparison asks for.
        """
        if isinstance(case.answer, Formula):
            if case.answer.total is not None:
                return cls._of_closed_form(truth, case.answer.total(case.scene))
            try:
                return cls._of_formula(case, case.answer)
            except Exception as error:  # somebody's own formula, which can't go on so far
                last = truth.bounces
                how = f"bounces 0 to {last}; its formula can say no more ({type(error).__name__}: {error})"
                return cls._ended(truth.mean, truth.stderr, tail_bound(case.scene, last), how)
        whole = case.answer.all_bounces(case.scene) or truth
        later = case.answer.later(case.scene) if whole is not truth else None
        last = whole.bounces
        if later is None:
            return cls._ended(
                whole.mean, whole.stderr, tail_bound(case.scene, last), f"bounces 0 to {last} of its data"
            )
        how = f"bounces 0 to {last} and the sum of all later ones, which is data of the case ({later.source})"
        return cls(
            whole.mean, whole.stderr, later.mean[0], later.stderr[0], np.zeros(case.scene.channels), how
        )

    @classmethod
    def _of_closed_form(cls, truth: Truth, total: Array) -> Series:
        """Whose sum is known by itself: what the terms lack is the sum of all later ones."""
        later = np.maximum(total - truth.mean.sum(axis=0), 0.0)
        none = np.zeros(total.shape[-1])
        return cls(truth.mean, truth.stderr, later, np.zeros_like(later), none, "a formula of its own")

    @classmethod
    def _of_formula(cls, case: Case, answer: Formula) -> Series:
        """With more bounces, until they have died away or the answer ends."""
        scene, regions = case.scene, Regions.of(*case.scene.shape[:2], case.tiles)
        end = min(MOST, MOST_NUMBERS // int(np.prod(scene.shape)))
        end = end if case.max_bounces is None else min(end, case.max_bounces)
        last = min(max(LEAST, case.bounces), end)
        while True:
            terms = answer.truth(scene, last).mean
            bound, rest = tail_bound(scene, last), _rest(regions.means(terms))
            share = float(rest.share.max())
            if last >= LEAST and share <= NEGLIGIBLE:
                bound = np.minimum(bound, 2 * rest.light.max(axis=0))
                return cls._ended(
                    terms, np.zeros_like(terms), bound, f"bounces 0 to {last}, by when they have died away"
                )
            if last == end:
                how = f"bounces 0 to {last}, " + (
                    "all that its answer has" if case.max_bounces else "and some more"
                )
                return cls._ended(terms, np.zeros_like(terms), bound, how)
            # what is left of a geometric series falls by the same factor with every bounce
            longer = last * np.log(0.5 * NEGLIGIBLE) / np.log(share) if share < 1 else np.inf
            last = min(max(last + 1, int(min(longer, 4 * last))), end)

    @classmethod
    def _ended(cls, terms: Array, errors: Array, bound: Array, how: str) -> Series:
        nothing = np.zeros(terms.shape[1:])
        return cls(terms, errors, nothing, nothing, bound, how)

    def total(self, scale: float = 1.0) -> WholeSum:
        """Σ sᵏ TᵏE.

        Args:
            scale: s, what every albedo is multiplied by.
        """
        n = len(self.terms) - 1
        powers = scale ** np.arange(n + 1)
        mean, stderr = (np.tensordot(powers, images, axes=1) for images in (self.terms, self.errors))
        rest = scale ** (n + 1)
        means = powers[:, None] * self.terms.mean(axis=(1, 2))
        with np.errstate(invalid="ignore"):
            tail = np.where(rest > 0, rest * self.bound, 0.0) + np.zeros_like(mean)
        # of a darker scene another share is left of each later bounce, and all of them together have a bound
        if scale == 1:
            # the errors of bounces that come from the same walks add, at most
            mean, stderr = mean + self.later, stderr + self.later_error
            means = np.concatenate([means, self.later.mean(axis=(0, 1))[None]])
        else:
            tail = tail + rest * self.later
        return WholeSum(mean, stderr, tail, means, n, self.how)


class _Rest(NamedTuple):
    """What is left of a geometric series: as radiance, and relative to the sum, ``(regions, channels)``."""

    light: Array
    share: Array


def _rest(means: Array) -> _Rest:
    """What follows after these terms if they go on to decay as their last third does.

    Args:
        means: of TᵏE over regions, ``(regions, bounces + 1, channels)``.
    """
    third = means.shape[1] // 3
    before, last = means[:, -2 * third : -third].sum(axis=1), means[:, -third:].sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        q = last / before
        light = np.where(last > 0, np.where(q < 1, last * q / (1 - q), np.inf), 0.0)
    return _Rest(light, light / denominators(means.sum(axis=1, keepdims=True))[:, 0])
