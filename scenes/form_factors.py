"""Exchange between rectangles with parallel edges: ∫∫ cos θ cos θ′ / πd² dA dA′ in closed form, an area.

Divided by the receiving area it is the mean irradiance by a lamp of exitance 1, divided by either area a form
factor. With x, y, ξ, η the coordinates of corners it is the fourfold alternating sum of (Ehlert and Smith 1993,
View factors for perpendicular and parallel rectangular plates, J. Thermophysics and Heat Transfer 7(1))

- parallel, at distance z, with a = x − ξ, b = y − η:
  2πG = b √(a² + z²) atan(b / √(a² + z²)) + a √(b² + z²) atan(a / √(b² + z²)) − (z²/2) ln(a² + b² + z²);
- perpendicular, x and ξ the distances from the line in which the planes meet, b = y − η along it:
  2πG = b √(x² + ξ²) atan(b / √(x² + ξ²)) − ¼ (x² + ξ² − b²) ln(x² + ξ² + b²).

A point takes the place of the rectangle in ``solid_angles``: the flux of a point light on a cell is its intensity
times ∫ cos θ / d² dA, with x and y from the foot of the perpendicular the alternating sum over the cell's corners of
G = atan(xy / z √(x² + y² + z²)) (Khadjavi 1968, Calculation of solid angle subtended by rectangular apertures).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def parallel_exchange(
    x: Array, y: Array, xi: tuple[float, float], eta: tuple[float, float], z: float
) -> Array:
    """Between every cell of a grid and a rectangle in a parallel plane.

    Args:
        x, y: the edges of the grid's columns ``(n + 1,)`` and rows ``(m + 1,)``, in world units.
        xi, eta: where the rectangle begins and ends, in the same coordinates.
        z: distance of the planes, > 0.

    Returns:
        ``(m, n)``, in the unit of area.
    """

    def G(x: Array, y: Array, xi: float, eta: float) -> Array:
        a, b = x - xi, y - eta
        along_a, along_b = np.sqrt(a**2 + z**2), np.sqrt(b**2 + z**2)
        angles = b * along_a * np.arctan(b / along_a) + a * along_b * np.arctan(a / along_b)
        return (angles - z**2 / 2 * np.log(a**2 + b**2 + z**2)) / (2 * np.pi)

    return _alternating(G, x, y, xi, eta)


def perpendicular_exchange(x: Array, y: Array, xi: tuple[float, float], eta: tuple[float, float]) -> Array:
    """Between every cell of a grid and a rectangle in a perpendicular plane.

    Args:
        x: the edges of the grid's columns ``(n + 1,)``, distances ≥ 0 from the line in which the planes meet.
        y: the edges of its rows ``(m + 1,)``, along that line.
        xi: where the rectangle begins and ends, distances ≥ 0 from that line.
        eta: where it begins and ends along it.

    Returns:
        ``(m, n)``, in the unit of area.
    """

    def G(x: Array, y: Array, xi: float, eta: float) -> Array:
        c, b = x**2 + xi**2, y - eta
        root, squared = np.sqrt(c), c + b**2
        # both terms tend to 0 where c does, and the second where the whole distance does
        angle = np.arctan2(b, root)
        logarithm = np.log(np.where(squared > 0, squared, 1))
        return (b * root * angle - (c - b**2) / 4 * logarithm) / (2 * np.pi)

    return _alternating(G, x, y, xi, eta)


def solid_angles(x: Array, y: Array, z: float) -> Array:
    """Under which a point sees every cell of a grid.

    Args:
        x, y: the edges of the grid's columns ``(n + 1,)`` and rows ``(m + 1,)``, from the foot of the perpendicular.
        z: distance of the point from the plane, > 0.

    Returns:
        ``(m, n)``, sr; the sign is that of the order in which the edges run.
    """
    columns, rows = x[None, :], y[:, None]
    G = np.arctan(columns * rows / (z * np.sqrt(columns**2 + rows**2 + z**2)))
    cells: Array = np.diff(np.diff(G, axis=0), axis=1)
    return cells


def _alternating(
    G: Callable[[Array, Array, float, float], Array],
    x: Array,
    y: Array,
    xi: tuple[float, float],
    eta: tuple[float, float],
) -> Array:
    """Σ ± G over the corners of the rectangle and of each cell."""
    columns, rows = x[None, :], y[:, None]
    at_corners = sum(
        (G(columns, rows, xi[k], eta[m]) * (-1) ** (k + m) for k in (0, 1) for m in (0, 1)),
        start=np.zeros((len(y), len(x))),
    )
    cells: Array = np.diff(np.diff(at_corners, axis=0), axis=1)
    return cells
