"""E, emission: the radiance surfaces emit, and how next-event estimation picks points of them.

An emitter is chosen with a probability proportional to its power, a point on it uniformly by area. ``sample``
returns points; ``pdf`` is the density of the same choice as a solid angle, which is what multiple importance
sampling weighs against the density of the BSDF.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference_tracer import sampling
from reference_tracer.points import Points
from scenes import PolarRange, Quad, Scene, Sphere

Array = NDArray[np.float64]


class Emitters:
    """All that emits in a scene."""

    def __init__(self, scene: Scene) -> None:
        surfaces = scene.surfaces
        dark = (0.0,) * scene.channels
        # one entry more than there are surfaces: NOWHERE = −1 finds it, and it is dark
        radiance = [s.emission.radiance if s.emission else dark for s in surfaces]
        self._radiance = np.array([*radiance, dark]).T
        zones = [(s.emission and s.emission.polar_range) or PolarRange() for s in surfaces]
        self._zone_axes = np.array([zone.axis for zone in zones]).T
        self._zone_cosines = np.array([zone.cosines for zone in zones]).T
        self._outward = np.array(
            [-1 if isinstance(s.shape, Sphere) and s.shape.inward else 1 for s in surfaces]
        )
        self._limited = np.array([zone.fraction < 1 for zone in zones] + [False])

        area = np.array([s.shape.area for s in surfaces]) * [zone.fraction for zone in zones]
        power = self._radiance[:, :-1].mean(axis=0) * area
        self._choice = power / power.sum()
        self._pdf_area = np.append(self._choice / area, 0.0)
        self._shapes = [s.shape for s in surfaces]

    def Le(self, points: Points, wo: Array) -> Array:
        """Radiance emitted from points along wo.

        Args:
            points: n points.
            wo: unit directions away from them, ``(3, n)``.

        Returns:
            ``(channels, n)``; 0 from the back, outside the zone that emits, and NOWHERE.
        """
        cosine = np.einsum("in,in->n", points.n, wo)
        radiance: Array = self._radiance[:, points.surface] * self._lit(points, cosine)
        return radiance

    def _lit(self, points: Points, cosine: Array) -> NDArray[np.bool_]:
        """Whether a direction at that cosine to the normal leaves the front, and the point is in the zone."""
        lit = cosine > 0
        limited = np.flatnonzero(self._limited[points.surface] & lit)
        lit[limited] = self._in_zone(points[limited])
        return lit

    def _in_zone(self, points: Points) -> NDArray[np.bool_]:
        outward = points.n * self._outward[points.surface]
        cosine = np.einsum("in,in->n", outward, self._zone_axes[:, points.surface])
        low, high = self._zone_cosines[:, points.surface]
        inside: NDArray[np.bool_] = (low <= cosine) & (cosine <= high)
        return inside

    def sample(self, rng: np.random.Generator, count: int) -> Points:
        """Points of emitters, chosen by power, then uniformly by area; ``count`` of them."""
        points = Points.nowhere(np.zeros((3, count)))
        points.surface[:] = np.searchsorted(np.cumsum(self._choice)[:-1], rng.random(count), side="right")
        u = rng.random((2, count))
        for i in np.flatnonzero(self._choice):
            lanes = points.surface == i
            points.x[:, lanes], points.n[:, lanes] = self._sample_shape(int(i), u[:, lanes])
        return points

    def _sample_shape(self, i: int, u: Array) -> tuple[Array, Array]:
        """Positions and normals on surface i, uniform by area."""
        shape = self._shapes[i]
        if isinstance(shape, Quad):
            corner, edge_u, edge_v = (
                np.array(e)[:, None] for e in (shape.corner, shape.edge_u, shape.edge_v)
            )
            return corner + u[0] * edge_u + u[1] * edge_v, np.tile(shape.normal[:, None], u.shape[1])
        outward = sampling.square_to_zone(u, *self._zone_cosines[:, i])
        axis = np.broadcast_to(self._zone_axes[:, i, None], outward.shape)
        outward = sampling.to_world(outward, axis)
        return np.array(shape.center)[:, None] + shape.radius * outward, -outward if shape.inward else outward

    def pdf(self, points: Points, wo: Array, distance_squared: Array) -> Array:
        """Solid angle density of ``sample`` at the points, seen from the end of a segment along wo.

        The area density p_A becomes p_A t² / cos θ; 0 where nothing is emitted towards wo.
        """
        cosine = np.einsum("in,in->n", points.n, wo)
        with np.errstate(divide="ignore", invalid="ignore"):
            density = self._pdf_area[points.surface] * distance_squared / cosine
        return np.where(self._lit(points, cosine), density, 0.0)
