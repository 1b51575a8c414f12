"""Direct light of lamps: one bounce in closed form, and nothing after it.

The first surface of each scene is the one that is lit and the only one that reflects. It is flat or convex, so
that it does not light itself, and the camera sees nothing else: E = 0, TE = (ρ/π) × irradiance, T²E = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from scenes.affine import Affine
from scenes.case import Case, Formula, Images, Tolerance
from scenes.irradiance_of_lamps import clipped, irradiance_per_radiance, polygon_irradiance, polygons
from scenes.irradiance_of_lights import irradiance_by_light
from scenes.lights import AreaLight, Light
from scenes.materials import Lambertian
from scenes.pixel_average import pixel_average
from scenes.scene import Scene
from scenes.sensor import Orthographic, Pinhole
from scenes.shapes import Disk, Mesh, Quad, Shape, Sphere
from scenes.surfaces import Surface, box
from scenes.transforms import transformed
from scenes.validation import Vector

Array = NDArray[np.float64]
Irradiance = Callable[[Scene, Array, Array], Array]

BLACK = Lambertian((0.0, 0.0, 0.0))
LAMP = AreaLight((9.0, 6.0, 4.0))
TOLERANCE = Tolerance(image=(0.005,), tile=(0.02,))

DIRECT = """\
Only the surface in view reflects, and no part of it sees another: the lamps are black. The image of E is
black, since the camera sees no lamp; TE = (ρ/π) × irradiance; T²E = 0."""

_CONVEX = "indirect light, and the look of the lamp itself: the camera does not see it"


# ---- the answer


def direct_light(scene: Scene, bounces: int) -> Images:
    """E, TE, … of a scene in which nothing stands between the lamps and the receiver."""
    return direct_images(scene, bounces, _unobstructed)


def direct_images(scene: Scene, bounces: int, irradiance: Irradiance) -> Images:
    """0, (ρ/π) × irradiance, 0, …

    Args:
        scene: its first surface is the receiver.
        bounces: the last one.
        irradiance: (scene, points ``(3, n)``, unit normals ``(3, n)``) → ``(channels, n)``.
    """
    material, sensor = scene.surfaces[0].material, scene.sensor
    assert isinstance(material, Lambertian)
    assert isinstance(sensor, Pinhole | Orthographic)
    albedo = np.reshape(np.asarray(material.albedo), (-1, 1))

    def radiance(origins: Array, directions: Array) -> Array:
        x, n = hit(scene.surfaces[0].shape, origins, directions)
        image: Array = albedo / np.pi * irradiance(scene, x, n)
        return image

    images = np.zeros((bounces + 1, *scene.shape))
    if bounces:
        images[1] = pixel_average(sensor, radiance)
    return images


def hit(shape: Shape, o: Array, d: Array) -> tuple[Array, Array]:
    """Where rays meet a quad or a sphere, and the normals there, ``(3, n)`` each.

    Raises:
        ValueError: a ray misses it.
    """
    if isinstance(shape, Quad):
        n = shape.normal[:, None]
        w = np.reshape(shape.corner, (3, 1)) - o
        x = o + (n * w).sum(axis=0) / (n * d).sum(axis=0) * d
        s, t = np.linalg.pinv(np.stack([shape.edge_u, shape.edge_v], axis=1)) @ (
            x - np.reshape(shape.corner, (3, 1))
        )
        met = (abs(s - 0.5) <= 0.5) & (abs(t - 0.5) <= 0.5) & ((n * d).sum(axis=0) < 0)
        normal = np.broadcast_to(n, x.shape)
    else:
        assert isinstance(shape, Sphere)
        w = o - np.reshape(shape.center, (3, 1))
        half = (w * d).sum(axis=0)
        discriminant = half**2 - (w**2).sum(axis=0) + shape.radius**2
        met = discriminant > 0
        x = o + (-half - np.sqrt(np.maximum(discriminant, 0))) * d
        normal = (x - np.reshape(shape.center, (3, 1))) / shape.radius
    if not met.all():
        raise ValueError(f"expected a camera that sees nothing but the receiver {shape}")
    return x, normal


def _unobstructed(scene: Scene, x: Array, n: Array) -> Array:
    """The sum over all that emits."""
    E = np.zeros((scene.channels, x.shape[1]))
    for surface in scene.surfaces:
        if surface.emission is not None:
            E += np.outer(
                surface.emission.diffuse_radiance, irradiance_per_radiance(surface.shape, x, n[:, 0])
            )
    for light in scene.lights:
        E += irradiance_by_light(light, x, n)
    return E


def _behind_a_screen(scene: Scene, x: Array, n: Array) -> Array:
    """The lamp less the screen, whose shadow lies within the lamp for every point."""
    _, lamp, screen = scene.surfaces
    assert isinstance(lamp.shape, Quad)
    assert isinstance(screen.shape, Quad)
    assert lamp.emission is not None
    ([corners], [edges]) = polygons(lamp.shape), polygons(screen.shape)
    d = edges[..., None] - x
    m, c = lamp.shape.normal, np.array(lamp.shape.corner)
    shadow = x + d * (m @ (c[:, None] - x)) / np.einsum("i,kin->kn", m, d)[:, None]
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if not (np.einsum("i,kin->kn", np.cross(m, end - start), shadow - start[:, None]) > 0).all():
            raise ValueError("expected a screen that hides a part of the lamp away from its edges")
    visible = polygon_irradiance(corners, x, n[:, 0]) - polygon_irradiance(edges, x, n[:, 0])
    return np.outer(lamp.emission.diffuse_radiance, visible)


def _over_a_wall(scene: Scene, x: Array, n: Array) -> Array:
    """The part of the lamp that is above the plane through the point and the top edge of the wall."""
    _, lamp, wall = scene.surfaces
    assert isinstance(lamp.shape, Quad)
    assert isinstance(wall.shape, Quad)
    assert lamp.emission is not None
    [corners] = polygons(lamp.shape)
    top = np.add(wall.shape.corner, wall.shape.edge_v)[:, None]
    across = np.cross(np.reshape(wall.shape.edge_u, (3, 1)), x - top, axis=0)
    up = across * np.sign(np.array(wall.shape.edge_v) @ across)
    visible = clipped(np.broadcast_to(corners[..., None], (4, *x.shape)), x, up)
    return np.outer(lamp.emission.diffuse_radiance, polygon_irradiance(visible, x, n[:, 0]))


# ---- scenes


def floor(
    albedo: Vector = (0.8, 0.5, 0.3),
    x: tuple[float, float] = (-6.0, 6.0),
    z: tuple[float, float] = (-6.0, 6.0),
) -> Surface:
    """A rectangle at y = 0, facing up."""
    edges = (x[1] - x[0], 0.0, 0.0), (0.0, 0.0, z[0] - z[1])
    return Surface("floor", Quad((x[0], 0.0, z[1]), *edges), Lambertian(albedo))


def view(origin: Vector = (1.4, 1.6, 2.2), target: Vector = (0.3, 0.0, 0.2), fov: float = 22.0) -> Pinhole:
    """A camera that looks down to the floor."""
    return Pinhole(origin, target, (0.0, 1.0, 0.0), fov, 64, 64)


def direct_case(
    name: str,
    title: str,
    surfaces: tuple[Surface, ...],
    derivation: str,
    source: str,
    *,
    family: str = "direct_light",
    sensor: Pinhole | Orthographic | None = None,
    lights: tuple[Light, ...] = (),
    evaluate: Callable[[Scene, int], Images] = direct_light,
    blind_to: str = _CONVEX,
) -> Case:
    """A case of this family; ``surfaces`` begin with the receiver."""
    return Case(
        name=name,
        family=family,
        title=title,
        scene=Scene(surfaces, sensor or view(), lights),
        answer=Formula(evaluate, source),
        bounces=2,
        tolerance=TOLERANCE,
        derivation=f"{derivation}\n\n{DIRECT}",
        blind_to=blind_to,
    )


def _lamp(shape: Shape, name: str = "lamp") -> Surface:
    return Surface(name, shape, BLACK, LAMP)


_LAMBERT = "Lambert 1760, Photometria; Arvo 1995, Analytic Methods for Simulated Light Transport"
_POLYGON = """\
The irradiance by a polygon of radiance L is (L/2) Σ Θᵢ n·Γᵢ, up to the sign that makes it positive: Θᵢ is the
angle under which edge i is seen, Γᵢ the unit normal of the plane through the point and that edge."""

_NUSSELT = "Nusselt 1928 (irradiance is the area of the lamp's projection onto the base of the hemisphere)"
_CONE = """\
From the point the lamp is an elliptic cone dᵀQd > 0. It has two planes of symmetry, so ∫ l dl over its directions
points along its axis a. Its length is the area of the ellipse that the cone's directions make when projected
along a: π / √((1 + |λ₁|/λ₃)(1 + |λ₂|/λ₃)), with the eigenvalues λ₁, λ₂ < 0 < λ₃ of Q. The irradiance is L n·a
times that."""


def triangle_over_plane() -> Case:
    """A tilted triangle, as a mesh."""
    shape = Mesh([(-1.3, 1.1, -0.9), (0.1, 1.7, -1.0), (-0.9, 1.5, 0.4)], [(0, 1, 2)])  # type: ignore[arg-type]
    title = "A tilted triangle over a floor: Lambert's formula"
    return direct_case("triangle-over-plane", title, (floor(), _lamp(shape)), _POLYGON, _LAMBERT)


_PANEL = Quad((-1.4, 1.2, 0.3), (0.5, 0.0, -1.25), (0.5, 0.5, 0.2))


def quad_over_plane() -> Case:
    """A tilted rectangle: the one light of the pair with ``hundred-tiles``."""
    title = "A tilted rectangle over a floor: Lambert's formula"
    return direct_case("quad-over-plane", title, (floor(), _lamp(_PANEL)), _POLYGON, _LAMBERT)


def hundred_tiles() -> Case:
    """The lamp of ``quad-over-plane`` cut into a hundred."""
    corner, u, v = np.array(_PANEL.corner), np.array(_PANEL.edge_u) / 10, np.array(_PANEL.edge_v) / 10
    tiles = tuple(
        _lamp(Quad(tuple(corner + i * u + j * v), tuple(u), tuple(v)), f"tile-{i}-{j}")
        for i in range(10)
        for j in range(10)
    )
    derivation = (
        "The lamp of quad-over-plane cut into ten by ten tiles. Irradiance is additive, so the answer is the same. "
        + _POLYGON
    )
    return direct_case(
        "hundred-tiles",
        "A rectangle cut into a hundred tiles: the same as one light",
        (floor(), *tiles),
        derivation,
        f"Smits and Jensen 2000, Global Illumination Test Scenes (the idea); {_LAMBERT}",
        blind_to=f"which of the tiles a path chose: they all have the same radiance; {_CONVEX}",
    )


def quad_below_horizon() -> Case:
    """A standing lamp that reaches below the plane of the floor, which ends before it."""
    shape = Quad((-1.7, -0.8, 1.3), (0.25, 0.0, -2.0), (-0.4, 2.2, -0.05))
    return direct_case(
        "quad-below-horizon",
        "A lamp half below the horizon: Lambert's formula for what is above",
        (floor(x=(-1.2, 6.0)), _lamp(shape)),
        f"The lamp is cut by the plane of the floor, since light from below it does not count. {_POLYGON}",
        _LAMBERT,
        sensor=view(fov=13.0),
    )


def sphere_over_plane() -> Case:
    """A sphere as a lamp."""
    return direct_case(
        "sphere-over-plane",
        "A sphere over a floor: π L (r/d)² cos θ",
        (floor(), _lamp(Sphere((-0.7, 1.2, -0.5), 0.5))),
        """\
A sphere of radius r whose centre is at distance d fills a round cone of sine r/d. Projected along its axis its
directions make a disk of area π (r/d)², and by symmetry ∫ l dl points along the axis. With θ the angle between
it and the normal the irradiance is π L (r/d)² cos θ, as if the sphere were a point.""",
        _NUSSELT,
    )


def disk_over_plane() -> Case:
    """A disk parallel to the floor."""
    shape = Disk((-0.6, 1.3, -0.4), (0.7, 0.0, 0.0), (0.0, 0.0, 0.7))
    return direct_case(
        "disk-over-plane",
        "A disk parallel to a floor",
        (floor(), _lamp(shape)),
        f"""\
{_CONE}
For a parallel disk, h above and x aside, this is (πL/2)(1 − (h² + x² − r²) / √((h² + x² + r²)² − 4r²x²)).""",
        f"{_NUSSELT}; parallel: Foote 1915, Illumination from a radiating disk",
    )


def moved_disk() -> Case:
    """A disk that was scaled, turned and moved."""
    affine = (
        Affine.translation((-0.9, 1.3, -0.3)) @ Affine.rotation((1.0, -0.4, 2.0), -38.0) @ Affine.scaling(0.6)
    )
    disk = _lamp(Disk((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    title = "A disk scaled, turned and moved"
    surfaces = floor(), transformed(disk, affine)
    return direct_case("moved-disk", title, surfaces, _CONE, _NUSSELT, sensor=view(fov=14.0))


def elliptical_disk_over_plane() -> Case:
    """An ellipse that no radius describes: its axes differ, and are not orthogonal."""
    disk = Disk((-0.7, 1.4, -0.4), (0.9, 0.1, -0.2), (0.3, -0.15, 0.4))
    title = "An ellipse as a lamp, by conjugate radii"
    return direct_case("elliptical-disk-over-plane", title, (floor(), _lamp(disk)), _CONE, _NUSSELT)


def ellipsoid_over_plane() -> Case:
    """A sphere stretched by three factors, and turned."""
    affine = (
        Affine.translation((-0.8, 1.4, -0.3))
        @ Affine.rotation((1.0, 2.0, -0.5), 50.0)
        @ Affine.scaling((0.7, 0.2, 0.45))
    )
    lamp = transformed(_lamp(Sphere((0.0, 0.0, 0.0), 1.0)), affine)
    title = "A sphere stretched and turned: an ellipsoid as a lamp"
    return direct_case("ellipsoid-over-plane", title, (floor(), lamp), _CONE, _NUSSELT)


def block_over_plane() -> Case:
    """A cube scaled by three factors and turned: all six faces emit, up to three light the floor."""
    affine = (
        Affine.translation((-0.8, 1.3, -0.5))
        @ Affine.rotation((1.0, 2.0, -2.0), 36.0)
        @ Affine.scaling((0.5, 0.25, 0.4))
    )
    axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    faces = box("lamp", (0.0, 0.0, 0.0), axes, BLACK, emission=LAMP)
    return direct_case(
        "block-over-plane",
        "An emitting block, scaled and turned",
        (floor(), *(transformed(face, affine) for face in faces)),
        f"A block is convex: no face hides another, and those that face away give nothing. {_POLYGON}",
        _LAMBERT,
        sensor=view(fov=10.0),
    )


def lamp_turned_away() -> Case:
    """Two lamps, of which one shows the floor its back."""
    away = Quad((0.5, 1.0, -0.9), (0.1, 0.0, 0.9), (0.9, 0.2, -0.1))
    return direct_case(
        "lamp-turned-away",
        "A lamp turned away from the floor, which gives nothing, beside one that lights it",
        (floor(), _lamp(_PANEL), _lamp(away, "turned-away")),
        f"Lamps emit from their front alone, and the second one's is turned to the sky. {_POLYGON}",
        _LAMBERT,
    )


def screened_lamp() -> Case:
    """A black screen inside the outline of the lamp."""
    lamp = Quad((-1.7, 2.0, -1.7), (1.8, 0.0, 0.0), (0.0, 0.0, 1.6))
    screen = Quad((-0.62, 1.2, -0.65), (0.35, 0.0, 0.0), (0.0, 0.05, 0.3))
    return direct_case(
        "screened-lamp",
        "A lamp with a screen before its middle: the difference of two form factors",
        (floor(), _lamp(lamp), Surface("screen", screen, BLACK)),
        f"""\
{_POLYGON} Seen from any point in view the screen lies within the lamp, so that what is hidden is just what a lamp
in the place of the screen would give: the irradiance is that by the lamp less that by the screen.""",
        _LAMBERT,
        sensor=view(origin=(1.9, 1.5, 0.4), target=(0.1, 0.0, 0.1), fov=11.0),
        evaluate=lambda scene, bounces: direct_images(scene, bounces, _behind_a_screen),
        blind_to=f"the place of the shadow's edges, since no point is in full light; {_CONVEX}",
    )


def lamp_over_a_wall() -> Case:
    """Every point in view is in the half shadow of one edge."""
    lamp = Quad((-1.3, 0.3, 1.0), (0.2, 0.0, -1.6), (-0.2, 2.0, -0.025))
    wall = Quad((-0.4, -0.1, 5.0), (0.0, 0.0, -10.0), (0.0, 0.6, 0.0))
    return direct_case(
        "lamp-over-a-wall",
        "A lamp that rises above a wall: the half shadow of an edge",
        (floor(), _lamp(lamp), Surface("wall", wall, BLACK)),
        f"""\
A point sees of the lamp what is above the plane through itself and the top edge of the wall, which reaches far
enough to either side. {_POLYGON}""",
        _LAMBERT,
        sensor=view(origin=(1.6, 2.2, 1.2), target=(0.5, 0.0, -0.1), fov=8.0),
        evaluate=lambda scene, bounces: direct_images(scene, bounces, _over_a_wall),
    )


CASES: Mapping[str, Callable[[], Case]] = {
    "triangle-over-plane": triangle_over_plane,
    "quad-over-plane": quad_over_plane,
    "hundred-tiles": hundred_tiles,
    "quad-below-horizon": quad_below_horizon,
    "sphere-over-plane": sphere_over_plane,
    "disk-over-plane": disk_over_plane,
    "moved-disk": moved_disk,
    "elliptical-disk-over-plane": elliptical_disk_over_plane,
    "ellipsoid-over-plane": ellipsoid_over_plane,
    "block-over-plane": block_over_plane,
    "lamp-turned-away": lamp_turned_away,
    "screened-lamp": screened_lamp,
    "lamp-over-a-wall": lamp_over_a_wall,
}
