"""The kernel as a sum of products: its one-dimensional integrals, and the operator, against other means."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import dblquad
from scipy.special import erf

from reference_tracer.elements.bases import Patches, graded
from reference_tracer.elements.form_factors import kernel, point_to_polygon
from reference_tracer.elements.separable_kernel import (
    STEP,
    Aligned,
    ParallelBlock,
    PerpendicularBlock,
    Transforms,
    exponents,
    gauss_transform,
)
from scenes import Quad

GRADED = graded(7, 5, True, False).placed(-0.3, 1.3)
FLOOR = Quad((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.8, 0.0))
Block = ParallelBlock | PerpendicularBlock
WALLS = {
    "touching": Quad((0.0, 0.0, 0.0), (0.0, 0.8, 0.0), (0.0, 0.0, 1.0)),
    "touching, edges exchanged and turned": Quad((0.0, 0.8, 0.0), (0.0, 0.0, 1.0), (0.0, -0.8, 0.0)),
    "touching, shifted along the edge": Quad((0.0, 0.3, 0.0), (0.0, 0.9, 0.0), (0.0, 0.0, 0.4)),
    "the other side": Quad((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.8, 0.0)),
    "along x": Quad((1.0, 0.8, 0.5), (-1.0, 0.0, 0.0), (0.0, 0.0, -0.5)),
    "above": Quad((0.2, 0.9, 0.6), (0.0, -1.0, 0.0), (-0.4, 0.0, 0.0)),
    "just above": Quad((0.1, 0.1, 0.01), (0.0, 0.8, 0.0), (0.7, 0.0, 0.0)),
    "not touching": Quad((-0.2, 1.0, 0.1), (0.0, 0.5, 0.0), (0.0, 0.0, 0.4)),
}


def test_the_sum_of_exponentials_is_r_to_the_minus_four() -> None:
    r = np.geomspace(1e-6, 1.0, 300)
    tau = np.exp(exponents(1e-6, 1.0))
    found = STEP * (tau**2 * np.exp(-np.outer(r**2, tau))).sum(axis=1)
    np.testing.assert_allclose(found * r**4, 1, atol=1e-10)


def test_gauss_transform_of_constants_and_lines_against_erf() -> None:
    x = np.array([-0.3, 0.0, 0.123, 0.9, 1.4, -2.0])
    a = np.linspace(-6, 24, 31)
    tau, low, high = np.exp(a)[:, None], -0.3 - x, 1.0 - x
    root = np.sqrt(tau)
    constant = np.sqrt(np.pi) / 2 / root * (erf(root * high) - erf(root * low))
    # ∫ z e^{−τz²} dz = −e^{−τz²} / 2τ, and |z| turns its sign at 0
    first = (np.exp(-tau * low**2) - np.exp(-tau * high**2)) / (2 * tau)
    found = gauss_transform(x, GRADED, a, 0)
    np.testing.assert_allclose(found.sum(axis=2), constant, atol=1e-13)
    np.testing.assert_allclose(found @ GRADED.nodes, first + x * constant, atol=1e-13)
    beside = (x <= -0.3) | (x >= 1.0)
    found = gauss_transform(x[beside], GRADED, a, 1).sum(axis=2)
    np.testing.assert_allclose(found, np.abs(first[:, beside]), atol=1e-13)


def block(receiver: Quad, source: Quad) -> tuple[Patches, Patches, Block]:
    meshes = graded(6, 3, True, True), graded(5, 4, True, False)
    a, b = Patches.of(receiver, meshes), Patches.of(source, meshes)
    aligned = Aligned.of(a, np.eye(3), 1.0), Aligned.of(b, np.eye(3), 1.0)
    assert aligned[0] is not None
    assert aligned[1] is not None
    kind = ParallelBlock if aligned[0].axes[2] == aligned[1].axes[2] else PerpendicularBlock
    return a, b, kind(aligned[0], aligned[1], Transforms(exponents(1e-5, 4.0)))


@pytest.mark.parametrize("turned", [False, True], ids=["floor from wall", "wall from floor"])
@pytest.mark.parametrize("name", WALLS)
def test_constants_against_lambert(name: str, turned: bool) -> None:
    a, b, operator = block(*((WALLS[name], FLOOR) if turned else (FLOOR, WALLS[name])))
    found = operator(np.stack([np.ones(len(b)), np.full(len(b), 3.0)]))
    n = np.tile(a.normal[:, None], len(a))
    expected = point_to_polygon(a.nodes, n, b.corners)
    assert expected.min() > 0
    np.testing.assert_allclose(found, [expected, 3 * expected], atol=1e-11)


@pytest.mark.parametrize("name", ["touching, edges exchanged and turned", "above"])
def test_a_polynomial_against_adaptive_quadrature(name: str) -> None:
    a, b, operator = block(FLOOR, WALLS[name])
    s, t = b.coordinates(b.nodes)
    found = operator((s**3 * t**2)[None])[0]
    for i in (3, len(a) // 2, len(a) - 7):
        x = a.nodes[:, i]

        def integrand(v: float, u: float, x: np.ndarray = x) -> float:
            y = b.points(np.array([u]), np.array([v]))
            value = kernel(x[:, None], a.normal[:, None], y, b.normal[:, None])
            return float(value[0] * b.area * u**3 * v**2)

        assert found[i] == pytest.approx(dblquad(integrand, 0, 1, 0, 1, epsabs=1e-9)[0], abs=2e-9)


def test_a_quad_out_of_line_is_not_aligned() -> None:
    mesh = graded(2, 1, True, True)
    for quad in (
        Quad((0.0, 0.0, 0.0), (1.0, 0.1, 0.0), (-0.1, 1.0, 0.0)),
        Quad((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, 1.0, 0.0)),
    ):
        assert Aligned.of(Patches.of(quad, (mesh, mesh)), np.eye(3), 1.0) is None
