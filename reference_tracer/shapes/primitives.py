"""The primitives of a scene: a mesh has one per triangle, every other surface is one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from scenes import Disk, Ellipsoid, Mesh, Quad, Shape, Sphere, Surface

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class Primitives:
    """All primitives: kinds, frames, normals.

    Attributes:
        kind: the type of the shape, ``(count,)`` of ``Quad``, ``Disk``, ``Mesh``, ``Sphere`` …
        surface: whose they are, ``(count,)``.
        first: the first primitive of each surface, ``(surfaces,)``.
        center: origin of the local frame, ``(count, 3)``: the middle, of a triangle its first vertex.
        axes: of the local frame as rows, ``(count, 3, 3)``: half edges or radii, of a triangle its edges from
            the first vertex; the third axis of a flat primitive is its unit normal.
        normal: unit normal of the front, ``(count, 3)``; 0 for ellipsoids.
        round: which of them are spheres and ellipsoids, ``(count,)``.
    """

    def __init__(self, surfaces: Sequence[Surface]) -> None:
        parts = [_frames(s.shape) for s in surfaces]
        counts = [len(center) for center, _ in parts]
        self.surface = np.repeat(np.arange(len(surfaces)), counts)
        self.first = np.cumsum([0, *counts])[:-1]
        self.center = np.concatenate([np.zeros((0, 3)), *(center for center, _ in parts)])
        self.axes = np.concatenate([np.zeros((0, 3, 3)), *(axes for _, axes in parts)])
        self.kind: NDArray[np.object_] = np.repeat(
            np.array([type(s.shape) for s in surfaces], dtype=np.object_), counts
        )
        self.round = (self.kind == Sphere) | (self.kind == Ellipsoid)
        self.normal = np.where(self.round[:, None], 0.0, self.axes[:, 2])

    def __len__(self) -> int:
        return len(self.surface)

    def corners(self) -> Array:
        """Points whose convex hull holds each primitive, ``(count, 8, 3)``; of flat ones some count twice."""
        kinds = [self.kind == Mesh, self.round]
        weights = np.select([kind[:, None, None] for kind in kinds], [_TRIANGLE, _CUBE], _SQUARE)
        corners: Array = self.center[:, None] + weights @ self.axes
        return corners


_CUBE = np.array([[a, b, c] for c in (-1, 1) for b in (-1, 1) for a in (-1, 1)])
_SQUARE = _CUBE * [1, 1, 0]
_TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]] + 5 * [[0, 0, 0]])


def _frames(shape: Shape) -> tuple[Array, Array]:
    """Centres ``(count, 3)`` and axes ``(count, 3, 3)``."""
    if isinstance(shape, Quad):
        u, v = np.array(shape.edge_u) / 2, np.array(shape.edge_v) / 2
        return (shape.corner + u + v)[None], np.array([[u, v, shape.normal]])
    if isinstance(shape, Disk):
        return np.array([shape.center]), np.array([[shape.axis_u, shape.axis_v, shape.normal]])
    if isinstance(shape, Sphere):
        return np.array([shape.center]), shape.radius * np.eye(3)[None]
    if isinstance(shape, Ellipsoid):
        return np.array([shape.center]), shape.matrix.T[None]
    if isinstance(shape, Mesh):
        a, b, c = shape.corners.transpose(1, 0, 2)
        n = np.cross(b - a, c - a)
        return a, np.stack([b - a, c - a, n / np.linalg.norm(n, axis=1, keepdims=True)], axis=1)
    raise TypeError(f"no shape: {shape!r}")
