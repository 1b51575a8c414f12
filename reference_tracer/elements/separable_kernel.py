"""The form factor kernel between rectangles with one common frame, as a sum of products of one-dimensional factors.

    K(x, y) = (n_x·(y − x)) (n_y·(x − y)) / π r⁴,      1/r⁴ = ∫ τ e^{−τ r²} dτ = ∫ e^{2a} e^{−r² exp a} da

r² = Σ (y_d − x_d)² over the three axes d, so e^{−τ r²} is a product of three factors, and each cosine depends on
one axis. The trapezoidal rule in a with step δ is in error by no more than 2 |Γ(2 + 2πi/δ)|, relative, at any r:
6·10⁻¹¹ for δ = 1/3 (Beylkin and Monzón 2010, Approximation by exponential sums revisited; Trefethen and Weideman
2014, The exponentially convergent trapezoidal rule). What is left are integrals of one variable, Gaussian times
polynomial, without any singularity other than the width of the Gaussian: shared edges need no special treatment.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference_tracer.elements.bases import Mesh, Patches, gauss, lagrange

Array = NDArray[np.float64]

STEP = 1 / 3

CUT = 6.0
"""Widths of a Gaussian beyond which it is nothing: below 3e-16."""

FAINTEST = -14.0
"""ln τ r² below which no τ is needed: those add up to e^{−28} of 1/r⁴."""

RULES = ((0.0, 0.05, 8), (0.05, 1.0, 12), (1.0, 4.0, 20), (4.0, np.inf, 36))
"""More than so many widths of the Gaussian, up to so many, so many nodes."""


def exponents(nearest: float, farthest: float) -> Array:
    """The grid of a = ln τ, multiples of STEP, that gives 1/r⁴ for nearest ≤ r ≤ farthest."""
    low = FAINTEST - 2 * np.log(farthest)
    high = np.log(CUT**2) - 2 * np.log(nearest)
    return STEP * np.arange(np.floor(low / STEP), np.ceil(high / STEP) + 1)


def gauss_transform(x: Array, mesh: Mesh, exponent: Array, power: int) -> Array:
    """∫ |y − x|^power e^{−τ(y − x)²} φ_j(y) dy, for the Lagrange polynomials φ_j of a mesh.

    Each integral is taken over the part of the cell within CUT widths of x, by a Gauss rule.

    Args:
        x: points, ``(n,)``.
        mesh: where the φ_j are.
        exponent: ln τ, ``(m,)``.
        power: 0 or 1.

    Returns:
        ``(m, n, len(mesh))``.
    """
    reach = CUT * np.exp(-exponent / 2)[:, None, None]
    low = np.maximum(mesh.breaks[:-1], x[:, None] - reach)
    high = np.minimum(mesh.breaks[1:], x[:, None] + reach)
    width = np.maximum(high - low, 0) * CUT / reach
    table = np.zeros((len(exponent), len(x), len(mesh)))
    for least, most, count in RULES:
        found = np.nonzero((width > least) & (width <= most))
        for order in np.unique(mesh.orders):
            m, i, c = (indices[mesh.orders[found[2]] == order, None] for indices in found)
            u, w = gauss(count)
            half = (high - low)[m, i, c] / 2
            y = (high + low)[m, i, c] / 2 + half * u
            distance = np.abs(y - x[i])
            f = half * w * np.exp(-np.exp(exponent)[m] * distance**2) * distance**power
            v = 2 * (y - mesh.breaks[c]) / np.diff(mesh.breaks)[c] - 1
            moments = legendre_moments(f, v, int(order))
            table[m, i, mesh.indices(c[:, 0])[:, :order]] = moments @ lagrange(int(order)).T
    return table


def legendre_moments(f: Array, u: Array, order: int) -> Array:
    """Σ_q f_q P_k(u_q) for k < order: ``(n, q)`` twice → ``(n, order)``."""
    moments = np.empty((len(f), order))
    before, P = np.zeros_like(u), np.ones_like(u)
    for k in range(order):
        moments[:, k] = np.einsum("nq,nq->n", f, P)
        before, P = P, ((2 * k + 1) / (k + 1)) * u * P - (k / (k + 1)) * before
    return moments


@dataclass(frozen=True)
class Aligned:
    """Patches of a rectangle in a frame whose axes are parallel to its edges and its normal.

    Attributes:
        level: coordinate along the normal's axis.
        axes: of s, of t and of the normal: a permutation of 0, 1, 2.
        meshes: of s and of t in coordinates of the frame, always ascending.
        flips: axes of a field's nodal values ``(…, s, t)`` that run against the frame.
    """

    level: float
    axes: tuple[int, int, int]
    meshes: tuple[Mesh, Mesh]
    flips: tuple[int, ...]

    @classmethod
    def of(cls, patches: Patches, frame: Array, unit: float) -> Aligned | None:
        """The same in a frame with orthonormal columns and a unit of length; None if they are not parallel."""
        corner, edges = patches.corner @ frame / unit, patches.edges @ frame / unit
        axes = np.abs(edges).argmax(axis=1)
        lengths = edges[[0, 1], axes]
        if axes[0] == axes[1] or np.abs(edges).sum() > np.abs(lengths).sum() * (1 + 1e-12):
            return None
        meshes = []
        for axis, length, mesh in zip(axes, lengths, patches.meshes, strict=True):
            placed = mesh.placed(corner[axis], length)
            # the same edge, computed from two quads, becomes the same number: distances to it are exact
            meshes.append(Mesh(np.round(placed.breaks, 14) + 0.0, placed.orders))
        normal = 3 - int(axes.sum())
        flips = tuple(int(i) - 2 for i in np.flatnonzero(lengths < 0))
        level = float(np.round(corner[normal], 14))
        return cls(level, (int(axes[0]), int(axes[1]), normal), (meshes[0], meshes[1]), flips)

    @property
    def margin(self) -> float:
        """The smallest distance of a node from an edge."""
        ends = [(m.nodes[0] - m.breaks[0], m.breaks[-1] - m.nodes[-1]) for m in self.meshes]
        return float(np.min(ends))

    def mesh(self, axis: int) -> Mesh:
        """The mesh along an axis that is not the normal's."""
        return self.meshes[self.axes.index(axis)]

    def ascending(self, values: Array, first: int) -> Array:
        """Nodal values ``(fields, nodes)`` ascending in the frame, ``(fields, axis first, the other axis)``."""
        flipped = np.flip(values.reshape(-1, len(self.meshes[0]), len(self.meshes[1])), self.flips)
        return flipped if self.axes[0] == first else flipped.swapaxes(1, 2)

    def nodal(self, ascending: Array, first: int) -> Array:
        """The inverse of ``ascending``."""
        ordered = ascending if self.axes[0] == first else ascending.swapaxes(1, 2)
        return np.flip(ordered, self.flips).reshape(len(ascending), -1)


class Transforms:
    """Gauss transforms between meshes, each computed once: in a box many surfaces share theirs."""

    def __init__(self, exponent: Array) -> None:
        self._exponent = exponent
        self._known: dict[tuple[bytes, bytes, bytes, int], Array] = {}

    def exponents(self, nearest: float) -> Array:
        """The first of the τ, as many as give 1/r⁴ from r = nearest on."""
        return np.asarray(
            np.exp(self._exponent[self._exponent <= np.log(CUT**2) - 2 * np.log(nearest) + STEP])
        )

    def __call__(self, x: Array, mesh: Mesh, power: int) -> Array:
        """``gauss_transform`` over the whole grid of exponents."""
        key = (x.tobytes(), mesh.breaks.tobytes(), mesh.orders.tobytes(), power)
        if key not in self._known:
            self._known[key] = gauss_transform(x, mesh, self._exponent, power)
        return self._known[key]


def _gap(receiver: Aligned, source: Aligned, axis: int) -> float:
    """The distance between two meshes along an axis."""
    a, b = receiver.mesh(axis).breaks, source.mesh(axis).breaks
    return float(max(b[0] - a[-1], a[0] - b[-1], 0.0))


class PerpendicularBlock:
    """The operator ∫ K(x, y) f(y) dA_y between rectangles at a right angle, each wholly in front of the other.

    With o the axis of both, p that of the receiver's position across it and q the source's:

        (Kf)(x) = Σ_m w_m g(x_p − y_p) ∫ e^{−τ(x_o − y_o)²} ∫ g(y_q − x_q) f(y) dy_q dy_o,   g(z) = |z| e^{−τz²}

    where y_p and x_q are constants: the planes that the two lie in.
    """

    def __init__(self, receiver: Aligned, source: Aligned, transforms: Transforms) -> None:
        self._receiver, self._source = receiver, source
        p, q = source.axes[2], receiver.axes[2]
        self._o = o = 3 - p - q
        x = np.abs(receiver.mesh(p).nodes - source.level)
        tau = transforms.exponents(float(np.hypot(x.min(), _gap(receiver, source, o))))
        self._across = x[:, None] * np.exp(-np.outer(x**2, tau)) * (STEP / np.pi * tau**2)
        self._in = transforms(np.array([receiver.level]), source.mesh(q), 1)[: len(tau), 0].T
        self._along = transforms(receiver.mesh(o).nodes, source.mesh(o), 0)[: len(tau)]

    def __call__(self, values: Array) -> Array:
        """Nodal values ``(fields, nodes of the source)`` → ``(fields, nodes of the receiver)``."""
        f = self._source.ascending(values, self._o) @ self._in  # (fields, o, m)
        g = self._along @ np.ascontiguousarray(f.transpose(2, 1, 0))  # (m, o, fields)
        return self._receiver.nodal(np.tensordot(g, self._across, axes=(0, 1)).transpose(1, 0, 2), self._o)


class ParallelBlock:
    """The same between rectangles in parallel planes that face each other at the distance h:

    (Kf)(x) = h² Σ_m w_m e^{−τh²} ∫ e^{−τ(x_o − y_o)²} ∫ e^{−τ(x_p − y_p)²} f(y) dy_p dy_o
    """

    def __init__(self, receiver: Aligned, source: Aligned, transforms: Transforms) -> None:
        self._receiver, self._source = receiver, source
        self._o, p = sorted(receiver.axes[:2])
        h = abs(receiver.level - source.level)
        tau = transforms.exponents(h)
        self._weights = h**2 * np.exp(-tau * h**2) * (STEP / np.pi * tau**2)
        self._factors = [
            transforms(receiver.mesh(axis).nodes, source.mesh(axis), 0)[: len(tau)] for axis in (self._o, p)
        ]

    def __call__(self, values: Array) -> Array:
        """Nodal values ``(fields, nodes of the source)`` → ``(fields, nodes of the receiver)``."""
        f = self._source.ascending(values, self._o)
        terms = zip(self._weights, *self._factors, strict=True)
        return self._receiver.nodal(
            sum(w * (along_o @ f @ along_p.T) for w, along_o, along_p in terms), self._o
        )
