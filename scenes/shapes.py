"""Shapes: where surfaces are, the data of G.

Each is closed under affine maps: the image of a quad is a quad, that of a sphere an ellipsoid. The front is the
side that the normal points to.
"""

from __future__ import annotations

import math
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from scenes.validation import SceneError, Vector, instance, number, path, vector

Array = NDArray[np.float64]


class Quad(msgspec.Struct, frozen=True, tag_field="type", tag="quad", forbid_unknown_fields=True):
    """A parallelogram: the points corner + s·edge_u + t·edge_v with s, t in [0, 1]. Normal: edge_u × edge_v.

    Attributes:
        corner: one corner, world coordinates.
        edge_u, edge_v: the two edges that leave it.
    """

    corner: Vector
    edge_u: Vector
    edge_v: Vector

    def __post_init__(self) -> None:
        vector(self, "corner")
        u, v = vector(self, "edge_u"), vector(self, "edge_v")
        # sine of the angle between the edges: a relative measure, so that a small quad is no degenerate one
        if not self.area > 1e-9 * math.hypot(*u) * math.hypot(*v):
            raise SceneError(path(self, "edge_v"), v, f"an edge that spans an area with edge_u = {u}")

    @property
    def _cross(self) -> NDArray[np.float64]:
        return np.cross(self.edge_u, self.edge_v)

    @property
    def area(self) -> float:
        """|edge_u × edge_v|."""
        return float(np.linalg.norm(self._cross))

    @property
    def normal(self) -> NDArray[np.float64]:
        """The unit normal of the front, ``(3,)``."""
        return self._cross / np.linalg.norm(self._cross)

    @property
    def is_rectangle(self) -> bool:
        """Whether the edges are orthogonal, to rounding."""
        u, v = np.asarray(self.edge_u), np.asarray(self.edge_v)
        return bool(abs(u @ v) <= 1e-6 * np.linalg.norm(u) * np.linalg.norm(v))


class Disk(msgspec.Struct, frozen=True, tag_field="type", tag="disk", forbid_unknown_fields=True):
    """An ellipse with its inside: center + s·axis_u + t·axis_v with s² + t² ≤ 1. Normal: axis_u × axis_v.

    Attributes:
        center: world coordinates.
        axis_u, axis_v: conjugate radii; orthogonal and of the same length for a circle.
    """

    center: Vector
    axis_u: Vector
    axis_v: Vector

    def __post_init__(self) -> None:
        vector(self, "center")
        u, v = vector(self, "axis_u"), vector(self, "axis_v")
        if not self.area / math.pi > 1e-9 * math.hypot(*u) * math.hypot(*v):
            raise SceneError(path(self, "axis_v"), v, f"an axis that spans an area with axis_u = {u}")

    @property
    def area(self) -> float:
        """π |axis_u × axis_v|."""
        return math.pi * float(np.linalg.norm(np.cross(self.axis_u, self.axis_v)))

    @property
    def normal(self) -> Array:
        """The unit normal of the front, ``(3,)``."""
        cross = np.cross(self.axis_u, self.axis_v)
        return cross / np.linalg.norm(cross)


class Sphere(msgspec.Struct, frozen=True, tag_field="type", tag="sphere", forbid_unknown_fields=True):
    """A sphere.

    Attributes:
        center: world coordinates.
        radius: > 0.
        inward: the front is the inside: for a cavity.
    """

    center: Vector
    radius: float
    inward: bool = False

    def __post_init__(self) -> None:
        vector(self, "center")
        if not number(self, "radius", "a number > 0") > 0:
            raise SceneError(path(self, "radius"), self.radius, "a number > 0")
        instance(self, "inward", bool, "True or False")

    @property
    def area(self) -> float:
        """4πr²."""
        return 4 * math.pi * self.radius**2


class Ellipsoid(msgspec.Struct, frozen=True, tag_field="type", tag="ellipsoid", forbid_unknown_fields=True):
    """The affine image of the unit sphere: center + x·axis_u + y·axis_v + z·axis_w.

    Attributes:
        center: world coordinates.
        axis_u, axis_v, axis_w: images of the unit vectors; they span a volume.
        inward: the front is the inside: for a cavity.
    """

    center: Vector
    axis_u: Vector
    axis_v: Vector
    axis_w: Vector
    inward: bool = False

    def __post_init__(self) -> None:
        vector(self, "center")
        lengths = [math.hypot(*vector(self, field)) for field in ("axis_u", "axis_v", "axis_w")]
        if not abs(np.linalg.det(self.matrix)) > 1e-9 * math.prod(lengths):
            raise SceneError(path(self, "axis_w"), self.axis_w, "an axis that spans a volume with the others")
        instance(self, "inward", bool, "True or False")

    @property
    def matrix(self) -> Array:
        """The linear map ``(3, 3)`` that takes the unit sphere to this one: its columns are the axes."""
        return np.array([self.axis_u, self.axis_v, self.axis_w]).T


class Mesh(msgspec.Struct, frozen=True, tag_field="type", tag="mesh", forbid_unknown_fields=True):
    """Triangles. A triangle's front is where its vertices run counterclockwise.

    Attributes:
        vertices: positions, world coordinates.
        triangles: three indices of vertices each.
        normals: shading normals, one per vertex, normalised; None for flat shading.
        uv: texture coordinates, one pair per vertex; None for none.
    """

    vertices: tuple[Vector, ...]
    triangles: tuple[tuple[int, int, int], ...]
    normals: tuple[Vector, ...] | None = None
    uv: tuple[tuple[float, float], ...] | None = None

    def __post_init__(self) -> None:
        _rows(self, "vertices", 3, "three numbers x, y, z")
        _check_triangles(self)
        for field, width in (("normals", 3), ("uv", 2)):
            if getattr(self, field) is not None:
                rows = _rows(self, field, width, f"{width} numbers")
                if len(rows) != len(self.vertices):
                    expected = f"{len(self.vertices)} of them, one per vertex"
                    raise SceneError(path(self, field), len(rows), expected)
        if self.normals is not None:
            _normalise(self)

    @property
    def corners(self) -> Array:
        """Positions of the corners, ``(triangles, 3 corners, 3)``."""
        corners: Array = np.array(self.vertices)[np.array(self.triangles)]
        return corners

    @property
    def areas(self) -> Array:
        """Area of each triangle, ``(triangles,)``."""
        a, b, c = self.corners.transpose(1, 0, 2)
        areas: Array = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        return areas

    @property
    def area(self) -> float:
        """Of all triangles together."""
        return float(self.areas.sum())


Shape = Quad | Disk | Sphere | Ellipsoid | Mesh


def _rows(owner: Any, field: str, width: int, expected: str) -> Array:
    """Freeze the field into tuples of so many finite numbers each."""
    try:
        rows = np.array(getattr(owner, field), dtype=float)
    except (TypeError, ValueError):
        rows = np.zeros(0)
    if rows.ndim != 2 or rows.shape[1] != width or not np.isfinite(rows).all():
        for i, row in enumerate(getattr(owner, field)):  # which one it is
            if not np.shape(row) == (width,) or not np.isfinite(np.asarray(row, dtype=float)).all():
                raise SceneError(path(owner, f"{field}[{i}]"), row, f"{expected}, finite")
        raise SceneError(path(owner, field), getattr(owner, field), f"a list of {expected}")
    msgspec.structs.force_setattr(owner, field, tuple(map(tuple, rows.tolist())))
    return rows


def _check_triangles(mesh: Mesh) -> None:
    """Freeze the triangles; refuse indices that no vertex has, triangles without an area, and the same twice."""
    indices = np.array(mesh.triangles)
    if indices.ndim != 2 or indices.shape[1] != 3 or indices.dtype.kind != "i":
        raise SceneError(path(mesh, "triangles"), mesh.triangles, "a list of three indices of vertices each")
    wrong = np.flatnonzero(((indices < 0) | (indices >= len(mesh.vertices))).any(axis=1))
    if len(wrong):
        expected = f"indices in [0, {len(mesh.vertices) - 1}]"
        raise SceneError(path(mesh, f"triangles[{wrong[0]}]"), mesh.triangles[wrong[0]], expected)
    msgspec.structs.force_setattr(mesh, "triangles", tuple(map(tuple, indices.tolist())))
    a, b, c = mesh.corners.transpose(1, 0, 2)
    longest = np.max([((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    flat = np.flatnonzero(~(2 * mesh.areas > 1e-9 * longest))
    if len(flat):
        found = mesh.corners[flat[0]].tolist()
        raise SceneError(path(mesh, f"triangles[{flat[0]}]"), found, "a triangle with an area")
    _, first, count = np.unique(np.sort(mesh.corners, axis=1), axis=0, return_index=True, return_counts=True)
    if (count > 1).any():
        i = first[count > 1][0]
        raise SceneError(
            path(mesh, f"triangles[{i}]"), mesh.triangles[i], "no triangle in the same place twice"
        )


def _normalise(mesh: Mesh) -> None:
    """Freeze unit normals; each on the front of every triangle that uses it, or no side could be told."""
    normals = np.array(mesh.normals)
    lengths = np.linalg.norm(normals, axis=1)
    if not (lengths > 0).all():
        i = int(np.argmin(lengths))
        raise SceneError(path(mesh, f"normals[{i}]"), mesh.normals[i], "a direction, not the zero vector")  # type: ignore[index]
    normals = np.where(np.abs(lengths - 1)[:, None] < 1e-15, normals, normals / lengths[:, None])
    msgspec.structs.force_setattr(mesh, "normals", tuple(map(tuple, normals.tolist())))
    a, b, c = mesh.corners.transpose(1, 0, 2)
    cosines = np.einsum("tvi,ti->tv", normals[np.array(mesh.triangles)], np.cross(b - a, c - a))
    if not (cosines > 0).all():
        i = int(np.argwhere(~(cosines > 0))[0, 0])
        expected = "shading normals on the front of the triangle (counterclockwise vertices)"
        raise SceneError(path(mesh, f"triangles[{i}]"), mesh.triangles[i], expected)
