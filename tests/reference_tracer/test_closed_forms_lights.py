"""The whole tracer against closed forms of lights: what each of them sends to a plane, and where none may be seen.

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

from reference_tracer.random_walk import Strategy
from scenes import (
    AreaLight,
    DirectionalLight,
    Disk,
    EnvironmentMap,
    Image,
    Lambertian,
    Mirror,
    PointLight,
    Quad,
    RadianceMeter,
    Scene,
    Sphere,
    SphericalHarmonicsEnvironment,
    SpotLight,
    Surface,
)

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("closed_forms.py"))))
BLACK, PLANE = shared.BLACK, shared.PLANE
down_at, lit, mean, strategies = shared.down_at, shared.lit, shared.mean, shared.strategies


# ---- point, spot and directional lights on a plane


def test_point_lights() -> None:
    lights = PointLight((0.3, 0.1, 0.5), (2.0,)), PointLight((-0.5, 0.4, 1.5), (3.0,))
    for x, y in ((0.3, 0.1), (-0.6, 0.7)):
        scene = lit(PLANE, *lights, sensor=down_at(x, y), material=Lambertian((0.7,)))
        expected = 0.0
        for light in lights:
            dx, dy, h = light.position[0] - x, light.position[1] - y, light.position[2]
            expected += 0.7 / math.pi * light.intensity[0] * h / (dx**2 + dy**2 + h**2) ** 1.5
        one = [
            mean(lit(PLANE, light, sensor=down_at(x, y), material=Lambertian((0.7,))), 2) for light in lights
        ]
        np.testing.assert_allclose(sum(one)[:, 0], [0, expected, 0], rtol=1e-12)
        assert mean(scene, 1, 4000)[1, 0] == pytest.approx(
            expected, rel=0.1
        )  # one of them is chosen by chance


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("offset", [0.0, 100.0])
def test_a_point_light_in_the_plane_of_a_ceiling(turned: bool, offset: float) -> None:
    """It lights all the floor, whichever way the ceiling faces; no pixel is left to rounding."""
    height, high = 1.7, offset + 1.7
    edges = ((2.0, 0.0, 0.0), (0.0, 2.0, 0.0))
    ceiling = Surface("ceiling", Quad((-1.0, -1.0, high), *(edges[::-1] if turned else edges)), BLACK)
    floor = Surface("floor", Quad((-1.0, -1.0, offset), *edges), Lambertian((0.8,)))
    above = Surface("above", Sphere((0.0, 0.0, offset + 4.0), 0.1), BLACK)  # so that the ceiling may occlude
    lamp, eye = (0.1, 0.2, high), np.array([0.0, 0.0, high - 0.01])
    for x, y in np.random.default_rng(0).uniform(-0.9, 0.9, (100, 2)):
        look = tuple(([x, y, offset] - eye).tolist())
        found = mean(
            Scene((ceiling, floor, above), RadianceMeter(tuple(eye), look), (PointLight(lamp, (3.0,)),)), 1
        )
        d = math.hypot(x - lamp[0], y - lamp[1], height)
        assert found[1, 0] == pytest.approx(0.8 / math.pi * 3 * height / d**3, rel=1e-10)


@pytest.mark.parametrize(("x", "share"), [(0.0, 1.0), (0.2, 1.0), (0.45, None), (0.9, 0.0)])
@strategies
def test_a_spot_light(x: float, share: float | None, strategy: Strategy) -> None:
    spot = SpotLight((0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (5.0,), cutoff=30.0, beam=15.0)
    angle = math.degrees(math.atan(x))
    share = (30 - angle) / 15 if share is None else share
    found = mean(lit(PLANE, spot, sensor=down_at(x, 0.0), material=Lambertian((1.0,))), 2, strategy=strategy)
    expected = share * 5 / math.pi / (1 + x * x) ** 1.5
    np.testing.assert_allclose(found[:, 0], [0, expected, 0], rtol=1e-12)


@strategies
def test_directional_light_and_its_shadow(strategy: Strategy) -> None:
    sun = DirectionalLight((1.0, 0.0, -1.0), (2.0,))
    ball = Surface("ball", Sphere((0.0, 0.0, 0.5), 0.2), BLACK)
    floor = Surface("floor", PLANE, Lambertian((0.5,)))
    for x, expected in (
        (-0.5, 0.5 / math.pi * 2 * math.sqrt(0.5)),
        (0.5, 0.0),
        (0.9, 0.5 / math.pi * 2 * math.sqrt(0.5)),
    ):
        found = mean(Scene((floor, ball), down_at(x, 0.0), (sun,)), 1, strategy=strategy)
        np.testing.assert_allclose(found[:, 0], [0, expected], rtol=1e-12)


def test_a_delta_light_is_not_seen_in_a_mirror() -> None:
    scene = lit(
        PLANE, PointLight((0.0, 0.0, 1.0), (1.0,)), sensor=down_at(0.0, 0.0, 20.0), material=Mirror((1.0,))
    )
    assert not mean(scene, 3).any()


# ---- lamps and environments


def test_a_two_sided_lamp_lights_both_ways(expect_means: Callable[..., None]) -> None:
    lamp = Surface(
        "lamp", Disk((0, 0, 0), (0.5, 0, 0), (0, 0.5, 0)), BLACK, AreaLight((1.0,)), two_sided=True
    )
    white = Lambertian((1.0,))
    up = Surface("up", Quad((-1, -1, -1), (2, 0, 0), (0, 2, 0)), white)
    down = Surface("down", Quad((-1, -1, 1), (0, 2, 0), (2, 0, 0)), white)
    for z in (1, -1):
        look = RadianceMeter((0.6, 0.0, 0.4 * z), (-0.6, 0.0, 0.6 * z))  # at (0, 0, z)
        found = np.array([mean(Scene((lamp, up, down), look), 1, 500, seed=seed)[1] for seed in range(24)])
        expect_means(found, 0.25 / 1.25, resolution=0.05)


def test_environments_from_everywhere(expect_means: Callable[..., None]) -> None:
    """A map of upper and lower half, seen directly and reflected; order 2 of spherical harmonics by A_l."""
    half = EnvironmentMap(Image((((3.0,),), ((3.0,),), ((1.0,),), ((1.0,),))))
    for z, radiance in ((0.9, 3.0), (-0.9, 1.0)):
        ray = RadianceMeter((0.0, 0.0, 5.0), (math.sqrt(1 - z * z), 0.0, z))
        assert mean(lit(Sphere((9.0, 9.0, 9.0), 0.1), half, sensor=ray, material=BLACK), 0)[0, 0] == radiance
    # linear in the latitude between ±22.5°: E / π = ∫ 2 L(sin φ) sin φ cos φ dφ by quadrature
    latitude, w = np.polynomial.legendre.leggauss(2000)
    latitude, w = (latitude + 1) * math.pi / 4, w * math.pi / 4
    above = np.minimum(2 + latitude / (math.pi / 8), 3)
    expected = float((2 * above * np.sin(latitude) * np.cos(latitude) * w).sum()) * 0.5
    scene = lit(PLANE, half, sensor=down_at(0.0, 0.0), material=Lambertian((0.5,)))
    found = np.array([mean(scene, 1, 500, seed=seed)[1] for seed in range(24)])
    expect_means(found, expected, resolution=0.05)
    # E(n) = Σ A_l c_lm Y_lm(n), A_0 = π, A_1 = 2π/3 (Ramamoorthi and Hanrahan 2001)
    harmonics = SphericalHarmonicsEnvironment(((1.0,), (0.0,), (0.4,), (0.0,)))
    y00, y10 = 0.5 / math.sqrt(math.pi), math.sqrt(3 / (4 * math.pi))
    expected = 0.5 * (y00 + 2 / 3 * 0.4 * y10)
    scene = lit(PLANE, harmonics, sensor=down_at(0.0, 0.0), material=Lambertian((0.5,)))
    found = np.array([mean(scene, 1, 500, seed=seed)[1] for seed in range(24)])
    expect_means(found, expected, resolution=0.05)
