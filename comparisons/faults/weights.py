"""Faults of the estimator that lie in its weights: those of a direction do not sum to one over both strategies.

The weights of multiple importance sampling stand in two places of a walk, ``_found`` for emission met by chance and
``_next_event``. Both must use the same densities and the same heuristic.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Fault
from comparisons.faults.planting import Replacement, in_tracer
from reference_tracer.bsdfs.bsdf import cosine
from reference_tracer.points import NOWHERE, Points
from reference_tracer.random_walk import RandomWalk

Array = NDArray[np.float64]


def _chance(weight: Callable[[Array, Array, Points], Array]) -> Replacement:
    """Emission found by chance is weighted like that.

    Args:
        weight: of the density with which the direction was chosen, inf for delta lobes and the sensor's rays; that
            of next event; and the points the directions start from.
    """

    def made_of(found: Callable[..., Array]) -> Any:
        def substitute(self: RandomWalk, previous: Points, vertex: Points, d: Array, pdf: Array) -> Array:
            if self.strategy != "mis":
                return found(self, previous, vertex, d, pdf)
            return self.emitters.Le(vertex, -d) * weight(
                pdf, self.emitters.pdf(previous, vertex, d), previous
            )

        return substitute

    return Replacement(RandomWalk, "_found", made_of)


def _squared(pdf: Array, of_next_event: Array, previous: Points) -> Array:
    weight: Array = 1 / (1 + (of_next_event / pdf) ** 2)
    return weight


def _in_full(pdf: Array, of_next_event: Array, previous: Points) -> Array:
    return np.ones_like(pdf)


def _mirrored(pdf: Array, previous: Points) -> NDArray[np.bool_]:
    """Where a delta lobe has chosen the direction, and not the sensor."""
    mirrored: NDArray[np.bool_] = np.isinf(pdf) & (previous.surface != NOWHERE)
    return mirrored


def _delta_lobe_of_density_one(pdf: Array, of_next_event: Array, previous: Points) -> Array:
    weight: Array = 1 / (1 + of_next_event / np.where(_mirrored(pdf, previous), 1, pdf))
    return weight


def _not_behind_mirrors(pdf: Array, of_next_event: Array, previous: Points) -> Array:
    weight: Array = ~_mirrored(pdf, previous) / (1 + of_next_event / pdf)
    return weight


def _unweighted(next_event: Callable[..., Any]) -> Any:
    """Next event as if it were the only strategy."""

    def substitute(self: RandomWalk, vertex: Points, wo: Array, u: Array) -> Any:
        with patch.object(self, "strategy", "nee"):
            return next_event(self, vertex, wo, u)

    return substitute


class _PerProjectedAngle:
    """A BSDF whose density is told per projected solid angle."""

    def __init__(self, bsdf: Any) -> None:
        self._bsdf = bsdf

    def __getattr__(self, name: str) -> Any:
        return getattr(self._bsdf, name)

    def pdf(self, points: Points, wi: Array, wo: Array) -> Array:
        """p / |cos θi|."""
        density: Array = self._bsdf.pdf(points, wi, wo)
        return density / np.maximum(np.abs(cosine(points, wi)), 1e-9)


def _by_projected_angle(next_event: Callable[..., Any]) -> Any:
    def substitute(self: RandomWalk, vertex: Points, wo: Array, u: Array) -> Any:
        with patch.object(self, "bsdf", _PerProjectedAngle(self.bsdf)):
            return next_event(self, vertex, wo, u)

    return substitute


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="two-heuristics",
        operator="estimator",
        what="what is found by chance is weighted by the power heuristic, next event by the balance heuristic",
        plant=in_tracer(_chance(_squared)),
    ),
    Fault(
        name="emission-counted-twice",
        operator="estimator",
        what="next event counts in full, and so does the emission that the next ray finds",
        plant=in_tracer(_chance(_in_full), Replacement(RandomWalk, "_next_event", _unweighted)),
        happened=("https://github.com/w23/xash3d-fwgs/issues/51",),
    ),
    Fault(
        name="chance-not-weighted",
        operator="estimator",
        what="emission found by chance counts in full, next event with its weight",
        plant=in_tracer(_chance(_in_full)),
        happened=("https://github.com/nvpro-samples/vk_raytrace/issues/13",),
    ),
    Fault(
        name="mirrors-weighted",
        operator="estimator",
        what="a mirror's direction has density 1, so emission behind it is shared with next event, which finds none",
        plant=in_tracer(_chance(_delta_lobe_of_density_one)),
        happened=("https://github.com/gkjohnson/three-gpu-pathtracer/pull/174",),
    ),
    Fault(
        name="lamps-lost-behind-mirrors",
        operator="estimator",
        what="emission that a mirror or glass shows is left to next event, which can't find it",
        plant=in_tracer(_chance(_not_behind_mirrors)),
    ),
    Fault(
        name="weight-per-projected-angle",
        operator="estimator",
        what="in next event's weight the BSDF's density is p / cos θ, per projected solid angle",
        plant=in_tracer(Replacement(RandomWalk, "_next_event", _by_projected_angle)),
    ),
)
