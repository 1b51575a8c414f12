"""How much of each pixel a sphere, a circle or a polar cap covers: their cones of rays, for ``coverage``.

With o the pinhole, a ray o + td:

- meets a sphere (c, r) from outside if (w·d)² > (w² − r²) d², w = c − o:    Q = wwᵀ − (w² − r²) I;
- passes through a circle of radius ϱ about c across the axis n: it meets the circle's plane at t = s / (n·d),
  s = n·(c − o), inside if |o − c + td|² < ϱ²; times (n·d)²:                 Q = ϱ² nnᵀ − BᵀB, B = (o − c)nᵀ + sI.

Nothing may stand in front of what is covered.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes.coverage import cone_coverage
from scenes.lights import PolarRange
from scenes.sensor import Pinhole
from scenes.shapes import Sphere

Array = NDArray[np.float64]


def sphere_coverage(sphere: Sphere, sensor: Pinhole) -> Array:
    """The share of each pixel that sees a sphere from outside, ``(height, width)``.

    Raises:
        ValueError: the camera is inside, or the outline is no ellipse in its image plane.
    """
    w, r = np.subtract(sphere.center, sensor.origin), sphere.radius
    if w @ w <= r**2:
        raise ValueError("the camera must be outside the sphere")
    return cone_coverage(np.outer(w, w) - (w @ w - r**2) * np.eye(3), w, sensor)


def circle_coverage(center: ArrayLike, axis: ArrayLike, radius: float, sensor: Pinhole) -> Array:
    """The share of each pixel whose rays pass through a circle, ``(height, width)``.

    Args:
        center: of the circle, world coordinates.
        axis: unit normal of its plane, on either side.
        radius: of the circle, > 0.
        sensor: not in the circle's plane.

    Raises:
        ValueError: the camera is in the plane, or the circle is no ellipse in its image plane.
    """
    n, offset = np.asarray(axis, dtype=float), np.subtract(sensor.origin, center)
    s = -float(n @ offset)
    if s == 0:
        raise ValueError("the camera must not lie in the plane of the circle")
    B = np.outer(offset, n) + s * np.eye(3)
    return cone_coverage(radius**2 * np.outer(n, n) - B.T @ B, np.sign(s) * n, sensor)


def cap_coverage(sphere: Sphere, zone: PolarRange, sensor: Pinhole) -> Array:
    """The share of each pixel that sees a polar cap of a sphere from inside, ``(height, width)``.

    Raises:
        ValueError: a zone between two rims, or a camera that does not see the cap through its rim.
    """
    if zone.low > 0 and zone.high < 180:
        raise ValueError("a zone between two rims is no single cone")
    cosine = zone.cosines[0 if zone.low == 0 else 1]
    axis, center = np.asarray(zone.axis), np.asarray(sphere.center)
    rim = center + sphere.radius * cosine * axis
    if (axis @ (rim - sensor.origin) > 0) != (zone.low == 0):
        raise ValueError("the camera must see the cap through its rim")
    return circle_coverage(rim, axis, sphere.radius * np.sqrt(1 - cosine**2), sensor)
