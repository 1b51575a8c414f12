"""Area lights whose radiance depends on the angle, held against quadrature over their surfaces.

The quadrature shares nothing with the tracer: points, normals and areas of each shape are written out here, and the
profile is NumPy's ``interp``.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from reference_tracer.emission import Emitters
from reference_tracer.emitters.angular_profile import AngularProfile
from reference_tracer.emitters.area_lights import AreaEmitter
from reference_tracer.points import NOWHERE, Points
from reference_tracer.propagation import RayCaster
from reference_tracer.random_walk import STRATEGIES, Strategy, render
from scenes import (
    AreaLight,
    Disk,
    Ellipsoid,
    Lambertian,
    Mesh,
    Pinhole,
    PolarRange,
    Quad,
    RadianceMeter,
    Scene,
    Shape,
    Sphere,
    Surface,
)

CAMERA = Pinhole((0.0, 0.0, 9.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0, 4, 4)
RADIANCE = (3.0, 5.0)
STRAIGHT = ((0.3, 2.0), (1.7, 0.5))  # without a corner: Gauss's rule has no error to speak of
BENT = ((0.2, 1.5), (0.9, 0.3), (0.4, 0.0), (1.6, 0.8), (0.1, 1.0))

RECTANGLE = Quad((-0.6, -0.5, 2.0), (0.0, 1.2, 0.0), (1.5, 0.0, 0.0))  # its front looks down
DISK = Disk((0.3, 0.1, 2.0), (0.1, 0.8, 0.1), (1.1, 0.2, 0.1))
BALL, CAVITY = Sphere((0.3, 0.2, 2.0), 0.9), Sphere((0.3, 0.2, 0.5), 1.7, inward=True)
EGG = Ellipsoid((0.3, 0.2, 2.0), (1.1, 0.0, 0.2), (0.1, 0.6, 0.0), (0.0, 0.3, 0.8))
OCTAHEDRON = Mesh(
    ((1.0, 0.0, 2.0), (-0.8, 0.0, 2.0), (0.0, 0.7, 2.0), (0.0, -0.9, 2.0), (0.1, 0.0, 3.0), (0.0, 0.2, 1.2)),
    ((0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)),
)
ZONE = PolarRange(20, 150, (0.6, 0.0, -0.8))
BELOW, WITHIN = (0.4, -0.3, 0.1), (0.9, -0.3, 0.4)

PLACES: dict[str, tuple[Shape, tuple[float, float, float], PolarRange | None]] = {
    "rectangle, by area": (RECTANGLE, (0.4, -0.3, -1.0), None),
    "rectangle, by solid angle": (RECTANGLE, (0.4, 0.3, 1.2), None),
    "disk": (DISK, BELOW, None),
    "ball": (BALL, BELOW, None),
    "cavity": (CAVITY, WITHIN, None),
    "zone of a cavity": (CAVITY, WITHIN, ZONE),
    "egg": (EGG, BELOW, None),
    "mesh": (OCTAHEDRON, BELOW, None),
}


def scene_of(
    shape: Shape, profile: tuple | None, zone: PolarRange | None = None, two_sided: bool = False
) -> Scene:
    light = AreaLight(RADIANCE, zone, profile)
    return Scene((Surface("lamp", shape, Lambertian((0.5, 0.5)), light, two_sided),), CAMERA)


def at(x: tuple, count: int, primitive: int = NOWHERE) -> Points:
    surface = np.full(count, 0 if primitive >= 0 else NOWHERE)
    places, up = (np.tile(np.array(v, dtype=float)[:, None], count) for v in (x, (0, 0, 1)))
    return Points(places, up, surface, primitive=np.full(count, primitive))


def gauss(count: int, low: float = 0.0, high: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return low + (high - low) * (nodes + 1) / 2, weights * (high - low) / 2


def emitted(profile: tuple, cosine: np.ndarray) -> np.ndarray:
    """Le ``(channels, n)``."""
    steps = np.linspace(0, 1, len(profile))
    factors = [np.interp(cosine, steps, column) for column in np.array(profile).T]
    return np.array(RADIANCE)[:, None] * factors


# ---- points y ``(n, 3)`` of shapes, and their areas as vectors along the side that emits


def flat(p: np.ndarray, u: np.ndarray, v: np.ndarray, kind: str) -> tuple[np.ndarray, np.ndarray]:
    a, weights = gauss(240)
    s, t = (g.ravel() for g in np.meshgrid(a, a, indexing="ij"))
    dA = np.outer(weights, weights).ravel()
    if kind == "triangle":  # a square, one of whose sides has shrunk
        s, t, dA = s * (1 - t), s * t, dA * s
    elif kind == "disk":
        phi = 2 * np.pi * (np.arange(180) + 0.3) / 180
        r, phi = (g.ravel() for g in np.meshgrid(np.sqrt(a), phi, indexing="ij"))
        s, t, dA = r * np.cos(phi), r * np.sin(phi), np.repeat(weights * np.pi / 180, 180)
    return p + np.outer(s, u) + np.outer(t, v), np.outer(dA, np.cross(u, v))


def round_one(shape: Sphere | Ellipsoid, axis: np.ndarray, low: float, high: float) -> tuple:
    """The part whose image on the unit sphere has a cosine to the axis between two limits."""
    M = shape.matrix if isinstance(shape, Ellipsoid) else shape.radius * np.eye(3)
    z, weights = gauss(1000, low, high)
    across = np.cross(axis, [0.6, -0.64, 0.48])
    across /= np.linalg.norm(across)
    z, phi = (g.ravel() for g in np.meshgrid(z, 2 * np.pi * (np.arange(200) + 0.3) / 200, indexing="ij"))
    r = np.sqrt(1 - z**2)
    p = (
        np.outer(z, axis)
        + np.outer(r * np.cos(phi), across)
        + np.outer(r * np.sin(phi), np.cross(axis, across))
    )
    dA = abs(np.linalg.det(M)) * p @ np.linalg.inv(M) * np.repeat(weights * 2 * np.pi / 200, 200)[:, None]
    return shape.center + p @ M.T, -dA if shape.inward else dA


def parts(shape: Shape, x: np.ndarray, zone: PolarRange | None) -> tuple[np.ndarray, np.ndarray]:
    if isinstance(shape, Quad):
        return flat(*map(np.array, (shape.corner, shape.edge_u, shape.edge_v)), "quad")
    if isinstance(shape, Disk):
        return flat(*map(np.array, (shape.center, shape.axis_u, shape.axis_v)), "disk")
    if isinstance(shape, Mesh):
        found = [
            flat(a, b - a, c - a, "triangle") for a, b, c in np.array(shape.vertices)[list(shape.triangles)]
        ]
        y, dA = (np.concatenate(each) for each in zip(*found, strict=True))
        return y, dA
    if zone is not None:
        return round_one(shape, np.array(zone.axis), *np.cos(np.radians([zone.high, zone.low])))
    if shape.inward:
        return round_one(shape, np.array([0.0, 0.0, 1.0]), -1, 1)
    M = shape.matrix if isinstance(shape, Ellipsoid) else shape.radius * np.eye(3)
    o = np.linalg.solve(M, x - shape.center)
    away = float(np.linalg.norm(o))
    return round_one(shape, o / away, 1 / away, 1.0)


def by_quadrature(
    shape: Shape, profile: tuple, x: tuple, zone: PolarRange | None, n: tuple | None = None
) -> np.ndarray:
    """∫ Le cos θ′ / t² dA, what arrives at x from everywhere; with a normal its irradiance, times cos θ inside."""
    y, dA = parts(shape, np.array(x), zone)
    back = np.array(x) - y
    t = np.linalg.norm(back, axis=1)
    projected = np.maximum((back * dA).sum(axis=1) / t, 0)  # cos θ′ dA; what looks away is not seen
    weight = projected / t**2
    if n is not None:
        weight = weight * np.maximum(-back @ n / t, 0)
    return emitted(profile, projected / np.linalg.norm(dA, axis=1)) @ weight


# ---- what next event finds


def by_sampling(scene: Scene, x: tuple, panels: int) -> np.ndarray:
    """The same as the mean of Li / pdf, by Gauss's rule over the unit square of random numbers."""
    nodes, weights = gauss(32)
    nodes = ((nodes + np.arange(panels)[:, None]) / panels).ravel()
    u = np.stack(np.meshgrid(nodes, nodes)).reshape(2, -1)
    weights = np.tile(weights / panels, panels)
    sample = Emitters(scene).sample(at(x, u.shape[1]), u)
    return (sample.Li / sample.pdf) @ np.outer(weights, weights).ravel()


@pytest.mark.parametrize("place", [name for name in PLACES if name != "mesh"])
@pytest.mark.parametrize(("profile", "rtol"), [(STRAIGHT, 1e-5), (BENT, 2e-3)])
def test_next_event(place: str, profile: tuple, rtol: float) -> None:
    shape, x, zone = PLACES[place]
    found = by_sampling(scene_of(shape, profile, zone), x, 8)
    np.testing.assert_allclose(found, by_quadrature(shape, profile, x, zone), rtol=rtol)
    # without the profile it would be something else
    plain = by_sampling(scene_of(shape, None, zone), x, 8)
    assert (np.abs(found / plain - 1) > 0.05).any()


def test_next_event_on_a_mesh(expect_means: Callable[..., None]) -> None:
    """Its triangles make steps in the unit square: random numbers instead."""
    u = np.random.default_rng(11).random((2, 64 * 2000))
    sample = Emitters(scene_of(OCTAHEDRON, BENT)).sample(at(BELOW, u.shape[1]), u)
    found = (sample.Li / sample.pdf).reshape(2, 64, 2000).mean(axis=2).T
    expect_means(found, by_quadrature(OCTAHEDRON, BENT, BELOW, None), resolution=0.04)


def test_next_event_from_the_sphere_itself() -> None:
    """A chord meets both ends alike: the irradiance is 2π ∫ p(μ) μ dμ."""
    outward = np.array([0.48, 0.6, 0.64])
    x = tuple(np.array(CAVITY.center) + CAVITY.radius * outward)
    sample = Emitters(scene_of(CAVITY, BENT)).sample(
        at(x, 2000, primitive=0), np.stack([(np.arange(2000) + 0.5) / 2000, np.full(2000, 0.3)])
    )
    found = (sample.Li * (-outward @ sample.wi) / sample.pdf).mean(axis=1)
    mu, weights = gauss(1000)
    np.testing.assert_allclose(found, 2 * np.pi * emitted(BENT, mu) @ (mu * weights), rtol=1e-5)


def test_both_sides_have_the_same_profile() -> None:
    above = (0.4, -0.3, 5.0)
    mirror_image = (0.4, -0.3, -1.0)  # the rectangle lies at z = 2
    assert not by_sampling(scene_of(RECTANGLE, BENT), above, 8).any()
    found = by_sampling(scene_of(RECTANGLE, BENT, two_sided=True), above, 8)
    np.testing.assert_allclose(found, by_quadrature(RECTANGLE, BENT, mirror_image, None), rtol=2e-3)


# ---- what chance finds


@pytest.mark.parametrize("place", PLACES)
def test_what_is_chosen_and_what_is_met_are_the_same(place: str) -> None:
    shape, x, zone = PLACES[place]
    scene = scene_of(shape, BENT, zone)
    emitters, reference = Emitters(scene), at(x, 4000)
    sample = emitters.sample(reference, np.random.default_rng(3).random((2, 4000)))
    met = RayCaster(scene)(reference, sample.wi)
    seen = (met.primitive == sample.primitive) & (sample.Li.any(axis=0))
    assert seen.sum() > 400
    np.testing.assert_allclose(
        emitters.Le(met, -sample.wi)[:, seen], sample.Li[:, seen], rtol=1e-5, atol=1e-6
    )


def test_emission_at_every_angle() -> None:
    cosine = np.array([-1.0, -0.3, 0.1, 0.25, 0.5, 0.8, 1.0])
    n = np.tile(RECTANGLE.normal[:, None], len(cosine))
    wo = np.stack([np.sqrt(1 - cosine**2), 0 * cosine, 0 * cosine]) + cosine * n
    points = Points(np.zeros((3, len(cosine))), n, np.zeros(len(cosine), dtype=int))
    found = Emitters(scene_of(RECTANGLE, BENT)).Le(points, wo)
    np.testing.assert_allclose(found, emitted(BENT, cosine) * (cosine > 0), rtol=1e-12)


# ---- all of it, by each strategy

FLOOR = Quad((-1.0, -1.0, -0.5), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0))
RHO = (0.5, 0.8)
LAMPS: dict[str, Shape] = {
    "quad": RECTANGLE,
    "disk": DISK,
    "sphere": BALL,
    "ellipsoid": EGG,
    "mesh": OCTAHEDRON,
}


def on_the_floor(name: str) -> tuple[Scene, np.ndarray]:
    """A scene of one pixel, which sees a point of the floor below a lamp; and TE there."""
    shape, x, n = LAMPS[name], (0.3, -0.2, -0.5), (0.0, 0.0, 1.0)
    lamp = Surface("lamp", shape, Lambertian((0.0, 0.0)), AreaLight(RADIANCE, angular_profile=BENT))
    meter = RadianceMeter((0.3, -0.2, 0.0), (0.0, 0.0, -1.0))
    scene = Scene((Surface("floor", FLOOR, Lambertian(RHO)), lamp), meter)
    return scene, np.array(RHO) / np.pi * by_quadrature(shape, BENT, x, None, n)


def replicates(scene: Scene, strategy: Strategy) -> np.ndarray:
    return np.array([render(scene, 1, 4096, seed, strategy, "sobol")[1, 0, 0] for seed in range(16)])


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("name", LAMPS)
def test_each_strategy(name: str, strategy: Strategy, expect_means: Callable[..., None]) -> None:
    scene, expected = on_the_floor(name)
    expect_means(replicates(scene, strategy), expected, resolution=0.05 if strategy == "bsdf" else 0.02)


def upside_down(self: AngularProfile, cosine: np.ndarray) -> np.ndarray:
    return emitted(BENT, 1 - np.clip(cosine, 0, 1)) / np.array(RADIANCE)[:, None]


@pytest.mark.parametrize(
    ("strategy", "owner", "method", "fault"),
    [
        ("nee", AreaEmitter, "sample", lambda self, reference, u: self._sample(reference, u)),
        ("mis", AreaEmitter, "sample", lambda self, reference, u: self._sample(reference, u)),
        ("nee", AngularProfile, "__call__", upside_down),
        ("bsdf", AngularProfile, "__call__", upside_down),
    ],
)
def test_planted_faults_are_found(
    strategy: Strategy,
    owner: type,
    method: str,
    fault: Callable,
    expect_means: Callable[..., None],
    off: type[Exception],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A profile that next event leaves out, or that is read from the wrong end."""
    scene, expected = on_the_floor("disk")
    monkeypatch.setattr(owner, method, fault)
    with pytest.raises(off):
        expect_means(replicates(scene, strategy), expected, resolution=0.05)


# ---- the power


@pytest.mark.parametrize("profile", [STRAIGHT, BENT])
def test_the_mean_of_a_profile(profile: tuple) -> None:
    """2 ∫ p(μ) μ dμ, panel by panel."""
    profile_of = AngularProfile(AreaLight(RADIANCE, angular_profile=profile))
    expected = np.zeros(2)
    for i in range(len(profile) - 1):
        mu, weights = gauss(4, i / (len(profile) - 1), (i + 1) / (len(profile) - 1))
        expected += emitted(profile, mu) / np.array(RADIANCE)[:, None] @ (2 * mu * weights)
    np.testing.assert_allclose(profile_of.mean, expected, rtol=1e-12)


def test_emitters_are_chosen_by_what_they_give_off() -> None:
    """Of two alike squares, one with a profile that halves its power."""
    other = Quad((-0.6, -0.5, 4.0), (0.0, 1.2, 0.0), (1.5, 0.0, 0.0))
    black = Lambertian((0.0, 0.0))
    surfaces = (
        Surface("plain", RECTANGLE, black, AreaLight((1.0, 1.0))),
        Surface("half", other, black, AreaLight((1.0, 1.0), angular_profile=((0.7, 0.3), (0.7, 0.3)))),
    )
    u = np.stack([np.full(3000, 0.5), np.full(3000, 0.5), (np.arange(3000) + 0.5) / 3000])
    sample = Emitters(Scene(surfaces, CAMERA)).sample(at((0, 0, 0), 3000), u)
    assert (sample.primitive == 0).sum() == 2000
