"""Shapes as triangles, all that OpenGL draws.

Quads and meshes are triangles. A disk is a polygon of the same area. A sphere is a cube, each of its faces divided
into n × n cells, equal in angle, and each corner moved to the sphere: flat cells lie inside it, by π² / 16 n² of the
radius in the middle of a face and less at its corners. Moving the corners out by half of that leaves ± half of it.

How much is left may change distances, or the place where an outline appears in the image. So n follows from both: the
deviation is at most 2.5·10⁻⁵ of the distance to the shape, and a four-hundredth of a pixel, seen from the sensor.
A ray that meets the shape at an angle finds it early or late by the deviation divided by the cosine; seen at an
angle, so many pixels are as many times further.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from comparisons.renderers.opengl_view import View
from comparisons.renderers.protocol import Unsupported
from scenes import Disk, Ellipsoid, Mesh, Quad, Sphere, Surface
from scenes.bounds import least

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

OF_DISTANCE = 2.5e-5
OF_PIXEL = 2.5e-3
CORNERS_OF_DISK = 4096
"""Its outline is off by π² / 6 of the inverse of their square, 10⁻⁷ of the radius, at most."""

_MOST_CELLS = 512
"""Along the edge of a face of the cube: 3 million triangles."""


class Triangles(NamedTuple):
    """Corners in world coordinates, ``(n, 3)``, and three indices each, counterclockwise on the front, ``(m, 3)``."""

    corners: Array
    indices: Indices


def triangles(surface: Surface, view: View) -> Triangles:
    """The shape of a surface, as fine as the view needs it.

    Raises:
        Unsupported: it is round and so near the sensor that it would take too many.
    """
    match surface.shape:
        case Quad(corner, u, v):
            corners = np.array(corner) + np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) @ np.array([u, v])
            return Triangles(corners, np.array([[0, 1, 2], [0, 2, 3]]))
        case Mesh() as mesh:
            return Triangles(np.array(mesh.vertices), np.array(mesh.triangles))
        case Disk() as disk:
            return _disk(disk)
        case Sphere() as sphere:
            radii = sphere.radius * np.eye(3)
            return _ellipsoid(surface, np.array(sphere.center), radii, sphere.inward, view)
        case Ellipsoid() as ellipsoid:
            return _ellipsoid(surface, np.array(ellipsoid.center), ellipsoid.matrix, ellipsoid.inward, view)


def _disk(disk: Disk) -> Triangles:
    n = CORNERS_OF_DISK
    angle = 2 * math.pi / n * np.arange(n)
    radius = math.sqrt(2 * math.pi / n / math.sin(2 * math.pi / n))  # of the polygon with the circle's area
    around = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1) @ np.array([disk.axis_u, disk.axis_v])
    rim = np.arange(n)
    fan = np.stack([np.full(n, n), rim, (rim + 1) % n], axis=1)
    return Triangles(np.array(disk.center) + np.concatenate([around, np.zeros((1, 3))]), fan)


def _ellipsoid(surface: Surface, center: Array, matrix: Array, inward: bool, view: View) -> Triangles:
    cells = _cells(surface, center, matrix, view)
    points, indices = sphere(cells)
    if inward != (np.linalg.det(matrix) < 0):
        indices = indices[:, ::-1]
    return Triangles(center + points @ matrix.T, indices)


def _cells(surface: Surface, center: Array, matrix: Array, view: View) -> int:
    """How many cells along the edge of a face of the cube keep the deviation as small as the view needs it."""
    stretch = np.linalg.svd(matrix, compute_uv=False)
    if view.parallel:
        forward = view.frame[:, 2]
        nearest = least(surface.shape, forward) - float(forward @ view.origin)
        pixel = view.smallest_pixel
    else:
        local = np.linalg.solve(matrix, view.origin - center)
        nearest = float(stretch[-1]) * abs(float(np.linalg.norm(local)) - 1)
        pixel = nearest * view.smallest_pixel
    allowed = min(OF_DISTANCE * nearest, OF_PIXEL * pixel) / float(stretch[0])
    cells = math.ceil(math.pi / math.sqrt(32 * allowed)) if allowed > 0 else _MOST_CELLS + 1
    if cells > _MOST_CELLS:
        kind = surface.shape.__struct_config__.tag
        raise Unsupported(
            f"{kind} {surface.name} so near the sensor, or in so many pixels: of triangles, more than "
            f"{12 * _MOST_CELLS**2 / 1e6:.0f} million would be needed"
        )
    return cells


@lru_cache(maxsize=4)
def sphere(cells: int) -> Triangles:
    """The unit sphere around 0, off by ± π² / 32 cells² at most."""
    s, t = np.mgrid[: cells + 1, : cells + 1]
    faces = []
    for axis in range(3):
        for end in (0, cells):
            face = np.empty((cells + 1, cells + 1, 3), dtype=np.intp)
            face[..., axis] = end
            # (axis, axis + 1, axis + 2) are right-handed, so s × t looks along +axis
            face[..., (axis + 1) % 3], face[..., (axis + 2) % 3] = (s, t) if end else (t, s)
            faces.append(face)
    # faces share the points of their edges, and not only nearly, or rays would slip through
    keys = np.stack(faces) @ np.array([(cells + 1) ** 2, cells + 1, 1])
    found, index = np.unique(keys, return_inverse=True)
    index = index.reshape(keys.shape)
    lattice = np.stack(
        [found // (cells + 1) ** 2, found // (cells + 1) % (cells + 1), found % (cells + 1)], axis=1
    )
    points = np.tan(math.pi / 4 * (2 * lattice / cells - 1))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    points *= 1 + math.pi**2 / 32 / cells**2
    a, b, c, d = index[:, :-1, :-1], index[:, 1:, :-1], index[:, 1:, 1:], index[:, :-1, 1:]
    # towards the corners of the cube cells are rhombi, and cut along the longer diagonal they would lie deeper
    longer = (
        np.linalg.norm(points[a] - points[c], axis=-1) > np.linalg.norm(points[b] - points[d], axis=-1)
    )[..., None]
    one = np.where(longer, np.stack([a, b, d], axis=-1), np.stack([a, b, c], axis=-1))
    two = np.where(longer, np.stack([b, c, d], axis=-1), np.stack([a, c, d], axis=-1))
    return Triangles(points, np.stack([one, two]).reshape(-1, 3))
