"""Rough metal and glass, and blends: albedos by quadrature, lobes by their value."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache

import numpy as np
from numpy.typing import NDArray

from scenes import fresnel, microfacets
from scenes.case import Case, Formula, Images, Tolerance
from scenes.interpolation import interpolant, interpolated
from scenes.library.specular import averages, cosines, sky
from scenes.lights import AreaLight, ConstantEnvironment, DirectionalLight
from scenes.materials import Blend, Conductor, Lambertian, Material, RoughConductor, RoughDielectric
from scenes.scene import Scene
from scenes.sensor import Pinhole
from scenes.shapes import Quad
from scenes.surfaces import Surface

Array = NDArray[np.float64]

_BLACK = Lambertian((0.0, 0.0, 0.0))
_TOLERANCE = Tolerance(image=(0.005,), tile=(0.02,))
_FLOOR = Quad((-20.0, 0.0, 20.0), (40.0, 0.0, 0.0), (0.0, 0.0, -40.0))
_CAMERA = Pinhole((0.3, 1.0, 0.4), (0.5, 0.0, -0.6), (0.0, 1.0, 0.0), 64.0, 64, 64)
_SKY = ConstantEnvironment((1.0, 2.0, 3.0))
_METAL = RoughConductor(eta=(0.2, 0.9, 1.4), k=(3.9, 2.5, 1.6), alpha=0.4, shadowing="separable")
_GLASS = RoughDielectric(alpha=0.4, interior_ior=1.5, shadowing="separable")
_WALTER = "Walter, Marschner, Li and Torrance 2007, EGSR"


def _floor(scene: Scene) -> tuple[Quad, Material]:
    """The first surface, which the camera sees."""
    surface = scene.surfaces[0]
    assert isinstance(surface.shape, Quad)
    return surface.shape, surface.material


def _local(quad: Quad, w: Array) -> Array:
    """Directions ``(3, n)`` in coordinates whose z is the normal of a rectangle."""
    u, v = np.array(quad.edge_u), np.array(quad.edge_v)
    return np.stack([u / np.linalg.norm(u), v / np.linalg.norm(v), quad.normal]) @ w


# ---- under a sky


def _albedo(material: Material, cos_theta: Array) -> Array:
    """∫ f cos θi dwi for directions at the cosines given, ``(channels, n)``; smooth lobes included."""
    match material:
        case Lambertian():
            assert isinstance(material.albedo, tuple)
            return np.tile(np.array(material.albedo)[:, None], len(cos_theta))
        case Conductor():
            return fresnel.conductor(cos_theta, material.eta, material.k)
        case RoughConductor():
            rough = material  # for the type checker, inside the function
            return interpolated(lambda c: microfacets.conductor_albedo(rough, c[0]), cos_theta[None])
        case Blend(first, second, weight):
            return (1 - weight) * _albedo(first, cos_theta) + weight * _albedo(second, cos_theta)
        case _:
            raise ValueError(f"no albedo is known of {type(material).__name__}")


def _under_sky(scene: Scene, bounces: int) -> Images:
    """TE = albedo(θ) e."""
    floor, material = _floor(scene)
    e = sky(scene)

    def series(k: int, o: Array, d: Array) -> Array:
        return e * _albedo(material, cosines(floor, o, d)) if k == 1 else 0 * e * d[:1]

    return averages(scene, bounces, series)


_UNDER_SKY = """\
Light comes from everywhere with radiance e, so TE = e ∫ f cos θi dwi = a(θo) e, with the albedo a for the angle to
the viewer. The plate is flat and alone: E = 0, T²E = 0. """


def rough_metal_sky() -> Case:
    """What single scattering leaves of rough metal."""
    return Case(
        name="rough-metal-sky",
        family="glossy",
        title="Rough metal under a constant sky, from 14° to 79°: TE = a(θ) e, the albedo by quadrature",
        scene=Scene((Surface("plate", _FLOOR, _METAL),), _CAMERA, (_SKY,)),
        answer=Formula(
            _under_sky, f"{_WALTER}, eq. 20, 23, 33, 34, by Gauss's quadrature over the hemisphere"
        ),
        bounces=2,
        tolerance=_TOLERANCE,
        derivation=_UNDER_SKY
        + """\
f = F D G / (4 cos θi cos θo) of GGX facets with separable shadowing. It is analytic in the angles of wi, so Gauss's
quadrature in the polar angle and equal steps in azimuth converge like a power; the albedo as a function of cos θo
is smooth, too, and is interpolated between Chebyshev points before pixels are averaged.""",
        blind_to="the shape of the lobe, except for its albedo; light between facets, which is left out on purpose",
    )


def blend_sky() -> Case:
    """Varnish: a smooth lobe that only sampling finds, and a diffuse one."""
    metal = Conductor(eta=(0.2, 0.9, 1.4), k=(3.9, 2.5, 1.6))
    blend = Blend(Lambertian((0.2, 0.5, 0.8)), metal, 0.35)
    return Case(
        name="blend-sky",
        family="glossy",
        title="A blend of diffuse and smooth metal under a constant sky: TE = ((1 − w) ρ + w F(θ)) e",
        scene=Scene((Surface("plate", _FLOOR, blend),), _CAMERA, (_SKY,)),
        answer=Formula(_under_sky, "linearity of R in f; Born and Wolf 1999, Principles of Optics, §14.2"),
        bounces=2,
        tolerance=_TOLERANCE,
        derivation=_UNDER_SKY
        + """\
A blend's albedo is the blend of the albedos, (1 − w) ρ + w F(θ). Next event can't find what the smooth lobe
mirrors: that part comes from sampling the blend alone, while the diffuse part may come from either.""",
        blind_to="directions: the sky is the same everywhere, so the lobes' shapes do not matter",
    )


def _tank(scene: Scene, bounces: int) -> Images:
    """TE = a_above e₁ + a_below e₂."""
    surface, glass = _floor(scene)
    assert isinstance(glass, RoughDielectric)
    above, [below] = (
        sky(scene),
        {s.emission.diffuse_radiance for s in scene.surfaces if s.emission is not None},
    )

    def series(k: int, o: Array, d: Array) -> Array:
        if k != 1:
            return np.zeros((scene.channels, d.shape[1]))
        cos_theta = cosines(surface, o, d)
        a = interpolated(lambda c: np.stack(microfacets.dielectric_albedos(glass, c[0])), cos_theta[None])
        radiance: Array = above * a[0] + np.array(below)[:, None] * a[1]
        return radiance

    return averages(scene, bounces, series)


def rough_glass_tank() -> Case:
    """Rough glass as the lid of a luminous tank."""
    light, r, h = AreaLight((6.0, 4.0, 2.0)), 20.0, 3.0
    sides = {
        "bottom": Quad((-r, -h, r), (2 * r, 0.0, 0.0), (0.0, 0.0, -2 * r)),
        "left": Quad((-r, -h, r), (0.0, 0.0, -2 * r), (0.0, h, 0.0)),
        "right": Quad((r, -h, -r), (0.0, 0.0, 2 * r), (0.0, h, 0.0)),
        "back": Quad((-r, -h, -r), (2 * r, 0.0, 0.0), (0.0, h, 0.0)),
        "front": Quad((r, -h, r), (-2 * r, 0.0, 0.0), (0.0, h, 0.0)),
    }
    tank = (Surface(name, shape, _BLACK, light) for name, shape in sides.items())
    return Case(
        name="rough-glass-tank",
        family="glossy",
        title="Rough glass over a luminous tank, under a sky: TE = a↑(θ) e₁ + a↓(θ) e₂, by quadrature",
        scene=Scene((Surface("lid", _FLOOR, _GLASS), *tank), _CAMERA, (_SKY,)),
        answer=Formula(
            _tank, f"{_WALTER}, eq. 20, 21, 23, 33, 34, by Gauss's quadrature over wi, and over facets"
        ),
        bounces=2,
        tolerance=_TOLERANCE,
        derivation="""\
The camera sees the lid alone. Above it is the sky with e₁, below it, inside the glass, black walls that emit e₂
into every direction that refraction can take. So TE = a↑ e₁ + a↓ e₂ with a↑ = ∫ f cos θi dwi over the upper
hemisphere and a↓ over the lower one, where f of radiance carries 1/η². The latter is done over the facets that wo
sees, on which it is smooth, while over wi it has an edge. Nothing comes back from the walls: T²E = 0.""",
        blind_to="the shapes of the two lobes, except for their albedos; light from inside the glass",
    )


# ---- under a sun


def _f(material: Material, wi: Array, wo: Array) -> Array:
    """f per channel in local directions, ``(channels, n)`` or ``(1, n)``."""
    match material:
        case Lambertian():
            assert isinstance(material.albedo, tuple)
            return np.tile(np.array(material.albedo)[:, None] / np.pi, wi.shape[1])
        case RoughConductor():
            return microfacets.conductor(material, wi, wo)
        case RoughDielectric():
            return microfacets.dielectric(material, wi, wo)[None]
        case Blend(first, second, weight):
            return (1 - weight) * _f(first, wi, wo) + weight * _f(second, wi, wo)
        case _:
            raise ValueError(f"no finite f is known of {type(material).__name__}")


def _under_sun(scene: Scene, bounces: int) -> Images:
    """TE = f |cos θi| times the irradiance across the light."""
    floor, material = _floor(scene)
    [sun] = scene.lights
    assert isinstance(sun, DirectionalLight)
    E = np.array(sun.irradiance)[:, None]
    wi = _local(floor, -np.array(sun.direction)[:, None])

    def series(k: int, o: Array, d: Array) -> Array:
        cosines(floor, o, d)  # every ray meets the floor
        radiance: Array = E * _f(material, wi, _local(floor, -d)) * (np.abs(wi[2]) * (k == 1))
        return radiance

    return averages(scene, bounces, series)


_UNDER_SUN = """\
Parallel light comes from one direction wi, with irradiance E⊥ on a plane across it: TE = f(wi, wo) |cos θi| E⊥. It
is no emission that a ray could meet, so E = 0, and only next event finds it. The plate is flat and alone:
T²E = 0. """


def _sun_case(
    name: str,
    title: str,
    material: Material,
    sun: DirectionalLight,
    why: str,
    blind_to: str,
    camera: Pinhole = _CAMERA,
) -> Case:
    return Case(
        name=name,
        family="glossy",
        title=title,
        scene=Scene((Surface("plate", _FLOOR, material),), camera, (sun,)),
        answer=Formula(_under_sun, f"{_WALTER}, eq. 20, 21, 23, 33, 34"),
        bounces=2,
        tolerance=_TOLERANCE,
        derivation=_UNDER_SUN + why,
        blind_to=blind_to,
    )


def rough_metal_sun() -> Case:
    """The highlight of rough metal."""
    return _sun_case(
        "rough-metal-sun",
        "The highlight of rough metal in parallel light: TE = f cos θi E⊥, f the GGX lobe",
        RoughConductor(eta=(0.2, 0.9, 1.4), k=(3.9, 2.5, 1.6), alpha=0.25, shadowing="separable"),
        DirectionalLight((0.25, -0.9, -0.8), (5.0, 3.0, 4.0)),
        "For metal f = F D G / (4 cos θi cos θo), with F at the angle to the facet half way between wi and wo.",
        "how lobes are sampled: no direction is",
    )


def rough_glass_sun() -> Case:
    """The highlight that comes through rough glass."""
    return _sun_case(
        "rough-glass-sun",
        "Parallel light inside rough glass, seen from outside: TE = f |cos θi| E⊥, f the refracted GGX lobe",
        RoughDielectric(alpha=0.3, interior_ior=1.5, shadowing="separable"),
        DirectionalLight((-0.35, 0.9, 0.3), (5.0, 3.0, 4.0)),
        "The light is inside the glass, and E⊥ is its irradiance there. The facet that refracts wi into wo has its "
        "normal along −(η wi + wo); f of radiance there is eq. 21 of Walter et al.",
        "how lobes are sampled; reflection",
        Pinhole((0.3, 1.0, 0.4), (0.9, 0.0, -0.3), (0.0, 1.0, 0.0), 44.0, 64, 64),
    )


def blend_sun() -> Case:
    """Both parts of a blend, as next event sees them."""
    return _sun_case(
        "blend-sun",
        "A blend of diffuse and rough metal in parallel light: TE = ((1 − w) ρ/π + w f) cos θi E⊥",
        Blend(Lambertian((0.2, 0.5, 0.8)), _METAL, 0.3),
        DirectionalLight((0.25, -0.9, -0.8), (5.0, 3.0, 4.0)),
        "A blend's f is the blend of the two: (1 − w) ρ/π + w F D G / (4 cos θi cos θo).",
        "how a blend is sampled: no direction is",
    )


# ---- under a lamp

_LAMP_NODES = 24


def _under_lamp(scene: Scene, bounces: int) -> Images:
    """TE = ∫ f cos θi e cos θ′ / r² dA over a rectangular lamp."""
    floor, material = _floor(scene)
    lamp = scene.surfaces[1]
    assert isinstance(lamp.shape, Quad)
    assert lamp.emission is not None
    nodes, weights = np.polynomial.legendre.leggauss(_LAMP_NODES)
    s, t = ((grid.ravel() + 1) / 2 for grid in np.meshgrid(nodes, nodes))
    y = np.array(lamp.shape.corner)[:, None] + np.outer(lamp.shape.edge_u, s) + np.outer(lamp.shape.edge_v, t)
    areas = np.outer(weights, weights).ravel() / 4 * lamp.shape.area
    e, n = np.array(lamp.emission.diffuse_radiance)[:, None], floor.normal
    assert isinstance(scene.sensor, Pinhole)
    eye, frame = np.array(scene.sensor.origin), scene.sensor.frame
    size = np.array([[0, scene.sensor.width], [0, scene.sensor.height], [1, 1]])
    right, up, forward = frame.T @ (scene.sensor.pixel_to_direction @ size)
    ends = np.stack([right, up]) / forward  # two corners of the image, in the coordinates of ``at``

    def reflected(x: Array, wo: Array) -> Array:
        """From one point of the floor, ``(channels,)``."""
        r = np.linalg.norm(y - x[:, None], axis=0)
        wi = (y - x[:, None]) / r
        geometry = (n @ wi) * -(lamp.shape.normal @ wi) / r**2  # type: ignore[union-attr]
        radiance: Array = _f(material, _local(floor, wi), _local(floor, wo[:, None])) @ (geometry * areas)
        return radiance

    def at(image: Array) -> Array:
        rays = frame @ np.stack([*image, np.ones_like(image[0])])
        wo = -rays / np.linalg.norm(rays, axis=0)
        points = eye[:, None] - wo * (n @ (np.array(floor.corner) - eye) / -(n @ wo))
        return np.stack([reflected(*pair) for pair in zip(points.T, wo.T, strict=True)], axis=1)

    @cache
    def TE() -> Callable[[Array], Array]:  # of the whole image: quadrature comes back for more points of it
        return interpolant(at, ends.min(axis=1), ends.max(axis=1))

    def series(k: int, o: Array, d: Array) -> Array:
        if k != 1:
            return np.zeros((scene.channels, d.shape[1]))
        cosines(floor, o, d)  # every ray meets the floor
        right, up, forward = frame.T @ d
        radiance: Array = e * TE()(np.stack([right, up]) / forward)
        return radiance

    return averages(scene, bounces, series)


def blend_lamp() -> Case:
    """Both parts of a blend, found both ways."""
    lamp = Quad((-0.4, 1.4, -1.9), (0.9, 0.0, 0.0), (0.0, 0.0, 0.7))
    surfaces = (
        Surface("plate", _FLOOR, Blend(Lambertian((0.2, 0.5, 0.8)), _METAL, 0.5)),
        Surface("lamp", lamp, _BLACK, AreaLight((5.0, 7.0, 4.0))),
    )
    camera = Pinhole((0.3, 1.0, 0.7), (0.4, 0.0, -0.3), (0.0, 1.0, 0.0), 44.0, 64, 64)
    return Case(
        name="blend-lamp",
        family="glossy",
        title="A blend of diffuse and rough metal under a rectangular lamp: TE by quadrature over the lamp",
        scene=Scene(surfaces, camera),
        answer=Formula(
            _under_lamp, f"{_WALTER}, eq. 20, 23, 33, 34; the rendering equation over areas, Kajiya 1986"
        ),
        bounces=2,
        tolerance=_TOLERANCE,
        derivation="""\
TE = ∫ f(wi, wo) e cos θi cos θ′ / r² dA over the lamp, with f = (1 − w) ρ/π + w F D G / (4 cos θi cos θo). Every
point of the floor sees the whole lamp, and the integrand is smooth on it: Gauss's quadrature with 24 × 24 nodes. The
result is smooth over the image and is interpolated between Chebyshev points before pixels are averaged. The camera
sees neither the lamp nor the edge of the floor: E = 0. The lamp is black: T²E = 0. Next event, sampling of
the blend, and any mixture of the two must give the same.""",
        blind_to="light that comes from anywhere else; further bounces",
    )


CASES: Mapping[str, Callable[[], Case]] = {
    "rough-metal-sky": rough_metal_sky,
    "blend-sky": blend_sky,
    "rough-glass-tank": rough_glass_tank,
    "rough-metal-sun": rough_metal_sun,
    "rough-glass-sun": rough_glass_sun,
    "blend-sun": blend_sun,
    "blend-lamp": blend_lamp,
}
