"""The whole tracer against closed forms of surfaces: every material, both sides, textures, shading normals.

Most of these have no noise, so that each pixel must be right to rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import numpy as np
import pytest

from reference_tracer.random_walk import Strategy, render
from scenes import (
    AreaLight,
    Checkerboard,
    Conductor,
    ConstantEnvironment,
    Dielectric,
    DirectionalLight,
    Disk,
    Lambertian,
    Material,
    Mesh,
    Mirror,
    Orthographic,
    Quad,
    RadianceMeter,
    RoughConductor,
    RoughDielectric,
    Scene,
    Sphere,
    Surface,
)

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("closed_forms.py"))))
BLACK, PLANE = shared.BLACK, shared.PLANE
down_at, lit, mean, strategies = shared.down_at, shared.lit, shared.mean, shared.strategies


# ---- under a constant environment


@strategies
def test_a_convex_body_reflects_it_once(strategy: Strategy) -> None:
    ball = Surface("ball", Sphere((0.0, 0.0, -1.0), 0.7), Lambertian((0.3, 0.6)))
    scene = lit(
        ball, ConstantEnvironment((2.0, 1.0)), sensor=RadianceMeter((0.1, 0.0, 2.0), (0.0, 0.0, -1.0))
    )
    found = mean(scene, 2, 20_000, strategy)
    assert found[0].tolist() == [0, 0]
    # bsdf and mis draw the cosine: no noise. nee draws directions uniformly: cos/p has a relative deviation of 1.3
    np.testing.assert_allclose(found[1], [0.6, 0.6], rtol=1e-12 if strategy == "bsdf" else 0.045)
    assert found[2].tolist() == [0, 0]


def fresnel(eta: float, cos_i: float) -> float:
    """Unpolarised reflectance of a dielectric, transmitted side of relative index eta (Born and Wolf 1.5.2)."""
    sin_t = math.sqrt(1 - cos_i**2) / eta
    if sin_t >= 1:
        return 1.0
    cos_t = math.sqrt(1 - sin_t**2)
    s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    return (s * s + p * p) / 2


@pytest.mark.parametrize("off", [0.0, 0.3, 0.55])
def test_a_glass_ball(off: float, expect_means: Callable[..., None]) -> None:
    """All internal angles are equal: F, (1 − F)², (1 − F)² F, (1 − F)² F², …; their sum is 1."""
    ball = Surface("ball", Sphere((0.0, 0.0, 0.0), 0.6), Dielectric(1.5))
    scene = lit(ball, ConstantEnvironment((1.0,)), sensor=RadianceMeter((off, 0.0, 3.0), (0.0, 0.0, -1.0)))
    F = fresnel(1.5, math.sqrt(1 - (off / 0.6) ** 2))
    expected = np.array([0, F, *((1 - F) ** 2 * F**j for j in range(4))])
    found = np.array([mean(scene, 5, 2000, seed=seed)[:, 0] for seed in range(24)])
    for k in range(4):  # of the later ones there are too few to judge
        expect_means(found[:, k], expected[k], resolution=0.04, scale=1.0)
    np.testing.assert_allclose(found.sum(axis=1), 1, atol=0.01)


def test_seen_from_inside_glass(expect_means: Callable[..., None]) -> None:
    """From the middle of a ball every ray leaves it straight: η² (1 − F) Fʲ; radiance ÷ η² is what is conserved."""
    ball = Surface("ball", Sphere((0.0, 0.0, 0.0), 0.6), Dielectric(1.5))
    scene = lit(ball, ConstantEnvironment((1.0,)), sensor=RadianceMeter((0.0, 0.0, 0.0), (0.0, 0.6, 0.8)))
    F = fresnel(1.5, 1.0)
    found = np.array([mean(scene, 3, 2000, seed=seed)[:, 0] for seed in range(24)])
    for k, expected in enumerate([0, 2.25 * (1 - F), 2.25 * (1 - F) * F, 2.25 * (1 - F) * F * F]):
        expect_means(found[:, k], expected, resolution=0.03, scale=2.25)


METALS = {"eta": (0.2, 1.1, 2.9), "k": (3.9, 6.8, 2.5)}


def metal_fresnel(eta: float, k: float, cos_i: float) -> float:
    """By complex Snell and Fresnel (Born and Wolf 14.2), unpolarised."""
    n = complex(eta, k)
    cos_t = np.sqrt(1 - (1 - cos_i**2) / n**2 + 0j)
    s = (cos_i - n * cos_t) / (cos_i + n * cos_t)
    p = (n * cos_i - cos_t) / (n * cos_i + cos_t)
    return float((abs(s) ** 2 + abs(p) ** 2) / 2)


@pytest.mark.parametrize("degrees", [0.0, 40.0, 75.0])
def test_a_metal_at_an_angle(degrees: float) -> None:
    scene = lit(
        PLANE,
        ConstantEnvironment((1.0, 2.0, 3.0)),
        sensor=down_at(0.1, 0.2, degrees),
        material=Conductor(**METALS),
    )
    cosine = math.cos(math.radians(degrees))
    expected = [L * metal_fresnel(e, k, cosine) for L, e, k in zip((1, 2, 3), *METALS.values(), strict=True)]
    np.testing.assert_allclose(mean(scene, 1)[1], expected, rtol=1e-12)


ROUGH: dict[str, Material] = {
    "metal that reflects all": RoughConductor((1.0,), (1e9,), 0.4),
    "glass": RoughDielectric(0.4),
}


@pytest.mark.parametrize("material", ROUGH)
@pytest.mark.parametrize("degrees", [10.0, 60.0])
@strategies
def test_what_a_rough_surface_loses(
    material: str, degrees: float, strategy: Strategy, expect_means: Callable[..., None]
) -> None:
    """A lossless one returns a constant environment but for its stated single-scattering loss.

    Through the glass the radiance of the other side comes ÷ η²; a black quad behind it stands for the dark inside.
    """
    from reference_tracer.reflection import bsdf_of

    rough = ROUGH[material]
    surfaces = [Surface("rough", PLANE, rough)]
    scene = Scene(tuple(surfaces), down_at(0.0, 0.0, degrees), (ConstantEnvironment((1.0,)),))
    loss = bsdf_of(scene).single_scattering_loss(0, np.array(math.cos(math.radians(degrees))))
    spp, resolution = (20_000, 0.09) if strategy == "nee" else (1000, 0.05)
    found = np.array([mean(scene, 1, spp, strategy, seed)[1] for seed in range(24)])
    if material == "glass":  # R from above and T / η² from below, both of radiance 1
        expect_means(found, _reflected_and_scaled(rough, degrees), resolution)
    else:
        assert 0 < float(loss) < 0.3
        expect_means(found, 1 - float(loss), resolution)


def _reflected_and_scaled(material: Material, degrees: float) -> float:
    """∫ f cos over both sides by quadrature of Walter's formulas as written (2007, eq. 20, 21, 33), η = 1.5 below."""
    assert isinstance(material, RoughDielectric)
    a2, eta = material.alpha**2, material.interior_ior
    z, w = np.polynomial.legendre.leggauss(400)
    phi = 2 * np.pi * (np.arange(400) + 0.5) / 400
    cos_i, phi = np.meshgrid(z, phi, indexing="ij")
    weight = w[:, None] * (2 * np.pi / 400)
    sin_i = np.sqrt(1 - cos_i**2)
    i = np.stack([sin_i * np.cos(phi), sin_i * np.sin(phi), cos_i])
    o = np.array([math.sin(math.radians(degrees)), 0.0, math.cos(math.radians(degrees))])[:, None, None]
    up = cos_i > 0
    h = np.where(up, i + o, -(i * eta + o))
    h = h / np.linalg.norm(h, axis=0)
    h = h * np.sign(h[2])
    oh, ih = (o * h).sum(axis=0), (i * h).sum(axis=0)
    D = a2 / (np.pi * (h[2] ** 2 * (a2 - 1) + 1) ** 2)

    def lambda_(c: np.ndarray) -> np.ndarray:
        return (np.sqrt(1 + a2 * (1 - c**2) / c**2) - 1) / 2

    G = 1 / (1 + lambda_(o[2]) + lambda_(cos_i))
    sin_t2 = (1 - oh**2) / eta**2
    cos_t = np.sqrt(np.maximum(1 - sin_t2, 0))
    s, p = (oh - eta * cos_t) / (oh + eta * cos_t), (eta * oh - cos_t) / (eta * oh + cos_t)
    F = (s**2 + p**2) / 2
    reflected = F * D * G / (4 * o[2] * np.abs(cos_i))
    # Lo = ∫ f Li cos: towards the viewer outside, radiance from inside is scaled by (1 / η)²
    refracted = np.abs(oh * ih) / np.abs(o[2] * cos_i) * (1 - F) * G * D / (oh + eta * ih) ** 2
    refracted = np.where((oh > 0) & (ih < 0), refracted, 0)
    f = np.where(up, np.where((oh > 0) & (ih > 0), reflected, 0), refracted)
    return float((f * np.abs(cos_i) * weight).sum())


@pytest.mark.parametrize(
    "material",
    [
        Dielectric(1e200),
        Dielectric(1e200, 1e-200),
        Conductor((1e200,), (1e200,)),
        Conductor((1e-200,), (1e200,)),
        Dielectric(1.0, 1e200),
    ],
)
def test_an_index_beyond_all_numbers_reflects_everything(material: Material) -> None:
    """F → 1 as |η| → ∞ or 0; a square that is no number any more must not make it anything else."""
    sky = ConstantEnvironment((1.0,))
    found = mean(
        lit(Sphere((0, 0, 0), 1.0), sky, sensor=RadianceMeter((0.3, 0, 3), (0, 0, -1)), material=material), 2
    )
    np.testing.assert_allclose(found[:, 0], [0, 1, 0], rtol=1e-12, atol=1e-12)


def test_a_checkerboard() -> None:
    board = Surface("it", PLANE, Lambertian(Checkerboard((0.2,), (0.6,), columns=2, rows=4)))
    for x, y, albedo in ((-0.5, -0.9, 0.2), (0.5, -0.9, 0.6), (-0.5, -0.4, 0.6), (0.5, 0.9, 0.2)):
        found = mean(lit(board, ConstantEnvironment((1.0,)), sensor=down_at(x, y)), 1, strategy="bsdf")
        assert found[1, 0] == pytest.approx(albedo, rel=1e-12)


# ---- mirrors


def test_an_emitter_in_a_mirror() -> None:
    lamp = Surface("lamp", Disk((0.5, 0.0, 1.0), (0.2, 0.0, 0.0), (0.0, -0.2, 0.0)), BLACK, AreaLight((3.0,)))
    mirror = Surface("mirror", PLANE, Mirror((0.8,)))
    camera = Orthographic((0.0, 0.0, 0.5), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 1.0, 4, 4)
    assert not render(Scene((lamp, mirror), camera), 2, 4, 0)[2].any()
    # 45° down at (0, 0) and up to the lamp at (0.5, 0, 0.5)… which hangs at height 1: seen at x = −0.5
    seen = RadianceMeter((-1.5, 0.0, 1.0), (1.0, 0.0, -1.0))
    np.testing.assert_allclose(mean(Scene((lamp, mirror), seen), 2), [[0.0], [2.4], [0.0]], atol=1e-12)


def test_two_parallel_mirrors() -> None:
    """A ray that goes to and fro n times between them meets the lamp at their end: ρⁿ e, and nothing else."""
    lower = Surface("lower", Quad((0, 0, 0), (10.5, 0, 0), (0, 1, 0)), Mirror((0.9,)))
    upper = Surface("upper", Quad((0, 0, 1), (0, 1, 0), (10.5, 0, 0)), Mirror((0.8,)))
    lamp = Surface("lamp", Quad((10.5, 0, 0), (0, 0, 1), (0, 1, 0)), BLACK, AreaLight((2.0,)))
    slope = RadianceMeter((0.0, 0.5, 0.5), (2.0, 0.0, -1.0))  # meets lower, upper, … at x = 1, 3, 5, 7, 9
    found = mean(Scene((lower, upper, lamp), slope), 7)[:, 0]
    expected = np.zeros(8)
    expected[5] = 2 * 0.9**3 * 0.8**2
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-14)


# ---- sides and shading normals


@pytest.mark.parametrize("two_sided", [False, True])
@strategies
def test_sides(two_sided: bool, strategy: Strategy) -> None:
    """Seen and lit from below, a plane is black, or as from above."""
    below = RadianceMeter((0.1, 0.2, -2.0), (0.0, 0.0, 1.0))
    for sensor, front in ((below, two_sided), (down_at(0.1, 0.2), True)):
        glowing = Surface("it", PLANE, BLACK, AreaLight((2.0,)), two_sided)
        assert mean(Scene((glowing,), sensor), 1, strategy=strategy)[:, 0].tolist() == [2.0 * front, 0.0]
        grey = Surface("it", PLANE, Lambertian((0.5,)), two_sided=two_sided)
        sun = DirectionalLight((0.0, 0.0, sensor.direction[2]), (math.pi,))
        found = mean(lit(grey, sun, sensor=sensor), 2, strategy=strategy)[:, 0]
        np.testing.assert_allclose(found, [0.0, 0.5 * front, 0.0], rtol=1e-12)


@pytest.mark.parametrize("tilt", [0.0, 0.4, -0.7])
@strategies
def test_shading_normals(tilt: float, strategy: Strategy) -> None:
    """The cosine is that of the shading normal; light that comes from behind the triangle itself gives nothing."""
    corners = ((-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0))
    ns = (math.sin(tilt), 0.0, math.cos(tilt))
    mesh = Mesh(corners, ((0, 1, 2), (0, 2, 3)), normals=(ns,) * 4)
    for angle in (0.2, -0.6, 1.4, 1.8):  # of the light; the last one is below the plane
        d = (-math.sin(angle), 0.0, -math.cos(angle))
        scene = lit(
            mesh, DirectionalLight(d, (math.pi,)), sensor=down_at(0.1, 0.2), material=Lambertian((0.5,))
        )
        cosine = max(0.0, math.cos(angle - tilt)) * (math.cos(angle) > 0)
        found = mean(scene, 2, strategy=strategy)[:, 0]
        np.testing.assert_allclose(found, [0.0, 0.5 * cosine, 0.0], rtol=1e-12, atol=1e-15)
