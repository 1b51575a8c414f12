"""∫ Li cos θ dω of area lights as sampling has it, held against closed forms.

The mean of Li · cos / pdf over the unit square of random numbers is an integral of a function that is mostly
smooth: Gauss's rule gives it without noise. Where it is not, random numbers and a standard error do.
"""

from __future__ import annotations

from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from reference_tracer.emitters import area_lights
from reference_tracer.emission import Emitters
from reference_tracer.points import NOWHERE, Points
from scenes import (
    AreaLight,
    Disk,
    Ellipsoid,
    Lambertian,
    Mesh,
    Pinhole,
    PolarRange,
    Quad,
    Scene,
    Shape,
    Sphere,
    Surface,
)

CAMERA = Pinhole((0.0, 0.0, 9.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0, 4, 4)
TILTED = (0.36, -0.48, 0.8)
RECTANGLE = Quad((-0.6, -0.5, 2.0), (0.0, 1.2, 0.0), (1.5, 0.0, 0.0))  # its front looks down
SLANTED = Quad((-1.0, -0.5, 2.0), (0.0, 1.2, 0.3), (1.5, 0.2, 0.0))
EGG = Ellipsoid((0.3, 0.2, 2.0), (0.7, 0.0, 0.2), (0.1, 0.4, 0.0), (0.0, 0.3, 0.5))


def lamp(
    shape: Shape, radiance: tuple = (1.0,), zone: PolarRange | None = None, two_sided: bool = False
) -> Scene:
    grey = Lambertian((0.5,) * len(radiance))
    return Scene((Surface("lamp", shape, grey, AreaLight(radiance, zone), two_sided),), CAMERA)


def at(x: tuple, n: tuple, count: int, primitive: int = NOWHERE) -> Points:
    columns = (np.tile(np.array(v, dtype=float)[:, None], count) for v in (x, n))
    surface = np.full(count, 0 if primitive >= 0 else NOWHERE)
    return Points(*columns, surface=surface, primitive=np.full(count, primitive))


def gauss(panels: int = 4, order: int = 32) -> tuple[np.ndarray, np.ndarray]:
    """Points of the unit square ``(2, k)`` and their weights, ``panels`` panels along each axis."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    nodes = ((nodes + 1) / 2 + np.arange(panels)[:, None]).ravel() / panels
    weights = np.tile(weights / 2 / panels, panels)
    return np.stack(np.meshgrid(nodes, nodes)).reshape(2, -1), np.outer(weights, weights).ravel()


def contributions(scene: Scene, reference: Points, u: np.ndarray) -> np.ndarray:
    sample = Emitters(scene).sample(reference, u)
    np.testing.assert_allclose((sample.wi**2).sum(axis=0), 1, rtol=1e-12)
    return sample.Li * np.maximum((sample.wi * reference.n).sum(axis=0), 0) / sample.pdf


def irradiance(scene: Scene, x: tuple, n: tuple, primitive: int = NOWHERE) -> np.ndarray:
    """Per channel, by Gauss's rule."""
    u, weights = gauss()
    return contributions(scene, at(x, n, len(weights), primitive), u) @ weights


def batches(scene: Scene, x: tuple, n: tuple, count: int = 2000, primitive: int = NOWHERE) -> np.ndarray:
    """64 means of the first channel over random numbers."""
    u = np.random.default_rng(11).random((2, 64 * count))
    values = contributions(scene, at(x, n, 64 * count, primitive), u)
    return values[0].reshape(64, count).mean(axis=1)


def polygon(corners: np.ndarray, x: tuple, n: tuple) -> float:
    """Irradiance from a polygon of radiance 1 above the horizon (Lambert 1760): ½ Σ βᵢ n · (vᵢ × vᵢ₊₁) / |…|."""
    v = corners - np.array(x)
    v /= np.linalg.norm(v, axis=1)[:, None]
    after = np.roll(v, -1, axis=0)
    cross = np.cross(v, after)
    sine = np.linalg.norm(cross, axis=1)
    angle = np.arctan2(sine, (v * after).sum(axis=1))
    return abs(float((angle / sine * (cross @ np.array(n))).sum())) / 2


def corners_of(quad: Quad) -> np.ndarray:
    c, u, v = (np.array(e) for e in (quad.corner, quad.edge_u, quad.edge_v))
    return np.array([c, c + u, c + u + v, c + v])


def outline(shape: Sphere | Ellipsoid | Disk, x: tuple) -> np.ndarray:
    """What is seen of it from x, as a polygon of 20 000 corners: where y · o = 1 on the unit sphere, from o."""
    phi = 2 * np.pi * np.arange(20_000) / 20_000
    center = np.array(shape.center)
    if isinstance(shape, Disk):
        return center + np.outer(np.cos(phi), shape.axis_u) + np.outer(np.sin(phi), shape.axis_v)
    matrix = shape.matrix if isinstance(shape, Ellipsoid) else shape.radius * np.eye(3)
    o = np.linalg.solve(matrix, np.array(x) - center)
    squared = o @ o
    s = np.cross(o, [0.3, 0.5, 0.7])
    s /= np.linalg.norm(s)
    t = np.cross(o, s) / np.sqrt(squared)
    circle = o / squared + np.sqrt(1 - 1 / squared) * (np.outer(np.cos(phi), s) + np.outer(np.sin(phi), t))
    return center + circle @ matrix.T


# ---- flat shapes


PLACES = [(0.4, -0.3, -1.0), (0.4, 0.3, 0.9), (0.1, 0.1, 1.4), (0.3, 0.0, 1.1), (4e2, 3e2, -1e3)]


def normals_at(quad: Quad, x: tuple) -> list[tuple]:
    """Two normals at x that see all of the quad."""
    away = np.mean(corners_of(quad), axis=0) - x
    normals = [(0.0, 0.0, 1.0), tuple(away / np.linalg.norm(away))]
    assert min(((corners_of(quad) - x) @ np.array(n)).min() for n in normals) > 0
    return normals


@pytest.mark.parametrize("x", PLACES)
def test_a_rectangle(x: tuple) -> None:
    for n in normals_at(RECTANGLE, x):
        expected = np.array([2, 3]) * polygon(corners_of(RECTANGLE), x, n)
        np.testing.assert_allclose(irradiance(lamp(RECTANGLE, (2.0, 3.0)), x, n), expected, rtol=1e-8)


@pytest.mark.parametrize("x", PLACES)
def test_a_parallelogram(x: tuple, expect_means: Callable[..., None]) -> None:
    """Of two triangles, so not smooth: Gauss's rule has an error of its own where they meet."""
    for n in normals_at(SLANTED, x):
        expected = polygon(corners_of(SLANTED), x, n)
        expect_means(batches(lamp(SLANTED), x, n), expected, resolution=0.015)
        np.testing.assert_allclose(irradiance(lamp(SLANTED), x, n), expected, rtol=1e-3)


@pytest.mark.parametrize("h", [1e-3, 1e-6, 1e-10, 1e-14])
@pytest.mark.parametrize("skew", [0.0, 0.3])
def test_a_quad_seen_edge_on(h: float, skew: float) -> None:
    """Beside the quad and almost in its plane, E = h ∫ cos / t³ dA: angles would have lost their digits."""
    quad = Quad((-1.5, -0.6, 0.0), (skew, 1.2, 0.0), (1.2, 0.0, 0.0))
    x, n = (0.4, 0.1, -h), (-1.0, 0.0, 0.0)
    (s, t), weights = gauss()
    y = np.array(quad.corner)[:, None] + np.outer(quad.edge_u, s) + np.outer(quad.edge_v, t)
    segment = y - np.array(x)[:, None]
    expected = h * (-segment[0] / (segment**2).sum(axis=0) ** 2) @ weights * quad.area
    np.testing.assert_allclose(
        irradiance(lamp(quad), x, n), expected, rtol=1e-3 if skew and h == 1e-3 else 1e-6
    )


@pytest.mark.parametrize("z", [1.0, 1.9, 1.99, 1.999])
@pytest.mark.parametrize(("px", "py"), [(0.1, 0.1), (0.9, 0.3), (0.9, 0.7), (1.2, 0.9)])
def test_close_to_a_rectangle(px: float, py: float, z: float) -> None:
    """Below the middle, an edge, a corner, and beside it: no point close by has a large weight.

    The largest contribution may be no more than a few times the irradiance, which by area it would be by far.
    """
    x, n = (px, py, z), (0.0, 0.0, 1.0)
    expected = polygon(corners_of(RECTANGLE), x, n)
    u, weights = gauss()
    values = contributions(lamp(RECTANGLE), at(x, n, len(weights)), u)[0]
    np.testing.assert_allclose(values @ weights, expected, rtol=1e-4)
    if px <= 0.9 and py <= 0.7:
        assert values.max() < 5 * expected


@pytest.mark.parametrize("threshold", [0.0, np.inf], ids=["solid angle", "area"])
def test_both_ways_to_choose_from_a_rectangle_agree(
    threshold: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(area_lights, "LOOKS_LARGE", threshold)
    x, n = (0.4, 0.3, 0.3), (0.0, 0.0, 1.0)
    found = irradiance(lamp(RECTANGLE), x, n)
    np.testing.assert_allclose(found, polygon(corners_of(RECTANGLE), x, n), rtol=1e-9)


def test_a_disk() -> None:
    """π L r² / (r² + d²) from its axis (Howell's B-13), from elsewhere by its outline; a skewed ellipse too."""
    for r, d in ((0.5, 2.0), (1.0, 0.5), (1e-6, 3.0)):
        disk = Disk((0.0, 0.0, d), (0.0, r, 0.0), (r, 0.0, 0.0))
        found = irradiance(lamp(disk, (4.0,)), (0, 0, 0), (0, 0, 1))
        np.testing.assert_allclose(found, 4 * np.pi * r**2 / (r**2 + d**2), rtol=1e-9)
    skewed, x = Disk((0.3, 0.1, 2.0), (0.1, 0.8, 0.0), (1.1, 0.2, 0.1)), (0.4, -0.3, 0.5)
    found = irradiance(lamp(skewed), x, (0, 0, 1))
    np.testing.assert_allclose(found, polygon(outline(skewed, x), x, (0, 0, 1)), rtol=1e-6)


# ---- spheres and ellipsoids


@pytest.mark.parametrize(
    ("distance", "slant"),
    [(1.0001, 0.0), (1.5, 0.0), (1.5, 40.0), (3.0, 40.0), (3.0, 70.0), (1e3, 40.0), (1e6, 40.0), (1e9, 89.0)],
)
def test_a_sphere_from_outside(distance: float, slant: float) -> None:
    """π L (r / d)² cos θ where all of it is above the horizon."""
    r = 0.7
    assert 90 - slant >= np.degrees(np.arcsin(1 / distance))
    n = (np.sin(np.radians(slant)), 0.0, np.cos(np.radians(slant)))
    found = irradiance(lamp(Sphere((0.0, 0.0, r * distance), r), (2.0, 5.0)), (0, 0, 0), n)
    expected = np.pi / distance**2 * n[2]
    np.testing.assert_allclose(found, [2 * expected, 5 * expected], rtol=1e-10)


@pytest.mark.parametrize("inside", [0.0, 0.3, 0.99, 1 - 1e-9])
@pytest.mark.parametrize("two_sided", [False, True])
def test_a_sphere_from_inside(inside: float, two_sided: bool, expect_means: Callable[..., None]) -> None:
    """π L wherever the reference is and wherever it looks."""
    shape = Sphere((1.0, 2.0, 3.0), 0.7, inward=not two_sided)
    x = tuple(np.array(shape.center) + 0.7 * inside * np.array(TILTED))
    expect_means(batches(lamp(shape, two_sided=two_sided), x, (0.0, -0.6, 0.8), 4000), np.pi, resolution=0.02)
    egg = Ellipsoid((1.0, 2.0, 3.0), (0.7, 0.0, 0.1), (0.1, 0.5, 0.0), (0.0, 0.2, 0.9), inward=not two_sided)
    x = tuple(np.array(egg.center) + egg.matrix @ (inside * np.array(TILTED)))
    expect_means(batches(lamp(egg, two_sided=two_sided), x, (0.0, -0.6, 0.8)), np.pi, resolution=0.04)


def test_a_sphere_from_itself() -> None:
    """π L without any noise: what is chosen is proportional to the cosine; on an ellipsoid, near that."""
    shape = Sphere((1.0, 2.0, 3.0), 0.7, inward=True)
    x, n = tuple(np.array(shape.center) + 0.7 * np.array(TILTED)), tuple(-np.array(TILTED))
    values = contributions(lamp(shape, (2.0,)), at(x, n, 1000, 0), np.random.default_rng(1).random((2, 1000)))
    np.testing.assert_allclose(values, 2 * np.pi, rtol=1e-12)
    sample = Emitters(lamp(shape)).sample(at(x, n, 100, 0), np.random.default_rng(2).random((2, 100)))
    there = np.array(x)[:, None] + sample.distance * sample.wi
    np.testing.assert_allclose(np.linalg.norm(there - np.array([[1], [2], [3]]), axis=0), 0.7, rtol=1e-12)
    assert irradiance(lamp(Sphere(shape.center, 0.7)), x, tuple(TILTED), 0) == 0
    egg = msgspec.structs.replace(EGG, inward=True)
    x = tuple(np.array(egg.center) + egg.matrix @ np.array(TILTED))
    n = np.linalg.solve(egg.matrix.T, -np.array(TILTED))
    found = irradiance(lamp(egg, (2.0,)), x, tuple(n / np.linalg.norm(n)), 0)
    np.testing.assert_allclose(found, 2 * np.pi, rtol=1e-9)


@pytest.mark.parametrize("x", [(0.4, -0.3, -1.0), (0.4, 0.3, 0.9), (4e2, 3e2, -1e4)])
def test_an_ellipsoid_from_outside(x: tuple) -> None:
    found = irradiance(lamp(EGG), x, (0, 0, 1))
    np.testing.assert_allclose(found, polygon(outline(EGG, x), x, (0, 0, 1)), rtol=1e-6)


def test_an_ellipsoid_that_is_a_sphere() -> None:
    x, n = (0.4, -0.3, 0.0), (0.0, 0.0, 1.0)
    turned = Ellipsoid((0.3, 0.2, 2.0), (0.3, 0.0, 0.4), (0.0, 0.5, 0.0), (-0.4, 0.0, 0.3))
    sphere = Sphere((0.3, 0.2, 2.0), 0.5)
    np.testing.assert_allclose(irradiance(lamp(turned), x, n), irradiance(lamp(sphere), x, n), rtol=1e-9)


def zone_by_quadrature(shape: Sphere, zone: PolarRange, x: tuple, n: tuple, outer: bool) -> float:
    """∫ cos cos / t² dA over the zone by the midpoint rule, of the side that is seen."""
    cosines = np.linspace(*zone.cosines, 801)
    z, phi = np.meshgrid((cosines[1:] + cosines[:-1]) / 2, 2 * np.pi * (np.arange(800) + 0.5) / 800)
    z, phi = z.ravel(), phi.ravel()
    s = np.cross(zone.axis, [0.3, 0.5, 0.7])
    s /= np.linalg.norm(s)
    frame = np.stack([s, np.cross(zone.axis, s), zone.axis], axis=1)
    r = np.sqrt(1 - z**2)
    outward = frame @ np.stack([r * np.cos(phi), r * np.sin(phi), z])
    segment = np.array(shape.center)[:, None] + shape.radius * outward - np.array(x)[:, None]
    squared = (segment**2).sum(axis=0)
    back = -(outward * segment).sum(axis=0) * (1 if outer else -1)
    cosine = np.maximum((np.array(n) @ segment), 0)
    return float((np.maximum(back, 0) * cosine / squared**2).mean()) * shape.area * zone.fraction


@pytest.mark.parametrize(("low", "high"), [(0, 60), (40, 130), (120, 180)])
def test_a_zone(low: float, high: float, expect_means: Callable[..., None]) -> None:
    zone, center = PolarRange(low, high, (0.6, 0.0, -0.8)), (0.3, 0.2, 2.0)
    ball, cavity = Sphere(center, 0.9), Sphere(center, 0.9, inward=True)
    outside, inside, n = (0.4, -0.3, 0.0), (0.5, -0.2, 1.7), (0.0, 0.6, 0.8)
    for two_sided in (False, True):
        found = batches(lamp(ball, zone=zone, two_sided=two_sided), outside, n, 4000)
        expected = zone_by_quadrature(ball, zone, outside, n, True)
        expect_means(found, expected, resolution=0.04)
        found = batches(lamp(cavity, zone=zone, two_sided=two_sided), inside, n, 4000)
        expect_means(found, zone_by_quadrature(ball, zone, inside, n, False), resolution=0.06)
    # its own surface hides the inner side from outside, and the outer one can't be seen from inside
    assert not irradiance(lamp(cavity, zone=zone), outside, n).any()
    assert not irradiance(lamp(ball, zone=zone), inside, n).any()


def test_a_zone_from_its_own_sphere() -> None:
    """All of it is seen from inside, also where rounding puts the reference outside."""
    rng, zone = np.random.default_rng(8), PolarRange(40, 100, (0.6, 0.0, -0.8))
    shape = Sphere((0.3, 0.2, 2.0), 0.9, inward=True)
    outward = rng.standard_normal((3, 1000))
    outward /= np.linalg.norm(outward, axis=0)
    x = np.array(shape.center)[:, None] + shape.radius * outward
    on = np.zeros(1000, dtype=int)
    reference = Points(x, -outward, surface=on, primitive=on)
    sample = Emitters(lamp(shape, zone=zone)).sample(reference, rng.random((2, 1000)))
    assert sample.Li.all()
    # cos θ = t / 2r at both ends: p = t² / (A cos θ) = cos θ / (π · share of the zone)
    np.testing.assert_allclose(sample.pdf, sample.distance / (2 * 0.9) / (np.pi * zone.fraction), rtol=1e-9)
    np.testing.assert_allclose((sample.wi * -outward).sum(axis=0), sample.distance / (2 * 0.9), atol=1e-9)


# ---- meshes


def test_a_mesh_that_is_a_quad(expect_means: Callable[..., None], off: type[Exception]) -> None:
    quad, count = SLANTED, 5
    grid = np.linspace(0, 1, count + 1) ** 1.5  # triangles of different size
    s, t = (g.ravel() for g in np.meshgrid(grid, grid, indexing="ij"))
    vertices = np.array(quad.corner) + np.outer(s, quad.edge_u) + np.outer(t, quad.edge_v)
    triangles = []
    for i, j in np.ndindex(count, count):
        a = i * (count + 1) + j
        b, c, d = a + count + 1, a + count + 2, a + 1
        triangles += [(a, b, c), (a, c, d)]
    mesh = Mesh(tuple(map(tuple, vertices.tolist())), tuple(triangles))
    x, n = (0.4, -0.3, 0.5), (0.0, 0.0, 1.0)
    found = batches(lamp(mesh), x, n)
    expect_means(found, polygon(corners_of(quad), x, n), resolution=0.02)
    with pytest.raises(off):
        expect_means(1.02 * found, polygon(corners_of(quad), x, n), resolution=0.02)
    turned = Mesh(mesh.vertices, tuple(t[::-1] for t in mesh.triangles))
    assert not batches(lamp(turned), x, n).any()
    expect_means(
        batches(lamp(turned, two_sided=True), x, n), polygon(corners_of(quad), x, n), resolution=0.02
    )


def test_a_convex_mesh(expect_means: Callable[..., None]) -> None:
    """The sum over the triangles that face the reference: a convex mesh hides nothing else."""
    v = (
        (1.0, 0.0, 2.0),
        (-0.8, 0.0, 2.0),
        (0.0, 0.7, 2.0),
        (0.0, -0.9, 2.0),
        (0.1, 0.0, 3.0),
        (0.0, 0.2, 1.2),
    )
    octahedron = Mesh(
        v, ((0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5))
    )
    x, n = (0.4, -0.3, 0.1), (0.0, 0.0, 1.0)
    expected = 0.0
    for a, b, c in octahedron.corners:
        if (x - a) @ np.cross(b - a, c - a) > 0:
            expected += polygon(np.array([a, b, c]), x, n)
    expect_means(batches(lamp(octahedron), x, n, 4000), expected, resolution=0.03)
