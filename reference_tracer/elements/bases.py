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

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from scenes import Quad

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

RATIO = 0.2
"""By how much patches shrink towards an edge, from one to the next."""

INNER = 3
"""Equal cells of an axis before grading."""


@cache
def gauss(count: int) -> tuple[Array, Array]:
    """Nodes and weights of Gauss and Legendre's rule on [−1, 1], ``(count,)`` each."""
    return legendre.leggauss(count)


@cache
def lagrange(count: int) -> Array:
    """Coefficients of the Lagrange polynomials of the Gauss nodes in Legendre polynomials, ``(count, count)``.

    That of node i is Σ_k (2k + 1)/2 · w_i P_k(u_i) P_k, since Gauss quadrature is exact.
    """
    u, w = gauss(count)
    return np.asarray(legendre.legvander(u, count - 1) * (np.arange(count) + 0.5) * w[:, None])


@dataclass(frozen=True)
class Mesh:
    """An interval cut into cells with Gauss nodes in each.

    Attributes:
        breaks: ends of the cells, ascending, ``(cells + 1,)``.
        orders: nodes of each cell, ≥ 1, ``(cells,)``.
    """

    breaks: Array
    orders: Indices

    def __len__(self) -> int:
        return int(self.orders.sum())

    @cached_property
    def most(self) -> int:
        """The largest order."""
        return int(self.orders.max())

    @cached_property
    def _starts(self) -> Indices:
        return np.cumsum(self.orders) - self.orders

    @cached_property
    def nodes(self) -> Array:
        """Gauss nodes of all cells, ascending, ``(n,)``."""
        ends = zip(self.breaks[:-1], self.breaks[1:], self.orders, strict=True)
        return np.concatenate([(a + b) / 2 + (b - a) / 2 * gauss(int(n))[0] for a, b, n in ends])

    @cached_property
    def weights(self) -> Array:
        """Quadrature weights at the nodes, ``(n,)``: exact up to degree 2 order − 1 in each cell."""
        sizes = zip(np.diff(self.breaks), self.orders, strict=True)
        return np.concatenate([size / 2 * gauss(int(n))[1] for size, n in sizes])

    @cached_property
    def _lagrange(self) -> Array:
        """``lagrange`` of each cell, zeros beyond its order, ``(cells, most, most)``."""
        matrices = np.zeros((len(self.orders), self.most, self.most))
        for matrix, n in zip(matrices, self.orders, strict=True):
            matrix[:n, :n] = lagrange(int(n))
        return matrices

    def cell(self, x: Array) -> Indices:
        """The cell that each x lies in, of the shape of x; the nearest one for an x outside."""
        found: Indices = np.clip(np.searchsorted(self.breaks, x, side="right") - 1, 0, len(self.orders) - 1)
        return found

    def basis(self, x: Array, cell: Indices) -> Array:
        """The Lagrange polynomials of given cells at x, ``(…, most)``; 0 beyond a cell's order.

        Args:
            x: points, ``(n, …)``.
            cell: the cell of each row of x, ``(n,)``.
        """
        along = (slice(None), *(None,) * (x.ndim - 1))
        u = 2 * (x - self.breaks[cell][along]) / (self.breaks[cell + 1] - self.breaks[cell])[along] - 1
        P = legendre.legvander(u, self.most - 1).reshape(len(x), -1, self.most)
        return np.asarray(P @ self._lagrange[cell].swapaxes(1, 2)).reshape(*x.shape, self.most)

    def indices(self, cell: Indices) -> Indices:
        """The nodes of given cells, ``(n, most)``; the last one stands for those beyond a cell's order."""
        within = np.minimum(np.arange(self.most), self.orders[cell, None] - 1)
        return np.asarray(self._starts[cell, None] + within)

    def placed(self, start: float, length: float) -> Mesh:
        """The same mesh from ``start`` over a length that may be negative, when this one is on [0, 1]."""
        breaks = start + length * self.breaks
        return Mesh(breaks, self.orders) if length > 0 else Mesh(breaks[::-1], self.orders[::-1])


def graded(order: int, levels: int, low: bool, high: bool, lines: Sequence[float] = ()) -> Mesh:
    """A mesh of [0, 1] whose cells shrink by RATIO towards the ends asked for, and their orders fall.

    A small cell has little weight, so a polynomial of a lower degree is as good there (Gui and Babuška 1986, The
    h, p and h-p versions of the finite element method in 1 dimension, II).

    Args:
        order: nodes per cell away from the ends.
        levels: how often the cell at a graded end is cut.
        low, high: whether 0 and 1 are graded.
        lines: further breaks in (0, 1), such as the edge of a shadow.
    """
    steps = RATIO ** np.arange(1, levels + 1) / INNER
    breaks = [*np.linspace(0, 1, INNER + 1), *lines, *(steps if low else ()), *(1 - steps if high else ())]
    mesh = uniform(order, 1, sorted(breaks))
    middle = (mesh.breaks[1:] + mesh.breaks[:-1]) / 2
    towards_end = np.minimum(np.where(low, middle, 1.0), np.where(high, 1 - middle, 1.0))
    shrunk = (towards_end < steps[:, None]).sum(axis=0)
    return Mesh(mesh.breaks, np.maximum(order - shrunk, min(order, 2)))


def uniform(order: int, cells: int, lines: Sequence[float] = ()) -> Mesh:
    """A mesh of [0, 1] with cells of one size and one order, and further breaks."""
    breaks = np.unique([*np.linspace(0, 1, cells + 1), *lines])
    return Mesh(breaks, np.full(len(breaks) - 1, order))


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
            Two arrays ``(n, support)``.
        """
        cells = self.meshes[0].cell(s), self.meshes[1].cell(t)
        in_s, in_t = self.meshes[0].basis(s, cells[0]), self.meshes[1].basis(t, cells[1])
        return self.indices(*cells), (in_s[:, :, None] * in_t[:, None, :]).reshape(len(s), self.support)

    @property
    def support(self) -> int:
        """How many basis functions a patch has at most."""
        return self.meshes[0].most * self.meshes[1].most

    def indices(self, cell_s: Indices, cell_t: Indices) -> Indices:
        """The nodes of patches, ``(n, support)``."""
        rows, columns = self.meshes[0].indices(cell_s), self.meshes[1].indices(cell_t)
        all_nodes: Indices = rows[:, :, None] * len(self.meshes[1]) + columns[:, None, :]
        return all_nodes.reshape(len(rows), self.support)

    def coordinates(self, x: Array) -> tuple[Array, Array]:
        """s and t of points in the quad's plane, ``(3, n)``."""
        s, t = np.linalg.pinv(self.edges.T) @ (x - self.corner[:, None])
        return s, t
