"""What a sensor sees first: G from the eye alone, in closed form, one ray through each pixel.

A flat shape spans local coordinates, x = c + s u + t v + h (u × v). A ray o + τ d meets its plane at
τ = −h(o) / h(d), and the shape where s and t are those of one of its points. An ellipsoid is the unit sphere in
q = M⁻¹ (x − c), where |q(o) + τ M⁻¹ d|² = 1 is a quadratic equation in τ. The first hit has the least τ > 0 of
all shapes, found by trying every one of them. This shares no code with the tracer.

Each ray starts at the sensor, in empty space: no ray starts on a surface here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenes.scene import Scene
from scenes.sensor import IrradianceMeter, Orthographic, RadianceMeter, Sensor
from scenes.shapes import Disk, Ellipsoid, Mesh, Quad, Shape, Sphere
from scenes.validation import SceneError

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

NOTHING = -1
"""The surface index of a ray that meets none."""

_TRIANGLES = 256  # at a time: arrays of so many times the rays


@dataclass(frozen=True)
class FirstHits:
    """What n rays meet first.

    Attributes:
        distance: along each ray, world units, ``(n,)``; inf where there is nothing.
        normal: unit normals of the front, not of shading, ``(3, n)``; 0 where there is nothing.
        surface: index in the scene, ``(n,)``; NOTHING where there is none.
    """

    distance: Array
    normal: Array
    surface: Indices


def sensor_rays(sensor: Sensor, at: tuple[float, float] = (0.5, 0.5)) -> tuple[Array, Array]:
    """Rays through one point of every pixel, row by row; of a lens those through its centre.

    Args:
        sensor: where they start.
        at: the point, from the top left corner of the pixel, in pixels.

    Returns:
        Origins and unit directions, ``(3, height · width)`` each.

    Raises:
        SceneError: an irradiance meter, whose pixel is no direction.
    """
    if isinstance(sensor, IrradianceMeter):
        raise SceneError("sensor", sensor, "a sensor with a ray for each pixel")
    y, x = np.mgrid[: sensor.height, : sensor.width]
    image = np.stack([x.ravel() + at[0], y.ravel() + at[1], np.ones(x.size)])
    origin = np.tile(np.array(sensor.origin)[:, None], x.size)
    if isinstance(sensor, RadianceMeter):
        return origin, np.array(sensor.direction)[:, None]
    if isinstance(sensor, Orthographic):
        return origin + sensor.pixel_to_offset @ image, np.tile(sensor.frame[:, 2:], x.size)
    d = sensor.pixel_to_direction @ image
    return origin, d / np.linalg.norm(d, axis=0)


def first_hits(scene: Scene, at: tuple[float, float] = (0.5, 0.5)) -> FirstHits:
    """What the rays of the sensor meet first; see ``sensor_rays``."""
    return first_hits_of(scene, *sensor_rays(scene.sensor, at))


def first_hits_of(scene: Scene, origin: Array, d: Array) -> FirstHits:
    """What rays meet first.

    Args:
        scene: its surfaces.
        origin: where they start, on no surface, ``(3, n)``.
        d: unit directions, ``(3, n)``.
    """
    n = origin.shape[1]
    distance, normal, surface = np.full(n, np.inf), np.zeros((3, n)), np.full(n, NOTHING)
    for i, part in enumerate(scene.surfaces):
        tau, front = _meet(part.shape, origin, d)
        nearer = np.flatnonzero(tau < distance)
        distance[nearer], normal[:, nearer], surface[nearer] = tau[nearer], front[:, nearer], i
    return FirstHits(distance, normal, surface)


def _meet(shape: Shape, origin: Array, d: Array) -> tuple[Array, Array]:
    """Distance to a shape, inf for none, ``(n,)``; unit normals of its front there, ``(3, n)``."""
    match shape:
        case Quad():
            return _flat(shape.corner, shape.edge_u, shape.edge_v, _in_square, origin, d)
        case Disk():
            return _flat(shape.center, shape.axis_u, shape.axis_v, _in_circle, origin, d)
        case Mesh():
            return _mesh(shape, origin, d)
        case Sphere():
            matrix = shape.radius * np.eye(3)
            return _ellipsoid(shape.center, matrix, shape.inward, origin, d)
        case Ellipsoid():
            return _ellipsoid(shape.center, shape.matrix, shape.inward, origin, d)


Inside = Callable[[Array, Array], NDArray[np.bool_]]


def _in_square(s: Array, t: Array) -> NDArray[np.bool_]:
    return (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)


def _in_circle(s: Array, t: Array) -> NDArray[np.bool_]:
    return s**2 + t**2 <= 1


def _in_triangle(s: Array, t: Array) -> NDArray[np.bool_]:
    return (s >= 0) & (t >= 0) & (s + t <= 1)


def _flat(
    start: object, u: object, v: object, inside: Inside, origin: Array, d: Array
) -> tuple[Array, Array]:
    start, u, v = (np.asarray(a, dtype=float)[None] for a in (start, u, v))
    tau, n = _flats(start, u, v, inside, origin, d)
    return tau[0], np.tile(n.T, origin.shape[1])


def _flats(start: Array, u: Array, v: Array, inside: Inside, origin: Array, d: Array) -> tuple[Array, Array]:
    """Distances to m flat shapes, ``(m, n)``, and their unit normals, ``(m, 3)``; all arguments ``(m, 3)``."""
    across = np.cross(u, v)
    local = np.linalg.inv(np.stack([u, v, across], axis=-1))
    so, to, ho = np.moveaxis(local @ (origin[None] - start[..., None]), 1, 0)
    sd, td, hd = np.moveaxis(local @ d[None], 1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):  # rays along the plane: no distance
        tau = -ho / hd
        met = (tau > 0) & np.isfinite(tau) & inside(so + tau * sd, to + tau * td)
    return np.where(met, tau, np.inf), across / np.linalg.norm(across, axis=1, keepdims=True)


def _mesh(mesh: Mesh, origin: Array, d: Array) -> tuple[Array, Array]:
    n = origin.shape[1]
    nearest, normal = np.full(n, np.inf), np.zeros((3, n))
    corners = mesh.corners
    for first in range(0, len(corners), _TRIANGLES):
        a, b, c = np.moveaxis(corners[first : first + _TRIANGLES], 1, 0)
        tau, fronts = _flats(a, b - a, c - a, _in_triangle, origin, d)
        which, least = tau.argmin(axis=0), tau.min(axis=0)
        nearer = np.flatnonzero(least < nearest)
        nearest[nearer], normal[:, nearer] = least[nearer], fronts[which[nearer]].T
    return nearest, normal


def _ellipsoid(center: object, matrix: Array, inward: bool, origin: Array, d: Array) -> tuple[Array, Array]:
    local = np.linalg.inv(matrix)
    q, w = local @ (origin - np.asarray(center, dtype=float)[:, None]), local @ d
    # |q + τ w|² = 1: a τ² + 2 b τ + c = 0
    a, b, c = (w * w).sum(axis=0), (q * w).sum(axis=0), (q * q).sum(axis=0) - 1
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b**2 - a * c)  # NaN: the ray passes by
        # of the two solutions, the one that is no difference of like numbers, and the other one from their product
        large = -(b + np.where(b < 0, -root, root))
        near, far = np.sort([large / a, c / large], axis=0)
        tau = np.where(near > 0, near, far)
        tau = np.where(tau > 0, tau, np.inf)
    hit = np.where(np.isfinite(tau), tau, 0.0)
    normal = local.T @ (q + hit * w) * (-1 if inward else 1)
    return tau, normal / np.linalg.norm(normal, axis=0)
