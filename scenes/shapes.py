"""Shapes: where surfaces are, the data of G.

They are closed under affine maps: the image of a quad is a quad, that of a sphere an ellipsoid. The front is the
side that the normal points to.

Texture coordinates (u, v):

- quad: (s, t);
- disk: ((1 + s) / 2, (1 + t) / 2);
- sphere, ellipsoid: of the point of the unit sphere, u = φ / 2π with the longitude φ in [0, 2π) from +x towards
  +y, and v = 1 − θ / π with the polar angle θ from +z; a sphere's local axes are those of the world;
- mesh: interpolated between those of the vertices.
"""

from __future__ import annotations

import math

import msgspec
import numpy as np
from numpy.typing import NDArray

from scenes.tables import table
from scenes.validation import SceneError, Vector, instance, path, positive, sine, vector

Array = NDArray[np.float64]


class Quad(
    msgspec.Struct, frozen=True, tag_field="type", tag="quad", forbid_unknown_fields=True, omit_defaults=True
):
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
        if not _spans(u, v):
            raise SceneError(path(self, "edge_v"), v, f"an edge that spans an area with edge_u = {u}")

    @property
    def area(self) -> float:
        """|edge_u × edge_v|."""
        return float(np.linalg.norm(np.cross(self.edge_u, self.edge_v)))

    @property
    def normal(self) -> Array:
        """The unit normal of the front, ``(3,)``."""
        cross = np.cross(self.edge_u, self.edge_v)
        return cross / np.linalg.norm(cross)


class Disk(
    msgspec.Struct, frozen=True, tag_field="type", tag="disk", forbid_unknown_fields=True, omit_defaults=True
):
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
        if not _spans(u, v):
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


class Sphere(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="sphere",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
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
        positive(self, "radius")
        if not 0 < self.area < math.inf:
            raise SceneError(path(self, "radius"), self.radius, "a radius whose square is a number > 0")
        instance(self, "inward", bool, "True or False")

    @property
    def area(self) -> float:
        """4πr²."""
        return 4 * math.pi * self.radius * self.radius


class Ellipsoid(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="ellipsoid",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
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
        axes = [np.asarray(vector(self, field)) for field in ("axis_u", "axis_v", "axis_w")]
        lengths = [math.hypot(*axis) for axis in axes]
        volume = 0.0
        if 0 < math.prod(lengths) < math.inf:
            volume = float(np.linalg.det([axis / length for axis, length in zip(axes, lengths, strict=True)]))
        if not abs(volume) > 1e-9:
            raise SceneError(path(self, "axis_w"), self.axis_w, "an axis that spans a volume with the others")
        instance(self, "inward", bool, "True or False")

    @property
    def matrix(self) -> Array:
        """The linear map ``(3, 3)`` that takes the unit sphere to this one: its columns are the axes."""
        return np.array([self.axis_u, self.axis_v, self.axis_w]).T


class Mesh(
    msgspec.Struct, frozen=True, tag_field="type", tag="mesh", forbid_unknown_fields=True, omit_defaults=True
):
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
        count = len(table(self, "vertices", (None, 3)))
        table(self, "triangles", (None, 3), low=0, high=count - 1, whole=True)
        _refuse_flat(self)
        if self.uv is not None:
            table(self, "uv", (count, 2))
        if self.normals is not None:
            _normalise(self, table(self, "normals", (count, 3)))

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


def _spans(u: Vector, v: Vector) -> bool:
    """Whether two vectors span an area; relative to their lengths, so that a small one is no degenerate one."""
    if not sine(np.asarray(u), np.asarray(v)) > 1e-9:
        return False
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(0 < np.linalg.norm(np.cross(u, v)) < math.inf)


def _refuse_flat(mesh: Mesh) -> None:
    """Refuse triangles without an area, which have no normal."""
    with np.errstate(over="ignore", invalid="ignore"):
        corners = mesh.corners
        longest = ((corners - np.roll(corners, 1, axis=1)) ** 2).sum(axis=2).max(axis=1)
        flat = np.flatnonzero(~((2 * mesh.areas > 1e-9 * longest) & (longest < math.inf)))
    if len(flat):
        found = tuple(map(tuple, corners[flat[0]].tolist()))
        raise SceneError(path(mesh, f"triangles[{flat[0]}]"), found, "three corners that span an area")


def _normalise(mesh: Mesh, normals: Array) -> None:
    """Freeze unit normals; each on the front of every triangle that uses it, or no side could be told."""
    lengths = np.array([math.hypot(*n) for n in normals])
    unusable = np.flatnonzero(~((lengths > 0) & (lengths < math.inf)))
    if len(unusable):
        found = tuple(normals[unusable[0]].tolist())
        raise SceneError(path(mesh, f"normals[{unusable[0]}]"), found, "a direction, not the zero vector")
    # dividing once more would change the last digits: not what JSON has kept
    unit = np.where(np.abs(lengths - 1)[:, None] < 1e-15, normals, normals / lengths[:, None])
    msgspec.structs.force_setattr(mesh, "normals", tuple(map(tuple, unit.tolist())))
    triangles, (a, b, c) = np.array(mesh.triangles), mesh.corners.transpose(1, 0, 2)
    cosines = np.einsum("tvi,ti->tv", unit[triangles], np.cross(b - a, c - a))
    behind = np.argwhere(~(cosines > 0))
    if len(behind):
        triangle, corner = behind[0]
        vertex = mesh.triangles[triangle][corner]
        expected = f"a direction on the front of triangles[{triangle}], whose vertices run counterclockwise"
        raise SceneError(path(mesh, f"normals[{vertex}]"), tuple(normals[vertex].tolist()), expected)
