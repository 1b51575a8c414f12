"""Shapes: areas and normals, in closed form and from points."""

from __future__ import annotations

import math

import numpy as np
import pytest

from scenes import Disk, Ellipsoid, Mesh, Quad, SceneError, Sphere

X, Y, Z, ORIGIN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)


def test_a_quad_is_a_parallelogram_with_a_right_handed_normal() -> None:
    quad = Quad((1.0, 1.0, 1.0), (2.0, 0.0, 0.0), (1.0, 3.0, 0.0))
    assert quad.area == pytest.approx(6.0)
    np.testing.assert_allclose(quad.normal, [0, 0, 1])


def test_a_disk_is_an_ellipse_with_a_right_handed_normal() -> None:
    """π a b for half axes a, b; and conjugate radii of the same ellipse give the same."""
    disk = Disk(X, (3.0, 0.0, 0.0), (0.0, 0.0, 2.0))
    c, s = math.cos(0.7), math.sin(0.7)
    conjugate = Disk(X, (3 * c, 0.0, 2 * s), (-3 * s, 0.0, 2 * c))
    assert disk.area == pytest.approx(6 * math.pi)
    assert conjugate.area == pytest.approx(6 * math.pi)
    np.testing.assert_allclose(disk.normal, [0, -1, 0])
    np.testing.assert_allclose(conjugate.normal, [0, -1, 0], atol=1e-15)


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_small_ones_are_no_degenerate_ones(size: float) -> None:
    x, y, z = (size, 0.0, 0.0), (0.0, size, 0.0), (0.0, 0.0, size)
    almost_x, almost_y = (size, size * 1e-10, 0.0), (0.0, size, size * 1e-10)
    assert Quad(ORIGIN, x, y).area == pytest.approx(size**2)
    assert Disk(ORIGIN, x, y).area == pytest.approx(math.pi * size**2)
    assert Mesh([ORIGIN, x, y], [(0, 1, 2)]).area == pytest.approx(size**2 / 2)
    assert np.linalg.det(Ellipsoid(ORIGIN, x, y, z).matrix) == pytest.approx(size**3)
    for make in (
        lambda: Quad(ORIGIN, x, almost_x),
        lambda: Disk(ORIGIN, x, almost_x),
        lambda: Mesh([ORIGIN, x, almost_x], [(0, 1, 2)]),
        lambda: Ellipsoid(ORIGIN, x, y, almost_y),
    ):
        with pytest.raises(SceneError):
            make()


def test_a_sphere() -> None:
    assert Sphere(ORIGIN, 2.0).area == pytest.approx(16 * math.pi)


def test_the_matrix_of_an_ellipsoid_takes_unit_vectors_to_its_axes() -> None:
    ellipsoid = Ellipsoid(ORIGIN, (1.0, 2.0, 3.0), (0.0, 1.0, 0.0), (0.0, 0.5, -1.0))
    np.testing.assert_array_equal(ellipsoid.matrix @ X, ellipsoid.axis_u)
    np.testing.assert_array_equal(ellipsoid.matrix @ Z, ellipsoid.axis_w)


def test_a_mesh() -> None:
    """A regular tetrahedron of edge √8: each face √3/4 · 8; its vector areas sum to zero, and to the volume 8/3."""
    mesh = Mesh(
        [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], [(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)]
    )
    np.testing.assert_allclose(mesh.areas, [2 * math.sqrt(3)] * 4)
    assert mesh.area == pytest.approx(8 * math.sqrt(3))
    a, b, c = mesh.corners.transpose(1, 0, 2)
    vector_areas = np.cross(b - a, c - a) / 2
    np.testing.assert_allclose(vector_areas.sum(axis=0), 0, atol=1e-14)
    assert (vector_areas * mesh.corners.mean(axis=1)).sum() / 3 == pytest.approx(8 / 3)


def test_the_triangles_of_a_sphere_have_its_area() -> None:
    """Inscribed triangles lack a share of the area that falls with the square of their size."""
    lacking = []
    for n in (8, 16, 32):
        theta, phi = np.meshgrid(np.linspace(0.3, 1.2, n + 1), np.linspace(0, 1.5, n + 1), indexing="ij")
        vertices = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=2)
        i = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
        triangles = [(a, a + n + 1, a + n + 2) for a in i] + [(a, a + n + 2, a + 1) for a in i]
        mesh = Mesh(vertices.reshape(-1, 3), triangles, vertices.reshape(-1, 3))
        lacking.append(1.5 * (math.cos(0.3) - math.cos(1.2)) - mesh.area)
    assert 0 < lacking[2] < 1e-3
    np.testing.assert_allclose(np.divide(lacking[:2], lacking[1:]), 4, rtol=0.02)


def test_normals_are_normalised_and_on_the_front() -> None:
    mesh = Mesh([ORIGIN, X, Y], [(0, 1, 2)], [(0, 0, 5), (3, 0, 4), (0, -0.6, 0.8)])
    np.testing.assert_allclose(mesh.normals, [(0, 0, 1), (0.6, 0, 0.8), (0, -0.6, 0.8)])
    with pytest.raises(SceneError, match=r"Mesh\.normals\[0\] = .* on the front of triangles\[0\]"):
        Mesh([ORIGIN, X, Y], [(0, 2, 1)], [(0, 0, 1)] * 3)
    with pytest.raises(SceneError, match=r"Mesh\.normals\[1\] = .* on the front of triangles\[0\]"):
        Mesh([ORIGIN, X, Y], [(0, 1, 2)], [Z, X, Z])  # along the triangle
