"""Rough surfaces by their facets: slopes, derivatives of the map from slopes to directions, Smith's integral.

Of the light from wi that the facets of slopes (p, q) send to wo, f cos θi dwi = F G P(p, q) (wo·m) / (cos θm cos θo)
dp dq, with the GGX density of slopes P = α² / (π (α² + p² + q²)²). No formula for D, G1 or a Jacobian is used.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from scenes import Blend, Conductor, Lambertian, Pinhole, RoughConductor, RoughDielectric, Scene
from scenes.library import case

SKY, SUN = (
    ("rough-metal-sky", "blend-sky", "rough-glass-tank"),
    ("rough-metal-sun", "rough-glass-sun", "blend-sun"),
)
SPOTS = [(0.35, -0.2), (-0.6, -0.9), (0.9, -0.5)]


def boundary(cos_theta: np.ndarray, index: complex) -> np.ndarray:
    """R from the two wave impedances, for both polarisations."""
    beyond = np.sqrt(index**2 - 1 + np.asarray(cos_theta, complex) ** 2)
    s = (cos_theta - beyond) / (cos_theta + beyond)
    p = (beyond / index**2 - cos_theta) / (beyond / index**2 + cos_theta)
    return (np.abs(s) ** 2 + np.abs(p) ** 2) / 2


def slopes_density(p: np.ndarray, q: np.ndarray, alpha: float) -> np.ndarray:
    return alpha**2 / (np.pi * (alpha**2 + p**2 + q**2) ** 2)


def facing(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    m = np.stack([-p, -q, np.ones_like(p)])
    return m / np.linalg.norm(m, axis=0)


def seen(w: np.ndarray, alpha: float) -> np.ndarray:
    """Smith's share 1 / (1 + Λ), Λ = ∫ (x − μ) P₁(x) dx / μ beyond the slope μ = cot θ of the direction."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    u, weights = (nodes + 1) / 2, weights / 2
    mu = (np.abs(w[2]) / np.hypot(w[0], w[1]))[..., None]
    s = u / (1 - u)
    marginal = alpha**2 / (2 * (alpha**2 + (mu + s) ** 2) ** 1.5)
    return 1 / (1 + (s * marginal / (1 - u) ** 2 * weights).sum(axis=-1) / mu[..., 0])


def mirrored(wo: np.ndarray, m: np.ndarray) -> np.ndarray:
    return 2 * (wo * m).sum(axis=0) * m - wo


def bent(wo: np.ndarray, m: np.ndarray, eta: float) -> np.ndarray:
    tangent = ((wo * m).sum(axis=0) * m - wo) / eta
    return tangent - np.sqrt(1 - (tangent**2).sum(axis=0)) * m


def send(
    material: RoughConductor | RoughDielectric, wo: np.ndarray, m: np.ndarray, below: bool
) -> np.ndarray:
    if below:
        return bent(wo, m, material.interior_ior)
    return mirrored(wo, m)


def share(material: RoughConductor | RoughDielectric, cos: np.ndarray, below: bool) -> np.ndarray:
    """What a facet passes on of radiance, ``(channels, n)``."""
    if isinstance(material, RoughConductor):
        return np.stack([boundary(cos, e + 1j * k) for e, k in zip(material.eta, material.k, strict=True)])
    F = boundary(cos, material.interior_ior)[None]
    return (1 - F) / material.interior_ior**2 if below else F


def f_cos(material: RoughConductor | RoughDielectric, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """f |cos θi|, ``(channels, n)``; directions local, one facet each."""
    below, h = bool(wi[2].flat[0] < 0), 1e-5
    m = -(wo + material.interior_ior * wi) if below else wi + wo
    m = m / np.linalg.norm(m, axis=0)
    p, q = -m[0] / m[2], -m[1] / m[2]
    np.testing.assert_allclose(send(material, wo, facing(p, q), below), wi * np.ones_like(wo), atol=1e-12)

    def derivative(dp: float, dq: float) -> np.ndarray:
        ends = [send(material, wo, facing(p + s * dp, q + s * dq), below) for s in (1, -1)]
        return (ends[0] - ends[1]) / (2 * h)

    spread = np.linalg.norm(np.cross(derivative(h, 0), derivative(0, h), axis=0), axis=0)
    cos_om = (wo * m).sum(axis=0)
    G = seen(wi, material.alpha) * seen(wo, material.alpha)
    area = slopes_density(p, q, material.alpha) * cos_om / (m[2] * wo[2])
    return share(material, cos_om, below) * (G * area / spread)


def albedo(material: RoughConductor | RoughDielectric, wo: np.ndarray, below: bool) -> np.ndarray:
    """∫ f |cos θi| dwi, ``(channels,)``: midpoints over slopes r = α √(u / (1 − u)), u = 1 − v²."""
    n = 1200
    v, phi = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n * np.pi)
    r, alpha = material.alpha * np.sqrt(1 - v**2) / v, material.alpha
    m = facing(-r * np.cos(phi), -r * np.sin(phi))  # wo is in the plane of x and z: half the azimuths
    wo = wo[:, None, None] * np.ones_like(v)
    cos_om = (wo * m).sum(axis=0)
    with np.errstate(divide="ignore"):
        wi = send(material, wo, m, below)
        G = seen_table(wi, alpha) * seen(wo[:, 0, 0], alpha)
    counts = (cos_om > 0) & ((wi[2] < 0) == below)
    weight = np.where(counts, cos_om / (m[2] * wo[2]) * G, 0) * 2 * v / n**2
    return (share(material, np.maximum(cos_om, 1e-9).ravel(), below) * weight.ravel()).sum(axis=1)


def seen_table(w: np.ndarray, alpha: float) -> np.ndarray:
    """``seen`` by interpolation in the angle."""
    theta = np.linspace(1e-6, np.pi / 2 - 1e-6, 4000)
    table = seen(np.stack([np.sin(theta), 0 * theta, np.cos(theta)]), alpha)
    return np.interp(np.arccos(np.clip(np.abs(w[2]), 0, 1)), theta, table)


def look_at(scene: Scene, x: float, z: float) -> Scene:
    """One pixel, so narrow that it sees one point of the floor, y = 0."""
    o = scene.sensor.origin
    return msgspec.structs.replace(scene, sensor=Pinhole(o, (x, 0.0, z), (0.0, 1.0, 0.0), 1e-4, 1, 1))


def to_viewer(scene: Scene, x: float, z: float) -> np.ndarray:
    """wo, local: the floor's edges are along x and −z."""
    d = np.subtract(scene.sensor.origin, (x, 0.0, z))
    d /= np.linalg.norm(d)
    return np.array([d[0], -d[2], d[1]])


def answer(name: str, x: float, z: float) -> np.ndarray:
    found = case(name)
    truth = found.answer.truth(look_at(found.scene, x, z), 2)
    assert truth is not None
    assert not truth.mean[[0, 2]].any()
    return truth.mean[1, 0, 0]


@pytest.mark.parametrize("spot", SPOTS)
def test_rough_metal_under_the_sky(spot: tuple[float, float]) -> None:
    scene = case("rough-metal-sky").scene
    wo = to_viewer(scene, *spot)
    turned = np.array([math.hypot(wo[0], wo[1]), 0.0, wo[2]])
    expected = albedo(scene.surfaces[0].material, turned, below=False) * scene.environment.radiance
    np.testing.assert_allclose(answer("rough-metal-sky", *spot), expected, rtol=1e-6)


@pytest.mark.parametrize("spot", SPOTS)
def test_rough_glass_over_the_tank(spot: tuple[float, float]) -> None:
    scene = case("rough-glass-tank").scene
    wo, glass = to_viewer(scene, *spot), scene.surfaces[0].material
    turned = np.array([math.hypot(wo[0], wo[1]), 0.0, wo[2]])
    expected = albedo(glass, turned, below=False) * scene.environment.radiance
    expected = expected + albedo(glass, turned, below=True) * scene.surfaces[1].emission.radiance
    np.testing.assert_allclose(answer("rough-glass-tank", *spot), expected, rtol=1e-6)


@pytest.mark.parametrize("spot", SPOTS)
def test_smooth_blend_under_the_sky(spot: tuple[float, float]) -> None:
    scene = case("blend-sky").scene
    blend, cos = scene.surfaces[0].material, to_viewer(scene, *spot)[2]
    assert isinstance(blend, Blend)
    assert isinstance(blend.first, Lambertian)
    assert isinstance(blend.second, Conductor)
    F = [boundary(cos, e + 1j * k) for e, k in zip(blend.second.eta, blend.second.k, strict=True)]
    mixed = (1 - blend.weight) * np.array(blend.first.albedo) + blend.weight * np.array(F)
    np.testing.assert_allclose(answer("blend-sky", *spot), mixed * scene.environment.radiance, rtol=1e-9)


def mixed_f_cos(material: object, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    match material:
        case Blend(first, second, weight):
            return (1 - weight) * mixed_f_cos(first, wi, wo) + weight * mixed_f_cos(second, wi, wo)
        case Lambertian(rho):
            return np.array(rho)[:, None] / np.pi * wi[2]
        case RoughConductor() | RoughDielectric():
            return f_cos(material, wi, wo)
    raise AssertionError(material)


@pytest.mark.parametrize("name", SUN)
def test_lobes_in_parallel_light(name: str) -> None:
    scene = case(name).scene
    d = -np.array(scene.lights[0].direction)
    wi = np.array([d[0], -d[2], d[1]])[:, None]
    target = scene.sensor.target
    spots = [(target[0] + dx, target[2] + dz) for dx, dz in [(0, 0), (0.2, 0.1), (-0.15, 0.2)]]
    found = []
    for spot in spots:
        wo = to_viewer(scene, *spot)[:, None]
        expected = mixed_f_cos(scene.surfaces[0].material, wi, wo)[:, 0] * scene.lights[0].irradiance
        np.testing.assert_allclose(answer(name, *spot), expected, rtol=1e-6)
        found.append(expected[0])
    assert np.ptp(found) > 0.02 * max(found)


def midpoints(f: Callable[[np.ndarray, np.ndarray], np.ndarray], n: int) -> np.ndarray:
    s, t = np.meshgrid(*[(np.arange(n) + 0.5) / n] * 2)
    return f(s.ravel(), t.ravel()).mean(axis=1)


@pytest.mark.parametrize("spot", SPOTS)
def test_blend_under_the_lamp(spot: tuple[float, float]) -> None:
    """Midpoint rules over the lamp, extrapolated."""
    scene = case("blend-lamp").scene
    plate, lamp = scene.surfaces
    x, wo = np.array([spot[0], 0.0, spot[1]]), to_viewer(scene, *spot)[:, None]
    corner, u, v = (np.array(a) for a in (lamp.shape.corner, lamp.shape.edge_u, lamp.shape.edge_v))

    def integrand(s: np.ndarray, t: np.ndarray) -> np.ndarray:
        r = corner[:, None] + np.outer(u, s) + np.outer(v, t) - x[:, None]
        squared = (r**2).sum(axis=0)
        wi = r / np.sqrt(squared)
        local = np.stack([wi[0], -wi[2], wi[1]])
        steradians = np.linalg.norm(np.cross(u, v)) * wi[1] / squared  # the lamp faces straight down
        return mixed_f_cos(plate.material, local, wo * np.ones_like(s)) * steradians

    assert lamp.shape.normal.tolist() == [0, -1, 0]
    expected = (4 * midpoints(integrand, 60) - midpoints(integrand, 30)) / 3 * lamp.emission.radiance
    np.testing.assert_allclose(answer("blend-lamp", *spot), expected, rtol=1e-6)


@pytest.mark.parametrize("name", [*SKY, *SUN, "blend-lamp"])
def test_a_coarse_image_is_the_mean_of_a_fine_one(name: str) -> None:
    found = case(name)
    fine, coarse = (found.answer.truth(found.scene.resized(3 * n, 2 * n), found.bounces) for n in (12, 3))
    assert fine is not None
    assert coarse is not None
    blocks = fine.mean.reshape(found.bounces + 1, 6, 4, 9, 4, 3).mean(axis=(2, 4))
    # pixel averages are to 1e-7 of the largest
    np.testing.assert_allclose(coarse.mean, blocks, rtol=1e-6, atol=1e-7 * coarse.mean.max())
    assert (
        coarse.mean[1].std(axis=(0, 1)) / coarse.mean[1].mean(axis=(0, 1))
    ).max() > 0.03  # not all the same


def test_correlated_shadowing_is_refused() -> None:
    found = case("rough-metal-sun")
    plate = found.scene.surfaces[0]
    other = msgspec.structs.replace(plate.material, shadowing="correlated")
    surfaces = (msgspec.structs.replace(plate, material=other),)
    with pytest.raises(ValueError, match="correlated"):
        found.answer.truth(msgspec.structs.replace(found.scene, surfaces=surfaces), 1)


def test_a_narrow_lobe_has_no_albedo() -> None:
    """Quadrature with that many nodes would miss it."""
    found = case("rough-metal-sky")
    plate = found.scene.surfaces[0]
    narrow = msgspec.structs.replace(plate, material=msgspec.structs.replace(plate.material, alpha=0.05))
    with pytest.raises(ValueError, match="narrower lobe"):
        found.answer.truth(msgspec.structs.replace(found.scene, surfaces=(narrow,)), 1)


def test_a_view_past_the_plate_is_refused() -> None:
    found = case("rough-metal-sun")
    up = msgspec.structs.replace(found.scene.sensor, target=(0.0, 1.0, -1.0))
    with pytest.raises(ValueError, match="misses the plate"):
        found.answer.truth(msgspec.structs.replace(found.scene, sensor=up), 1)
