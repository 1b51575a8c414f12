"""A hierarchy meets what its shapes meet, one by one; a closed mesh lets nothing out."""

from __future__ import annotations

import numpy as np
import pytest

from reference_tracer.points import NOWHERE, Points
from reference_tracer.propagation import RayCaster
from reference_tracer.shapes.hierarchy import LEAF, Hierarchy
from reference_tracer.shapes.intersection import Flats, triangle_excess
from scenes import AreaLight, Lambertian, Mesh, Pinhole, Scene, Sphere, Surface

CAMERA = Pinhole((0.0, 0.0, 0.1), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), 40.0, 4, 4)


def triangles(count: int, seed: int = 1, size: float = 0.3) -> tuple[np.ndarray, np.ndarray]:
    """First corners ``(count, 3)`` and axes ``(count, 3, 3)``."""
    rng = np.random.default_rng(seed)
    u, v = rng.uniform(-size, size, (2, count, 3))
    n = np.cross(u, v)
    axes = np.stack([u, v, n / np.linalg.norm(n, axis=1, keepdims=True)], axis=1)
    return rng.uniform(-1, 1, (count, 3)), axes


@pytest.mark.parametrize("count", [1, LEAF, LEAF + 1, 200, 3000])
def test_as_without_it(count: int) -> None:
    centers, axes = triangles(count)

    def leaf(some: np.ndarray) -> Flats:
        return Flats(centers[some], axes[some], triangle_excess, some)

    corners = centers[:, None] + np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]) @ axes
    tree = Hierarchy(corners.min(axis=1), corners.max(axis=1), leaf)
    rng, n = np.random.default_rng(2), 2000
    x = rng.uniform(-2, 2, (3, n))
    d = rng.uniform(-1, 1, (3, n)) - x
    d /= np.linalg.norm(d, axis=0)
    d[:, :3] = np.eye(3)  # along the sides of the boxes, too
    start = np.where(np.arange(n) % 2, rng.integers(count, size=n), NOWHERE)
    found = []
    for shapes in (tree, leaf(np.arange(count))):
        t, primitive = np.full(n, np.inf), np.full(n, NOWHERE)
        with np.errstate(all="ignore"):
            shapes.meet(x, d, start, t, primitive)
        found.append((t, primitive))
    np.testing.assert_array_equal(found[0][1], found[1][1])
    np.testing.assert_array_equal(found[0][0], found[1][0])
    assert np.count_nonzero(found[0][1] >= 0) > (0 if count < 200 else 200)


def test_many_balls_as_one_by_one() -> None:
    """From space, and from points on balls and within them; nearest first, told by an independent formula."""
    rng, n = np.random.default_rng(3), 3000
    centers, radii = rng.uniform(-1, 1, (LEAF * 8, 3)), rng.uniform(0.01, 0.2, LEAF * 8)
    balls = [
        Surface(f"{i}", Sphere(c.tolist(), float(r)), Lambertian((0.5,)), AreaLight((1.0,)))
        for i, (c, r) in enumerate(zip(centers, radii, strict=True))
    ]
    caster = RayCaster(Scene(tuple(balls), CAMERA))
    assert isinstance(caster._all[0], Hierarchy)
    at = Points.nowhere(rng.uniform(-1, 1, (3, n)))
    for _ in range(3):
        d = rng.standard_normal((3, n))
        d /= np.linalg.norm(d, axis=0)
        met = caster(at, d)
        # |x + t d − c|² = r², all rays by all balls
        offset = at.x.T[:, None] - centers
        b, c = np.einsum("nsi,in->ns", offset, d), (offset**2).sum(axis=2) - radii**2
        c[np.arange(n), at.primitive] = np.where(at.primitive >= 0, 0, c[np.arange(n), at.primitive])
        root = np.sqrt(np.where(b * b > c, b * b - c, np.nan))
        t = np.where(-b - root > 1e-12, -b - root, -b + root)
        t = np.where(t > 1e-12, t, np.inf)
        np.testing.assert_array_equal(
            met.primitive, np.where(np.isfinite(t).any(axis=1), t.argmin(axis=1), NOWHERE)
        )
        assert np.count_nonzero(met.primitive >= 0) > n / 10
        at = met[np.flatnonzero(met.primitive >= 0)]
        n = len(at)


def ball(bands: int) -> Mesh:
    """A closed ball of triangles, its fronts inside."""
    theta, phi = np.linspace(0, np.pi, bands + 1)[1:-1], 2 * np.pi * np.arange(2 * bands) / (2 * bands)
    rings = [
        np.stack([np.sin(t) * np.cos(phi), np.sin(t) * np.sin(phi), np.full_like(phi, np.cos(t))], 1)
        for t in theta
    ]
    vertices = np.concatenate([[[0, 0, 1]], *rings, [[0, 0, -1]]])
    n, last, faces = 2 * bands, 1 + 2 * bands * (bands - 1), []
    for i in range(n):
        j = (i + 1) % n
        faces += [(0, 1 + j, 1 + i), (last, last - n + i, last - n + j)]
        for ring in range(bands - 2):
            a, b, c, d = (1 + n * r + k for r in (ring, ring + 1) for k in (i, j))
            faces += [(a, b, c), (b, d, c)]
    return Mesh(tuple(map(tuple, vertices.tolist())), tuple(faces))


def test_nothing_slips_out_of_a_closed_mesh() -> None:
    """2,000 walks of 10 legs in a ball of 2,208 triangles, wherever they start."""
    mesh = ball(24)
    assert len(mesh.triangles) == 2208
    scene = Scene((Surface("ball", mesh, Lambertian((0.5,)), AreaLight((1.0,))),), CAMERA)
    rng, caster, n = np.random.default_rng(5), RayCaster(scene), 2000
    at, d = Points.nowhere(np.zeros((3, n))), rng.standard_normal((3, n))
    for _ in range(10):
        d /= np.linalg.norm(d, axis=0)
        at = caster(at, d)
        assert (at.surface == 0).all()
        assert ((at.n * d).sum(axis=0) < 0).all()
        d = at.n + 0.999 * d / 2 + 0.4 * rng.standard_normal((3, n))
        d *= np.where((at.n * d).sum(axis=0) > 0, 1, -1)
