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
    M = sensor.pixel_to_direction
    q = M.T @ cone @ M  # (x, y, 1) q (x, y, 1)ᵀ > 0 inside; x, y in pixels
    if q[0, 0] >= 0 or np.linalg.det(q[:2, :2]) <= 0:
        raise ValueError("the cone must cut the image plane in an ellipse")
    center = -np.linalg.solve(q[:2, :2], q[:2, 2])
    if (M @ np.append(center, 1)) @ axis <= 0:  # the nappe that is meant lies behind the camera
        return np.zeros((sensor.height, sensor.width))

    rows, columns = np.arange(sensor.height, dtype=float), np.arange(sensor.width, dtype=float)
    x0, y0 = np.broadcast_arrays(columns[None, :], rows[:, None])
    kinks = np.clip(_kinks(q, x0, y0), y0, y0 + 1)
    edges = np.sort(np.concatenate([kinks, [y0, y0 + 1]]), axis=0)
    low, high = edges[:-1], edges[1:]

    # y = low + (high − low) sin²(φ), which takes the square root at the top and bottom of the ellipse away
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    phi = (nodes + 1) * np.pi / 4
    y = low + (high - low) * np.sin(phi).reshape(-1, 1, 1, 1) ** 2
    dy = (high - low) * (np.sin(2 * phi) * weights * np.pi / 4).reshape(-1, 1, 1, 1)
    left, right = _chord(q, y)
    length = np.clip(np.minimum(right, x0 + 1) - np.maximum(left, x0), 0, 1)
    coverage: Array = (length * dy).sum(axis=(0, 1))
    return coverage


def _chord(q: Array, y: Array) -> tuple[Array, Array]:
    """Where the ellipse begins and ends in the row y; both at the same place if the row misses it."""
    b, c = q[0, 1] * y + q[0, 2], q[1, 1] * y**2 + 2 * q[1, 2] * y + q[2, 2]
    root = np.sqrt(np.maximum(b**2 - q[0, 0] * c, 0))
    return (b - root) / -q[0, 0], (b + root) / -q[0, 0]


def _kinks(q: Array, x0: Array, y0: Array) -> Array:
    """The y at which the ellipse has its top, its bottom, or crosses a vertical edge of the pixel, ``(6, …)``."""
    columns = []
    for x in (x0, x0 + 1):
        a, b, c = q[1, 1], q[0, 1] * x + q[1, 2], q[0, 0] * x**2 + 2 * q[0, 2] * x + q[2, 2]
        root = np.sqrt(np.maximum(b**2 - a * c, 0))
        columns += [(-b - root) / a, (-b + root) / a]
    # top and bottom: the discriminant of the chord, a quadratic in y, is zero
    quadratic = [
        q[0, 1] ** 2 - q[0, 0] * q[1, 1],
        2 * (q[0, 1] * q[0, 2] - q[0, 0] * q[1, 2]),
        q[0, 2] ** 2 - q[0, 0] * q[2, 2],
    ]
    ends = np.real(np.roots(quadratic))
    return np.stack(columns + [np.full_like(y0, end) for end in ends])
