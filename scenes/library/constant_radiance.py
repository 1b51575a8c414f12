"""Spheres of constant radiance: walls that emit at every angle what they do not reflect there.

Inside a sphere a ray arrives under the angle at which it has left, so that T acts on functions of that angle alone,
and every bounce is known, not just the sum.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from scenes import fresnel, microfacets
from scenes.case import Case, Formula, Images, Tolerance
from scenes.interpolation import interpolant
from scenes.library.sphere_wall import wall_and_camera
from scenes.lights import AreaLight
from scenes.materials import Blend, Conductor, Lambertian, Material, RoughConductor
from scenes.pixel_average import pixel_average
from scenes.scene import Scene
from scenes.sensor import Pinhole
from scenes.shapes import Sphere
from scenes.surfaces import Surface

Array = NDArray[np.float64]
Field = Callable[[Array], Array]
"""Radiance that leaves the wall, everywhere alike: cosines to the normal ``(n,)`` → ``(channels, n)``."""

STEPS = 256
"""Of the profile. Its chords leave 1 − a by up to 1.4e-5 of it, at the angles that the cameras see."""

FINE = 128
"""Pixels along the shorter side of an image, from which on a pixel holds few of these steps."""

NODES = 4
"""Of Gauss's quadrature over the cosine, in each step."""

_SPHERE = """\
The chord between two points of a sphere meets the normals of both under the same angle. So where the radiance
L(θ) leaves the wall everywhere alike, a point of it receives L(θi) from the angle θi, and what it reflects,
(TL)(θo) = ∫ f(wi, wo) L(θi) cos θi dwi, is again a function of the angle alone. With the albedo
a(θ) = ∫ f cos θi dwi and E = e (1 − a) the constant e solves L = E + TL, in this as in any other closed scene of
such walls, where the sum is all that is known (Szirmay-Kalos et al. 2001). Here every bounce is.
The wall emits e p(cos θ), p the chords of 1 − a between 257 cosines: what is emitted is exactly what the answer
takes as E, and its sum over all bounces is e within 2·10⁻⁵.
"""

_SOURCE = (
    "Szirmay-Kalos, Kovács and Abbas 2001, Testing Monte-Carlo Global Illumination Methods with Analytically "
    "Computable Scenes, WSCG, p. 419–426, for the sum of closed scenes, and for spheres"
)
_BORN = "Born and Wolf 1999, Principles of Optics, §14.2"


# ---- T, as it acts on functions of the angle: what is mirrored stays at it, what is scattered is an integral


def mirrored(material: Material, c: Array) -> Array:
    """The share F of radiance that is mirrored, ``(channels, n)``, at cosines ``(n,)``."""
    match material:
        case Conductor(eta, k):
            return fresnel.conductor(c, eta, k)
        case Blend(first, second, weight):
            return (1 - weight) * mirrored(first, c) + weight * mirrored(second, c)
        case _:
            return np.zeros((material.channels or 1, len(c)))


def scattered(material: Material, field: Field) -> Field:
    """∫ f L cos θi dwi over all that is not mirrored.

    Raises:
        ValueError: a material whose reflection is not known here.
    """
    match material:
        case Lambertian(albedo) if isinstance(albedo, tuple):
            nodes, weights = np.polynomial.legendre.leggauss(NODES)
            mu = (np.arange(STEPS)[:, None] + (nodes + 1) / 2).ravel() / STEPS
            mean = field(mu) @ (mu * np.tile(weights, STEPS)) / STEPS  # 2 ∫ L μ dμ
            radiance = (np.array(albedo) * mean)[:, None]
            return lambda c: np.tile(radiance, len(c))
        case Conductor():
            return lambda c: np.zeros((material.channels, len(c)))
        case RoughConductor():
            metal, incident = material, field(microfacets.COSINES)
            found = interpolant(
                lambda c: microfacets.conductor_reflected(metal, c[0], incident), np.zeros(1), np.ones(1)
            )
            return lambda c: found(c[None])
        case Blend(first, second, weight):
            one, other = scattered(first, field), scattered(second, field)
            return lambda c: (1 - weight) * one(c) + weight * other(c)
        case _:
            raise ValueError(
                f"no reflection is known of {material}; expected a Lambertian, a metal or a blend"
            )


def series(material: Material, E: Field, bounces: int) -> Field:
    """E, TE, …, TⁿE: cosines ``(n,)`` → ``(bounces + 1, channels, n)``, by TL = F L + what is scattered of L."""
    sources: list[Field] = []

    def evaluate(c: Array) -> Array:
        F, L = mirrored(material, c), [E(c)]
        for source in sources:
            L.append(F * L[-1] + source(c))
        return np.stack(L)

    for _ in range(bounces):
        sources.append(scattered(material, lambda c: evaluate(c)[-1]))
    return evaluate


def absorbing(material: Material) -> tuple[tuple[float, ...], ...]:
    """The angular profile 1 − a(θ), to six digits."""
    cosines = np.maximum(np.arange(STEPS + 1) / STEPS, 1e-9)  # at 0 a is a limit
    albedo = series(material, lambda c: np.ones((material.channels or 1, len(c))), 1)(cosines)[1]
    return tuple(map(tuple, (1 - albedo).T.round(6).tolist()))


def emitted(light: AreaLight) -> Field:
    """E: the radiance of a light with a profile.

    Raises:
        ValueError: it has none.
    """
    if light.angular_profile is None:
        raise ValueError("the wall emits the same in every direction; expected an angular profile")
    factors = np.array(light.angular_profile).T
    steps = np.linspace(0, 1, factors.shape[1])
    e = np.array(light.radiance)[:, None]
    return lambda c: e * np.stack([np.interp(c, steps, p) for p in factors])


# ---- cases


def _images(scene: Scene, bounces: int) -> Images:
    """TᵏE where each pixel's rays meet the wall."""
    wall, shape, sensor = wall_and_camera(scene)
    if len(scene.surfaces) > 1 or scene.lights or wall.emission is None or wall.emission.polar_range:
        raise ValueError("expected nothing but a sphere that emits from all of its wall")
    o = (np.array(sensor.origin) - shape.center)[:, None] / shape.radius
    fields = series(wall.material, emitted(wall.emission), bounces)
    # later bounces are darker, and are to be as exact
    in_view = np.linspace(math.sqrt(1 - float((o**2).sum())), 1, 100)
    scales = fields(in_view).max(axis=(1, 2))
    scales[scales == 0] = 1

    def radiance(_: Array, d: Array) -> Array:
        closest = o - (o * d).sum(axis=0) * d
        found = fields(np.sqrt(1 - (closest**2).sum(axis=0))) / scales[:, None, None]
        return np.asarray(found.reshape(-1, d.shape[1]))

    image = _average(sensor, radiance).reshape(*scene.shape[:2], bounces + 1, -1)
    return np.moveaxis(image * scales[:, None], 2, 0)


def _total(scene: Scene) -> Images:
    """The constant e, within 2·10⁻⁵."""
    wall, _, _ = wall_and_camera(scene)
    assert wall.emission is not None
    return np.broadcast_to(np.array(wall.emission.radiance), scene.shape).copy()


def _average(sensor: Pinhole, radiance: Callable[[Array, Array], Array]) -> Array:
    """The mean over every pixel; of large ones over the small ones inside, on which the profile is smooth enough."""
    times = math.ceil(FINE / min(sensor.width, sensor.height))
    fine = pixel_average(replace(sensor, width=times * sensor.width, height=times * sensor.height), radiance)
    blocks = fine.reshape(sensor.height, times, sensor.width, times, -1)
    return np.asarray(blocks.mean(axis=(1, 3)))


def _case(name: str, title: str, material: Material, source: str, derivation: str, **other: Any) -> Case:
    wall = Surface(
        "wall",
        Sphere((0.0, 0.0, 0.0), 1.0, inward=True),
        material,
        AreaLight((1.0, 2.0, 3.0), angular_profile=absorbing(material)),
    )
    sensor = Pinhole((0.3, -0.4, 0.8), (1.0, 0.2, -0.4), (0.1, 1.0, 0.0), 90.0, 64, 64)
    usual: dict[str, Any] = {"bounces": 5, "tolerance": Tolerance(image=(0.005,), tile=(0.02,))}
    return Case(
        name=name,
        family="constant_radiance",
        title=title,
        scene=Scene((wall,), sensor),
        answer=Formula(_images, f"{_SOURCE}; {source}", total=_total),
        derivation=_SPHERE + derivation,
        **(usual | other),
    )


def mirror() -> Case:
    """Smooth metal: what leaves at an angle stays at it."""
    metal = Conductor(eta=(1.5, 1.2, 1.0), k=(0.3, 1.0, 2.0))
    return _case(
        "constant-radiance-mirror",
        "Inside of a sphere of smooth metal that emits e (1 − F(θ)): TᵏE = F(θ)ᵏ E(θ), in all e",
        metal,
        _BORN,
        "A mirrored ray keeps its angle at every bounce, so that a is Fresnel's F(θ), and TᵏE = F(θ)ᵏ E(θ).",
        blind_to="where mirrored rays go, as long as they keep their angle; next event, which mirrors leave out",
    )


def rough() -> Case:
    """Rough metal: what leaves at an angle comes from angles about it."""
    metal = RoughConductor(eta=(3.0, 0.5, 0.2), k=(3.0, 2.5, 3.9), alpha=0.3, shadowing="separable")
    return _case(
        "constant-radiance-rough",
        "Inside of a sphere of rough metal that emits e (1 − a(θ)): TᵏE by quadrature over the angle, in all e",
        metal,
        "Walter, Marschner, Li and Torrance 2007, EGSR, eq. 20, 23, 33, 34, by Gauss's quadrature",
        """\
f = F D G / (4 cos θi cos θo) of GGX facets, with separable shadowing; what is lost between facets is counted as
absorbed. T is a quadrature over the hemisphere, of 80 polar angles and 80 azimuths, which crowd where the lobe is
narrow; as a function of cos θo its result is analytic, and taken to the next bounce as a Chebyshev series.""",
        blind_to="small errors in the shape of the lobe that leave its albedo: a diffuse one of the same albedo "
        "changes TE by up to 7 %, a mirror by up to 14 %; where reflected rays arrive; a profile read at the wrong "
        "end of a ray, for both angles are the same",
    )


def blend() -> Case:
    """Varnish: a diffuse lobe, which any strategy finds, and a smooth one, which only sampling does."""
    metal = Conductor(eta=(1.5, 1.2, 1.0), k=(0.3, 1.0, 2.0))
    return _case(
        "constant-radiance-blend",
        "Inside of a sphere, diffuse and smooth metal: (TL)(θ) = (1 − w) ρ 2∫ L μ dμ + w F(θ) L(θ), in all e",
        Blend(Lambertian((0.6, 0.7, 0.8)), metal, 0.4),
        f"{_BORN}; linearity of R in f",
        """\
The diffuse lobe reflects ρ times the mean of L over the hemisphere, weighted by the cosine, 2 ∫ L(μ) μ dμ with
μ = cos θ, into every direction alike; the smooth one F(θ) L(θ). So a = (1 − w) ρ + w F(θ), and each bounce is one
integral over [0, 1] and one product.""",
        blind_to="where reflected rays arrive; directions of the diffuse lobe that keep its mean of L; a profile "
        "read at the wrong end of a ray, for both angles are the same",
    )


CASES: Mapping[str, Callable[[], Case]] = {
    "constant-radiance-mirror": mirror,
    "constant-radiance-rough": rough,
    "constant-radiance-blend": blend,
}
