"""The finite-dimensional spaces that radiance is projected on: tensor Legendre polynomials on patches of quads.

On every patch of a surface the space holds the products of Legendre polynomials P_k(s) P_l(t) with k, l < order.
A function is kept by its values at the tensor Gauss–Legendre nodes, which determine it: order 1 is radiosity, one
value per patch. The projection is interpolation there; it is the L² projection with its integrals taken by Gauss
quadrature, and has the order of it.

A field that leaves a diffuse surface behaves like z log z at a distance z from an edge shared with another surface,
and like a function of the polar angle alone about a corner where such an edge ends. So patches shrink
geometrically towards edges (Atkinson 1997, The numerical solution of integral equations of the second kind, ch. 9).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from scenes import Quad

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

RATIO = 0.15
"""By how much patches shrink towards an edge; hp methods gain most near (√2 − 1)² (Gui and Babuška 1986)."""


@dataclass(frozen=True)
class Mesh:
    """An interval cut into cells, with ``order`` Gauss nodes in each.

    Attributes:
        breaks: ends of the cells, ascending, ``(cells + 1,)``.
        order: nodes per cell, ≥ 1.
    """

    breaks: Array
    order: int

    def __len__(self) -> int:
        return (len(self.breaks) - 1) * self.order

    @cached_property
    def _reference(self) -> tuple[Array, Array]:
        return legendre.leggauss(self.order)

    @cached_property
    def nodes(self) -> Array:
        """Gauss nodes of all cells, ascending, ``(n,)``."""
        middle, half = (self.breaks[1:] + self.breaks[:-1]) / 2, np.diff(self.breaks) / 2
        return np.asarray(middle[:, None] + half[:, None] * self._reference[0]).ravel()

    @cached_property
    def weights(self) -> Array:
        """Quadrature weights at the nodes, ``(n,)``: exact up to degree 2 order − 1 in each cell."""
        return np.outer(np.diff(self.breaks) / 2, self._reference[1]).ravel()

    @cached_property
    def from_legendre(self) -> Array:
        """Takes values (or moments) of P_0 … P_{order−1} to those of the Lagrange polynomials, ``(order, order)``.

        The Lagrange polynomial of node i is Σ_k (2k + 1)/2 · w_i P_k(u_i) P_k, since Gauss quadrature is exact.
        """
        u, w = self._reference
        matrix: Array = legendre.legvander(u, self.order - 1) * (np.arange(self.order) + 0.5) * w[:, None]
        return matrix

    def cell(self, x: Array) -> Indices:
        """The cell that each x lies in, of the shape of x; the nearest one for an x outside."""
        found: Indices = np.clip(np.searchsorted(self.breaks, x, side="right") - 1, 0, len(self.breaks) - 2)
        return found

    def basis(self, x: Array, cell: Indices) -> Array:
        """The Lagrange polynomials of given cells at x, ``(…, order)``."""
        u = 2 * (x - self.breaks[cell]) / (self.breaks[cell + 1] - self.breaks[cell]) - 1
        return np.asarray(legendre.legvander(u, self.order - 1) @ self.from_legendre.T)

    def placed(self, start: float, length: float) -> Mesh:
        """The same mesh on [start, start + length], when this one is on [0, 1]."""
        return Mesh(start + length * self.breaks, self.order)


def graded(order: int, levels: int, low: bool, high: bool, lines: tuple[float, ...] = ()) -> Mesh:
    """A mesh of [0, 1] whose cells shrink by RATIO ``levels`` times towards the ends asked for.

    Args:
        order: nodes per cell.
        levels: how often the cell at a graded end is cut.
        low, high: whether 0 and 1 are graded.
        lines: further breaks in (0, 1), such as the edge of a shadow.
    """
    steps = RATIO ** np.arange(1, levels + 1)
    breaks = [0.0, 0.5, 1.0, *lines]
    breaks += [*(steps / 2)] if low else []
    breaks += [*(1 - steps / 2)] if high else []
    return Mesh(np.unique(np.clip(breaks, 0, 1)), order)


def uniform(order: int, cells: int, lines: tuple[float, ...] = ()) -> Mesh:
    """A mesh of [0, 1] with cells of one size, and further breaks."""
    return Mesh(np.unique([*np.linspace(0, 1, cells + 1), *lines]), order)


@dataclass(frozen=True)
class Patches:
    """A quad cut into patches: the points corner + s·edges[0] + t·edges[1], with a mesh for s and one for t.

    Attributes:
        corner: world coordinates, ``(3,)``.
        edges: the two of them, ``(2, 3)``.
        normal: of the front, ``(3,)``.
        meshes: of s and of t, each on [0, 1].
    """

    corner: Array
    edges: Array
    normal: Array
    meshes: tuple[Mesh, Mesh]

    @classmethod
    def of(cls, quad: Quad, meshes: tuple[Mesh, Mesh]) -> Patches:
        """The patches of a quad."""
        return cls(np.array(quad.corner), np.array([quad.edge_u, quad.edge_v]), quad.normal, meshes)

    def __len__(self) -> int:
        return len(self.meshes[0]) * len(self.meshes[1])

    @property
    def shape(self) -> tuple[int, int]:
        """Of a field's nodal values: nodes in s, nodes in t."""
        return len(self.meshes[0]), len(self.meshes[1])

    @cached_property
    def area(self) -> float:
        """Of the quad."""
        return float(np.linalg.norm(np.cross(*self.edges)))

    @cached_property
    def corners(self) -> Array:
        """The four corners in their order about the normal, ``(3, 4)``."""
        s, t = np.array([0, 1, 1, 0]), np.array([0, 0, 1, 1])
        return self.points(s, t)

    def points(self, s: Array, t: Array) -> Array:
        """World coordinates, ``(3, n)``."""
        return self.corner[:, None] + np.outer(self.edges[0], s) + np.outer(self.edges[1], t)

    @cached_property
    def nodes(self) -> Array:
        """World coordinates of all nodes, t running fastest, ``(3, n)``."""
        s, t = np.meshgrid(self.meshes[0].nodes, self.meshes[1].nodes, indexing="ij")
        return self.points(s.ravel(), t.ravel())

    @cached_property
    def weights(self) -> Array:
        """Area weights at the nodes, ``(n,)``."""
        return self.area * np.outer(self.meshes[0].weights, self.meshes[1].weights).ravel()

    def basis(self, s: Array, t: Array) -> tuple[Indices, Array]:
        """The nodes whose basis functions are not zero at points, and these functions' values there.

        Args:
            s, t: ``(n,)``.

        Returns:
            Two arrays ``(n, order²)``.
        """
        cells = self.meshes[0].cell(s), self.meshes[1].cell(t)
        in_s, in_t = self.meshes[0].basis(s, cells[0]), self.meshes[1].basis(t, cells[1])
        return self.indices(*cells), (in_s[:, :, None] * in_t[:, None, :]).reshape(len(s), -1)

    def indices(self, cell_s: Indices, cell_t: Indices) -> Indices:
        """The nodes of patches, ``(n, order²)``."""
        rows = cell_s[:, None] * self.meshes[0].order + np.arange(self.meshes[0].order)
        columns = cell_t[:, None] * self.meshes[1].order + np.arange(self.meshes[1].order)
        count = rows.shape[1] * columns.shape[1]
        return (rows[:, :, None] * len(self.meshes[1]) + columns[:, None, :]).reshape(len(rows), count)

    def coordinates(self, x: Array) -> tuple[Array, Array]:
        """s and t of points in the quad's plane, ``(3, n)``."""
        s, t = np.linalg.pinv(self.edges.T) @ (x - self.corner[:, None])
        return s, t
