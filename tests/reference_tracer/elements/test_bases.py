"""Meshes and patches: exact for polynomials, and quick to converge at an edge's singularity."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from reference_tracer.elements.bases import Mesh, Patches, graded, uniform
from scenes import Quad

MESHES = {
    "one cell": uniform(6, 1),
    "equal cells": uniform(4, 5, (0.3,)),
    "graded at both ends": graded(7, 4, True, True, (0.4, 0.77)),
    "graded at one end": graded(5, 3, False, True),
    "two orders": Mesh(np.array([0.0, 0.2, 1.0]), np.array([4, 6])),
}
QUAD = Quad((0.3, -1.0, 2.0), (1.0, 0.2, 0.0), (-0.4, 1.5, 0.3))


@pytest.mark.parametrize("name", MESHES)
def test_quadrature_of_polynomials_is_exact(name: str) -> None:
    mesh = MESHES[name]
    for k in range(2 * int(mesh.orders.min())):
        assert mesh.weights @ mesh.nodes**k == pytest.approx(1 / (k + 1), abs=1e-14)


@pytest.mark.parametrize("name", MESHES)
def test_the_basis_interpolates_and_reproduces_polynomials(name: str) -> None:
    mesh = MESHES[name]
    x = np.random.default_rng(1).random(200)
    for points, f in ((mesh.nodes, np.cos(5 * mesh.nodes)), (x, None)):
        values = np.polynomial.Polynomial([1.0, -2.0, 0.0, 3.0][: int(mesh.orders.min())])
        cell = mesh.cell(points)
        found = np.einsum("nk,nk->n", mesh.basis(points, cell), values(mesh.nodes)[mesh.indices(cell)])
        np.testing.assert_allclose(found, values(points), atol=1e-13)
        if f is not None:
            found = np.einsum("nk,nk->n", mesh.basis(points, cell), f[mesh.indices(cell)])
            np.testing.assert_allclose(found, f, atol=1e-13)


def test_a_mesh_turned_around() -> None:
    mesh = graded(5, 3, True, False)
    turned = mesh.placed(2.0, -4.0)
    np.testing.assert_allclose(turned.nodes, np.sort(2 - 4 * mesh.nodes), atol=1e-14)
    assert turned.weights.sum() == pytest.approx(4)


def error_of_z_log_z(mesh: Mesh) -> float:
    """L² error of the interpolation of z log z, by a quadrature much finer near 0."""
    fine = Mesh(np.concatenate([[0.0], np.geomspace(1e-12, 1, 200)]), np.full(200, 12))
    cell = mesh.cell(fine.nodes)
    values = (mesh.nodes * np.log(mesh.nodes))[mesh.indices(cell)]
    off = np.einsum("nk,nk->n", mesh.basis(fine.nodes, cell), values) - fine.nodes * np.log(fine.nodes)
    return float(np.sqrt(off**2 @ fine.weights))


def test_grading_beats_equal_cells_at_an_edge() -> None:
    """z log z: equal cells converge like h^1.5 whatever the order, graded ones by a factor for each level."""
    equal = [error_of_z_log_z(uniform(8, n)) for n in (4, 8, 16)]
    for coarse, fine in pairwise(equal):
        assert coarse / fine == pytest.approx(2**1.5, rel=0.02)
    finer = [error_of_z_log_z(graded(8, levels, True, False)) for levels in (1, 2, 3)]
    assert finer[0] > 4 * finer[1] > 16 * finer[2]
    assert len(graded(8, 3, True, False)) < len(uniform(8, 16)) / 2
    assert finer[2] < equal[2] / 3


def test_patches_lie_on_their_quad() -> None:
    patches = Patches.of(QUAD, (uniform(3, 2), graded(4, 2, True, True)))
    assert patches.weights.sum() == pytest.approx(QUAD.area)
    s, t = np.random.default_rng(2).random((2, 9))
    np.testing.assert_allclose(patches.coordinates(patches.points(s, t)), [s, t], atol=1e-14)
    assert np.abs(patches.normal @ (patches.nodes - np.array(QUAD.corner)[:, None])).max() < 1e-14
    # the nodes are numbered as the basis says
    s, t = patches.coordinates(patches.nodes)
    indices, values = patches.basis(s, t)
    f = np.sin(3 * s) + t**2
    np.testing.assert_allclose(np.einsum("nk,nk->n", values, f[indices]), f, atol=1e-13)
