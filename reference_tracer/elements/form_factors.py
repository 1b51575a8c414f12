"""Form factors: how much of the light that arrives at a point comes from a part of a surface.

    K(x, y) = cos θ_x cos θ_y / π r² · V(x, y)         F(x, A) = ∫_A K(x, y) dA_y

F is the irradiance at x divided by π times the radiance of A; it sums to 1 over everything that x sees. Here are
the kernel, Lambert's formula for a polygon, and the operator ∫ K(x, y) f(y) dA_y from one patched quad to another by
quadrature, for pairs without structure.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from reference_tracer.elements.bases import Mesh, Patches, uniform
from reference_tracer.points import Points
from reference_tracer.propagation import RayCaster

Array = NDArray[np.float64]

FAR_ORDER = 24
"""Nodes per axis that a pair of quads may need to count as far apart."""
NEAR = 1.5
"""A part of a source is cut in four while it is nearer than that many of its half diagonals."""
DEEPEST = 14
"""How often at most."""

SHADOW_DEEPEST = 2
"""How often at most for the edge of a shadow."""

BISECTIONS = 14
"""Steps that find the edge of a shadow on a line."""

INSIDE = 1e-6
"""Share of a part's length at which its ends are looked at."""

BATCH = 400_000
"""Kernel values held at once."""


def kernel(x: Array, nx: Array, y: Array, ny: Array) -> Array:
    """cos θ_x cos θ_y / π r², per area of y; 0 unless each is in front of the other.

    Args:
        x, nx: points and their unit normals, ``(3, …)``.
        y, ny: the same at the other end; all broadcast against each other.
    """
    d = y - x
    cosines = np.maximum(np.einsum("i...,i...->...", nx, d), 0) * np.maximum(
        -np.einsum("i...,i...->...", ny, d), 0
    )
    result: Array = cosines / (np.pi * np.einsum("i...,i...->...", d, d) ** 2)
    return result


def point_to_polygon(x: Array, nx: Array, corners: Array) -> Array:
    """The form factor of a polygon that lies wholly above the horizon of the points, exactly.

        F = 1/2π Σ_i γ_i n·(r_i × r_{i+1}) / |r_i × r_{i+1}|

    with r_i from the point to corner i, and γ_i the angle between r_i and r_{i+1} (Lambert 1760, Photometria; as
    in Baum, Rushmeier and Winget 1989, Improving radiosity solutions, SIGGRAPH 23(3)). The sign is that of
    a front: the corners run counterclockwise about the polygon's normal.

    Args:
        x, nx: points and their unit normals, ``(3, n)``.
        corners: ``(3, corners)``, counterclockwise seen from the front.

    Returns:
        ``(n,)``.
    """
    r = corners[:, None, :] - x[:, :, None]
    after = np.roll(r, -1, axis=2)
    cross = np.cross(r, after, axis=0)
    sine, cosine = np.linalg.norm(cross, axis=0), np.einsum("inc,inc->nc", r, after)
    angle = np.arctan2(sine, cosine)
    with np.errstate(invalid="ignore", divide="ignore"):  # an edge seen end on covers no angle
        along = np.where(sine > 0, np.einsum("in,inc->nc", nx, cross) / sine, 0.0)
    total: Array = -(angle * along).sum(axis=1) / (2 * np.pi)
    return total


class FarBlock:
    """The operator of a pair far apart against its size: its kernel is interpolated at few nodes on either side.

    On an axis of half length h at a distance d, the kernel is analytic in the ellipse of radius
    ρ = d/h + √(1 + d²/h²), so that n nodes leave an error of ρ⁻ⁿ (Trefethen 2013, Approximation theory, thm 8.2).
    """

    def __init__(self, receiver: Patches, source: Patches, orders: tuple[int, int]) -> None:
        coarse_r, self._up = _coarse(receiver, orders[0])
        coarse_s, _ = _coarse(source, orders[1])
        # ∫ ℓ_k φ_j, exactly: both are polynomials in each cell
        self._down = [_mixed_moments(mesh, orders[1]) for mesh in source.meshes]
        x, y = coarse_r.nodes, coarse_s.nodes
        nx, ny = receiver.normal[:, None, None], source.normal[:, None, None]
        self._kernel = source.area * kernel(x[:, :, None], nx, y[:, None, :], ny)
        self._shapes = coarse_s.shape, coarse_r.shape, source.shape

    def __call__(self, values: Array) -> Array:
        """Nodal values ``(fields, nodes of the source)`` → ``(fields, nodes of the receiver)``."""
        fields = len(values)
        f = values.reshape(fields, *self._shapes[2])
        f = self._down[0] @ f @ self._down[1].T
        g = (f.reshape(fields, -1) @ self._kernel.T).reshape(fields, *self._shapes[1])
        return (self._up[0] @ g @ self._up[1].T).reshape(fields, -1)


def _coarse(patches: Patches, order: int) -> tuple[Patches, tuple[Array, Array]]:
    """The same quad as one patch of that order, and the interpolation from it to the nodes in s and in t."""
    mesh = uniform(order, 1)
    coarse = Patches(patches.corner, patches.edges, patches.normal, (mesh, mesh))
    up_s, up_t = (mesh.basis(m.nodes, mesh.cell(m.nodes)) for m in patches.meshes)
    return coarse, (up_s, up_t)


def _mixed_moments(mesh: Mesh, order: int) -> Array:
    """∫ ℓ_k(s) φ_j(s) ds on [0, 1]: ℓ_k on the whole, φ_j on a mesh; ``(order, len(mesh))``."""
    whole, fine = uniform(order, 1), Mesh(mesh.breaks, np.maximum(order, mesh.orders))
    cell = mesh.cell(fine.nodes)
    spread = np.zeros((len(fine), len(mesh)))
    np.add.at(spread, (np.arange(len(fine))[:, None], mesh.indices(cell)), mesh.basis(fine.nodes, cell))
    everywhere = whole.basis(fine.nodes, whole.cell(fine.nodes))
    moments: Array = (everywhere * fine.weights[:, None]).T @ spread
    return moments


def far_orders(receiver: Patches, source: Patches, accuracy: float) -> tuple[int, int] | None:
    """Nodes per axis that a FarBlock needs on the receiver and on the source; None if they are too near."""
    distance = separation(receiver, source)
    orders = []
    for patches in (receiver, source):
        ratio = 2 * distance / np.linalg.norm(patches.edges, axis=1).max()
        rho = ratio + np.hypot(1, ratio)
        if rho**-FAR_ORDER > accuracy:
            return None
        orders.append(int(np.ceil(np.log(1 / accuracy) / np.log(rho))))
    return orders[0], orders[1]


def separation(a: Patches, b: Patches) -> float:
    """A lower bound of the distance between two quads: the widest gap along any of their edges and normals."""
    directions = np.vstack([a.edges, b.edges, a.normal, b.normal])
    directions = directions / np.linalg.norm(directions, axis=1)[:, None]
    along_a, along_b = directions @ a.corners, directions @ b.corners
    gaps = np.maximum(along_b.min(axis=1) - along_a.max(axis=1), along_a.min(axis=1) - along_b.max(axis=1))
    return float(max(gaps.max(), 0.0))


class DenseBlock:
    """The operator of any pair, as a matrix ``(nodes of the receiver, nodes of the source)``."""

    def __init__(self, matrix: Array) -> None:
        self.matrix = matrix

    def __call__(self, values: Array) -> Array:
        """Nodal values ``(fields, nodes of the source)`` → ``(fields, nodes of the receiver)``."""
        result: Array = values @ self.matrix.T
        return result


def of_patches(receiver: Patches, source: Patches) -> Array:
    """The matrix for a source with one value per patch, all of it above the receiver's horizon: exact."""
    breaks_s, breaks_t = (mesh.breaks for mesh in source.meshes)
    n = np.tile(receiver.normal[:, None], len(receiver))
    columns = []
    for s in pairwise(breaks_s):
        for t in pairwise(breaks_t):
            corners = source.points(np.array(s)[[0, 1, 1, 0]], np.array(t)[[0, 0, 1, 1]])
            columns.append(point_to_polygon(receiver.nodes, n, corners))
    return np.stack(columns, axis=1)


class AdaptiveQuadrature:
    """The matrix for any pair: parts of the source are cut in four while they are near to a node.

    With ``visible`` = (ray caster, receiver's index, source's index), every kernel value is multiplied by the
    visibility of its two ends, and parts that the edge of a shadow crosses are cut as well, SHADOW_DEEPEST times at
    most; then the edge is found on each line of nodes, and its seen side integrated.

    Attributes:
        matrix: ``(nodes of the receiver, nodes of the source)``.
    """

    def __init__(
        self, receiver: Patches, source: Patches, visible: tuple[RayCaster, int, int] | None = None
    ) -> None:
        self._receiver, self._source, self._visible = receiver, source, visible
        self._count = max(mesh.most for mesh in source.meshes) + 2  # nodes of a quadrature, per axis
        self.matrix = np.zeros((len(receiver), len(source)))
        breaks_s, breaks_t = (mesh.breaks for mesh in source.meshes)
        cells = (np.arange(n) for n in (len(receiver), len(breaks_s) - 1, len(breaks_t) - 1))
        i, s, t = (a.ravel() for a in np.meshgrid(*cells, indexing="ij"))
        low, size = (
            np.stack([breaks_s[s], breaks_t[t]]),
            np.stack([np.diff(breaks_s)[s], np.diff(breaks_t)[t]]),
        )
        self._integrate(i, low, size)

    def _integrate(self, i: NDArray[np.intp], low: Array, size: Array) -> None:
        """Add the integrals over the parts low … low + size of the source, seen from node i of the receiver."""
        x, source = self._receiver.nodes, self._source
        count = max(1, BATCH // self._count**2)
        for depth in range(DEEPEST + 1):
            center = source.points(*(low + size / 2))
            reach = np.linalg.norm(np.linalg.norm(source.edges, axis=1)[:, None] * size / 2, axis=0)
            cut = (np.linalg.norm(center - x[:, i], axis=0) < NEAR * reach) & (depth < DEEPEST)
            far = np.flatnonzero(~cut)
            for part in np.split(far, range(count, len(far), count)):
                cut[part] = self._add(i[part], low[:, part], size[:, part], whole=depth < SHADOW_DEEPEST)
            if not cut.any():
                return
            i, low, size = np.tile(i[cut], 4), low[:, cut], size[:, cut] / 2
            quarters = np.array([[0, 1, 0, 1], [0, 0, 1, 1]])
            low = (low[:, None, :] + quarters[:, :, None] * size[:, None, :]).reshape(2, -1)
            size = np.tile(size, 4)

    def _add(self, i: NDArray[np.intp], low: Array, size: Array, whole: bool) -> NDArray[np.bool_]:
        """Add what a rule of ``_count``² nodes gives; with ``whole``, leave out and return the parts half hidden."""
        rule = uniform(self._count, 1)
        u, v = (a.ravel() for a in np.meshgrid(rule.nodes, rule.nodes, indexing="ij"))
        s, t = low[:, :, None] + size[:, :, None] * np.stack([u, v])[:, None, :]
        weight = np.outer(size.prod(axis=0), np.outer(rule.weights, rule.weights))
        if self._visible is None:
            self._accumulate(i, s, t, weight)
            return np.zeros(len(i), dtype=bool)
        # where the edge of a shadow cuts off no more than a strip, only the corners tell
        corners = np.array(
            [[INSIDE, 1 - INSIDE, INSIDE, 1 - INSIDE], [INSIDE, INSIDE, 1 - INSIDE, 1 - INSIDE]]
        )
        s_corners, t_corners = low[:, :, None] + size[:, :, None] * corners[:, None, :]
        seen, facing = self._sees(i, s, t)
        seen_corners, facing_corners = self._sees(i, s_corners, t_corners)
        some = np.any(seen, axis=1) | np.any(seen_corners, axis=1)
        half: NDArray[np.bool_] = some & np.any(facing & ~seen, axis=1)
        half |= some & np.any(facing_corners & ~seen_corners, axis=1)
        self._accumulate(i, s, t, weight * seen * ~half[:, None])
        if not whole and half.any():
            self._add_half_hidden(i[half], low[:, half], size[:, half])
        return half & whole

    def _add_half_hidden(self, i: NDArray[np.intp], low: Array, size: Array) -> None:
        """Add parts that the edge of a shadow crosses: by lines, each from one side of the part to the edge.

        The lines run along the axis on which more of them meet the edge, which bisection finds on each.
        """
        rule = uniform(self._count, 1)
        across = np.broadcast_to(rule.nodes, (len(i), self._count))
        ends = [
            [
                self._seen_on_lines(axis, i, low, size, np.full(across.shape, end))
                for end in (INSIDE, 1 - INSIDE)
            ]
            for axis in (0, 1)
        ]
        crossed = np.stack([(first != last).sum(axis=1) for first, last in ends])
        for axis, mine in ((0, crossed[0] >= crossed[1]), (1, crossed[0] < crossed[1])):
            if not mine.any():
                continue
            first, last = (seen[mine] for seen in ends[axis])
            part = i[mine], low[:, mine], size[:, mine]
            near, far = np.zeros(first.shape), np.ones(first.shape)
            for _ in range(BISECTIONS):
                middle = (near + far) / 2
                alike = self._seen_on_lines(axis, *part, middle) == first
                near, far = np.where(alike, middle, near), np.where(alike, far, middle)
            edge = (near + far) / 2
            start = np.where(last & ~first, edge, 0.0)
            length = np.where(last, 1.0, np.where(first, edge, 0.0)) - start
            along = start[:, :, None] + length[:, :, None] * rule.nodes
            beside = np.broadcast_to(across[mine][:, :, None], along.shape)
            local = np.stack([along, beside] if axis == 0 else [beside, along])
            local = local.reshape(2, len(first), self._count**2)
            weight = length[:, :, None] * rule.weights[:, None] * rule.weights
            s, t = part[1][:, :, None] + part[2][:, :, None] * local
            self._accumulate(
                part[0], s, t, weight.reshape(len(first), self._count**2) * part[2].prod(axis=0)[:, None]
            )

    def _seen_on_lines(
        self, axis: int, i: NDArray[np.intp], low: Array, size: Array, along: Array
    ) -> NDArray[np.bool_]:
        """Whether points of parts are seen: one on each of ``_count`` lines along an axis, ``(parts, lines)``."""
        across = np.broadcast_to(uniform(self._count, 1).nodes, along.shape)
        local = np.stack([along, across] if axis == 0 else [across, along])
        return self._sees(i, *(low[:, :, None] + size[:, :, None] * local))[0]

    def _accumulate(self, i: NDArray[np.intp], s: Array, t: Array, weight: Array) -> None:
        """Add Σ_q w_q K(x_i, y_q) φ_j(y_q), with y_q at s, t ``(parts, nodes)`` and w_q a share of the area."""
        source, shape = self._source, s.shape
        weight = weight * source.area * self._kernel(i, s, t)
        indices, basis = source.basis(s.ravel(), t.ravel())
        moments = np.einsum("nq,nqk->nk", weight, basis.reshape(*shape, source.support))
        indices = indices.reshape(*shape, source.support)[:, 0]
        np.add.at(self.matrix, (i[:, None], indices), moments)

    def _kernel(self, i: NDArray[np.intp], s: Array, t: Array) -> Array:
        """Without visibility, ``(parts, nodes)``."""
        y = self._source.points(s.ravel(), t.ravel()).reshape(3, *s.shape)
        x, nx = self._receiver.nodes[:, i, None], self._receiver.normal[:, None, None]
        return kernel(x, nx, y, self._source.normal[:, None, None])

    def _sees(self, i: NDArray[np.intp], s: Array, t: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Whether node i sees the source's points at s, t ``(parts, nodes)``, and whether the two face each other."""
        assert self._visible is not None
        cast, here, there = self._visible
        facing = self._kernel(i, s, t) > 0
        part, _ = np.nonzero(facing)
        x, y = self._receiver.nodes[:, i[part]], self._source.points(s[facing], t[facing])
        d = (y - x) / np.linalg.norm(y - x, axis=0)
        n = np.tile(self._receiver.normal[:, None], x.shape[1])
        hit = cast(Points(x, n, np.full(x.shape[1], here)), d)
        seen = np.zeros(facing.shape, dtype=bool)
        seen[facing] = hit.surface == there
        return seen, facing
