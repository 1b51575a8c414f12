"""Ours and Mitsuba's along single rays, and the shapes that they meet.

Where nothing is random, single rays are: an emitter, a lit surface, a mirror. Their values agree to the single
precision that Mitsuba computes in, at dozens of random places, so a convention that differs anywhere shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.renderers.mitsuba import MitsubaRenderer
from reference_tracer.random_walk import render
from scenes import (
    AreaLight,
    Disk,
    Image,
    Lambertian,
    Light,
    Mesh,
    Quad,
    RadianceMeter,
    Scene,
    Shape,
    Sphere,
    Surface,
)

Array = NDArray[np.float64]
GREY = Lambertian((0.5, 0.25, 0.75))
LAMP = AreaLight((1.0, 2.0, 4.0))


def image(rows: int, columns: int, high: float = 1.0) -> Image:
    pixels = np.random.default_rng(rows * columns).uniform(0.1, high, (rows, columns, 3))
    return Image(tuple(tuple(tuple(pixel) for pixel in row) for row in pixels.tolist()))


def rotated(mirrored: bool = False) -> Any:
    """Three orthonormal axes, none of them along the world's."""
    axes = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    axes[0] *= np.linalg.det(axes) * (-1 if mirrored else 1)
    return tuple(map(tuple, axes.tolist()))


def sphere_points(count: int, seed: int = 0) -> Array:
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1)[:, None]


def around(shape: Shape, count: int) -> Array:
    """Directions from a shape to viewers: all of them.

    With shading normals only those well away from the horizon, on either side. Where the two normals disagree about
    the side Mitsuba differs: docs/findings/mitsuba-shading-normals.md.
    """
    d = sphere_points(count)
    if not (isinstance(shape, Mesh) and shape.normals):
        return d
    d = np.array([0.0, 0.0, 1.0]) + 0.35 * d
    return d * np.where(np.arange(count) % 2, 1.0, -1.0)[:, None]


Rays = Sequence[tuple[Array, Array]]


def rays_to(targets: Array, origins: Array) -> Rays:
    return [(o, t - o) for o, t in zip(origins, targets, strict=True)]


def along(
    mitsuba: MitsubaRenderer, surfaces: Sequence[Surface], lights: Sequence[Light], rays: Rays, bounces: int
) -> tuple[Array, Array]:
    """Ours and theirs along rays, ``(rays, bounces + 1, 3)``: one path each."""
    ours, theirs = [], []
    for origin, direction in rays:
        view = Scene(tuple(surfaces), RadianceMeter(tuple(origin), tuple(direction)), tuple(lights))
        ours.append(render(view, bounces, 1, 0)[:, 0, 0])
        theirs.append(mitsuba.render(view, range(bounces + 1), 1, 0)[:, 0, 0])
    return np.array(ours), np.array(theirs)


def assert_same(
    mitsuba: MitsubaRenderer,
    surfaces: Sequence[Surface],
    lights: Sequence[Light],
    rays: Rays,
    bounces: int = 1,
    rtol: float = 2e-5,
) -> Array:
    """No random number matters along these rays, and the values are the same. Returns them."""
    ours, theirs = along(mitsuba, surfaces, lights, rays, bounces)
    assert len(np.unique(ours.round(6), axis=0)) > 1, "the same everywhere: nothing is tried"
    np.testing.assert_allclose(theirs, ours, rtol=rtol, atol=1e-6 * ours.max())
    return ours


# ---- shapes

U, V, CORNER = np.array([0.9, 0.1, 0.2]), np.array([-0.22, 1.1, 0.44]), np.array([-0.4, -0.5, 0.1])
RADIUS = np.linalg.norm(U) / np.linalg.norm(V)
QUAD = Quad(tuple(CORNER), tuple(U), tuple(V))
DISK = Disk((0.1, 0.2, 0.3), tuple(U), tuple(RADIUS * V))
BALL = Sphere((0.1, -0.2, 0.3), 0.8)
# two triangles that share an edge, bent along it; texture coordinates beyond [0, 1] on every side
MESH = Mesh(
    ((-0.5, -0.6, 0.0), (0.6, -0.5, 0.1), (0.5, 0.6, 0.0), (-0.6, 0.5, 0.4)),
    ((0, 1, 2), (0, 2, 3)),
    uv=((-0.3, -0.2), (1.2, 0.1), (1.3, 1.4), (0.1, 1.2)),
)
SMOOTH = Mesh(
    MESH.vertices, MESH.triangles, normals=((-0.2, -0.1, 1.0), (0.2, -0.1, 1), (0.2, 0.3, 1), (0, 0.1, 1))
)


def points_on(shape: Shape, count: int, seed: int = 1) -> Array:
    s, t = np.random.default_rng(seed).random((2, count, 1))
    match shape:
        case Quad():
            return np.array(shape.corner) + s * np.array(shape.edge_u) + t * np.array(shape.edge_v)
        case Disk():
            r, phi = np.sqrt(s), 2 * np.pi * t
            u, v = np.array(shape.axis_u), np.array(shape.axis_v)
            return np.array(shape.center) + r * np.cos(phi) * u + r * np.sin(phi) * v
        case Sphere():
            return np.array(shape.center) + shape.radius * sphere_points(count, seed)
        case Mesh():
            a, b, c = shape.corners[np.arange(count) % len(shape.triangles)].transpose(1, 0, 2)
            s, t = np.where(s + t > 1, 1 - s, s), np.where(s + t > 1, 1 - t, t)
            return a + s * (b - a) + t * (c - a)
    raise AssertionError(shape)


SHAPES: dict[str, Shape] = {
    "quad": QUAD,
    "parallelogram": Quad(tuple(CORNER), tuple(U), tuple(V + 0.4 * U)),
    "disk": DISK,
    "ellipse": Disk(DISK.center, tuple(U), tuple(0.6 * V + 0.3 * U)),
    "sphere": BALL,
    "mesh": MESH,
    "smooth mesh": SMOOTH,
}

FLOOR = Surface("floor", Quad((-3.0, -3.0, 0.0), (6.0, 0.0, 0.0), (0.0, 6.0, 0.0)), GREY)
