"""Lights as Mitsuba understands them: where they shine, how brightly, and in which colour."""

from __future__ import annotations

from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import numpy as np
import pytest

from comparisons.renderers.mitsuba import MitsubaRenderer
from scenes import (
    ConstantEnvironment,
    DirectionalLight,
    Disk,
    EnvironmentMap,
    Light,
    Mirror,
    PointLight,
    Sphere,
    SpotLight,
    Surface,
)

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("single_rays.py"))))
FLOOR, GREY = shared.FLOOR, shared.GREY
along, assert_same, image = shared.along, shared.assert_same, shared.image
rays_to, rotated, sphere_points = shared.rays_to, shared.rotated, shared.sphere_points

LIGHTS: dict[str, Light] = {
    "point": PointLight((0.3, 0.4, 2.0), (1.0, 20.0, 300.0)),
    "spot": SpotLight((0.3, 0.4, 2.0), (0.1, 0.2, -1.0), (1.0, 2.0, 30.0), 50.0, 20.0),
    "spot without falloff": SpotLight((0.3, 0.4, 2.0), (0.1, 0.2, -1.0), (1.0, 2.0, 3.0), 30.0, 30.0),
    "spot, falling from the axis on": SpotLight(
        (0.3, 0.4, 2.0), (0.0, 0.0, -1.0), (1.0, 2.0, 3.0), 45.0, 0.0
    ),
    "spot wider than a half space": SpotLight((0.3, 0.4, 2.0), (0.0, 1.0, 0.3), (1.0, 2.0, 3.0), 150.0, 30.0),
    "spot of all directions": SpotLight((0.3, 0.4, 2.0), (0.0, 1.0, 0.0), (1.0, 2.0, 3.0), 180.0, 0.0),
    "directional": DirectionalLight((0.3, -0.5, -0.8), (1.0, 20.0, 300.0)),
}


@pytest.mark.parametrize("name", LIGHTS)
def test_a_light_on_a_floor(mitsuba: MitsubaRenderer, name: str) -> None:
    """A ball casts a shadow, so that the light is seen to come from where it should."""
    xy = np.random.default_rng(2).uniform(-2.9, 2.9, (60, 2))
    targets = np.column_stack([xy, np.zeros(60)])
    ball = Surface("ball", Sphere((0.2, -0.5, 0.6), 0.5), GREY)
    ours = assert_same(
        mitsuba,
        [FLOOR, ball],
        [LIGHTS[name]],
        rays_to(targets, targets + np.array([0.1, 0.2, 3.0])),
        rtol=5e-5,
    )
    assert 0 < (ours[:, 1, 0] > 0).mean() < 1


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("size", [(4, 7), (1, 5), (5, 1), (1, 1), (8, 16)])
def test_an_environment_map(mitsuba: MitsubaRenderer, size: tuple[int, int], mirrored: bool) -> None:
    """Random directions, and those where conventions would part: poles and the seam."""
    axes = rotated(mirrored)
    light = EnvironmentMap(image(*size, high=20.0), axes)
    seam = np.array([[1.0, s, z] for s in (-1e-3, 1e-3) for z in (-0.5, 0.8)])
    poles = np.array([[1e-3, 2e-3, s] for s in (-1.0, 1.0)])
    d = np.concatenate([sphere_points(40), seam @ axes, poles @ axes])
    rays = [(np.zeros(3), direction) for direction in d]
    if size == (1, 1):
        ours, theirs = along(mitsuba, [], [light], rays, 0)
        np.testing.assert_allclose(theirs, ours, rtol=1e-6)
    else:
        assert_same(mitsuba, [], [light], rays, 0, rtol=2e-4)


def test_a_constant_environment(mitsuba: MitsubaRenderer) -> None:
    rays = [(np.zeros(3), d) for d in sphere_points(10)]
    half = Surface(
        "half", Disk((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), Mirror((0.5, 0.25, 0.125))
    )
    assert_same(mitsuba, [half], [ConstantEnvironment((1.0, 20.0, 300.0))], rays)
