"""T as a matrix: light transport of diffuse scenes of quads, without noise.

In a basis with nodes x_i and functions φ_j the rendering equation is a linear system,

    L = E + TL,     T_ij = ρ_i ∫ K(x_i, y) φ_j(y) dA_y,     TᵏE = (ρF)ᵏ E,     (I − T)⁻¹E by a linear solve.

K is geometry alone, so that one operator F serves all channels. Bases (see ``bases``):

    legendre   tensor Legendre polynomials on patches graded towards edges
    constant   one value on each of equal patches: radiosity (Goral et al. 1984)
    haar       the same space in its wavelets, small entries of T dropped (Gortler et al. 1993)

F is made of one block per pair of surfaces: exact one-dimensional factors for rectangles with a common frame
(``separable_kernel``), interpolation for pairs far apart, adaptive quadrature with ray-cast visibility for the rest
(``form_factors``). Zatz 1993, Galerkin radiosity, SIGGRAPH; Atkinson and Chandler 1998, The collocation method for
solving the radiosity equation for unoccluded surfaces, J. Integral Equ. Appl. 10(3).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import combinations, pairwise
from typing import Literal

import numpy as np
import scipy.sparse
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, gmres

from reference_tracer.elements import haar, pixel_averages
from reference_tracer.elements.bases import Patches
from reference_tracer.elements.form_factors import AdaptiveQuadrature, DenseBlock, FarBlock, far_orders, of_patches
from reference_tracer.elements.meshing import Sight, Splits, check, diameter, meshed
from reference_tracer.propagation import RayCaster
from reference_tracer.elements.separable_kernel import (
    Aligned,
    ParallelBlock,
    PerpendicularBlock,
    Transforms,
    exponents,
)
from scenes import Scene

Array = NDArray[np.float64]
Basis = Literal["legendre", "constant", "haar"]
Block = Callable[[Array], Array]

DEFAULTS: dict[Basis, tuple[int, int]] = {"legendre": (10, 6), "constant": (1, 4), "haar": (1, 4)}
"""Order and levels of each basis."""

WITHOUT_STRUCTURE = (3, 1)
"""Order and levels of legendre, where some pair of surfaces needs adaptive quadrature."""

FAR_ACCURACY = 1e-9
"""Of an interpolated kernel."""

MOST_GROWTH = 1e7
"""Of light by reflection, before rounding decides: with albedo ρ all over a closed scene it is 1/(1 − ρ)."""

MOST = 2e8
"""Entries that matrices may have: 1.6 GB."""


class SingularTransportError(ArithmeticError):
    """I − T has no inverse: light that never leaves and is never absorbed."""


class FormFactors:
    """F: nodal radiance → irradiance / π at the nodes, block by block."""

    def __init__(self, scene: Scene, surfaces: list[Patches]) -> None:
        self.surfaces = surfaces
        ends = np.cumsum([0, *(len(patches) for patches in surfaces)])
        self.slices = [slice(int(a), int(b)) for a, b in pairwise(ends)]
        self.size = int(ends[-1])
        self._sight, self._cast = Sight(surfaces), RayCaster(scene)
        self._align()
        count = range(len(surfaces))
        self._plan = {(i, j): self._shortcut(i, j) for i in count for j in count if self._sight.see(i, j)}

    def __call__(self, values: Array) -> Array:
        """Fields ``(fields, nodes)`` → ``(fields, nodes)``."""
        result = np.zeros((len(values), self.size))
        for (i, j), block in self.blocks.items():
            result[:, self.slices[i]] += block(values[:, self.slices[j]])
        return result

    @property
    def structured(self) -> bool:
        """Whether no pair of surfaces needs adaptive quadrature."""
        return None not in self._plan.values()

    @cached_property
    def blocks(self) -> dict[tuple[int, int], Block]:
        """(i, j) → the operator from surface j to surface i, for pairs that see each other."""
        pairs = [pair for pair, shortcut in self._plan.items() if shortcut is None]
        entries = sum(len(self.surfaces[i]) * len(self.surfaces[j]) for i, j in pairs)
        if entries > MOST:
            raise ValueError(
                f"order and levels make {self.size} nodes, and {entries:.0e} entries of matrices between surfaces "
                f"that need quadrature; expected at most {MOST:.0e}: lower order or levels"
            )
        return {(i, j): make() if make else self._by_quadrature(i, j) for (i, j), make in self._plan.items()}

    def matrix(self) -> Array:
        """F in full, ``(nodes, nodes)``."""
        if self.size**2 > MOST:
            raise ValueError(
                f"{self.size} nodes make a matrix of {self.size**2:.0e} entries; expected at most {MOST:.0e}"
            )
        F = np.zeros((self.size, self.size))
        for (i, j), block in self.blocks.items():
            F[self.slices[i], self.slices[j]] = block(np.eye(len(self.surfaces[j]))).T
        return F

    def _align(self) -> None:
        """Rectangles in as few frames as there are: those of a room share one, those of a turned block another."""
        unit = diameter(self.surfaces)
        frames: list[Array] = []
        self._aligned = [_in_a_frame(patches, frames, unit) for patches in self.surfaces]
        found = [each for each in self._aligned if each]
        # how near a node of one comes to another one: across a shared edge, or from plane to plane
        near = [1.0, *(aligned.margin for _, aligned in found)]
        for (k, a), (l, b) in combinations(found, 2):  # noqa: E741
            if k == l and a.axes[2] == b.axes[2] and a.level != b.level:
                near.append(abs(a.level - b.level))
        self._transforms = Transforms(exponents(min(near), farthest=1.0))

    def _shortcut(self, i: int, j: int) -> Callable[[], Block] | None:
        """What makes the operator from surface j to surface i, unless that is adaptive quadrature."""
        receiver, source = self.surfaces[i], self.surfaces[j]
        if self._sight.hidden(i, j) or not self._sight.face(i, j):
            return None
        if orders := far_orders(receiver, source, FAR_ACCURACY):
            return partial(FarBlock, receiver, source, orders)
        a, b = self._aligned[i], self._aligned[j]
        if a and b and a[0] == b[0]:
            kind = ParallelBlock if a[1].axes[2] == b[1].axes[2] else PerpendicularBlock
            return partial(kind, a[1], b[1], self._transforms)
        return (lambda: DenseBlock(of_patches(receiver, source))) if source.support == 1 else None

    def _by_quadrature(self, i: int, j: int) -> Block:
        visible = (self._cast, i, j) if self._sight.hidden(i, j) else None
        return DenseBlock(AdaptiveQuadrature(self.surfaces[i], self.surfaces[j], visible).matrix)


def _in_a_frame(patches: Patches, frames: list[Array], unit: float) -> tuple[int, Aligned] | None:
    """The first frame that a quad fits into, or its own one, which is then added; None if it is no rectangle."""
    u, n = patches.edges[0] / np.linalg.norm(patches.edges[0]), patches.normal
    own = np.stack([u, np.cross(n, u), n], axis=1)
    for k, frame in enumerate([*frames, own]):
        if aligned := Aligned.of(patches, frame, unit):
            frames[k:] = frames[k:] or [own]
            return k, aligned
    return None


@dataclass(frozen=True)
class Errors:
    """How far a solution is from a finer one, relative; 0 where a term is zero.

    Attributes:
        surfaces: L² norm of the difference over that of the finer term, ``(bounces + 1, surfaces, channels)``.
        image: largest difference of a pixel over the mean of the finer image, ``(bounces + 1, channels)``.
    """

    surfaces: Array
    image: Array

    @property
    def largest(self) -> float:
        """Of all of them."""
        return float(max(self.surfaces.max(), self.image.max()))


@dataclass(frozen=True)
class Solution:
    """Every TᵏE of a scene in a finite basis.

    Attributes:
        scene: what was solved.
        basis, order, levels, splits, threshold: as in ``solve``.
        F: the form factors, or their wavelet transform.
        terms: nodal radiance of E, TE, …, ``(bounces + 1, channels, nodes)``.
    """

    scene: Scene
    basis: Basis
    order: int
    levels: int
    splits: Splits | None
    threshold: float
    F: FormFactors | haar.WaveletFormFactors
    terms: Array

    @property
    def surfaces(self) -> list[Patches]:
        """The patches of each surface."""
        return self.F.surfaces

    @cached_property
    def inverse(self) -> Array:
        """(I − T)⁻¹E, all bounces at once: nodal radiance, ``(channels, nodes)``.

        Raises:
            SingularTransportError: the linear solve finds none.
        """
        albedo = nodal_albedo(self.scene, self.surfaces)
        L: Array = np.empty_like(self.terms[0])
        for c, E in enumerate(self.terms[0]):
            system = LinearOperator(
                (self.F.size,) * 2, lambda v, c=c: v - albedo[c] * self.F(v.reshape(1, -1))[0]
            )
            L[c], failed = gmres(system, E, rtol=1e-13, atol=0.0, restart=100, maxiter=2)
            growth, size = np.linalg.norm(L[c]), np.linalg.norm(E)
            if (failed and np.linalg.norm(system @ L[c] - E) > 1e-10 * size) or growth > MOST_GROWTH * size:
                raise SingularTransportError(
                    f"channel {c}: (I − T) L = E has no solution, or one {growth / size:.0e} times as large as E; "
                    "expected a scene that is open or has an albedo below 1"
                )
        return L

    def radiance(self, surface: str, s: Array, t: Array, field: Array | None = None) -> Array:
        """Radiance that leaves the points corner + s·edge_u + t·edge_v of a surface.

        Args:
            surface: its name.
            s, t: in [0, 1], ``(n,)``.
            field: nodal radiance ``(…, nodes)``; all terms by default.

        Returns:
            ``(…, n)``; by default ``(bounces + 1, channels, n)``.
        """
        names = [each.name for each in self.scene.surfaces]
        if surface not in names:
            raise ValueError(f"no surface is called {surface!r}; there are {', '.join(names)}")
        i = names.index(surface)
        indices, basis = self.surfaces[i].basis(np.asarray(s, dtype=float), np.asarray(t, dtype=float))
        field = self.terms if field is None else field
        values: Array = np.einsum("...nk,nk->...n", field[..., self.F.slices[i]][..., indices], basis)
        return values

    def image(self, field: Array | None = None) -> Array:
        """Averages over the sensor's pixels, exact but for the radiance.

        Args:
            field: nodal radiance ``(…, channels, nodes)``; all terms by default.

        Returns:
            ``(…, height, width, channels)``; by default ``(bounces + 1, height, width, channels)``.
        """
        field = self.terms if field is None else field
        return pixel_averages.image(self._pixel_weights, field, self.scene.sensor)

    @cached_property
    def _pixel_weights(self) -> scipy.sparse.csr_array:
        return pixel_averages.weights(self.scene.sensor, self.surfaces)

    def refined(self, times: int = 1) -> Solution:
        """The same in a finer basis: each time one level, and for legendre one order more."""
        order = self.order + (times if self.basis == "legendre" else 0)
        bounces = len(self.terms) - 1
        levels, threshold = self.levels + times, self.threshold / 4**times
        return solve(self.scene, bounces, self.basis, order, levels, self.splits, threshold)

    def compared(self, finer: Solution) -> Errors:
        """How far this solution is from a finer one of the same scene."""
        bounces, channels, _ = self.terms.shape
        surfaces = np.zeros((bounces, len(self.surfaces), channels))
        for i, (patches, surface) in enumerate(zip(finer.surfaces, self.scene.surfaces, strict=True)):
            s, t = (a.ravel() for a in np.meshgrid(*(m.nodes for m in patches.meshes), indexing="ij"))
            expected = finer.terms[..., finer.F.slices[i]]
            difference = self.radiance(surface.name, s, t) - expected
            surfaces[:, i] = _ratio(
                np.sqrt(difference**2 @ patches.weights), np.sqrt(expected**2 @ patches.weights)
            )
        image, expected = self.image(), finer.image()
        largest = np.abs(image - expected).max(axis=(1, 2))
        return Errors(surfaces, _ratio(largest, expected.mean(axis=(1, 2))))

    @cached_property
    def error(self) -> Errors:
        """The estimate from one refinement."""
        return self.compared(self.refined())


def _ratio(difference: Array, size: Array) -> Array:
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(difference == 0, 0.0, difference / size)


def nodal_albedo(scene: Scene, surfaces: list[Patches]) -> Array:
    """At every node, ``(channels, nodes)``."""
    counts = [len(patches) for patches in surfaces]
    return np.repeat(np.array([s.material.albedo for s in scene.surfaces]), counts, axis=0).T


def solve(
    scene: Scene,
    bounces: int,
    basis: Basis = "legendre",
    order: int | None = None,
    levels: int | None = None,
    splits: Splits | None = None,
    threshold: float = 1e-4,
) -> Solution:
    """Every TᵏE up to k = ``bounces`` of a diffuse scene of quads.

    Args:
        scene: quads, Lambertian, any number of channels.
        bounces: the last bounce.
        basis: the space, and for haar the sparse form of T in it.
        order: nodes per patch and axis (polynomial degree + 1) away from edges; 1 for constant and haar.
        levels: of grading for legendre; for constant and haar there are 2^levels patches per axis. The defaults
            give the empty Cornell box to 10⁻⁵; they are coarse where pairs of surfaces need quadrature.
        splits: further mesh lines, where the edge of a shadow lies: surface name → values of s, values of t.
        threshold: of haar: entries of T below threshold × the largest one are dropped.

    Raises:
        UnsupportedSceneError: a surface is not a quad or not Lambertian.
        ValueError: an argument that can't be.
    """
    check(scene)
    if basis not in DEFAULTS:
        raise ValueError(f"basis = {basis!r}: expected one of {', '.join(DEFAULTS)}")
    if bounces < 0:
        raise ValueError(f"bounces = {bounces}: expected 0 or more")
    usual = DEFAULTS[basis]
    if (
        basis == "legendre"
        and None in (order, levels)
        and not FormFactors(scene, meshed(scene, 2, 0)).structured
    ):
        usual = WITHOUT_STRUCTURE
    order, levels = usual[0] if order is None else order, usual[1] if levels is None else levels
    if basis != "legendre" and order != 1:
        raise ValueError(f"order = {order}: the basis {basis} has order 1")
    if basis == "haar" and splits:
        raise ValueError("splits: the basis haar halves its patches and has no other lines; use constant")
    surfaces = meshed(scene, order, levels, splits, grading=basis == "legendre")
    full = FormFactors(scene, surfaces)
    F = haar.WaveletFormFactors(full, threshold) if basis == "haar" else full
    albedo = nodal_albedo(scene, surfaces)
    dark = (0.0,) * scene.channels
    emitted = [s.emission.radiance if s.emission else dark for s in scene.surfaces]
    terms = np.empty((bounces + 1, scene.channels, F.size))
    terms[0] = np.repeat(np.array(emitted), [len(patches) for patches in surfaces], axis=0).T
    for k in range(bounces):
        terms[k + 1] = albedo * F(terms[k])
    return Solution(scene, basis, order, levels, splits, threshold, F, terms)
