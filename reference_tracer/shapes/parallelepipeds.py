"""Quads that are faces of the same parallelepiped: found, so that rays can meet them together."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TOLERANCE = 1e-12
"""Of corners that are the same, relative to the size of the quad."""

MOST = 64
"""Quads among which to look: all pairs are tried, and more belong into a hierarchy anyway."""


def find(centers: Array, axes: Array) -> list[tuple[Array, Array, NDArray[np.intp]]]:
    """Parallelepipeds with at least three of their faces among the quads; no quad belongs to two of them.

    Args:
        centers: of the quads, ``(quads, 3)``.
        axes: their half edges in the first two rows, ``(quads, 3, 3)``.

    Returns:
        For each its centre ``(3,)``, its half edges as rows ``(3, 3)``, and for each face 2·axis + side the
        position of its quad, −1 for a missing one, ``(6,)``.
    """
    if len(centers) > MOST:
        return []
    corners = [_corners(center, u, v) for center, (u, v, _) in zip(centers, axes, strict=True)]
    free, found = set(range(len(centers))), []
    for i, j in combinations(range(len(centers)), 2):
        if not {i, j} <= free or not _same(corners[i] + centers[j] - centers[i], corners[j]):
            continue
        half = np.array([*axes[i, :2], (centers[j] - centers[i]) / 2])
        if abs(np.linalg.det(half)) <= 1e-9 * np.prod(np.linalg.norm(half, axis=1)):
            continue  # two translates in one plane span nothing
        center = (centers[i] + centers[j]) / 2
        faces = np.array([_face(center, half, f, corners, free) for f in range(6)])
        if (faces >= 0).sum() >= 3:
            found.append((center, half, faces))
            free -= set(faces.tolist())
    return found


def _face(center: Array, half: Array, face: int, corners: list[Array], free: set[int]) -> int:
    """The quad on that face, −1 for none."""
    axis, side = face // 2, 2 * (face % 2) - 1
    wanted = _corners(center + side * half[axis], half[(axis + 1) % 3], half[(axis + 2) % 3])
    return next((k for k in sorted(free) if _same(wanted, corners[k])), -1)


def _corners(center: Array, u: Array, v: Array) -> Array:
    return np.array([center - u - v, center + u - v, center + u + v, center - u + v])


def _same(a: Array, b: Array) -> bool:
    """Whether two quads have the same corners, in any order."""
    distance = np.linalg.norm(a[:, None] - b, axis=2).min(axis=1)
    return bool((distance <= TOLERANCE * np.abs(a - a.mean(axis=0)).max()).all())
