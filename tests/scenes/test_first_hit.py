"""First hits against points that are known to lie on shapes, and rays that are known to miss them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from scenes import (
    AreaLight,
    Disk,
    Ellipsoid,
    IrradianceMeter,
    Lambertian,
    Mesh,
    Orthographic,
    Pinhole,
    PointLight,
    Quad,
    RadianceMeter,
    Scene,
    SceneError,
    Shape,
    Sphere,
    Surface,
    ThinLens,
    library,
)
from scenes.first_hit import NOTHING, first_hits, first_hits_of, sensor_rays

GREY = Lambertian((0.5,))
ORIGIN, Y, Z = (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
RNG = np.random.default_rng(3)
N = 300

QUAD = Quad((1.0, 0.0, 2.0), (1.0, 0.5, 0.0), (0.0, 1.0, 1.0))
DISK = Disk((1.0, 0.0, 2.0), (1.0, 0.5, 0.0), (0.0, 0.3, 0.6))
MESH = Mesh([ORIGIN, (1, 0, 0), (0, 1, 0), (1.0, 1.0, 0.5)], [(0, 1, 2), (1, 3, 2)])
BALL = Ellipsoid((1.0, 0.0, 2.0), (1.0, 0.2, 0.0), (0.0, 2.0, 0.3), (0.5, 0.0, 0.5))


def scene_of(*shapes: Shape) -> Scene:
    parts = tuple(Surface(f"{i}", shape, GREY) for i, shape in enumerate(shapes))
    return Scene(parts, RadianceMeter(ORIGIN, Z), (PointLight((0, 50, 0), (1.0,)),))


def aimed(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rays at points from somewhere far around; origins, directions, distances."""
    origin = 20 * RNG.normal(size=points.shape)
    length = np.linalg.norm(points - origin, axis=0)
    return origin, (points - origin) / length, length


def flat_points(shape: Quad | Disk | Mesh, inside: bool) -> np.ndarray:
    """Points of the plane of a flat shape, on it or beside it; of a mesh, of its first triangle."""
    s, t = RNG.uniform(0.02, 0.98, (2, N)) if inside else RNG.uniform(1.02, 3, (2, N))
    if isinstance(shape, Quad):
        start, u, v = shape.corner, shape.edge_u, shape.edge_v
    elif isinstance(shape, Disk):
        start, u, v = shape.center, shape.axis_u, shape.axis_v
        angle = 2 * np.pi * t
        s, t = s * np.cos(angle), s * np.sin(angle)
    else:
        a, b, c = shape.corners[0]
        start, u, v = a, b - a, c - a
        s, t = (s, t * (1 - s)) if inside else (s, t)
    return np.array(start)[:, None] + np.outer(u, s) + np.outer(v, t)


@pytest.mark.parametrize("shape", [QUAD, DISK, MESH], ids=["quad", "disk", "mesh"])
def test_rays_at_points_of_a_flat_shape_meet_it_there(shape: Any) -> None:
    origin, d, distance = aimed(flat_points(shape, inside=True))
    hits = first_hits_of(scene_of(shape), origin, d)
    # a bent mesh may have its other triangle before this one
    same = hits.distance >= distance * (1 - 1e-9)
    assert same.mean() > (0.8 if isinstance(shape, Mesh) else 0.999)
    np.testing.assert_allclose(hits.distance[same], distance[same], rtol=1e-10)
    assert (hits.surface == 0).all()
    u, v = (
        (np.diff(shape.corners[0], axis=0)[0], shape.corners[0][2] - shape.corners[0][0])
        if isinstance(shape, Mesh)
        else (shape.edge_u, shape.edge_v)
        if isinstance(shape, Quad)
        else (shape.axis_u, shape.axis_v)
    )
    normal = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
    np.testing.assert_allclose(hits.normal[:, same].T, np.tile(normal, (same.sum(), 1)), atol=1e-12)


@pytest.mark.parametrize("shape", [QUAD, DISK], ids=["quad", "disk"])
def test_rays_beside_a_flat_shape_meet_nothing(shape: Any) -> None:
    origin, d, _ = aimed(flat_points(shape, inside=False))
    hits = first_hits_of(scene_of(shape), origin, d)
    assert np.isinf(hits.distance).all()
    assert (hits.surface == NOTHING).all()
    assert not hits.normal.any()
    away = first_hits_of(
        scene_of(shape), *aimed(flat_points(shape, inside=True))[:2] * np.array([[[1]], [[-1]]])
    )
    assert np.isinf(away.distance).all(), "what lies behind the ray is not met"


@pytest.mark.parametrize("inward", [False, True])
@pytest.mark.parametrize("kind", ["sphere", "ellipsoid"])
def test_the_near_side_of_a_ball_from_outside_and_the_far_side_from_inside(kind: str, inward: bool) -> None:
    matrix, center = (1.5 * np.eye(3), np.array([1.0, 2.0, 3.0])) if kind == "sphere" else (
        BALL.matrix, np.array(BALL.center))  # fmt: skip
    shape: Shape = Sphere((1.0, 2.0, 3.0), 1.5, inward)
    if kind == "ellipsoid":
        shape = Ellipsoid(BALL.center, BALL.axis_u, BALL.axis_v, BALL.axis_w, inward)
    q = RNG.normal(size=(3, N))
    q /= np.linalg.norm(q, axis=0)
    x, normal = center[:, None] + matrix @ q, np.linalg.inv(matrix).T @ q * (-1 if inward else 1)
    normal /= np.linalg.norm(normal, axis=0)
    # from a point beyond the surface along its normal, the point is on the near side
    outward = normal * (-1 if inward else 1)
    outside = first_hits_of(scene_of(shape), x + 0.7 * outward, -outward)
    np.testing.assert_allclose(outside.distance, 0.7, rtol=1e-9)
    np.testing.assert_allclose(outside.normal, normal, atol=1e-9)
    # from the centre, every point is met
    to = x - center[:, None]
    length = np.linalg.norm(to, axis=0)
    inside = first_hits_of(scene_of(shape), np.tile(center[:, None], N), to / length)
    np.testing.assert_allclose(inside.distance, length, rtol=1e-12)
    np.testing.assert_allclose(inside.normal, normal, atol=1e-12)
    # tangents at a distance miss it
    tangent = np.cross(outward.T, [0.3, -0.5, 0.8]).T
    tangent /= np.linalg.norm(tangent, axis=0)
    beside = first_hits_of(scene_of(shape), x + 0.01 * outward - 30 * tangent, tangent)
    assert np.isinf(beside.distance).all()


def test_the_nearest_of_several_is_met_whatever_their_order() -> None:
    near, far = Quad((-1, -1, 2), (2, 0, 0), (0, 2, 0)), Quad((-1, -1, 5), (0, 2, 0), (2, 0, 0))
    origin, d = np.zeros((3, 1)), np.array([[0.1], [0.2], [1.0]])
    for shapes, expected in (((near, far), 0), ((far, near), 1)):
        hits = first_hits_of(scene_of(*shapes), origin, d)
        assert hits.surface == [expected]
        assert hits.distance == pytest.approx([2.0])
        assert hits.normal[:, 0] == pytest.approx([0, 0, 1])


@pytest.mark.parametrize(
    "sensor",
    [
        Pinhole((0, 0, 5), ORIGIN, Y, 60, 6, 4),
        ThinLens((0, 0, 5), ORIGIN, Y, 60, 6, 4, 0.3, 2.0),
        Orthographic((0, 0, 5), ORIGIN, Y, 4.0, 6, 4),
    ],
    ids=["pinhole", "thin lens", "orthographic"],
)
def test_rays_through_pixels(sensor: Any) -> None:
    """A wall across the view: where the ray of a pixel meets it, by similar triangles."""
    wall = Surface("wall", Quad((-9, -9, 0), (18, 0, 0), (0, 18, 0)), GREY, AreaLight((1.0,)))
    origin, d = sensor_rays(sensor, (0.25, 0.75))
    hits = first_hits(Scene((wall,), sensor), (0.25, 0.75))
    x, y, z = origin + hits.distance * d
    half = 2.0 if isinstance(sensor, Orthographic) else 5 * np.tan(np.radians(30))
    columns, rows = np.meshgrid(np.arange(6) + 0.25, np.arange(4) + 0.75)
    np.testing.assert_allclose(x, ((columns - 3) / 2 * half).ravel(), atol=1e-12)
    np.testing.assert_allclose(y, ((2 - rows) / 2 * half).ravel(), atol=1e-12)
    np.testing.assert_allclose(z, 0, atol=1e-12)


def test_a_meter_has_one_ray_or_none() -> None:
    origin, d = sensor_rays(RadianceMeter((1, 2, 3), Y))
    assert origin.T.tolist() == [[1, 2, 3]]
    assert d.T.tolist() == [[0, 1, 0]]
    with pytest.raises(SceneError, match="a sensor with a ray for each pixel"):
        sensor_rays(IrradianceMeter((1, 2, 3), Y))


def test_a_mesh_of_many_triangles_is_taken_in_parts() -> None:
    """480 triangles from inside: rays go somewhere, and never farther than the ring reaches."""
    scene = library.case("furnace-mesh").scene.resized(12, 12)
    hits = first_hits(scene)
    assert (hits.surface >= 0).all()
    assert hits.distance.max() < 20
