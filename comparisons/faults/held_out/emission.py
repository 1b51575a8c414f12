"""Faults of E, held out: conventions of lights that are read in another way than they were meant."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Fault
from comparisons.faults.planting import Replacement, in_tracer
from comparisons.faults.scene_changes import of_lights, replace
from reference_tracer import spherical_harmonics
from reference_tracer.emitters.angular_profile import AngularProfile
from reference_tracer.emitters.delta_lights import DeltaEmitter
from reference_tracer.emitters.environments import Constant, LatitudeLongitudeMap
from scenes import DirectionalLight, SpotLight

Array = NDArray[np.float64]
Method = Callable[..., Any]

SOFTENING = 0.02
"""What is added to the square of a distance, so that nothing is divided by zero."""


def _with_condon_shortley(evaluate: Method) -> Method:
    """The phase (−1)^m is in the basis functions, and not in the coefficients."""

    def phased(order: int, directions: Array) -> Array:
        values: Array = evaluate(order, directions)
        for l in range(order):  # noqa: E741  the degree is called l
            for m in range(-l, l + 1):
                values[spherical_harmonics.index(l, m)] *= (-1) ** abs(m)
        return values

    return phased


def _first_column_meets_the_last(radiance: Method) -> Method:
    """C columns of pixels are spread over C − 1 steps of longitude, so that the last one lies on the first."""

    def spread(self: LatitudeLongitudeMap, d: Array) -> Any:
        x, y, z = self._axes @ d
        columns, radius = self._columns, np.hypot(x, y)
        # the longitude at which the right map has what the wrong one has here
        turn = np.arctan2(y, x) / (2 * np.pi) % 1
        phi = 2 * np.pi * (turn * (columns - 1) + 0.5) / columns
        return radiance(self, self._axes.T @ np.stack([radius * np.cos(phi), radius * np.sin(phi), z]))

    return spread


def _without_ground(radiance: Method) -> Method:
    return lambda self, d: radiance(self, d) * (d[1] >= 0)


def _softened(incident: Method) -> Method:
    def arriving(self: DeltaEmitter, reference: Any) -> tuple[Array, Array, Array]:
        wi, distance, Li = incident(self, reference)
        if isinstance(self.light, DirectionalLight):
            return wi, distance, Li
        return wi, distance, Li * (distance**2 / (distance**2 + SOFTENING))

    return arriving


def _by_the_angle(profile: Method) -> Method:
    """The rows of the table lie at equal steps of the angle, from 90° to 0°, not of its cosine."""
    return lambda self, cosine: profile(self, 1 - np.arccos(np.clip(cosine, 0, 1)) / (np.pi / 2))


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="harmonics-with-condon-shortley",
        operator="E",
        what="spherical harmonics of odd order m have the other sign",
        plant=in_tracer(Replacement(spherical_harmonics, "evaluate", _with_condon_shortley)),
        happened=("https://github.com/TheRealMJP/BakingLab/issues/2",),
    ),
    Fault(
        name="environment-first-column-on-the-last",
        operator="E",
        what="the first and the last column of environment maps are taken to lie at the same longitude",
        plant=in_tracer(Replacement(LatitudeLongitudeMap, "radiance", _first_column_meets_the_last)),
        happened=("https://github.com/mitsuba-renderer/mitsuba3/issues/469",),
    ),
    Fault(
        name="environment-without-ground",
        operator="E",
        what="constant environments are a sky, and black below the horizon",
        plant=in_tracer(Replacement(Constant, "radiance", _without_ground)),
    ),
    Fault(
        name="point-lights-softened",
        operator="E",
        what="0.02 is added to the squared distance that the light of point and spot lights is divided by",
        plant=in_tracer(Replacement(DeltaEmitter, "incident", _softened)),
    ),
    Fault(
        name="spot-beam-for-its-margin",
        operator="E",
        what="the beam of spots is taken for the width of the fall-off, from the cutoff inwards",
        plant=of_lights(SpotLight, change=lambda spot: replace(spot, beam=max(spot.cutoff - spot.beam, 0.0))),
    ),
    Fault(
        name="lamp-profile-by-the-angle",
        operator="E",
        what="angular profiles of lamps are read as tables over the angle, not over its cosine",
        plant=in_tracer(Replacement(AngularProfile, "__call__", _by_the_angle)),
    ),
)
