"""A point light in a sphere: its direct light is uneven, all that comes after it even and known."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from scenes.case import Case, Formula, Images, Tolerance
from scenes.library.sphere_wall import EQUAL_EXCHANGE, SPHERE_SOURCE, albedo_of, wall_and_camera
from scenes.lights import PointLight
from scenes.materials import Lambertian
from scenes.pixel_average import pixel_average
from scenes.scene import Scene
from scenes.sensor import Pinhole
from scenes.shapes import Sphere
from scenes.surfaces import Surface
from scenes.validation import Vector

Array = NDArray[np.float64]

_SMALLEST = 24  # pixels across an image of 90° for which quadrature settles


def _point(scene: Scene, bounces: int) -> Images:
    """E = 0; TE = (ρ/π) I cos θ / d²; TᵏE = ρᵏ I / πR² from k = 2 on."""
    wall, shape, sensor = wall_and_camera(scene)
    [light] = scene.lights
    assert isinstance(light, PointLight)
    center, place = np.array(shape.center)[:, None], np.array(light.position)[:, None]
    if np.linalg.norm(place - center) >= shape.radius:
        raise ValueError("expected the light inside the sphere")
    rho, intensity = albedo_of(wall), np.asarray(light.intensity)

    def direct(o: Array, d: Array) -> Array:
        b = ((o - center) * d).sum(axis=0)
        t = -b + np.sqrt(b**2 - ((o - center) ** 2).sum(axis=0) + shape.radius**2)
        x = o + t * d
        to_light = place - x
        distance = np.linalg.norm(to_light, axis=0)
        cosine = (to_light * (center - x)).sum(axis=0) / (distance * shape.radius)
        return np.outer(rho / np.pi * intensity, cosine / distance**2)

    images = np.zeros((bounces + 1, *scene.shape))
    if bounces >= 1:
        height, width, channels = scene.shape
        fine = math.ceil(_SMALLEST / min(height, width))  # a large pixel is the mean of small ones inside it
        image = pixel_average(replace(sensor, width=fine * width, height=fine * height), direct)
        images[1] = image.reshape(height, fine, width, fine, channels).mean(axis=(1, 3))
    for k in range(2, bounces + 1):
        images[k] = rho**k * intensity / (np.pi * shape.radius**2)
    return images


_POINT = (
    EQUAL_EXCHANGE
    + """\
A point light of intensity I gives the irradiance I cos θ / d²: TE = (ρ/π) I cos θ / d², and E is 0, since a point
is no surface. All its flux 4πI meets the wall, of area 4πR², so that the mean of the irradiance is I / R², the mean
of TE is ρI / πR², and T²E = ρ² I / πR² everywhere; TᵏE = ρᵏ I / πR² from there on."""
)


def _case(name: str, title: str, scene: Scene, source: str, **texts: Any) -> Case:
    return Case(
        name=name,
        family="point_in_sphere",
        title=title,
        scene=scene,
        answer=Formula(_point, source),
        bounces=5,
        tolerance=Tolerance(image=(0.005,), tile=(0.02,)),
        **texts,
    )


def _lit_by_point(radius: float, albedo: Vector, light: PointLight, sensor: Pinhole) -> Scene:
    wall = Surface("wall", Sphere((0.0, 0.0, 0.0), radius, inward=True), Lambertian(albedo))
    return Scene((wall,), sensor, (light,))


def point_in_sphere() -> Case:
    """A point light off the centre of a sphere: direct light is uneven, all further light even."""
    sensor = Pinhole((0.3, -0.2, -0.4), (-0.1, 0.15, 0.8), (0.1, 1.0, 0.0), 90.0, 64, 64)
    return _case(
        "point-in-sphere",
        "A point light off the centre of a sphere: TE = (ρ/π) I cos θ / d², then TᵏE = ρᵏ I / πR²",
        _lit_by_point(1.0, (0.8, 0.6, 0.4), PointLight((-0.35, 0.3, 0.4), (2.0, 3.0, 5.0)), sensor),
        SPHERE_SOURCE,
        derivation=_POINT,
        blind_to="wrong directions of reflected light, from the second bounce on; E: a point is not seen",
    )


def cie_171_sphere() -> Case:
    """10 000 lm in the middle of a sphere of 96 m², the area of a room of 4 m × 4 m × 4 m."""
    intensity, radius = 10_000 / (4 * math.pi), math.sqrt(96 / (4 * math.pi))
    light = PointLight((0.0, 0.0, 0.0), (intensity, intensity, intensity))
    sensor = Pinhole((0.5, -0.3, 0.4), (-1.0, 0.4, -1.0), (0.0, 1.0, 0.0), 90.0, 64, 64)
    return _case(
        "cie-171-sphere",
        "CIE 171:2006, 5.8, as a sphere: 10 000 lm on 96 m², illuminances sum to (Φ/S) / (1 − ρ)",
        _lit_by_point(radius, (0.8, 0.5, 0.2), light, sensor),
        "CIE 171:2006, test case 5.8, internal reflected component; the series is derived here",
        derivation=_POINT
        + """
The test case gives the indirect illuminance of a room as (Φ/S) ρ / (1 − ρ), which is exact for a sphere and not for
a box, where it is compared with a mean. Here Φ = 4πI and S = 4πR²: radiance TᵏE = (ρᵏ/π) Φ/S, and its illuminances
sum to Φ/S (direct) and (Φ/S) ρ / (1 − ρ) (indirect).""",
        blind_to="wrong directions, of direct light too: every bounce is uniform; E: a point is not seen",
    )


CASES: Mapping[str, Callable[[], Case]] = {
    "point-in-sphere": point_in_sphere,
    "cie-171-sphere": cie_171_sphere,
}
