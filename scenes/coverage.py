"""How much of each pixel a cone covers: the exact pixel average of an indicator.

A disk, a sphere and the rim of a cap, seen through a pinhole, are cones of rays dᵀQd > 0, and a cone cuts the
image plane in a conic. Along a row of the image its interior is a segment with ends in closed form; only the
integral over the height of the pixel is done by quadrature, between the points where the integrand has a kink.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenes.sensor import Pinhole

Array = NDArray[np.float64]

_NODES = 24  # Gauss-Legendre points between two kinks; 1e-9 is reached with 12


def cone_coverage(cone: Array, axis: Array, sensor: Pinhole) -> Array:
    """The share of each pixel's square whose rays lie inside a cone.

    Args:
        cone: symmetric ``(3, 3)`` matrix Q, world coordinates; a direction d is inside if dᵀQd > 0.
        axis: ``(3,)``, a direction inside the nappe that is meant; the opposite one does not count.
        sensor: the cone must meet its image plane in an ellipse.

    Returns:
        ``(height, width)``, in [0, 1].

    Raises:
        ValueError: the conic is no ellipse.
    """
    q = conic(cone, axis, sensor)
    if q is None:
        return np.zeros((sensor.height, sensor.width))

    # row by row: at once, all pixels with all their nodes would take gigabytes
    return np.stack([_row_coverage(q, float(y), sensor.width) for y in range(sensor.height)])


def half_space_coverage(normal: Array, sensor: Pinhole) -> Array:
    """The share of each pixel's square whose rays d have n·d > 0: one side of a straight line, exactly.

    With a x + b y + c > 0 in the image, the integral of the step function over a square is the second difference of
    max(·, 0)² / 2ab. Along an axis on which it hardly changes it counts as constant, which costs less than 1e-8.

    Args:
        normal: n, ``(3,)``, world coordinates.
        sensor: the camera.

    Returns:
        ``(height, width)``, in [0, 1].
    """
    a, b, c = sensor.pixel_to_direction.T @ normal
    x, y = np.meshgrid(np.arange(sensor.width), np.arange(sensor.height))
    value = a * x + b * y + c
    small = 1e-8 * max(abs(a), abs(b))
    if abs(a) <= small and abs(b) <= small:
        return np.where(value > 0, 1.0, 0.0)
    if abs(a) <= small or abs(b) <= small:
        step = b if abs(a) <= small else a
        along: Array = (np.maximum(value + step, 0) - np.maximum(value, 0)) / step
        return along
    positive = [np.maximum(value + i * a + j * b, 0) ** 2 for i, j in ((1, 1), (1, 0), (0, 1), (0, 0))]
    share: Array = (positive[0] - positive[1] - positive[2] + positive[3]) / (2 * a * b)
    # inside, all four are squares of large numbers: what is a whole pixel is known without them
    corners = np.stack([value, value + a, value + b, value + a + b])
    return np.where(
        corners.min(axis=0) >= 0, 1.0, np.where(corners.max(axis=0) <= 0, 0.0, np.clip(share, 0, 1))
    )


def _row_coverage(q: Array, y0: float, width: int) -> Array:
    """The share of each pixel of the row [y0, y0 + 1] that lies inside the ellipse, ``(width,)``."""
    x0 = np.arange(width, dtype=float)
    breaks = np.clip(kinks(q, x0), y0, y0 + 1)
    edges = np.sort(np.concatenate([breaks, np.broadcast_to([[y0], [y0 + 1]], (2, width))]), axis=0)
    low, high = edges[:-1], edges[1:]

    # y = low + (high − low) sin²(φ), which takes the square root at the top and bottom of the ellipse away
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    phi = (nodes + 1).reshape(-1, 1, 1) * np.pi / 4
    y = low + (high - low) * np.sin(phi) ** 2
    dy = (high - low) * np.sin(2 * phi) * weights.reshape(-1, 1, 1) * np.pi / 4
    left, right = chord(q, y)
    length = np.clip(np.minimum(right, x0 + 1) - np.maximum(left, x0), 0, 1)
    coverage: Array = (length * dy).sum(axis=(0, 1))
    return coverage


def conic(cone: Array, axis: Array, sensor: Pinhole) -> Array | None:
    """The ellipse in which a cone cuts the image plane: (x, y, 1) q (x, y, 1)ᵀ > 0 inside, x and y in pixels.

    Args:
        cone, axis, sensor: as of ``cone_coverage``.

    Returns:
        q, symmetric ``(3, 3)``; None if the nappe that is meant lies behind the camera.

    Raises:
        ValueError: the conic is no ellipse.
    """
    M = sensor.pixel_to_direction
    q: Array = M.T @ cone @ M
    if q[0, 0] >= 0 or np.linalg.det(q[:2, :2]) <= 0:
        raise ValueError("the cone must cut the image plane in an ellipse")
    center = -np.linalg.solve(q[:2, :2], q[:2, 2])
    return q if (M @ np.append(center, 1)) @ axis > 0 else None


def chord(q: Array, y: Array) -> tuple[Array, Array]:
    """Where the ellipse begins and ends in the row y; both at the same place if the row misses it."""
    b, c = q[0, 1] * y + q[0, 2], q[1, 1] * y**2 + 2 * q[1, 2] * y + q[2, 2]
    root = np.sqrt(np.maximum(b**2 - q[0, 0] * c, 0))
    return (b - root) / -q[0, 0], (b + root) / -q[0, 0]


def kinks(q: Array, x0: Array) -> Array:
    """The y at which the ellipse has its top, its bottom, or crosses a vertical edge of a pixel, ``(6, width)``."""
    crossings = []
    for x in (x0, x0 + 1):
        a, b, c = q[1, 1], q[0, 1] * x + q[1, 2], q[0, 0] * x**2 + 2 * q[0, 2] * x + q[2, 2]
        root = np.sqrt(np.maximum(b**2 - a * c, 0))
        crossings += [(-b - root) / a, (-b + root) / a]
    # top and bottom: the discriminant of the chord, a quadratic in y, is zero
    quadratic = [
        q[0, 1] ** 2 - q[0, 0] * q[1, 1],
        2 * (q[0, 1] * q[0, 2] - q[0, 0] * q[1, 2]),
        q[0, 2] ** 2 - q[0, 0] * q[2, 2],
    ]
    ends = np.real(np.roots(quadratic))
    return np.stack(crossings + [np.full_like(x0, end) for end in ends])
