"""Faults of the estimator, held out: points and directions that do not have the density they are divided by."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Fault
from comparisons.faults.next_event import prepared
from comparisons.faults.planting import Replacement, in_tracer
from reference_tracer import sampling
from reference_tracer.emitters import area_lights
from reference_tracer.emitters.environments import Constant
from reference_tracer.points import Points
from reference_tracer.random_walk import RandomWalk

Array = NDArray[np.float64]
Method = Callable[..., Any]


class _Reversed:
    """A BSDF that is asked for the density of the direction to the viewer, given that to the light."""

    def __init__(self, bsdf: Any) -> None:
        self._bsdf = bsdf

    def __getattr__(self, name: str) -> Any:
        return getattr(self._bsdf, name)

    def pdf(self, points: Points, wi: Array, wo: Array) -> Array:
        """With the two directions exchanged."""
        density: Array = self._bsdf.pdf(points, wo, wi)
        return density


def _by_the_reverse(next_event: Method) -> Method:
    def substitute(self: RandomWalk, vertex: Points, wo: Array, u: Array) -> Any:
        with patch.object(self, "bsdf", _Reversed(self.bsdf)):
            return next_event(self, vertex, wo, u)

    return substitute


def _never_the_last(emitters: Any) -> None:
    emitters._ends = emitters._ends.copy()
    emitters._ends[-1:] = 1


def _by_the_angle(square_to_direction: Method) -> Method:
    """The polar angle is uniform, and not its cosine: too many directions near the poles."""

    def directions(self: Constant, u: Array) -> tuple[Array, Array]:
        d = sampling.from_versine(1 - np.cos(np.pi * u[0]), u[1])
        return d, self.square_to_direction_pdf(d)

    return directions


def _of_the_tangent(cone: Method) -> Method:
    """tan θ = 1 / |o| instead of sin θ: the cone to the rim of the disk through the centre."""

    def narrower(squared: Array) -> Array:
        distance = np.sqrt(np.maximum(squared, 1))
        versine: Array = 1 - distance / np.hypot(distance, 1)
        return versine

    return narrower


def _triangle_without_root(square_to_triangle: Method) -> Method:
    return lambda u: np.stack([1 - u[0], u[0] * u[1]])


def _disk_without_root(square_to_disk: Method) -> Method:
    return lambda u: u[0] * sampling.circle(u[1])


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="weight-by-the-reverse-density",
        operator="estimator",
        what="next event's weight has the BSDF's density with the two directions exchanged",
        plant=in_tracer(Replacement(RandomWalk, "_next_event", _by_the_reverse)),
        happened=("https://github.com/mmp/pbrt-v4/pull/215",),
    ),
    Fault(
        name="last-emitter-never-chosen",
        operator="estimator",
        what="the choice among emitters ends one too early: the last but one is chosen in place of the last",
        plant=in_tracer(prepared(_never_the_last)),
    ),
    Fault(
        name="environment-directions-by-the-angle",
        operator="estimator",
        what="directions to constant environments crowd about the poles, and have the density 1 / 4π",
        plant=in_tracer(Replacement(Constant, "square_to_direction", _by_the_angle)),
        happened=("https://github.com/asny/three-d/pull/279",),
    ),
    Fault(
        name="cone-of-the-tangent",
        operator="estimator",
        what="the cone in which a sphere is chosen has tan θ = radius / distance: its rim is left out",
        plant=in_tracer(Replacement(area_lights, "_cone", _of_the_tangent)),
    ),
    Fault(
        name="triangle-without-root",
        operator="estimator",
        what="points of a triangle crowd about one of its corners, and have the density of even ones",
        plant=in_tracer(Replacement(sampling, "square_to_triangle", _triangle_without_root)),
        happened=("https://github.com/thi-ng/geom/pull/83",),
    ),
    Fault(
        name="disk-without-root",
        operator="estimator",
        what="points of a disk crowd about its centre: the radius is uniform, and not its square",
        plant=in_tracer(Replacement(sampling, "square_to_disk", _disk_without_root)),
        happened=("https://github.com/thi-ng/geom/pull/83",),
    ),
)
