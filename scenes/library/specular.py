"""Smooth metal and glass: light goes single ways, so that every bounce can be followed. Mirrors: ``mirrors``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from scenes import fresnel
from scenes.case import Case, Formula, Images, Tolerance
from scenes.cone_average import average_across_cone
from scenes.images import Image
from scenes.lights import AreaLight, ConstantEnvironment, EnvironmentMap
from scenes.materials import Conductor, Dielectric, Lambertian
from scenes.pixel_average import pixel_average
from scenes.scene import Scene
from scenes.sensor import Orthographic, Pinhole
from scenes.shapes import Quad, Sphere
from scenes.surfaces import Surface, box

Array = NDArray[np.float64]
Series = Callable[[int, Array, Array], Array]
"""Bounce, origins ``(3, n)``, unit directions ``(3, n)`` → radiance ``(channels, n)``."""

M = TypeVar("M")

_BLACK = Lambertian((0.0, 0.0, 0.0))
_UP = (0.0, 1.0, 0.0)
_TOLERANCE = Tolerance(image=(0.005,), tile=(0.02,))
_SERIES = Tolerance(image=(0.005, 0.005, 0.005, 0.01, 0.02), tile=(0.02, 0.02, 0.02, 0.05, 0.1))
"""Later terms of a series of reflections are small, and few paths find them."""
_FRESNEL = "Born and Wolf 1999, Principles of Optics"


def averages(scene: Scene, bounces: int, series: Series) -> Images:
    """The average of every bounce over every pixel, ``(bounces + 1, height, width, channels)``."""
    sensor = scene.sensor
    assert isinstance(sensor, Pinhole | Orthographic)
    return np.stack(
        [pixel_average(sensor, lambda o, d, k=k: series(k, o, d)) for k in range(bounces + 1)]  # type: ignore[misc]
    )


def sky(scene: Scene) -> Array:
    """Radiance of the constant environment, ``(channels, 1)``."""
    assert isinstance(scene.environment, ConstantEnvironment)
    return np.array(scene.environment.radiance)[:, None]


def cosines(quad: Quad, o: Array, d: Array) -> Array:
    """Cosines at which rays meet the front of a rectangle, ``(n,)``.

    Raises:
        ValueError: one misses it.
    """
    n, corner = quad.normal, np.array(quad.corner)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        x = o + d * (n @ (corner - o) / (n @ d)) - corner
    edges = np.array([quad.edge_u, quad.edge_v])
    st = edges @ x / (edges**2).sum(axis=1)[:, None]
    if not ((-n @ d > 0) & (st > 0).all(axis=0) & (st < 1).all(axis=0)).all():
        raise ValueError("a ray misses the plate: the camera must see nothing else, in a less wide image")
    cos_theta: Array = -n @ d
    return cos_theta


def _one(scene: Scene, kind: type[M]) -> tuple[Surface, M]:
    """The first surface whose material is of a kind, and the material."""
    return next((s, s.material) for s in scene.surfaces if isinstance(s.material, kind))


def _emission(scene: Scene) -> Array:
    """Radiance of the one surface that emits, ``(channels, 1)``."""
    [radiance] = [s.emission.diffuse_radiance for s in scene.surfaces if s.emission is not None]
    return np.array(radiance)[:, None]


def _metal(scene: Scene, bounces: int) -> Images:
    """TE = F(θ) e."""
    surface, metal = _one(scene, Conductor)
    assert isinstance(surface.shape, Quad)
    plate, e = surface.shape, sky(scene)

    def series(k: int, o: Array, d: Array) -> Array:
        return fresnel.conductor(cosines(plate, o, d), metal.eta, metal.k) * (e if k == 1 else 0 * e)

    return averages(scene, bounces, series)


def metal_angles() -> Case:
    """A smooth plate of metal seen from steep to grazing angles, under a constant sky."""
    floor = Quad((-20.0, 0.0, 20.0), (40.0, 0.0, 0.0), (0.0, 0.0, -40.0))
    metal = Conductor(eta=(0.2, 0.9, 1.4), k=(3.9, 2.5, 1.6))
    camera = Pinhole((0.3, 1.0, 0.4), (0.5, 0.0, -0.6), _UP, 64.0, 64, 64)
    return Case(
        name="metal-angles",
        family="specular",
        title="Smooth metal under a constant sky, from 14° to 79°: TE = F(θ) e",
        scene=Scene((Surface("plate", floor, metal),), camera, (ConstantEnvironment((1.0, 2.0, 3.0)),)),
        answer=Formula(_metal, f"{_FRESNEL}, §14.2"),
        bounces=2,
        tolerance=_TOLERANCE,
        derivation="""\
Wherever a ray is mirrored to, it finds e: TE = F(θ) e, F the mean of the two polarisations' reflectances for the
complex index η + ik of each channel. Nothing else is there: E = 0, for the camera sees the plate alone, and what
is reflected leaves, so T²E = 0. A pixel's average is a quadrature over the angles that it sees.""",
        blind_to="the direction of reflection: the sky is the same everywhere",
    )


def slab(scene: Scene, bounces: int) -> Images:
    """R above, then (1 − R)² Rᵏ⁻², in turn below and above; without a sky it is black above."""
    _, glass = _one(scene, Dielectric)
    [top] = [s.shape for s in scene.surfaces if s.name.endswith(".top")]
    assert isinstance(top, Quad)
    below = _emission(scene)
    above = 0 * below if scene.environment is None else sky(scene)
    eta = glass.interior_ior / glass.exterior_ior

    def series(k: int, o: Array, d: Array) -> Array:
        R = fresnel.dielectric(cosines(top, o, d), eta)
        if k < 2:
            return above * R * k
        return (below if k % 2 == 0 else above) * ((1 - R) ** 2 * R ** (k - 2))

    return averages(scene, bounces, series)


def glass_slab() -> Case:
    """A slab of heavy glass above a luminous ground, under a sky of another colour."""
    half = ((20.0, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 20.0))
    ground = Quad((-30.0, -0.5, 30.0), (60.0, 0.0, 0.0), (0.0, 0.0, -60.0))
    surfaces = (
        *box("slab", (0.0, -0.1, 0.0), half, Dielectric(interior_ior=2.4)),
        Surface("ground", ground, _BLACK, AreaLight((3.0, 1.0, 2.0))),
    )
    camera = Pinhole((0.3, 1.0, 0.4), (0.9, 0.0, -2.2), _UP, 22.0, 64, 64)
    return Case(
        name="glass-slab",
        family="specular",
        title="A slab of glass, sky above and lamp below: TE = R e, TᵏE = (1 − R)² Rᵏ⁻² e, in turn below and above",
        scene=Scene(surfaces, camera, (ConstantEnvironment((1.0, 2.0, 4.0)),)),
        answer=Formula(slab, f"{_FRESNEL}, §1.5.2; the series of §7.6.1, summed as intensities"),
        bounces=4,
        max_bounces=12,
        tolerance=_SERIES,
        derivation="""\
The light inside the slab meets both faces under the same angle, and Stokes's relations give both the same R from
inside as from outside. From the camera: R is mirrored into the sky, which is TE. 1 − R enters, and 1 − R leaves
below: T²E = (1 − R)² e of the ground. What is reflected inside instead leaves above, then below, and so on:
TᵏE = (1 − R)² Rᵏ⁻². Radiance changes by 1/η² on entering and by η² on leaving. The ground is black. Every
boundary takes the light for unpolarised. Up to bounce 12 no ray comes near the sides of the slab.
The reference tracer is not held to ±0.2 % at every bounce, since few paths carry the later ones:
in a quarter of the image one million of them resolve 3 % of T³E and 6 % of T⁴E.""",
        blind_to="factors of η², which cancel on the way through; small errors of refracted directions",
    )


def _ball(scene: Scene, bounces: int) -> Images:
    """The series of internal reflections of a sphere, seen from outside or from inside."""
    surface, glass = _one(scene, Dielectric)
    assert isinstance(surface.shape, Sphere)
    center, r, e = np.array(surface.shape.center)[:, None], surface.shape.radius, sky(scene)
    eta = glass.interior_ior / glass.exterior_ior
    outside = np.linalg.norm(scene.sensor.origin - center[:, 0]) > r

    def series(k: int, o: Array, d: Array) -> Array:
        closest = o - center
        closest = closest - (closest * d).sum(axis=0) * d
        cos2 = 1 - (closest**2).sum(axis=0) / r**2
        if cos2.min() <= 0:
            raise ValueError("a ray misses the ball: the camera must see nothing else, in a less wide image")
        cos_theta = np.sqrt(cos2)
        R = fresnel.dielectric(cos_theta, eta if outside else 1 / eta)
        if k == 0:
            return e * 0 * R
        if not outside:
            return e * eta**2 * (1 - R) * R ** (k - 1)
        return e * (R if k == 1 else (1 - R) ** 2 * R ** (k - 2))

    return averages(scene, bounces, series)


def glass_ball() -> Case:
    """A ball of glass so near that nothing else is in the picture."""
    ball = Surface("ball", Sphere((0.1, -0.2, 0.0), 1.0), Dielectric(interior_ior=2.4))
    camera = Pinhole((1.3, 0.6, 1.2), (0.55, 0.25, 0.1), _UP, 18.0, 64, 64)
    return Case(
        name="glass-ball",
        family="specular",
        title="A ball of glass under a constant sky: TE = R e, TᵏE = (1 − R)² Rᵏ⁻² e",
        scene=Scene((ball,), camera, (ConstantEnvironment((3.0, 1.0, 2.0)),)),
        answer=Formula(_ball, f"{_FRESNEL}, §1.5.2; chords of a sphere are equal"),
        bounces=4,
        tolerance=_SERIES,
        derivation="""\
All chords of a ray inside a sphere are equally long and meet it under the same angle, so R is the same at every
reflection, inside and outside. TE = R e is mirrored off the front; (1 − R)² e goes through with two refractions;
each reflection inside multiplies by R. The factors 1/η² and η² of radiance cancel. The sum is e for every ray:
a ball of clear glass can't be seen under a uniform sky. R follows from the ray's distance b from the centre,
sin θ = b / r, and a pixel's average is a quadrature over it.
The reference tracer is not held to ±0.2 % at every bounce, since few paths carry the later ones:
in a quarter of the image four million of them resolve 1 % of T³E and 7 % of T⁴E.""",
        blind_to="refracted directions, as long as the angle stays; factors of η², which cancel",
    )


def inside_glass() -> Case:
    """The camera inside a ball of glass: radiance there is η² of that outside."""
    ball = Surface("ball", Sphere((0.0, 0.0, 0.0), 1.0), Dielectric(interior_ior=1.5))
    camera = Pinhole((0.4, -0.3, 0.4), (0.7, 0.5, -0.2), _UP, 70.0, 64, 64)
    return Case(
        name="inside-glass",
        family="specular",
        title="A camera in a ball of glass under a constant sky: TᵏE = η² (1 − R) Rᵏ⁻¹ e, in all η² e",
        scene=Scene((ball,), camera, (ConstantEnvironment((1.0, 2.0, 3.0)),)),
        answer=Formula(_ball, f"{_FRESNEL}, §1.5.2; radiance over η² is kept: Veach 1997, §5.2"),
        bounces=3,
        tolerance=_SERIES,
        derivation="""\
Radiance over η² is what refraction keeps: light that enters glass is squeezed into a narrower cone, and its
radiance grows by η². A ray from the camera leaves at once with 1 − R, or is reflected and meets the sphere again
under the same angle: TᵏE = η² (1 − R) Rᵏ⁻¹ e, and the sum over all bounces is η² e. The camera is nearer to the
centre than r / η, where no direction is totally reflected.
The reference tracer is not held to ±0.2 % at every bounce, since few paths carry the later ones:
in a quarter of the image two million of them resolve 1.5 % of T²E and 10 % of T³E.""",
        blind_to="total internal reflection; where refracted rays go, since the sky is the same everywhere",
    )


def _under_glass(scene: Scene, bounces: int) -> Images:
    """TE = (1 − R) e / η² from below, R e from above."""
    surface, glass = _one(scene, Dielectric)
    assert isinstance(surface.shape, Quad)
    water, eta = surface.shape, glass.interior_ior / glass.exterior_ior
    below, above = _emission(scene), sky(scene)

    def series(k: int, o: Array, d: Array) -> Array:
        R = fresnel.dielectric(cosines(water, o, d), eta)
        return (above * R + below * (1 - R) / eta**2) * (k == 1)

    return averages(scene, bounces, series)


def lamp_under_water() -> Case:
    """A luminous ground in water, seen from above: 1/η² of its radiance comes out."""
    water = Quad((-20.0, 0.0, 20.0), (40.0, 0.0, 0.0), (0.0, 0.0, -40.0))
    ground = Quad((-30.0, -0.4, 30.0), (60.0, 0.0, 0.0), (0.0, 0.0, -60.0))
    surfaces = (
        Surface("water", water, Dielectric(interior_ior=1.33)),
        Surface("ground", ground, _BLACK, AreaLight((9.0, 4.0, 2.0))),
    )
    camera = Pinhole((0.3, 1.0, 0.4), (0.5, 0.0, -0.6), _UP, 64.0, 64, 64)
    return Case(
        name="lamp-under-water",
        family="specular",
        title="A luminous ground under water and a sky above: TE = R e₁ + (1 − R) e₂ / η²",
        scene=Scene(surfaces, camera, (ConstantEnvironment((1.0, 2.0, 3.0)),)),
        answer=Formula(_under_glass, f"{_FRESNEL}, §1.5.2; radiance over η² is kept: Veach 1997, §5.2"),
        bounces=2,
        tolerance=_TOLERANCE,
        derivation="""\
The ground emits e₂ inside the water. Leaving it, light spreads into a wider cone: its radiance falls by η², and
1 − R of it passes. R of the sky's radiance e₁ is mirrored. Both are one bounce: TE = R e₁ + (1 − R) e₂ / η². The
ground is black and the water's surface is flat, so nothing follows. That the water ends nowhere but at its
surface does no harm: a renderer knows of media only by the boundaries that a ray crosses.""",
        blind_to="where refracted rays go, for the ground looks the same everywhere; reflection from inside",
    )


def _window(scene: Scene, bounces: int) -> Images:
    """TE = η² (1 − R) of where refraction leads, and R of where reflection does."""
    surface, glass = _one(scene, Dielectric)
    environment = scene.environment
    assert isinstance(surface.shape, Quad)
    assert isinstance(scene.sensor, Pinhole)
    assert isinstance(environment, EnvironmentMap)
    water, n, eta = surface.shape, surface.shape.normal, glass.interior_ior / glass.exterior_ior

    def radiance(o: Array, d: Array) -> Array:
        cos_theta = cosines(water, o, -d)  # against its front, as if the rays came from outside
        R = fresnel.dielectric(cos_theta, 1 / eta)
        along = d - np.outer(n, cos_theta)
        sine = eta * np.linalg.norm(
            along, axis=0
        )  # where it is more than 1, 1 − R is 0, and any direction will do
        beyond = eta * along / np.maximum(sine, 1) + np.outer(n, np.sqrt(np.maximum(1 - sine**2, 0)))
        mirrored = along - np.outer(n, cos_theta)
        return eta**2 * (1 - R) * _one_cell(environment, beyond) + R * _one_cell(environment, mirrored)

    images = np.zeros((bounces + 1, *scene.shape))
    if bounces:
        cone = np.outer(n, n) - (1 - 1 / eta**2) * np.eye(3)  # sin θ < 1/η
        images[1] = average_across_cone(scene.sensor, radiance, cone, n)
    return images


def _one_cell(light: EnvironmentMap, d: Array) -> Array:
    """Radiance of a map of 2 × 2 pixels, ``(channels, n)``, where it is bilinear in both angles.

    Raises:
        ValueError: a direction beyond the centres of the pixels, or in the half where the map closes.
    """
    pixels = light.image.array
    x, y, z = np.array(light.axes) @ d
    s, t = (np.arctan2(y, x) % (2 * np.pi)) / np.pi - 0.5, 2 * np.arccos(z) / np.pi - 0.5
    if pixels.shape[:2] != (2, 2) or min(s.min(), t.min()) < 0 or max(s.max(), t.max()) > 1:
        raise ValueError("expected a view in which the map is one bilinear cell, between its four pixels")
    shares = np.stack([(1 - t) * (1 - s), (1 - t) * s, t * (1 - s), t * s])
    found: Array = pixels.reshape(4, -1).T @ shares
    return found


def snells_window() -> Case:
    """A camera under water that looks up across the critical angle, in an environment that is brighter above."""
    water = Quad((-20.0, 0.0, 20.0), (40.0, 0.0, 0.0), (0.0, 0.0, -40.0))
    # rows: right, left; columns: below, above
    right, left = ((0.9, 0.3, 0.1), (2.0, 5.0, 9.0)), ((0.2, 0.6, 0.3), (6.0, 4.0, 3.0))
    axes = ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0))
    camera = Pinhole((0.0, -0.5, 0.0), (0.03, 0.3, -0.62), (0.1, 1.0, 0.0), 56.0, 64, 64)
    return Case(
        name="snells-window",
        family="specular",
        title="From under water: the sky in Snell's window, total reflection around it: TE = η² (1 − R) L + R L′",
        scene=Scene(
            (Surface("water", water, Dielectric(interior_ior=1.33)),),
            camera,
            (EnvironmentMap(Image((right, left)), axes),),
        ),
        answer=Formula(_window, f"{_FRESNEL}, §1.5.2 and §1.5.4; radiance over η² is kept: Veach 1997, §5.2"),
        bounces=2,
        tolerance=_TOLERANCE,
        derivation="""\
Up to the critical angle, sin θ = 1/η, 1 − R leaves the water, refracted: the whole sky stands in a cone of 49°,
its radiance L there η² times as large. R is mirrored to where the radiance is L′; beyond the critical angle R = 1.
TE = η² (1 − R) L + R L′. The environment is 2 × 2 pixels of a map, turned so that all that is in view, refracted or
mirrored, lies between their centres, where radiance is bilinear in the two angles of the map: brighter above, of
another colour to either side. Its lower half is taken to be in the water, as in lamp-under-water. The water is flat,
so what leaves it meets nothing: T²E = 0. At the critical angle R has the slope of a square root; a pixel that sees
it is integrated on both sides of the circle, which in the image is an ellipse.""",
        blind_to="reflection inside a closed body of glass; refraction into the denser medium",
    )


CASES: Mapping[str, Callable[[], Case]] = {
    "metal-angles": metal_angles,
    "glass-slab": glass_slab,
    "glass-ball": glass_ball,
    "inside-glass": inside_glass,
    "lamp-under-water": lamp_under_water,
    "snells-window": snells_window,
}
