"""Sweep and prune: which of many boxes meet, without a look at every pair."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_BLOCK = 1 << 16  # pairs that are looked at together: they stay in the cache


def meeting_pairs(low: Array, high: Array) -> Iterator[tuple[Indices, Indices]]:
    """Pairs of boxes that meet along every axis.

    They are sorted by where they begin along the axis that leaves the fewest pairs; a box can then meet only
    those that begin before it ends (Baraff 1992, Dynamic simulation of non-penetrating rigid bodies, app. C).

    Args:
        low, high: limits, ``(n, axes)``; touching counts.

    Yields:
        Indices of the ones and the others, block by block; every pair once.
    """
    orders = np.argsort(low, axis=0)
    best, axis, order = np.inf, 0, np.arange(0)
    for k in range(low.shape[1]):
        starts = low[orders[:, k], k]
        counts = np.searchsorted(starts, high[orders[:, k], k], side="right") - np.arange(1, len(low) + 1)
        if counts.sum() < best:
            best, axis, order, after = counts.sum(), k, orders[:, k], counts
    if not 0 < best < np.inf:
        return
    blocks = np.unique(np.searchsorted(np.cumsum(after), np.arange(0, best, _BLOCK), side="right"))
    for first, last in zip(blocks, [*blocks[1:], len(after)], strict=True):
        counts = after[first:last]
        i = np.repeat(np.arange(first, last), counts)
        j = i + 1 + np.arange(len(i)) - np.repeat(np.cumsum(counts) - counts, counts)
        a, b = order[i], order[j]
        for k in range(low.shape[1]):
            if k != axis:
                meet = (low[a, k] <= high[b, k]) & (low[b, k] <= high[a, k])
                a, b = a[meet], b[meet]
        if len(a):
            yield a, b
