"""Surfaces: boxes made of quads, and what goes with what."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from scenes import (
    AreaLight,
    Blend,
    Checkerboard,
    Dielectric,
    Lambertian,
    Mesh,
    Mirror,
    PolarRange,
    Quad,
    SceneError,
    Sphere,
    Surface,
    box,
)

GREY = Lambertian((0.5,))
CUBE = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
TURNED = ((0.6, 0.0, -0.8), (0.0, 2.0, 0.0), (0.4, 0.0, 0.3))
FACES = ["left", "right", "bottom", "top", "back", "front"]
SKEW = ((1.0, 0.2, 0.0), (0.3, 1.0, 0.1), (0.0, -0.4, 2.0))


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


def test_half_edges_are_right_handed() -> None:
    with pytest.raises(SceneError, match=r"box\.half_edges"):
        box("box", (0, 0, 0), (CUBE[1], CUBE[0], CUBE[2]), GREY)


BALL = Sphere((0.0, 0.0, 0.0), 1.0)


def test_channels_and_emission() -> None:
    assert Surface("s", BALL, GREY).channels == 1
    assert Surface("s", BALL, Dielectric()).channels is None
    lit = Surface("s", BALL, Dielectric(), AreaLight((0.0, 1.0)))
    assert (lit.channels, lit.emits) == (2, True)
    assert not Surface("s", BALL, GREY).emits
    assert not Surface("s", BALL, GREY, AreaLight((0.0,))).emits
    with pytest.raises(
        SceneError, match=r"Surface\.emission\.radiance = .*1 channels, as material\.albedo has"
    ):
        Surface("s", BALL, GREY, AreaLight((1.0, 1.0)))


@pytest.mark.parametrize("material", [Dielectric(), Blend(GREY, Dielectric(), 0.1)])
def test_glass_is_not_two_sided(material: object) -> None:
    with pytest.raises(
        SceneError, match=r"Surface\.two_sided = True: expected False: a dielectric has two sides"
    ):
        Surface("s", BALL, material, two_sided=True)


def test_only_a_sphere_has_a_zone() -> None:
    quad = Quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    with pytest.raises(SceneError, match=r"Surface\.emission\.polar_range"):
        Surface("s", quad, GREY, AreaLight((1.0,), PolarRange()))
    assert Surface("s", BALL, GREY, AreaLight((1.0,), PolarRange())).emits


def test_a_textured_mesh_has_coordinates() -> None:
    corners, textured = [(0, 0, 0), (1, 0, 0), (0, 1, 0)], Lambertian(Checkerboard((0.1,), (0.9,)))
    for material in (textured, Blend(Mirror((1.0,)), textured, 0.5)):
        with pytest.raises(SceneError, match=r"Surface\.shape\.uv"):
            Surface("s", Mesh(corners, [(0, 1, 2)]), material)
        Surface("s", Mesh(corners, [(0, 1, 2)], uv=[(0, 0), (1, 0), (0, 1)]), material)
    Surface("s", Mesh(corners, [(0, 1, 2)]), GREY)
