"""Where a ray has met a primitive: normals, shading normals and texture coordinates of the point."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference_tracer.points import NOWHERE, Points
from reference_tracer.shapes.primitives import Primitives
from reference_tracer.vectors import dot, norm
from scenes import Mesh, Scene
from scenes.materials import is_textured

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class Coordinates:
    """Makes points of primitives and positions."""

    def __init__(self, scene: Scene, primitives: Primitives) -> None:
        self._p, self._surfaces = primitives, scene.surfaces
        # one entry more than there are primitives: NOWHERE = −1 finds it
        self._normal = np.concatenate([primitives.normal, [[0, 0, 1]]]).T.copy()
        self._surface = np.append(primitives.surface, NOWHERE)
        self._one_each = len(primitives) == len(scene.surfaces)
        self._inverse = np.linalg.inv(primitives.axes)
        self._round = np.flatnonzero(primitives.round)
        self._two_sided = np.array([s.two_sided for s in scene.surfaces] + [False])
        smooth = [isinstance(s.shape, Mesh) and s.shape.normals is not None for s in scene.surfaces]
        self._smooth = np.flatnonzero(smooth)
        self._textured = np.flatnonzero([is_textured(s.material) for s in scene.surfaces])

    def points(self, x: Array, d: Array, primitive: Indices) -> Points:
        """Points of primitives.

        Args:
            x: positions, ``(3, n)``; put onto an ellipsoid exactly, since a distance is rounded.
            d: directions in which they were met, ``(3, n)``.
            primitive: what was met, ``(n,)``.
        """
        surface = primitive if self._one_each else self._surface.take(primitive)
        n = self._normal.take(primitive, axis=1)
        for i in self._round:
            lanes = np.flatnonzero(primitive == i)
            x[:, lanes], n[:, lanes] = self._on_ellipsoid(int(i), x.take(lanes, axis=1))
        if self._two_sided.any():
            behind = np.flatnonzero(self._two_sided.take(surface) & (dot(n, d) > 0))
            n[:, behind] *= -1
        points = Points(x, n, surface, primitive, n)
        if len(self._smooth):
            points.ns = self._shading_normals(points)
        if len(self._textured):
            points.uv = self._texture_coordinates(points)
        return points

    def _on_ellipsoid(self, i: int, x: Array) -> tuple[Array, Array]:
        """The nearest points in the direction of the centre, and the normals there: M⁻ᵀ of those of the sphere."""
        center, rows, shape = (
            self._p.center[i, :, None],
            self._p.axes[i],
            self._surfaces[self._p.surface[i]].shape,
        )
        local = self._inverse[i].T @ (x - center)
        local /= norm(local)
        n = self._inverse[i] @ local
        n /= norm(n)
        return center + rows.T @ local, -n if shape.inward else n

    def _local(self, x: Array, primitive: Indices) -> Array:
        """Coordinates in the frames of the primitives, ``(3, n)``."""
        offset = x.T - self._p.center[primitive]
        local: Array = np.einsum("nij,ni->jn", self._inverse[primitive], offset)
        return local

    def _shading_normals(self, points: Points) -> Array:
        """Interpolated over each triangle of meshes that have them."""
        ns = points.n.copy()
        for i in self._smooth:
            lanes = np.flatnonzero(points.surface == i)
            if len(lanes):
                mesh, at = self._surfaces[i].shape, points[lanes]
                smooth = self._interpolate(np.array(mesh.normals), mesh, int(i), at)  # type: ignore[union-attr,arg-type]
                smooth /= norm(smooth)
                # on the side of the normal, which on a two-sided mesh may have been turned
                front = self._normal.take(at.primitive, axis=1)
                ns[:, lanes] = smooth * np.sign(dot(front, at.n))
        return ns

    def _interpolate(self, values: Array, mesh: Mesh, surface: int, at: Points) -> Array:
        """Values at vertices ``(vertices, k)``, linear over each triangle, ``(k, n)``."""
        a, b, _ = self._local(at.x, at.primitive)
        corners = np.array(mesh.triangles)[at.primitive - self._p.first[surface]]
        p, q, r = (values[corners[:, i]].T for i in range(3))
        interpolated: Array = p * (1 - a - b) + q * a + r * b
        return interpolated

    def _texture_coordinates(self, points: Points) -> Array:
        """(u, v) on textured surfaces, 0 elsewhere.

        A quad's are its s and t. A disk's run over the square around it. A sphere's are longitude / 2π from
        local +x towards +y, and polar angle / π from −z. A mesh has its own.
        """
        uv = np.zeros((2, len(points)))
        for i in self._textured:
            lanes = np.flatnonzero(points.surface == i)
            shape, at = self._surfaces[i].shape, points[lanes]
            if isinstance(shape, Mesh):
                uv[:, lanes] = self._interpolate(np.array(shape.uv), shape, int(i), at)
                continue
            local = self._local(at.x, at.primitive)
            if self._p.round[self._p.first[i]]:
                longitude = np.arctan2(local[1], local[0]) / (2 * np.pi) % 1
                uv[:, lanes] = longitude, np.arccos(np.clip(-local[2], -1, 1)) / np.pi
            else:
                uv[:, lanes] = (local[:2] + 1) / 2
        return uv
