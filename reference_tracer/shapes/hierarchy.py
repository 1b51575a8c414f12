"""A bounding volume hierarchy for many shapes, walked by whole blocks of rays (Rubin and Whitted 1980).

A node looks at all its children at once: the rays are held against the children's boxes in one stacked pass, and
each child gets those that meet its box before what they have met so far. NumPy pays per call, so nodes are wide
and leaves are large.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from reference_tracer.shapes.intersection import TINY, Shapes

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

LEAF = 24
"""Shapes that are tested one by one."""
CHILDREN = 8


class Hierarchy:
    """Shapes, grouped by nearness; ``meet`` as of all shapes."""

    def __init__(self, low: Array, high: Array, leaf: Callable[[Indices], Shapes]) -> None:
        """Build it.

        Args:
            low, high: corners of the bounding boxes of all shapes, ``(shapes, 3)``.
            leaf: makes the shapes of these indices.
        """
        self._children: list[Shapes] = []
        lows, highs = [], []
        for group in _split((low + high) / 2, np.arange(len(low)), CHILDREN):
            if len(group) <= LEAF:
                self._children.append(leaf(group))
            else:
                self._children.append(Hierarchy(low[group], high[group], lambda i, g=group: leaf(g[i])))  # type: ignore[misc]
            lows.append(low[group].min(axis=0))
            highs.append(high[group].max(axis=0))
        # boxes grow by a few roundings, so that a ray within the plane of a flat box can't slip by
        margin = 1e-14 * (np.abs(lows).max() + np.abs(highs).max())
        self._low, self._high = np.array(lows).T[:, :, None] - margin, np.array(highs).T[:, :, None] + margin

    def meet(self, x: Array, d: Array, start: Indices, t: Array, primitive: Indices) -> None:
        """See ``intersection``."""
        enter, leave = self._spans(x, d)
        met = (enter <= leave) & (leave > 0)
        for child, enters, meets in zip(self._children, enter, met, strict=True):
            lanes = np.flatnonzero(meets & (enters < t))
            if len(lanes):
                t_child, which = t.take(lanes), primitive.take(lanes)
                child.meet(x.take(lanes, axis=1), d.take(lanes, axis=1), start.take(lanes), t_child, which)
                t[lanes], primitive[lanes] = t_child, which

    def _spans(self, x: Array, d: Array) -> tuple[Array, Array]:
        """Where the rays enter and leave the children's boxes, ``(children, n)`` each."""
        inverse = (1 / (d + TINY))[:, None]
        a, b = (self._low - x[:, None]) * inverse, (self._high - x[:, None]) * inverse
        return np.minimum(a, b).max(axis=0), np.maximum(a, b).min(axis=0)


def _split(centers: Array, indices: Indices, parts: int) -> list[Indices]:
    """Indices in groups of equal size, by halving along the longest side of their centres."""
    if parts == 1 or len(indices) <= LEAF:
        return [indices]
    extent = centers[indices].max(axis=0) - centers[indices].min(axis=0)
    order = indices[np.argsort(centers[indices, extent.argmax()], kind="stable")]
    middle = len(order) // 2
    return _split(centers, order[:middle], parts // 2) + _split(centers, order[middle:], parts // 2)
