"""Averages of a piecewise polynomial radiance over the squares of a pinhole's pixels, without sampling.

Seen from the pinhole, the edge of a patch is a straight line in the image. Each pixel is cut along these lines into
convex polygons, in each of which a single patch is seen and its radiance is smooth; a Gauss rule integrates that.
What a surface in front hides is cut away in the same manner (Weiler and Atherton 1977, Hidden surface removal using
polygon area sorting, SIGGRAPH 11(2)), so that areas are exact, edges of surfaces and of lights included.
Two surfaces that cut through each other are taken for the one that is in front at the middle of their overlap.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from reference_tracer.elements.bases import Patches, uniform
from scenes import Pinhole

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

SLIVER = 1e-13
"""A distance in pixels that counts as zero."""

SMALL = 0.25
"""Share of a patch, in s and in t, up to which three Gauss points per axis integrate its polynomials."""


@dataclass(frozen=True)
class Polygons:
    """Convex polygons in the image, one orientation for all.

    Attributes:
        vertices: in pixels, ``(n, most vertices, 2)``; the shorter ones repeat their last vertex.
        pixel: the row-major pixel that each is a part of, ``(n,)``.
    """

    vertices: Array
    pixel: Indices

    def __len__(self) -> int:
        return len(self.pixel)

    def __getitem__(self, which: NDArray[np.bool_] | Indices) -> Polygons:
        return Polygons(self.vertices[which], self.pixel[which])

    @property
    def centers(self) -> Array:
        """A point inside each, ``(n, 2)``."""
        return np.asarray(self.vertices.mean(axis=1))

    def beyond(self, line: Array) -> Array:
        """Signed distance of the vertices from the line ax + by + c = 0, ``(n, vertices)``."""
        return np.asarray(self.vertices @ line[:2] + line[2])

    def clipped(self, line: Array) -> Polygons:
        """The parts where ax + by + c ≥ 0 (Sutherland and Hodgman 1974); empty ones are left out."""
        distance = self.beyond(line)
        kept = np.any(distance > SLIVER, axis=1)
        whole: NDArray[np.bool_] = np.all(distance[kept] >= -SLIVER, axis=1)
        found, distance = self[kept], distance[kept]
        cut, here = found[~whole], distance[~whole]
        if not len(cut):
            return found
        after, there = np.roll(cut.vertices, -1, axis=1), np.roll(here, -1, axis=1)
        crossing = (here >= 0) != (there >= 0)
        share = here / np.where(crossing, here - there, 1.0)
        middle = cut.vertices + share[..., None] * (after - cut.vertices)
        candidates = np.stack([cut.vertices, middle], axis=2).reshape(len(cut), -1, 2)
        taken = np.stack([here >= 0, crossing], axis=2).reshape(len(cut), -1)
        count = taken.sum(axis=1)
        order = np.argsort(~taken, axis=1, kind="stable")[:, : count.max()]
        order = np.take_along_axis(order, np.minimum(np.arange(count.max()), count[:, None] - 1), axis=1)
        left = Polygons(np.take_along_axis(candidates, order[..., None], axis=1), cut.pixel)
        return _joined(found[whole], left)

    def split(self, line: Array) -> Polygons:
        """The same area, with no polygon on both sides of a line."""
        return _joined(self.clipped(line), self.clipped(-line))

    def quadrilaterals(self) -> Polygons:
        """The same area in polygons of four vertices, fans about the first one; triangles repeat their last."""
        last = self.vertices.shape[1] - 1
        fan = []
        for i in range(1, last, 2):
            corners = self.vertices[:, [0, i, i + 1, min(i + 2, last)]]
            flat = (corners[:, 1] == corners[:, 2]).all(axis=1) & (corners[:, 2] == corners[:, 3]).all(axis=1)
            fan.append(Polygons(corners[~flat], self.pixel[~flat]))
        return reduce(_joined, fan)

    def rule(self, count: int) -> tuple[Array, Array]:
        """Gauss points ``(n, points, 2)`` of quadrilaterals and their weights ``(n, points)``: sums are areas.

        Each is a bilinear image of the unit square.
        """
        square = uniform(count, 1)
        u, v = (a.ravel()[:, None] for a in np.meshgrid(square.nodes, square.nodes, indexing="ij"))
        a, b, c, d = (self.vertices[:, None, j] for j in range(4))
        along_u, along_v = (1 - v) * (b - a) + v * (c - d), (1 - u) * (d - a) + u * (c - b)
        stretch = np.abs(along_u[..., 0] * along_v[..., 1] - along_u[..., 1] * along_v[..., 0])
        points = a + u * (b - a) + v * (d - a) + u * v * (a - b + c - d)
        return points, stretch * np.outer(square.weights, square.weights).ravel()


def _joined(a: Polygons, b: Polygons) -> Polygons:
    most = max(a.vertices.shape[1], b.vertices.shape[1])
    padded = [
        np.concatenate(
            [p.vertices, np.repeat(p.vertices[:, -1:], most - p.vertices.shape[1], axis=1)], axis=1
        )
        for p in (a, b)
    ]
    return Polygons(np.concatenate(padded), np.concatenate([a.pixel, b.pixel]))


def pixels(sensor: Pinhole) -> Polygons:
    """The squares of all pixels."""
    rows, columns = np.divmod(np.arange(sensor.width * sensor.height), sensor.width)
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    corners = np.stack([columns, rows], axis=1)[:, None, :] + square
    return Polygons(corners.astype(float), np.arange(len(rows)))


class View:
    """A quad as a pinhole sees it."""

    def __init__(self, sensor: Pinhole, patches: Patches) -> None:
        self.patches = patches
        self._origin = np.array(sensor.origin)
        self._to_direction = sensor.pixel_to_direction
        self._height = float(patches.normal @ (self._origin - patches.corner))
        size = np.linalg.norm(patches.edges, axis=1).max()
        self.edge_on = abs(self._height) < 1e-12 * size
        self.from_the_front = self._height > 0 and not self.edge_on

    def line(self, axis: int, value: float) -> Array:
        """Coefficients of the line in the image where s (axis 0) or t (axis 1) has a value; above 0 where less."""
        fixed, free = np.full(2, value), np.array([0.0, 1.0])
        ends = self.patches.points(*((fixed, free) if axis == 0 else (free, fixed))) - self._origin[:, None]
        plane = np.cross(ends[:, 0], ends[:, 1])
        plane = plane * -np.sign(plane @ self.patches.edges[axis])
        coefficients = plane @ self._to_direction
        return np.asarray(coefficients / max(np.hypot(*coefficients[:2]), 1e-300))

    def edges(self) -> list[Array]:
        """The lines of its four edges, above 0 inside."""
        return [sign * self.line(axis, end) for axis in (0, 1) for sign, end in ((-1, 0.0), (1, 1.0))]

    def depth(self, points: Array) -> Array:
        """How far points of the image are from the pinhole, in lengths of their direction; points ``(…, 2)``."""
        return -self._height / (self._directions(points) @ self.patches.normal)

    def coordinates(self, points: Array) -> tuple[Array, Array]:
        """s and t of the points seen at points of the image, ``(…, 2)``."""
        x = self._origin + self.depth(points)[..., None] * self._directions(points)
        s, t = self.patches.coordinates(x.reshape(-1, 3).T)
        return s.reshape(x.shape[:-1]), t.reshape(x.shape[:-1])

    def _directions(self, points: Array) -> Array:
        return np.asarray(points @ self._to_direction[:, :2].T + self._to_direction[:, 2])


def visible_parts(views: list[View], i: int, squares: Polygons) -> Polygons:
    """The parts of pixels in which surface i is seen, and no other one in front of it."""
    parts = _inside(squares, views[i])
    for j, other in enumerate(views):
        if j == i or other.edge_on:
            continue
        shared = np.isin(parts.pixel, np.unique(_inside(parts, other).pixel))
        free, rest = parts[~shared], parts[shared]
        for line in other.edges():
            if len(rest):
                free, rest = _joined(free, rest.clipped(-line)), rest.clipped(line)
        # of what is left, both surfaces cover all
        nearer = views[i].depth(rest.centers) < other.depth(rest.centers) * (1 + 1e-9)
        parts = _joined(free, rest[nearer])
    return parts


def _inside(polygons: Polygons, view: View) -> Polygons:
    for line in view.edges():
        polygons = polygons.clipped(line)
    return polygons


def weights(sensor: Pinhole, surfaces: list[Patches]) -> scipy.sparse.csr_array:
    """The matrix ``(pixels, nodes of all surfaces)`` that takes nodal radiance to averages over pixels.

    Pixels are row-major; the nodes of the surfaces follow one another.
    """
    views = [View(sensor, patches) for patches in surfaces]
    start = np.cumsum([0, *(len(patches) for patches in surfaces)])
    squares = pixels(sensor)
    shape = (len(squares), int(start[-1]))
    total = scipy.sparse.csr_array(shape)
    for i, view in enumerate(views):
        if view.from_the_front:
            rows, columns, values = _surface_weights(view, visible_parts(views, i, squares))
            total = total + scipy.sparse.csr_array((values, (rows, columns + start[i])), shape=shape)
    return total


def image(weights: scipy.sparse.csr_array, field: Array, sensor: Pinhole) -> Array:
    """Averages of nodal radiance ``(…, channels, nodes)`` over pixels, ``(…, height, width, channels)``."""
    *rest, channels, nodes = field.shape
    flat = weights @ field.reshape(-1, nodes).T
    return np.moveaxis(flat.reshape(sensor.height, sensor.width, *rest, channels), (0, 1), (-3, -2))


def _surface_weights(view: View, parts: Polygons) -> tuple[Indices, Indices, Array]:
    """Entries of the matrix of one surface: pixels, nodes, weights."""
    meshes = view.patches.meshes
    for axis, mesh in enumerate(meshes):
        for value in mesh.breaks[1:-1]:
            parts = parts.split(view.line(axis, value))
    parts = parts.quadrilaterals()
    cells = [mesh.cell(a) for mesh, a in zip(meshes, view.coordinates(parts.centers), strict=True)]
    count = _points_needed(view, parts, cells)
    values = np.zeros((len(parts), view.patches.support))
    for n in np.unique(count):
        some = count == n
        points, weight = parts[some].rule(int(n))
        s, t = view.coordinates(points)
        in_s, in_t = (m.basis(a, c[some]) for m, a, c in zip(meshes, (s, t), cells, strict=True))
        values[some] = ((weight[..., None] * in_s).swapaxes(1, 2) @ in_t).reshape(-1, view.patches.support)
    indices = view.patches.indices(cells[0], cells[1])
    return np.repeat(parts.pixel, view.patches.support), indices.ravel(), values.ravel()


def _points_needed(view: View, parts: Polygons, cells: list[Indices]) -> Indices:
    """Gauss points per axis for each part, by its share of its patch and the patch's order."""
    needed = np.full(len(parts), 3)
    for mesh, cell, along in zip(view.patches.meshes, cells, view.coordinates(parts.vertices), strict=True):
        share = np.ptp(along, axis=1) / np.diff(mesh.breaks)[cell]
        needed = np.maximum(needed, np.where(share > SMALL, (mesh.orders[cell] + 3) // 2, 0))
    return needed
