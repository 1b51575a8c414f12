"""The average over each pixel of a radiance that is smooth there, by Gauss's quadrature with a check.

A pixel is the mean over its square (box filter), and an answer is that mean. Where a pixel sees an edge, this is
not for it: see ``coverage``, or choose a camera that sees no edge.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from scenes.sensor import Orthographic, Pinhole

Array = NDArray[np.float64]
Radiance = Callable[[Array, Array], Array]

TOLERANCE = 1e-7
"""Of an average, relative to the largest of the image."""

ORDERS = (3, 5, 8, 12, 18, 27)
"""Nodes per axis, one after the other until two agree."""


class NotSmoothError(ValueError):
    """A pixel that quadrature does not settle: it sees an edge, or something very narrow."""


def pixel_average(sensor: Pinhole | Orthographic, radiance: Radiance) -> Array:
    """The mean of a radiance over every pixel, ``(height, width, channels)``.

    Args:
        sensor: the camera.
        radiance: origins ``(3, n)`` and unit directions ``(3, n)`` of rays → ``(channels, n)``.

    Raises:
        NotSmoothError: naming a pixel on which orders disagree.
    """
    averages = pixel_averages(sensor, radiance, np.arange(sensor.width * sensor.height))
    return averages.T.reshape(sensor.height, sensor.width, -1)


def pixel_averages(sensor: Pinhole | Orthographic, radiance: Radiance, pixels: NDArray[np.intp]) -> Array:
    """The mean of a radiance over some of the pixels, ``(channels, len(pixels))``.

    Args:
        sensor, radiance: as of ``pixel_average``.
        pixels: their numbers, row by row, ``(n,)``.

    Raises:
        NotSmoothError: naming a pixel on which orders disagree.
    """
    averages, left = np.empty((0, 0)), np.arange(len(pixels))
    for order in ORDERS:
        found = _gauss(sensor, radiance, pixels[left], order)
        if order == ORDERS[0]:
            averages = found
            continue
        largest = np.abs(averages).max(initial=0)
        unsettled = np.abs(found - averages[:, left]).max(axis=0) > TOLERANCE * largest
        averages[:, left] = found
        left = left[unsettled]
        if not len(left):
            return averages
    row, column = divmod(int(pixels[left[0]]), sensor.width)
    raise NotSmoothError(
        f"row {row}, column {column}: quadrature of {ORDERS[-2]}² and {ORDERS[-1]}² nodes disagree; expected a pixel "
        "that sees no edge"
    )


def rays(sensor: Pinhole | Orthographic, x: Array, y: Array) -> tuple[Array, Array]:
    """Origins and unit directions of the rays through points of the image, in pixels from its top left corner."""
    image = np.stack([x, y, np.ones_like(x)])
    origin = np.tile(np.array(sensor.origin)[:, None], len(x))
    if isinstance(sensor, Orthographic):
        return origin + sensor.pixel_to_offset @ image, np.tile(sensor.frame[:, 2:], len(x))
    d = sensor.pixel_to_direction @ image
    return origin, d / np.linalg.norm(d, axis=0)


def _gauss(sensor: Pinhole | Orthographic, radiance: Radiance, pixels: NDArray[np.intp], order: int) -> Array:
    """Averages over pixels, ``(channels, len(pixels))``."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    nodes, weights = (nodes + 1) / 2, weights / 2
    rows, columns = np.divmod(pixels, sensor.width)
    x = columns[:, None, None] + nodes[None, None, :] + 0 * nodes[None, :, None]
    y = rows[:, None, None] + nodes[None, :, None] + 0 * nodes[None, None, :]
    values = radiance(*rays(sensor, x.ravel(), y.ravel()))
    average: Array = values.reshape(len(values), len(pixels), order**2) @ np.outer(weights, weights).ravel()
    return average
