"""Emission that depends on the angle: Le(θ) = radiance · p(cos θ), p linear between equal steps of the cosine."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenes import AreaLight

Array = NDArray[np.float64]


class AngularProfile:
    """p of an area light.

    Attributes:
        mean: of p over directions weighted by the cosine, 2 ∫ p(μ) μ dμ, ``(channels,)``: what the emitter gives
            off, over what it would without a profile.
    """

    def __init__(self, light: AreaLight) -> None:
        rows = light.angular_profile or ((1.0,) * len(light.radiance),) * 2
        self._factors = np.array(rows).T
        self._differences, self._steps = np.diff(self._factors), len(rows) - 1
        # μ p(μ) is of second degree between two steps: Simpson's rule is exact
        ends = np.arange(len(rows)) / self._steps
        middle = (ends[1:] + ends[:-1]) / 2
        at_ends, at_middle = self._factors * ends, self(middle) * middle
        integrals = (at_ends[:, :-1] + 4 * at_middle + at_ends[:, 1:]) / (6 * self._steps)
        self.mean = 2 * integrals.sum(axis=1)

    def __call__(self, cosine: Array) -> Array:
        """p at cosines to the normal, ``(n,)`` → ``(channels, n)``; beyond 1, where rounding puts some, as at 1."""
        place = np.clip(cosine, 0, 1) * self._steps
        step = np.minimum(place.astype(np.intp), self._steps - 1)
        factors: Array = self._factors.take(step, axis=1) + self._differences.take(step, axis=1) * (
            place - step
        )
        return factors
