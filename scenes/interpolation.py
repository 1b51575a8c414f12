"""Expensive smooth functions at many points: Chebyshev interpolation on the box that they span, with a check."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

Array = NDArray[np.float64]

TOLERANCE = 1e-9
"""Of the last coefficients, relative to the largest."""

ORDERS = (12, 24, 48)
"""Nodes per axis, one after the other until the last coefficients are nothing."""


def interpolated(function: Callable[[Array], Array], points: Array) -> Array:
    """The values of a function, from few evaluations.

    Args:
        function: points ``(axes, m)`` → ``(channels, m)``, analytic on the box; axes is 1 or 2.
        points: ``(axes, n)``.

    Returns:
        ``(channels, n)``.

    Raises:
        ValueError: the coefficients do not fall.
    """
    return interpolant(function, points.min(axis=1), points.max(axis=1))(points)


def interpolant(function: Callable[[Array], Array], low: Array, high: Array) -> Callable[[Array], Array]:
    """A function that takes the place of another one, wherever it is needed on a box.

    Args:
        function: as above.
        low, high: corners of the box, ``(axes,)``.

    Returns:
        points ``(axes, n)`` → ``(channels, n)``.

    Raises:
        ValueError: the coefficients do not fall.
    """
    middle, half = (low + high)[:, None] / 2, np.maximum((high - low)[:, None] / 2, 1e-12)
    for order in ORDERS:
        nodes = chebyshev.chebpts1(order)
        grid = np.stack(np.meshgrid(*[nodes] * len(low), indexing="ij")).reshape(len(low), -1)
        values = function(middle + half * grid)
        invert = np.linalg.inv(chebyshev.chebvander(nodes, order - 1))
        c = values.reshape(-1, *[order] * len(low))
        for axis in range(1, c.ndim):
            c = np.moveaxis(np.tensordot(invert, c, axes=(1, axis)), 0, axis)
        tails = [np.abs(np.take(c, [-2, -1], axis=axis)).max() for axis in range(1, c.ndim)]
        if max(tails) <= TOLERANCE * np.abs(c).max():
            return lambda points: _sum(c, (points - middle) / half)
    raise ValueError(f"{ORDERS[-1]} Chebyshev coefficients are not enough; expected a smooth function")


def _sum(c: Array, at: Array) -> Array:
    """The series with coefficients ``(channels, order[, order])`` at points of [−1, 1] or its square."""
    bases = [chebyshev.chebvander(a, c.shape[-1] - 1) for a in at]
    last: Array = c @ bases[-1].T  # (channels, [order,] n)
    return last if len(bases) == 1 else np.einsum("cin,ni->cn", last, bases[0])
