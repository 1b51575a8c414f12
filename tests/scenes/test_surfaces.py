"""Shapes: areas, normals, and boxes made of quads."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest

from scenes import AreaLight, Lambertian, PolarRange, Quad, SceneError, Sphere, box

GREY = Lambertian((0.5,))
CUBE = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
TURNED = ((0.6, 0.0, -0.8), (0.0, 2.0, 0.0), (0.4, 0.0, 0.3))
FACES = ["left", "right", "bottom", "top", "back", "front"]
SKEW = ((1.0, 0.2, 0.0), (0.3, 1.0, 0.1), (0.0, -0.4, 2.0))


def test_a_quad_is_a_parallelogram_with_a_right_handed_normal() -> None:
    quad = Quad((1.0, 1.0, 1.0), (2.0, 0.0, 0.0), (1.0, 3.0, 0.0))
    assert quad.area == pytest.approx(6.0)
    np.testing.assert_allclose(quad.normal, [0, 0, 1])
    assert not quad.is_rectangle
    assert Quad((0, 0, 0), (0.6, 0.8, 0.0), (-0.8, 0.6, 0.0)).is_rectangle


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_a_small_quad_is_no_degenerate_one(size: float) -> None:
    assert Quad((0, 0, 0), (size, 0, 0), (0, size, 0)).area == pytest.approx(size**2)
    with pytest.raises(SceneError):
        Quad((0, 0, 0), (size, 0, 0), (size, size * 1e-10, 0))


def test_a_sphere_and_its_zones() -> None:
    assert Sphere((0, 0, 0), 2.0).area == pytest.approx(16 * math.pi)
    assert PolarRange().fraction == 1
    assert PolarRange(0, 90).fraction == pytest.approx(0.5)
    parts = [PolarRange(0, 45), PolarRange(45, 100), PolarRange(100, 180)]
    assert sum(part.fraction for part in parts) == pytest.approx(1)
    assert PolarRange(0, 45, (0.0, 3.0, 4.0)).axis == pytest.approx((0.0, 0.6, 0.8))


@pytest.mark.parametrize("inward", [False, True])
@pytest.mark.parametrize("half_edges", [CUBE, TURNED, SKEW], ids=["cube", "turned", "skew"])
def test_a_box_is_six_quads_about_a_volume(half_edges: tuple, inward: bool) -> None:
    center, light = np.array([0.5, -1.0, 2.0]), AreaLight((1.0,))
    faces = box("box", tuple(center), half_edges, GREY, inward=inward, emission=light)
    assert [face.name.removeprefix("box.") for face in faces] == FACES
    assert all(face.material == GREY and face.emission == light for face in faces)

    signs = np.array(list(product([-1, 1], repeat=3)))
    corners = {tuple(np.round(corner, 9)) for corner in center + signs @ np.array(half_edges)}
    middles, vectors = [], []
    for i, face in enumerate(faces):
        corner, u, v = (np.array(e) for e in (face.shape.corner, face.shape.edge_u, face.shape.edge_v))
        assert {tuple(np.round(corner + s * u + t * v, 9)) for s in (0, 1) for t in (0, 1)} <= corners
        middles.append(corner + (u + v) / 2 - center)
        vectors.append(face.shape.normal * face.shape.area)
        # face 2i + 1 stands at the end of half edge i, face 2i at the other end
        np.testing.assert_allclose(middles[-1], (1 if i % 2 else -1) * np.array(half_edges[i // 2]))
        assert (middles[-1] @ face.shape.normal < 0) == inward

    # the vector areas of a closed surface sum to zero, and to the volume times 3 against the positions
    volume = 8 * np.linalg.det(half_edges)
    np.testing.assert_allclose(np.sum(vectors, axis=0), 0, atol=1e-12)
    assert np.sum(np.multiply(middles, vectors)) == pytest.approx(-3 * volume if inward else 3 * volume)
