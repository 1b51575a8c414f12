"""Points of a quad, uniform by the solid angle under which a reference close by sees it.

All lengths are in the frame of the quad: the first axis along edge_u, the third along its normal, the origin in
the middle. A reference stands at (x, y, h), h ≠ 0, and it does not matter on which side.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference_tracer import sampling
from reference_tracer.vectors import unit

Array = NDArray[np.float64]


def near_quad(u: float, v: float, v_across: float) -> NearQuad:
    """The quad whose edges are (u, 0) and (v, v_across)."""
    if abs(v) <= 1e-12 * v_across:
        return Rectangle(u, v_across)
    return Parallelogram(u, v, v_across)


class NearQuad(ABC):
    """How a quad is seen from close by."""

    @abstractmethod
    def solid_angle(self, reference: Array) -> Array:
        """Under which references ``(3, n)`` see it, sr, ``(n,)``. The density is one over it."""

    @abstractmethod
    def sample(self, u: Array, reference: Array) -> Array:
        """Points (x, y) less the reference, ``(2, n)``, for u ``(2, n)``."""


@dataclass
class Rectangle(NearQuad):
    """By the spherical rectangle (Ureña et al. 2013)."""

    u: float
    v: float

    def solid_angle(self, reference: Array) -> Array:
        """As the base class says."""
        return sampling.spherical_rectangle_angle(*self._seen_from(reference))

    def sample(self, u: Array, reference: Array) -> Array:
        """As the base class says."""
        return sampling.square_to_spherical_rectangle(u, *self._seen_from(reference))

    def _seen_from(self, reference: Array) -> tuple[Array, Array, Array]:
        half = np.array([[self.u], [self.v]]) / 2
        return -half - reference[:2], half - reference[:2], np.abs(reference[2])


@dataclass
class Parallelogram(NearQuad):
    """By two spherical triangles (Arvo 1995), of which one is chosen by its share."""

    u: float
    v: float
    v_across: float

    def solid_angle(self, reference: Array) -> Array:
        """As the base class says."""
        a, b, c, d = self._corners(reference)
        angle: Array = sampling.spherical_triangle_angle(a, b, c) + sampling.spherical_triangle_angle(a, c, d)
        return angle

    def sample(self, u: Array, reference: Array) -> Array:
        """As the base class says."""
        a, b, c, d = self._corners(reference)
        first, second = sampling.spherical_triangle_angle(a, b, c), sampling.spherical_triangle_angle(a, c, d)
        share = first / (first + second)
        lower = u[0] < share
        # within the share of the one that was chosen, the number is uniform again
        rest = np.where(lower, u[0], u[0] - share) / np.where(lower, share, 1 - share)
        corners = a, np.where(lower, b, c), np.where(lower, c, d)
        direction = sampling.square_to_spherical_triangle(np.stack([np.minimum(rest, 1), u[1]]), *corners)
        points: Array = direction[:2] * (np.abs(reference[2]) / direction[2])
        return points

    def _corners(self, reference: Array) -> list[Array]:
        """Unit directions to the four corners, counterclockwise; the plane lies at +|h|."""
        corners = []
        for s, t in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)):
            corner = np.abs(reference)
            corner[0], corner[1] = s * self.u + t * self.v - reference[0], t * self.v_across - reference[1]
            corners.append(unit(corner))
        return corners
