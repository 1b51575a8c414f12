"""Interreflection in spheres where the field is not uniform, and every bounce is still known.

All cases rest on one fact: every element of the wall of a sphere lights every other one equally (``sphere_wall``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenes.case import Case, Formula, Images, Tolerance
from scenes.images import Image
from scenes.library.sphere_wall import EQUAL_EXCHANGE, SPHERE_SOURCE, albedo_of, radiance_of, wall_and_camera
from scenes.lights import AreaLight, PolarRange
from scenes.materials import ImageTexture, Lambertian, Material, Mirror
from scenes.round_coverage import cap_coverage, circle_coverage, sphere_coverage
from scenes.scene import Scene
from scenes.sensor import Pinhole
from scenes.shapes import Disk, Shape, Sphere
from scenes.surfaces import Surface
from scenes.validation import Vector

Array = NDArray[np.float64]

_ENCLOSURE = (
    EQUAL_EXCHANGE
    + """\
A body takes the share f of what each point of the wall sees, the same from every point: (r/R)² for a sphere in
the middle; for a flat disk that cuts off a cap that cap's share, (1 − h/R) / 2 at the distance h from the centre,
since the disk is seen under the solid angle of the cap behind it. The body itself sees the wall alone.
So radiance is b on the wall and d on a body at every bounce, with b′ = ρ ((1 − Σf) b + Σ f d), d′ = ρ_body b.
Several disks see each other too, unevenly; they are black, so that nothing comes of it."""
)

_BLACK = Lambertian((0.0, 0.0, 0.0))
_TURN = (0.36, 0.48, 0.8)  # no axis of a case


def _case(
    name: str, title: str, scene: Scene, evaluate: Callable[[Scene, int], Images], **other: Any
) -> Case:
    usual: dict[str, Any] = {
        "answer": Formula(evaluate, other.pop("source", SPHERE_SOURCE)),
        "bounces": 5,
        "tolerance": Tolerance(image=(0.005,), tile=(0.02,)),
    }
    return Case(name=name, family="interreflection", title=title, scene=scene, **(usual | other))


# ---- bodies in a sphere


def _share(body: Shape, wall: Sphere) -> float:
    """The share of what a point of the wall sees, weighted by the cosine, that a body takes.

    Raises:
        ValueError: the body is neither a sphere in the middle nor a disk that closes off a cap.
    """
    offset = np.subtract(body.center, wall.center) if isinstance(body, Disk | Sphere) else np.ones(3)
    if isinstance(body, Sphere) and not offset.any():
        return (body.radius / wall.radius) ** 2
    if isinstance(body, Disk):
        h = -float(offset @ body.normal)  # its front looks at the centre
        rim = np.array([np.add(offset, axis) for axis in (body.axis_u, body.axis_v)])
        if (
            np.allclose(offset, -h * body.normal)
            and np.allclose((rim**2).sum(axis=1), wall.radius**2)
            and h > 0
        ):
            return (1 - h / wall.radius) / 2
    raise ValueError(
        f"{body} is neither a sphere around the wall's centre nor a disk with its rim on the wall"
    )


def _enclosure(scene: Scene, bounces: int) -> Images:
    """b′ = ρ ((1 − Σf) b + Σ f d) on the wall, d′ = ρ_body b on the bodies."""
    wall, shape, sensor = wall_and_camera(scene)
    bodies = scene.surfaces[1:]
    if len(bodies) > 1 and any(albedo_of(body).any() for body in bodies):
        raise ValueError("several bodies light each other unevenly; expected black ones")
    shares = np.array([_share(body.shape, shape) for body in bodies])
    covered = np.array([_coverage(body.shape, sensor) for body in bodies])
    rho, rho_bodies = albedo_of(wall), np.array([albedo_of(body) for body in bodies])
    b, d = radiance_of(wall), np.array([radiance_of(body) for body in bodies])
    images = np.empty((bounces + 1, *scene.shape))
    for image in images:
        image[:] = np.multiply.outer(1 - covered.sum(axis=0), b) + np.tensordot(covered, d, axes=(0, 0))
        b, d = rho * ((1 - shares.sum()) * b + shares @ d), rho_bodies * b
    return images


def _coverage(body: Shape, sensor: Pinhole) -> Array:
    if isinstance(body, Sphere):
        return sphere_coverage(body, sensor)
    assert isinstance(body, Disk)
    return circle_coverage(body.center, body.normal, float(np.linalg.norm(body.axis_u)), sensor)


def _port(name: str, axis: Vector, degrees: float, material: Material, radiance: Vector) -> Surface:
    """A flat disk that cuts the cap of so many degrees about an axis off the unit sphere; it looks inward."""
    a = np.asarray(axis) / np.linalg.norm(axis)
    u = np.cross(a, _TURN)
    u *= math.sin(math.radians(degrees)) / np.linalg.norm(u)
    places = (math.cos(math.radians(degrees)) * a, u, np.cross(u, a))
    center, axis_u, axis_v = ((float(x), float(y), float(z)) for x, y, z in places)
    return Surface(name, Disk(center, axis_u, axis_v), material, AreaLight(radiance))


def sphere_two_caps() -> Case:
    """A white cavity with two black lamps of another size and colour, flat, each before its cap."""
    surfaces = (
        Surface("wall", Sphere((0.0, 0.0, 0.0), 1.0, inward=True), Lambertian((0.9, 0.7, 0.5))),
        _port("large-lamp", (0.2, 0.3, 1.0), 30.0, _BLACK, (4.0, 1.0, 2.0)),
        _port("small-lamp", (0.9, -0.3, 0.35), 22.0, _BLACK, (2.0, 8.0, 3.0)),
    )
    sensor = Pinhole((-0.35, 0.05, -0.4), (0.5, 0.0, 0.6), (0.1, 1.0, 0.0), 75.0, 64, 64)
    return _case(
        "sphere-two-caps",
        "Inside of a sphere with two flat black lamps: TᵏE = (e₁f₁ + e₂f₂) ρᵏ (1 − f₁ − f₂)ᵏ⁻¹ on its wall",
        Scene(surfaces, sensor),
        _enclosure,
        derivation=_ENCLOSURE,
        blind_to="wrong directions of reflected light: after one bounce the wall is uniform; occlusion: it is convex",
    )


def sphere_flat_port() -> Case:
    """A lamp that also reflects, flat in the wall of a sphere: light reaches it at every second bounce first."""
    surfaces = (
        Surface("wall", Sphere((0.0, 0.0, 0.0), 1.0, inward=True), Lambertian((0.8, 0.6, 0.4))),
        _port("port", (-0.3, 0.5, 0.8), 50.0, Lambertian((0.3, 0.7, 0.9)), (4.0, 3.0, 5.0)),
    )
    sensor = Pinhole((0.3, -0.2, -0.4), (-0.2, 0.35, 0.6), (0.1, 1.0, 0.0), 90.0, 64, 64)
    return _case(
        "sphere-flat-port",
        "Inside of a sphere with a flat lamp that reflects: two unknowns, b on the wall and d on the lamp",
        Scene(surfaces, sensor),
        _enclosure,
        derivation=_ENCLOSURE,
        blind_to="wrong directions of light reflected by the port: all of it meets the wall; occlusion: it is convex",
    )


def concentric_spheres() -> Case:
    """A ball in the middle of a sphere; both emit and reflect, and the ball stands in the light's way."""
    surfaces = (
        Surface(
            "shell",
            Sphere((0.0, 0.0, 0.0), 1.0, inward=True),
            Lambertian((0.8, 0.5, 0.3)),
            AreaLight((0.2, 0.5, 1.0)),
        ),
        Surface(
            "ball", Sphere((0.0, 0.0, 0.0), 0.45), Lambertian((0.4, 0.9, 0.6)), AreaLight((3.0, 2.0, 4.0))
        ),
    )
    sensor = Pinhole((0.7, 0.3, -0.35), (-0.3, -0.15, 0.4), (0.1, 1.0, 0.0), 90.0, 64, 64)
    return _case(
        "concentric-spheres",
        "A ball in the middle of a sphere, both emit and reflect: two unknowns, b on the shell and d on the ball",
        Scene(surfaces, sensor),
        _enclosure,
        source="form factors of concentric spheres: (r/R)² from shell to ball, by reciprocity; 1 back",
        derivation=_ENCLOSURE,
        blind_to="directions of light that are wrong in a way that keeps the shares of ball and shell",
    )


# ---- a sphere of several albedos: surfaces are zones of a texture


def _zones(scene: Scene, bounces: int) -> Images:
    """E is e on the lamp; TᵏE = ρ(x) e f ρ̄ᵏ⁻¹ on the wall, with ρ̄ = Σ ρᵢ fᵢ over what is left of the zones."""
    wall, shape, sensor = wall_and_camera(scene)
    [lamp] = scene.surfaces[1:]
    assert isinstance(lamp.shape, Disk)
    assert isinstance(wall.material, Lambertian)
    texture = wall.material.albedo
    assert isinstance(texture, ImageTexture)
    if texture.interpolation != "nearest" or texture.image.array.shape[1] != 1:
        raise ValueError("expected a texture of one column that is not interpolated: zones of one albedo")
    rows = texture.image.array[:, 0]
    starts = [i for i in range(len(rows)) if i == 0 or (rows[i] != rows[i - 1]).any()]
    edges, rows = np.array([*starts, len(rows)]) * 180 / len(rows), rows[starts]

    e, f = radiance_of(lamp), _share(lamp.shape, shape)
    shares = -np.diff(np.cos(np.radians(edges))) / 2
    behind = _zone_behind(lamp.shape, shape, f, edges)
    shares[behind] -= f
    lamp_covers = _coverage(lamp.shape, sensor)
    within = np.stack([_within_polar_angle(float(edge), shape, sensor) for edge in edges])
    covered = np.diff(within, axis=0)
    covered[behind] -= lamp_covers

    rho, mean = np.tensordot(covered, rows, axes=(0, 0)), shares @ rows
    images = np.empty((bounces + 1, *scene.shape))
    images[0] = lamp_covers[..., None] * e
    for k in range(1, bounces + 1):
        images[k] = rho * e * f * mean ** (k - 1)
    return images


def _within_polar_angle(edge: float, wall: Sphere, sensor: Pinhole) -> Array:
    """The share of each pixel that sees the wall at a polar angle below an edge, in degrees from +z."""
    if edge in (0, 180):
        return np.full((sensor.height, sensor.width), edge / 180)
    return cap_coverage(wall, PolarRange(0.0, edge), sensor)


def _zone_behind(lamp: Disk, wall: Sphere, share: float, edges: Array) -> int:
    """Which zone the lamp's cap lies in.

    Raises:
        ValueError: it lies in more than one.
    """
    toward, half = np.subtract(lamp.center, wall.center), math.acos(1 - 2 * share)
    middle = math.acos(toward[2] / np.linalg.norm(toward))
    low, high = math.degrees(max(middle - half, 0)), math.degrees(min(middle + half, math.pi))
    first, last = np.searchsorted(edges, [low, high]) - 1
    if first != last:
        raise ValueError(
            f"the lamp reaches from {low:.4g}° to {high:.4g}°; expected it in one of the zones {edges}"
        )
    return int(first)


def sphere_zones() -> Case:
    """Three zones of other albedos about the pole, and a flat black lamp in the last of them."""
    rows = ((0.9, 0.2, 0.5), (0.3, 0.8, 0.6)) + 4 * ((0.6, 0.5, 0.9),)
    albedo = ImageTexture(Image(tuple((row,) for row in rows)), "nearest")
    surfaces = (
        Surface("wall", Sphere((0.0, 0.0, 0.0), 1.0, inward=True), Lambertian(albedo)),
        _port("lamp", (0.95, 0.3, 0.09), 22.0, _BLACK, (8.0, 12.0, 10.0)),
    )
    sensor = Pinhole((-0.45, -0.1, -0.5), (0.25, 0.15, 0.5), (0.2, 1.0, 0.0), 90.0, 64, 64)
    return _case(
        "sphere-zones",
        "Inside of a sphere of three albedos with a flat black lamp: TᵏE = ρ(x) e f ρ̄ᵏ⁻¹",
        Scene(surfaces, sensor),
        _zones,
        derivation=EQUAL_EXCHANGE
        + """\
A flat lamp is seen under the solid angle of the cap that it cuts off, whose share is f, and gives the irradiance
π f e everywhere: TE = ρ(x) f e with the albedo ρ(x) of the place. A zone between θᵢ and θᵢ₊₁ has the share
fᵢ = (cos θᵢ − cos θᵢ₊₁) / 2, less f where the lamp hides a cap of it. So T²E = ρ(x) ρ̄ f e with ρ̄ = Σ ρᵢ fᵢ, and so
on. The lamp itself is black. A pixel on an edge has its shares of both sides, inside and outside an ellipse.""",
        blind_to="wrong directions of reflected light that meet every zone in its share; turns about the pole of ρ",
    )


# ---- half a sphere on a mirror


def _dome(scene: Scene, bounces: int) -> Images:
    """u_k = ρ (u_(k−1) / 2 + m u_(k−2) / 2 + s_k) on the dome, s₁ = f e, s₂ = m f e; m times that in the mirror."""
    wall, shape, sensor = wall_and_camera(scene)
    [mirror] = scene.surfaces[1:]
    assert isinstance(mirror.shape, Disk)
    assert isinstance(mirror.material, Mirror)
    assert wall.emission is not None
    assert wall.emission.polar_range is not None
    zone, n = wall.emission.polar_range, mirror.shape.normal
    high = math.degrees(math.acos(np.asarray(zone.axis) @ n)) + zone.high
    if mirror.shape.center != shape.center or zone.low > 0 or high > 90:
        raise ValueError("expected a mirror through the centre, and a cap that lies above it")
    x, y, z = np.asarray(zone.axis) - 2 * (np.asarray(zone.axis) @ n) * n
    below = PolarRange(0.0, zone.high, (float(x), float(y), float(z)))
    cap = cap_coverage(shape, zone, sensor)[..., None]
    image_of_cap = cap_coverage(shape, below, sensor)[..., None]
    in_mirror = circle_coverage(shape.center, n, shape.radius, sensor)[..., None]

    e, rho, m = (
        np.asarray(wall.emission.diffuse_radiance),
        albedo_of(wall),
        np.asarray(mirror.material.reflectance),
    )
    sources = {1: zone.fraction * e, 2: m * zone.fraction * e}
    u = [np.zeros_like(e), np.zeros_like(e)]  # at bounces −1 and 0
    images = np.empty((bounces + 1, *scene.shape))
    images[0] = cap * e
    for k in range(1, bounces + 1):
        u.append(rho * (u[-1] / 2 + m * u[-2] / 2 + sources.get(k, 0)))
        images[k] = (1 - in_mirror) * u[-1] + in_mirror * m * u[-2]
        if k == 1:
            images[k] += image_of_cap * m * e
    return images


def dome_on_mirror() -> Case:
    """A diffuse dome on a mirror through its centre; the camera sees both, the lamp and its image."""
    emission = AreaLight((4.0, 3.0, 6.0), PolarRange(0.0, 30.0, (0.75, 0.6, 0.3)))
    surfaces = (
        Surface("dome", Sphere((0.0, 0.0, 0.0), 1.0, inward=True), Lambertian((0.8, 0.6, 0.4)), emission),
        Surface("mirror", Disk((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)), Mirror((0.6, 0.9, 0.75))),
    )
    sensor = Pinhole((-0.2, 0.7, -0.1), (0.2, 0.0, 0.1), (0.3, 0.5, 1.0), 100.0, 64, 64)
    return _case(
        "dome-on-mirror",
        "Half a sphere, diffuse, on a mirror, lit by a cap: the sphere unfolded, each image one bounce later",
        Scene(surfaces, sensor),
        _dome,
        source=SPHERE_SOURCE + "; method of images",
        derivation=EQUAL_EXCHANGE
        + """\
The mirror, of reflectance m, halves the sphere, and what a point of the dome sees in it are the images of the
dome: the other half of the sphere, every element of which lights it equally too, m times as much and a bounce
later. With the cap's share f of the whole sphere the radiance u of the dome is
u_k = ρ (½ u_(k−1) + ½ m u_(k−2) + s_k), s₁ = f e, s₂ = m f e, and the mirror shows m times the bounce before.""",
        blind_to="wrong directions of light that the dome reflects, as long as half of it meets the mirror",
    )


CASES: Mapping[str, Callable[[], Case]] = {
    "sphere-two-caps": sphere_two_caps,
    "sphere-flat-port": sphere_flat_port,
    "concentric-spheres": concentric_spheres,
    "sphere-zones": sphere_zones,
    "dome-on-mirror": dome_on_mirror,
}
