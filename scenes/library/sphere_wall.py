"""What the cases inside a sphere share: why every element of its wall lights every other one equally."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from scenes.materials import Lambertian
from scenes.scene import Scene
from scenes.sensor import Pinhole
from scenes.shapes import Sphere
from scenes.surfaces import Surface

Array = NDArray[np.float64]

EQUAL_EXCHANGE = """\
Between two points x, y of a sphere of radius r the angle to either normal is the same and |x − y| = 2r cos θ,
so cos θ cos θ′ / |x − y|² = 1 / 4r²: every element of the wall lights every other one equally, wherever it is,
and a zone that covers the share f of the sphere and has the radiance b gives the irradiance π f b everywhere.
"""

SPHERE_SOURCE = "Walsh 1920; Goebel 1967, Appl. Opt. 6(1):125; a cap's share is (1 − cos θ) / 2, Archimedes"


def wall_and_camera(scene: Scene) -> tuple[Surface, Sphere, Pinhole]:
    """The cavity, its shape, and the camera in it.

    Raises:
        ValueError: the first surface is no cavity, or the camera is not in it.
    """
    wall, sensor = scene.surfaces[0], scene.sensor
    assert isinstance(wall.shape, Sphere)
    assert isinstance(sensor, Pinhole)
    if not wall.shape.inward or math.dist(sensor.origin, wall.shape.center) >= wall.shape.radius:
        raise ValueError("expected a sphere whose front is its inside, and the camera in it")
    return wall, wall.shape, sensor


def albedo_of(surface: Surface) -> Array:
    """Of a Lambertian surface without a texture, ``(channels,)``."""
    assert isinstance(surface.material, Lambertian)
    assert isinstance(surface.material.albedo, tuple)
    return np.asarray(surface.material.albedo)


def radiance_of(surface: Surface) -> Array:
    """What a surface emits, 0 if nothing, ``(channels,)``."""
    return np.asarray(
        surface.emission.diffuse_radiance if surface.emission else np.zeros(surface.channels or 0)
    )
