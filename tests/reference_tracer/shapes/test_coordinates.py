"""Normals, shading normals and texture coordinates of points that rays meet, against their definitions."""

from __future__ import annotations

import numpy as np
import pytest

from reference_tracer.points import NOWHERE, Points
from reference_tracer.propagation import RayCaster
from scenes import (
    AreaLight,
    Checkerboard,
    Disk,
    Ellipsoid,
    Lambertian,
    Mesh,
    Pinhole,
    Quad,
    Scene,
    Shape,
    Sphere,
    Surface,
)

CHECKS = Lambertian(Checkerboard((0.1,), (0.9,)))
CAMERA = Pinhole((0.0, 0.0, 9.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0, 4, 4)


def scene_of(shape: Shape, two_sided: bool = False, material: Lambertian = CHECKS) -> Scene:
    return Scene((Surface("it", shape, material, AreaLight((1.0,)), two_sided),), CAMERA)


def towards(scene: Scene, targets: np.ndarray, origin: tuple[float, float, float]) -> Points:
    x = np.tile(np.array(origin)[:, None], targets.shape[1])
    d = targets - x
    return RayCaster(scene)(Points.nowhere(x), d / np.linalg.norm(d, axis=0))


ST = np.random.default_rng(1).random((2, 50))


def test_a_quad_has_its_s_and_t() -> None:
    quad = Quad((0.2, -0.3, 1.0), (2.0, 0.5, 0.0), (-0.5, 1.0, 0.3))
    x = np.array(quad.corner)[:, None] + np.outer(quad.edge_u, ST[0]) + np.outer(quad.edge_v, ST[1])
    hit = towards(scene_of(quad), x, (0.1, 0.2, 9.0))
    np.testing.assert_allclose(hit.uv, ST, atol=1e-13)


def test_a_disk_has_the_square_around_it() -> None:
    disk = Disk((0.2, -0.3, 1.0), (2.0, 0.5, 0.0), (-0.5, 1.0, 0.3))
    a, b = 0.7 * (2 * ST - 1)
    x = np.array(disk.center)[:, None] + np.outer(disk.axis_u, a) + np.outer(disk.axis_v, b)
    hit = towards(scene_of(disk), x, (0.1, 0.2, 9.0))
    np.testing.assert_allclose(hit.uv, [(a + 1) / 2, (b + 1) / 2], atol=1e-13)


@pytest.mark.parametrize("inward", [False, True])
def test_spheres_have_longitude_and_polar_angle(inward: bool) -> None:
    u, v = 0.02 + 0.96 * ST
    unit = np.array(
        [
            np.sin(np.pi * v) * np.cos(2 * np.pi * u),
            np.sin(np.pi * v) * np.sin(2 * np.pi * u),
            -np.cos(np.pi * v),
        ]
    )
    axes = ((2.0, 0.3, 0.0), (0.0, 1.0, 0.4), (0.5, 0.0, 0.8))
    for shape, M in (
        (Sphere((1.0, 2.0, 3.0), 0.5, inward), 0.5 * np.eye(3)),
        (Ellipsoid((1.0, 2.0, 3.0), *axes, inward), np.array(axes).T),
    ):
        x = np.array(shape.center)[:, None] + M @ unit
        hit = towards(scene_of(shape), x, shape.center)  # seen from the middle, each point is met
        np.testing.assert_allclose(hit.uv, [u, v], atol=1e-12)
        gradient = np.linalg.inv(M).T @ unit
        n = gradient / np.linalg.norm(gradient, axis=0) * (-1 if inward else 1)
        np.testing.assert_allclose(hit.n, n, atol=1e-12)
        np.testing.assert_array_equal(hit.n, hit.ns)


MESH = Mesh(
    vertices=((0.0, 0.0, 0.0), (2.0, 0.0, 0.2), (0.0, 2.0, 0.4), (2.0, 2.0, 1.0)),
    triangles=((0, 1, 2), (1, 3, 2)),
    normals=((0.1, 0.0, 1.0), (0.3, 0.1, 2.0), (-0.2, 0.2, 1.0), (0.0, -0.4, 1.0)),
    uv=((0.1, 0.2), (0.9, 0.1), (0.0, 0.8), (1.0, 1.0)),
)


def on_mesh() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which triangle, barycentric weights (3, n), positions (3, n)."""
    rng = np.random.default_rng(3)
    which = rng.integers(2, size=60)
    weights = rng.dirichlet((1, 1, 1), 60).T
    return which, weights, np.einsum("nvi,vn->in", MESH.corners[which], weights)


@pytest.mark.parametrize("two_sided", [False, True])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_mesh_is_interpolated(two_sided: bool, side: float) -> None:
    which, weights, x = on_mesh()
    hit = towards(scene_of(MESH, two_sided), x, (0.5, 0.7, 9.0 * side))
    np.testing.assert_array_equal(hit.primitive, which)
    assert not hit.surface.any()
    at = np.array(MESH.triangles)[which]
    np.testing.assert_allclose(hit.uv, np.einsum("nvi,vn->in", np.array(MESH.uv)[at], weights), atol=1e-12)
    ns = np.einsum("nvi,vn->in", np.array(MESH.normals)[at], weights)
    turned = -1 if two_sided and side < 0 else 1
    np.testing.assert_allclose(hit.ns, turned * ns / np.linalg.norm(ns, axis=0), atol=1e-12)
    a, b, c = MESH.corners.transpose(1, 0, 2)
    n = np.cross(b - a, c - a)[which].T
    np.testing.assert_allclose(hit.n, turned * n / np.linalg.norm(n, axis=0), atol=1e-12)


def test_two_sides() -> None:
    quad = Quad((-1.0, -1.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0))
    x, d = Points.nowhere(np.array([[0.0] * 3, [0.0] * 3, [1.0, -1.0, 5.0]])), np.zeros((3, 3))
    d[2] = [-1, 1, 1]
    for two_sided in (True, False):
        hit = RayCaster(scene_of(quad, two_sided))(x, d)
        assert hit.surface.tolist() == [0, 0, NOWHERE]
        assert hit.n[2].tolist() == [1, -1 if two_sided else 1, 1]


def test_without_textures_there_are_no_coordinates() -> None:
    plain = scene_of(MESH, material=Lambertian((0.5,)))
    assert towards(plain, on_mesh()[2], (0.5, 0.7, 9.0)).uv is None
