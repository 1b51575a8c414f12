"""Direct light of what is no surface: points, spots, parallel light, environments. One bounce in closed form.

As in ``direct_light`` the first surface of each scene is a receiver that does not light itself, and all that is in
view.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from scenes.affine import Affine
from scenes.case import Case, Images
from scenes.cone_average import average_across_cone
from scenes.images import Image
from scenes.irradiance_of_lights import irradiance_by_light
from scenes.library.direct_light import BLACK, direct_case, direct_light, floor, hit, view
from scenes.lights import (
    DirectionalLight,
    EnvironmentMap,
    Light,
    PointLight,
    SphericalHarmonicsEnvironment,
    SpotLight,
)
from scenes.materials import Lambertian
from scenes.scene import Scene
from scenes.sensor import Pinhole
from scenes.shapes import Disk, Quad, Sphere
from scenes.surfaces import Surface

Array = NDArray[np.float64]

_LAMBERT = "Lambert 1760, Photometria: the inverse square law and the cosine law"
_POINT = "A point of intensity I at distance d gives the irradiance I cos θ / d²."
_BALL = Surface("ball", Sphere((0.3, -0.2, 0.1), 1.0), Lambertian((0.8, 0.5, 0.3)))
_BLIND_TO = "lights of finite size, and indirect light"


def _case(
    name: str,
    title: str,
    receiver: Surface,
    lights: tuple[Light, ...],
    sensor: Pinhole,
    derivation: str,
    source: str,
    blind_to: str = _BLIND_TO,
    *,
    others: tuple[Surface, ...] = (),
    evaluate: Callable[[Scene, int], Images] = direct_light,
) -> Case:
    return direct_case(
        name,
        title,
        (receiver, *others),
        derivation,
        source,
        family="direct_light_of_lights",
        sensor=sensor,
        lights=lights,
        evaluate=evaluate,
        blind_to=blind_to,
    )


def point_over_plane() -> Case:
    """One point, out of view."""
    light = PointLight((-0.5, 1.1, -0.4), (5.0, 8.0, 12.0))
    title = "A point over a floor: I cos θ / d²"
    return _case("point-over-plane", title, floor(), (light,), view(fov=24.0), _POINT, _LAMBERT)


def _shadow_of_a_disk(scene: Scene, bounces: int) -> Images:
    """The point's light outside the shadow, 0 inside; each pixel's average across its rim."""
    receiver, disk = scene.surfaces
    [light], sensor = scene.lights, scene.sensor
    assert isinstance(light, PointLight)
    assert isinstance(sensor, Pinhole)
    assert isinstance(receiver.shape, Quad)
    assert isinstance(receiver.material, Lambertian)
    assert isinstance(disk.shape, Disk)
    albedo = np.reshape(np.array(receiver.material.albedo), (3, 1))
    cone, axis = _cone_of_the_shadow(np.array(light.position), disk.shape, receiver.shape, sensor)

    def radiance(o: Array, d: Array) -> Array:
        x, n = hit(receiver.shape, o, d)
        lit = (d * (cone @ d)).sum(axis=0) < 0
        image: Array = albedo / np.pi * irradiance_by_light(light, x, n) * lit
        return image

    images = np.zeros((bounces + 1, *scene.shape))
    if bounces:
        images[1] = average_across_cone(sensor, radiance, cone, axis)
    return images


def _cone_of_the_shadow(p: Array, disk: Disk, floor: Quad, sensor: Pinhole) -> tuple[Array, Array]:
    """The cone Q of rays of the camera, dᵀQd > 0, that meet a disk's shadow by a point, and a direction inside."""
    o, c, m = np.array(sensor.origin), np.array(disk.center), floor.normal
    height = m @ (np.array(floor.corner) - o)
    to_disk = np.linalg.inv(np.stack([disk.axis_u, disk.axis_v, disk.normal], axis=1))
    # x − p = Wd / m·d for the point x of the floor, and p + t (x − p) is in the disk's plane where (a, b, 0) is
    W = to_disk @ (np.outer(o - p, m) + height * np.eye(3))
    g = to_disk @ (p - c)
    a, b = g[0] * W[2] - g[2] * W[0], g[1] * W[2] - g[2] * W[1]
    middle = p + (c - p) * (m @ (np.array(floor.corner) - p)) / (m @ (c - p))
    return np.outer(W[2], W[2]) - np.outer(a, a) - np.outer(b, b), middle - o


def disk_shadow() -> Case:
    """A point, and a black disk that stands in its light."""
    disk = Disk((-0.24, 0.75, -0.15), (0.1, 0.05, 0.1), (0.05, 0.1, -0.1))
    return _case(
        "disk-shadow",
        "The shadow of a disk in the light of a point: I cos θ / d² outside of an ellipse",
        floor(),
        (PointLight((-0.8, 1.5, -0.5), (9.0, 6.0, 12.0)),),
        view(),
        f"""\
{_POINT} A point of the floor is lit unless the segment to the light meets the disk. With a, b the coordinates on the
disk of where the line meets its plane, in units of its radii, that is where a² + b² < 1. Seen from the camera these
rays d are an elliptic cone dᵀQd > 0: light, disk and floor are related by projections, which take conics to conics.
The mean of a pixel is a quadrature in pieces that end at the rim of the cone. The disk turns its back to the floor,
and casts the shadow that its front would.""",
        f"{_LAMBERT}; the rest is projective geometry",
        blind_to="half shadows, and indirect light",
        others=(Surface("disk", disk, BLACK),),
        evaluate=_shadow_of_a_disk,
    )


def four_points() -> Case:
    """Four points of different colours, of which one is below the floor."""
    lights = (
        PointLight((-0.9, 1.2, 0.5), (12.0, 1.0, 2.0)),
        PointLight((0.2, 0.9, -1.1), (1.0, 8.0, 3.0)),
        PointLight((-0.4, 2.0, -0.3), (0.5, 2.0, 30.0)),
        PointLight((0.4, -0.5, 0.2), (12.0, 9.0, 15.0)),
    )
    return _case(
        "four-points",
        "Four points of different colours, one of them below the floor",
        floor(),
        lights,
        view(fov=24.0),
        f"{_POINT} Irradiance is additive. The fourth point is behind the floor and gives nothing.",
        _LAMBERT,
    )


def spot_falloff() -> Case:
    """A spot whose fall-off fills the image."""
    light = SpotLight((-0.35, 1.5, -0.3), (0.35, -1.0, 0.2), (14.0, 9.0, 11.0), cutoff=35.0, beam=3.0)
    return _case(
        "spot-falloff",
        "A slanted spot whose fall-off fills the image",
        floor(),
        (light,),
        view(target=(0.75, 0.0, 0.6), fov=10.0),
        f"{_POINT} Between beam and cutoff I falls linearly with the angle from the axis.",
        f"{_LAMBERT}; the fall-off is the scene's own definition",
        blind_to="where the cone ends: the whole image lies between beam and cutoff; indirect light",
    )


def spot_beam() -> Case:
    """A spot of constant intensity over the image."""
    light = SpotLight((-0.35, 1.5, -0.3), (0.45, -1.0, 0.3), (14.0, 9.0, 11.0), cutoff=50.0, beam=45.0)
    return _case(
        "spot-beam",
        "A slanted spot whose full beam fills the image",
        floor(),
        (light,),
        view(target=(0.75, 0.0, 0.6), fov=10.0),
        f"{_POINT} Within the beam a spot is a point.",
        _LAMBERT,
        blind_to="the fall-off of the spot, which is out of view; indirect light",
    )


def directional_on_sphere() -> Case:
    """Parallel light on a ball, seen from the lit side."""
    light = DirectionalLight((-0.6, -0.9, -0.5), (3.0, 5.0, 7.0))
    return _case(
        "directional-on-sphere",
        "Parallel light on a ball: E cos θ",
        _BALL,
        (light,),
        Pinhole((1.2, 1.6, 4.0), (0.45, 0.0, 0.3), (0.0, 1.0, 0.0), 12.0, 64, 64),
        "Parallel light of irradiance E across its direction gives E cos θ, θ from the normal of the ball.",
        _LAMBERT,
        blind_to="the terminator: only the lit side is in view; indirect light",
    )


def bright_texel() -> Case:
    """One bright texel in a turned map of 16 × 32."""
    pixels = np.zeros((16, 32, 3))
    pixels[4, 7] = 90.0, 60.0, 120.0
    axes = Affine.rotation((1.0, 2.0, 0.5), 20.0).linear
    return _case(
        "bright-texel",
        "One bright texel of an environment map on a ball",
        _BALL,
        (EnvironmentMap(Image(pixels), axes),),  # type: ignore[arg-type]
        Pinhole((1.6, 3.8, 3.3), (0.35, 0.2, 0.45), (0.4, 1.0, 0.0), 10.0, 64, 64),
        """\
Between the centres of texels the map is bilinear in θ and φ, so that one texel gives a pyramid: L h(θ) h(φ) with two
hat functions. It is above the horizon of every point in view, so the irradiance is n·v with v = ∫ L h(θ) h(φ) l dl,
l dl = (sin² θ cos φ, sin² θ sin φ, sin θ cos θ) dθ dφ: products of integrals of a hat times a cosine, all
elementary.""",
        "Lambert 1760 (the cosine law), integrated over the bilinear map",
        blind_to="the black rest of the map, the seam and the poles; indirect light",
    )


def spherical_harmonics_on_sphere() -> Case:
    """Degrees 0 to 3; what degree 3 brings to radiance, irradiance does not see."""
    rng = np.random.default_rng(171)
    coefficients = np.round(rng.uniform(-0.12, 0.12, (16, 3)), 3)
    coefficients[0] = math.sqrt(4 * math.pi) * np.array([0.8, 0.6, 0.7])
    coefficients[1:4] += [[0.5, 0.1, 0.2], [-0.2, 0.3, 0.1], [0.1, -0.1, 0.4]]
    axes = Affine.rotation((0.5, 1.0, 2.0), 65.0).linear
    return _case(
        "harmonics-on-sphere",
        "Spherical harmonics of degrees 0 to 3 on a ball: π, 2π/3, π/4, 0",
        _BALL,
        (SphericalHarmonicsEnvironment(tuple(map(tuple, coefficients.tolist())), axes),),
        Pinhole((-2.0, 1.2, 3.6), (0.2, -0.1, 0.2), (0.0, 1.0, 0.0), 12.0, 64, 64),
        """\
The irradiance of a point with normal n is the environment convolved with max(cos θ, 0), which multiplies each
harmonic of degree l by A_l = π, 2π/3, π/4, 0 for l = 0, 1, 2, 3 (Funk and Hecke): E(n) = Σ A_l c_lm Y_lm(n). The
environment is positive everywhere, and no part of a ball hides it from the half space of another.""",
        "Ramamoorthi and Hanrahan 2001, An Efficient Representation for Irradiance Environment Maps",
        blind_to="degree 3 of the environment, which irradiance does not see; the outline of the ball",
    )


CASES: Mapping[str, Callable[[], Case]] = {
    "point-over-plane": point_over_plane,
    "disk-shadow": disk_shadow,
    "four-points": four_points,
    "spot-falloff": spot_falloff,
    "spot-beam": spot_beam,
    "directional-on-sphere": directional_on_sphere,
    "bright-texel": bright_texel,
    "harmonics-on-sphere": spherical_harmonics_on_sphere,
}
