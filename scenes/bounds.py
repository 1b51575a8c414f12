"""How far shapes and scenes reach."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenes.scene import Scene
from scenes.shapes import Disk, Ellipsoid, Mesh, Quad, Shape, Sphere

Array = NDArray[np.float64]


def least(shape: Shape, n: Array) -> float:
    """The least n · x of all points x of the shape; n is ``(3,)``."""
    match shape:
        case Quad():
            u, v = np.dot(n, shape.edge_u), np.dot(n, shape.edge_v)
            return float(np.dot(n, shape.corner) + min(u, 0) + min(v, 0))
        case Disk():
            return float(np.dot(n, shape.center) - np.hypot(np.dot(n, shape.axis_u), np.dot(n, shape.axis_v)))
        case Sphere():
            return float(np.dot(n, shape.center) - shape.radius * np.linalg.norm(n))
        case Ellipsoid():
            return float(np.dot(n, shape.center) - np.linalg.norm(shape.matrix.T @ n))
        case Mesh():
            return float((np.array(shape.vertices) @ n).min())


def bounds(shape: Shape) -> Array:
    """Least and largest x, y, z, ``(2, 3)``."""
    return np.array([[least(shape, n) for n in np.eye(3)], [-least(shape, -n) for n in np.eye(3)]])


def extent(scene: Scene) -> float:
    """The largest coordinate of the surfaces, by its absolute value; 1 without surfaces."""
    return max((float(np.abs(bounds(surface.shape)).max()) for surface in scene.surfaces), default=1.0)


def farthest(scene: Scene) -> float:
    """A distance from the sensor's origin beyond which there is no surface; 0 without surfaces."""
    origin = np.asarray(scene.sensor.origin)
    reach = [np.abs(bounds(surface.shape) - origin).max(axis=0) for surface in scene.surfaces]
    return max((float(np.linalg.norm(corner)) for corner in reach), default=0.0)
