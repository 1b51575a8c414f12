"""Spheres of constant radiance by rays followed through space, and rough metal by its facets.

Of the formulas, and of the library's camera, nothing is used: rays are met with the sphere by hand, reflectances
come from wave impedances, microfacets from slopes (see ``test_glossy``), and the angle of arrival from the normal
where a ray arrives.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from scenes import AreaLight, Blend, Conductor, Lambertian, Mirror, PolarRange, RoughConductor, Scene, Surface
from scenes.case import Case
from scenes.library import case
from scenes.library.constant_radiance import CASES, series


def loaded(file: str) -> Any:
    """A module of the tests beside this one."""
    spec = importlib.util.spec_from_file_location(Path(file).stem, Path(__file__).with_name(file))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


facets, camera_rays = loaded("test_glossy.py"), loaded("brute_force.py").camera_rays
MIRROR, ROUGH, BLEND = "constant-radiance-mirror", "constant-radiance-rough", "constant-radiance-blend"
TOLERANCE = {MIRROR: 1e-6, ROUGH: 1e-5, BLEND: 1e-6}
BOUNCES, WIDTH, HEIGHT, NODES = 5, 3, 2, 60

Field = Callable[[np.ndarray], np.ndarray]
"""Cosines ``(n,)`` → radiance ``(channels, n)``."""


# ---- rays in the sphere


def arrivals(x: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where rays from points x ``(3, n)`` in the unit sphere, or on it, meet the wall, and the cosine there."""
    b, c = (x * d).sum(axis=0), (x * x).sum(axis=0) - 1
    t = -b + np.sqrt(np.maximum(b * b - c, 0))
    y = x + t * d
    return y, (y * d).sum(axis=0) / np.linalg.norm(y, axis=0)


def rays(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Origins and directions ``(3, n)`` of NODES² rays through each pixel of the image, and what each counts."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    nodes, weights = (nodes + 1) / 2, weights / 2
    row, column, i, j = (g.ravel() for g in np.indices((HEIGHT, WIDTH, NODES, NODES)))
    o, d = camera_rays(scene.sensor, column + nodes[j], row + nodes[i])
    assert scene.surfaces[0].shape.radius == 1
    assert scene.surfaces[0].shape.center == (0, 0, 0)
    return o.T, d.T, weights[i] * weights[j]


def averages(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """``(channels, rays)`` → ``(height, width, channels)``."""
    return (values * weights).reshape(-1, HEIGHT, WIDTH, NODES**2).sum(axis=3).transpose(1, 2, 0)


def emission(light: AreaLight) -> Field:
    """The profile, searched step by step."""
    rows, e = np.array(light.angular_profile), np.array(light.radiance)

    def E(c: np.ndarray) -> np.ndarray:
        step = np.searchsorted(np.linspace(0, 1, len(rows)), c, side="right").clip(1, len(rows) - 1) - 1
        share = (c * (len(rows) - 1) - step)[:, None]
        return ((rows[step] * (1 - share) + rows[step + 1] * share) * e).T

    return E


def constant(light: AreaLight) -> Field:
    return lambda c: np.tile(np.array(light.radiance)[:, None], len(c))


def fresnel(metal: Conductor | RoughConductor, cosine: np.ndarray) -> np.ndarray:
    return np.stack([facets.boundary(cosine, e + 1j * k) for e, k in zip(metal.eta, metal.k, strict=True)])


# ---- every bounce: origins and directions of the camera's rays → ``(bounces + 1, channels, n)``


def by_mirrors(metal: Conductor, E: Field, x: np.ndarray, d: np.ndarray, bounces: int) -> np.ndarray:
    """Each ray is followed through space, from mirror to mirror."""
    found, throughput = [], np.ones((3, x.shape[1]))
    for _ in range(bounces + 1):
        x, cosine = arrivals(x, d)
        found.append(throughput * E(cosine))
        throughput = throughput * fresnel(metal, cosine)
        d = d - 2 * (d * x).sum(axis=0) * x / (x * x).sum(axis=0)
    return np.array(found)


def by_blend(blend: Blend, E: Field, x: np.ndarray, d: np.ndarray, bounces: int) -> np.ndarray:
    """The diffuse part from all directions of the hemisphere above a point, each followed to where it arrives."""
    assert isinstance(blend.first, Lambertian)
    assert isinstance(blend.second, Conductor)
    z = (np.arange(20_000) + 0.5) / 20_000
    phi = np.arange(len(z)) * 2.4  # any azimuth will do
    wi = np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), -z])
    _, around = arrivals(np.tile([[0.0], [0.0], [1.0]], len(z)), wi)
    _, seen = arrivals(x, d)
    F_around, F_seen = fresnel(blend.second, around), fresnel(blend.second, seen)
    L_around, L_seen, found = E(around), E(seen), []
    for _ in range(bounces + 1):
        found.append(L_seen)
        # ∫ f L cos θ dω = ρ ∫ 2z L dz
        diffuse = (np.array(blend.first.albedo) * (2 * z * L_around).mean(axis=1))[:, None]
        L_around, L_seen = (
            (1 - blend.weight) * diffuse + blend.weight * F * L
            for F, L in ((F_around, L_around), (F_seen, L_seen))
        )
    return np.array(found)


def by_facets(metal: RoughConductor, E: Field, x: np.ndarray, d: np.ndarray, bounces: int) -> np.ndarray:
    """Radiance as a polynomial in the angle, which every facet that mirrors a direction sends on."""
    nodes, to_series, T = transfers(metal)
    first = E(np.cos((nodes + 1) * np.pi / 4))
    _, cosine = arrivals(x, d)
    basis = at_angles(np.arccos(np.minimum(cosine, 1)), to_series)
    L, found = np.einsum("con,cn->co", T, first), [E(cosine)]
    for _ in range(bounces):
        found.append(L @ basis.T)
        L = np.einsum("con,cn->co", T, L)
    return np.array(found)


@cache
def transfers(metal: RoughConductor) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes in −1 to 1 of the angle, the matrix from values there to coefficients, and T at the nodes."""
    count = 22
    nodes = np.polynomial.chebyshev.chebpts1(count)
    to_series = np.linalg.inv(np.polynomial.chebyshev.chebvander(nodes, count - 1))
    T = np.stack([transfer(metal, (theta + 1) * np.pi / 4, to_series) for theta in nodes], axis=1)
    return nodes, to_series, T


def at_angles(theta: np.ndarray, to_series: np.ndarray) -> np.ndarray:
    """What a polynomial's values at the nodes count for at other angles, ``(n, nodes)``."""
    return np.polynomial.chebyshev.chebvander(4 * theta / np.pi - 1, len(to_series) - 1) @ to_series


def transfer(metal: RoughConductor, theta: float, to_series: np.ndarray) -> np.ndarray:
    """TL at an angle, from L at the nodes, ``(channels, nodes)``: midpoints over slopes, as in ``test_glossy``.

    The wall is at +z, and looks down. With n = 1,200 all five bounces agree with the answer to 3.5e-7.
    """
    n = 360
    v, phi = (g.ravel() for g in np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n * np.pi))
    r = metal.alpha * np.sqrt(1 - v**2) / v
    m = facets.facing(-r * np.cos(phi), -r * np.sin(phi))
    wo = np.array([np.sin(theta), 0.0, np.cos(theta)])[:, None]
    cos_om = (wo * m).sum(axis=0)
    wi = facets.mirrored(wo * np.ones_like(m), m)
    counts = np.flatnonzero((cos_om > 0) & (wi[2] > 1e-9))
    m, wi, cos_om = m[:, counts], wi[:, counts], cos_om[counts]
    with np.errstate(divide="ignore"):
        G = facets.seen_table(wi, metal.alpha) * facets.seen(wo, metal.alpha)
    weight = cos_om / (m[2] * wo[2]) * G * 2 * v[counts] / n**2
    _, arriving = arrivals(np.tile([[0.0], [0.0], [1.0]], len(counts)), wi * [[1.0], [1.0], [-1.0]])
    return (fresnel(metal, cos_om) * weight) @ at_angles(np.arccos(np.minimum(arriving, 1)), to_series)


FOLLOWED: dict[str, Callable[..., np.ndarray]] = {MIRROR: by_mirrors, ROUGH: by_facets, BLEND: by_blend}


@cache
def expected(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Every bounce of a case by the above, and T⁶e of the constant e, which is what five bounces lack of e."""
    scene = case(name).scene.resized(WIDTH, HEIGHT)
    wall, (x, d, weights) = scene.surfaces[0], rays(scene)
    assert wall.emission is not None
    bounces = FOLLOWED[name](wall.material, emission(wall.emission), x, d, BOUNCES)
    rest = FOLLOWED[name](wall.material, constant(wall.emission), x, d, BOUNCES + 1)[-1]
    return np.stack([averages(values, weights) for values in bounces]), averages(rest, weights)


def answer(found: Case, scene: Scene) -> np.ndarray:
    truth = found.answer.truth(scene.resized(WIDTH, HEIGHT), BOUNCES)
    assert truth is not None
    return truth.mean


def difference(found: np.ndarray, name: str) -> float:
    """The largest, relative to the brightest pixel of its bounce."""
    images, _ = expected(name)
    return float((np.abs(found - images) / images.max(axis=(1, 2, 3), keepdims=True)).max())


def test_a_chord_meets_both_normals_under_the_same_angle() -> None:
    x, d = np.random.default_rng(1).normal(size=(2, 3, 50))
    x, d = x / np.linalg.norm(x, axis=0), d / np.linalg.norm(d, axis=0)
    leaving = (x * d).sum(axis=0)
    _, arriving = arrivals(x, d * -np.sign(leaving))
    np.testing.assert_allclose(arriving, np.abs(leaving), rtol=1e-12)


@pytest.mark.parametrize("name", CASES)
def test_every_bounce(name: str) -> None:
    found = case(name)
    images = answer(found, found.scene)
    assert difference(images, name) < TOLERANCE[name]
    for image in images:  # and no bounce is the same everywhere
        assert np.ptp(image[..., 0]) > 0.01 * image[..., 0].mean()


@pytest.mark.parametrize("name", CASES)
def test_the_sum_is_constant(name: str) -> None:
    """What five bounces lack of e is T⁶e; the chords of the profile leave the 2·10⁻⁵ that the page speaks of."""
    found = case(name)
    total = answer(found, found.scene).sum(axis=0) + expected(name)[1]
    e = found.scene.surfaces[0].emission.radiance
    np.testing.assert_allclose(total, np.broadcast_to(e, total.shape), rtol=2e-5)


@pytest.mark.parametrize("name", [MIRROR, BLEND])
def test_how_close_the_profile_is(name: str) -> None:
    """1.4e-5, from the steepest angle that the camera sees on."""
    scene = case(name).scene
    wall, steepest = scene.surfaces[0], np.sqrt(1 - np.dot(scene.sensor.origin, scene.sensor.origin))
    cosine = np.linspace(steepest, 1, 9000)
    material = wall.material
    a = fresnel(material.second if isinstance(material, Blend) else material, cosine)
    if isinstance(material, Blend):
        a = (1 - material.weight) * np.array(material.first.albedo)[:, None] + material.weight * a
    emitted = emission(wall.emission)(cosine) / np.array(wall.emission.radiance)[:, None]
    assert np.abs(emitted / (1 - a) - 1).max() < 1.4e-5


@pytest.mark.parametrize("step", [1, 3, 40])
def test_the_profile_of_rough_metal(step: int) -> None:
    """1 − a at cosines down to 1/256, where the lobe is very narrow; six digits were kept."""
    wall = case(ROUGH).scene.surfaces[0]
    cosine = step / 256
    wo = np.array([np.sqrt(1 - cosine**2), 0.0, cosine])
    albedo = facets.albedo(wall.material, wo, below=False)
    np.testing.assert_allclose(wall.emission.angular_profile[step], 1 - albedo, rtol=0, atol=2e-6)


def changed(scene: Scene, **fields: Any) -> Scene:
    wall = msgspec.structs.replace(scene.surfaces[0], **fields)
    return msgspec.structs.replace(scene, surfaces=(wall, *scene.surfaces[1:]))


def diffuse(wall: Surface) -> dict[str, Any]:
    """The same power into every direction alike."""
    factors = np.array(wall.emission.angular_profile)
    mean = np.average(factors, axis=0, weights=np.arange(len(factors)))
    return {"emission": msgspec.structs.replace(wall.emission, angular_profile=np.stack([mean, mean]))}


def other(**fields: Any) -> Callable[[Surface], dict[str, Any]]:
    return lambda wall: {"material": msgspec.structs.replace(wall.material, **fields)}


@pytest.mark.parametrize(
    ("name", "fault"),
    [
        *((name, diffuse) for name in (MIRROR, ROUGH, BLEND)),
        (MIRROR, other(k=(0.31, 1.0, 2.0))),
        (ROUGH, other(alpha=0.302)),
        (BLEND, other(weight=0.501)),
    ],
)
def test_planted_faults_are_found(name: str, fault: Callable[[Surface], dict[str, Any]]) -> None:
    found = case(name)
    scene = changed(found.scene, **fault(found.scene.surfaces[0]))
    assert difference(answer(found, scene), name) > 50 * TOLERANCE[name]


def test_lobes_of_another_shape_are_seen() -> None:
    """Of the same albedo, but diffuse, or a mirror: TE is off by up to 7 % and 14 %, as the case says."""
    wall = case(ROUGH).scene.surfaces[0]
    E, cosine = emission(wall.emission), np.linspace(0.33, 1, 50)
    albedo, TE = (
        series(wall.material, field, 1)(cosine)[1] for field in (constant(AreaLight((1.0, 1.0, 1.0))), E)
    )
    mu = (np.arange(10_000) + 0.5) / 10_000
    diffuse = albedo * (2 * mu * E(mu)).mean(axis=1)[:, None]
    assert np.abs(diffuse / TE - 1).max() == pytest.approx(0.07, abs=0.005)
    assert np.abs(albedo * E(cosine) / TE - 1).max() == pytest.approx(0.14, abs=0.005)


def test_size_and_place_do_not_matter() -> None:
    found = case(BLEND)
    wall, sensor = found.scene.surfaces[0], found.scene.sensor
    shape = msgspec.structs.replace(wall.shape, center=(1.0, 2.0, 3.0), radius=2.0)
    places = {
        field: tuple((2 * np.array(getattr(sensor, field)) + [1, 2, 3]).tolist())
        for field in ("origin", "target")
    }
    scene = Scene((msgspec.structs.replace(wall, shape=shape),), msgspec.structs.replace(sensor, **places))
    np.testing.assert_allclose(answer(found, scene), answer(found, found.scene), rtol=1e-9)


def test_what_is_no_such_sphere_is_refused() -> None:
    found = case(MIRROR)
    light = found.scene.surfaces[0].emission
    no_profile = {"emission": AreaLight((1.0, 1.0, 1.0))}
    zone = {"emission": msgspec.structs.replace(light, polar_range=PolarRange(0.0, 90.0))}
    unknown = {"material": Mirror((0.5, 0.5, 0.5))}
    for fields, message in ((no_profile, "angular profile"), (zone, "all of its wall"), (unknown, "Mirror")):
        with pytest.raises(ValueError, match=message):
            answer(found, changed(found.scene, **fields))
