"""Overlaps of flat pieces: whether two polygons, disks, or one of each in the same plane share an area.

All functions take many pairs at once and answer for each. Pieces that only touch do not overlap: what they share
must be wider than a millionth of the smaller one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]

_WIDTH = 1e-6  # share of the smaller piece that an overlap is wider than


def polygons_overlap(a: Array, b: Array, normal: Array) -> Bools:
    """Whether convex polygons share an area, by the theorem of separating axes.

    Two convex polygons are disjoint if and only if they are so along the normal of one of their edges.

    Args:
        a, b: corners in order, ``(n, 4, 3)``; a triangle has its last corner twice.
        normal: of the plane, ``(n, 3)``.

    Returns:
        ``(n,)``.
    """
    # seen along the coordinate that the normal is largest in, which changes no answer: x, y are (4, n)
    seen = np.argsort(np.abs(normal), axis=1)[:, None, :2]
    (ax, ay), (bx, by) = (np.take_along_axis(p - a[:, :1], seen, axis=2).T for p in (a, b))
    overlap = np.ones(len(a), dtype=bool)
    for side in range(8):
        left = np.flatnonzero(overlap)  # the first edges separate most pairs
        axl, ayl, bxl, byl = ax[:, left], ay[:, left], bx[:, left], by[:, left]
        x, y = (axl, ayl) if side < 4 else (bxl, byl)
        u, v = x[(side + 1) % 4] - x[side % 4], y[(side + 1) % 4] - y[side % 4]
        on_a, on_b = u * ayl - v * axl, u * byl - v * bxl
        shared = np.minimum(on_a.max(axis=0), on_b.max(axis=0)) - np.maximum(
            on_a.min(axis=0), on_b.min(axis=0)
        )
        narrower = np.minimum(np.ptp(on_a, axis=0), np.ptp(on_b, axis=0))
        # a triangle has one edge that is none
        overlap[left] = (shared > _WIDTH * narrower) | ((u == 0) & (v == 0))
    return overlap


def disk_overlaps_polygon(frame: Array, center: Array, corners: Array) -> Bools:
    """Whether a disk and a convex polygon share an area: in the disk's frame it is the unit circle.

    Args:
        frame: axis_u, axis_v and the normal as columns, ``(n, 3, 3)``.
        center: of the disk, ``(n, 3)``.
        corners: of the polygon, ``(n, 4, 3)``; a triangle has its last corner twice.

    Returns:
        ``(n,)``.
    """
    local = np.linalg.solve(frame, (corners - center[:, None]).transpose(0, 2, 1))[:, :2]  # (n, 2, 4)
    edge = np.roll(local, -1, axis=2) - local
    length = np.maximum((edge**2).sum(axis=1), np.finfo(float).tiny)
    along = np.clip(-(local * edge).sum(axis=1) / length, 0, 1)  # of each edge, the point next to the centre
    nearest = np.linalg.norm(local + along[:, None] * edge, axis=1).min(axis=1)
    side = local[:, 0] * edge[:, 1] - local[:, 1] * edge[:, 0]
    inside = (side >= 0).all(axis=1) | (side <= 0).all(axis=1)
    return _is_within(np.where(inside, 0.0, nearest), np.ptp(local, axis=2).max(axis=1))


def disks_overlap(frame: Array, center: Array, other_frame: Array, other_center: Array) -> Bools:
    """Whether two disks share an area.

    In the frame of the first, the other is c + Mq with |q| ≤ 1. Its point next to the origin is a least-squares
    problem in a ball: q = −(MᵀM + λ)⁻¹ Mᵀc with the smallest λ ≥ 0 for which |q| ≤ 1, found by bisection
    (Moré and Sorensen 1983, Computing a trust region step).

    Args:
        frame, other_frame: axis_u, axis_v and the normal as columns, ``(n, 3, 3)``.
        center, other_center: ``(n, 3)``.

    Returns:
        ``(n,)``.
    """
    c = np.linalg.solve(frame, (other_center - center)[..., None])[:, :2]
    M = np.linalg.solve(frame, other_frame)[:, :2, :2]
    U, sigma, _ = np.linalg.svd(M)
    c = (U.transpose(0, 2, 1) @ c)[..., 0]  # along the axes of the other ellipse

    def q(multiplier: Array) -> Array:
        solution: Array = -sigma * c / (sigma**2 + multiplier[:, None])
        return solution

    low, high = np.zeros(len(c)), sigma[:, 0] * np.linalg.norm(c, axis=1)
    for _ in range(100):
        middle = (low + high) / 2
        outside = np.linalg.norm(q(middle), axis=1) > 1
        low, high = np.where(outside, middle, low), np.where(outside, high, middle)
    nearest = np.linalg.norm(c + sigma * q(high), axis=1)
    nearest[np.linalg.norm(q(np.zeros(len(c))), axis=1) <= 1] = 0.0
    return _is_within(nearest, 2 * sigma[:, 0])


def _is_within(distance: Array, extent: Array) -> Bools:
    """Whether what is so far from the centre reaches into the unit circle, by more than a touch."""
    within: Bools = distance < 1 - _WIDTH * np.minimum(1, extent)
    return within
