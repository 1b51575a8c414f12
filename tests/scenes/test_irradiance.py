"""Irradiance in closed form: limits, relations between lamps, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

from scenes import (
    ConstantEnvironment,
    Disk,
    Ellipsoid,
    EnvironmentMap,
    Image,
    Mesh,
    PointLight,
    Quad,
    Scene,
    Sphere,
    SphericalHarmonicsEnvironment,
    SpotLight,
    Surface,
)
from scenes.irradiance_of_lamps import clipped, irradiance_per_radiance
from scenes.irradiance_of_lights import irradiance_by_light
from scenes.library import case

UP = np.array([0.0, 1.0, 0.0])
X = np.array([[0.3, -0.2, 1.5], [0.0, 0.0, 0.0], [0.1, 0.7, -0.4]])
N = np.tile(UP[:, None], 3)


def test_a_parallel_disk_is_footes_formula() -> None:
    r, h = 0.7, 1.3
    found = irradiance_per_radiance(Disk((0, h, 0), (r, 0, 0), (0, 0, r)), X, UP)
    s = X[0] ** 2 + X[2] ** 2
    expected = np.pi / 2 * (1 - (h**2 + s - r**2) / np.sqrt((h**2 + s + r**2) ** 2 - 4 * r**2 * s))
    np.testing.assert_allclose(found, expected, rtol=1e-13)


def test_a_round_ellipsoid_is_a_sphere() -> None:
    ball = Ellipsoid((-0.4, 1.2, 0.3), (0.5, 0, 0), (0, 0.3, 0.4), (0, -0.4, 0.3))
    sphere = irradiance_per_radiance(Sphere((-0.4, 1.2, 0.3), 0.5), X, UP)
    np.testing.assert_allclose(irradiance_per_radiance(ball, X, UP), sphere, rtol=1e-12)


def test_a_flattened_ellipsoid_tends_to_a_disk() -> None:
    u, v = (0.5, 0.0, 0.2), (0.0, 0.0, -0.4)  # conjugate radii, not orthogonal
    disk = Disk((-0.4, 1.2, 0.3), v, u) if np.cross(u, v)[1] > 0 else Disk((-0.4, 1.2, 0.3), u, v)
    flat = Ellipsoid(disk.center, u, v, (0.0, 1e-4, 0.0))
    found = irradiance_per_radiance(flat, X, UP)
    np.testing.assert_allclose(found, irradiance_per_radiance(disk, X, UP), rtol=1e-6)


def test_a_polygon_of_many_corners_tends_to_a_disk() -> None:
    t = 2 * np.pi * np.arange(720) / 720
    corners = np.stack([0.6 * np.cos(t) - 0.5, 1.1 + 0.2 * np.cos(t), 0.5 * np.sin(t)], axis=1)
    fan = [(0, i, i + 1) for i in range(1, 719)]
    found = irradiance_per_radiance(Mesh(corners, fan), X, UP)
    disk = Disk((-0.5, 1.1, 0.0), (0.6, 0.2, 0.0), (0.0, 0.0, 0.5))
    np.testing.assert_allclose(found, irradiance_per_radiance(disk, X, UP), rtol=5e-5)


def test_a_lamp_far_away_is_a_point() -> None:
    point = PointLight((80.0, 300.0, -40.0), (0.7 * 0.9,))
    quad = Quad((79.65, 300.0, -40.45), (0.7, 0.0, 0.0), (0.0, 0.0, 0.9))
    cosine = 300 / np.linalg.norm(np.reshape(point.position, (3, 1)) - X, axis=0)
    found = irradiance_per_radiance(quad, X, UP)
    np.testing.assert_allclose(found, irradiance_by_light(point, X, N)[0] * cosine, rtol=1e-4)


def test_a_plane_above_is_a_hemisphere_and_the_back_gives_nothing() -> None:
    wide = Quad((-1e5, 1.0, -1e5), (2e5, 0.0, 0.0), (0.0, 0.0, 2e5))
    np.testing.assert_allclose(irradiance_per_radiance(wide, X, UP), np.pi, rtol=1e-8)
    sky = ConstantEnvironment((1.0, 2.0))
    np.testing.assert_allclose(irradiance_by_light(sky, X, N), np.pi * np.array([[1] * 3, [2] * 3]))
    back = Quad(wide.corner, wide.edge_v, wide.edge_u)
    assert not irradiance_per_radiance(back, X, UP).any()
    assert not irradiance_per_radiance(Disk((0, 1, 0), (0, 0, 1), (1, 0, 0)), X, UP).any()
    below = Quad((0, -2.0, 0), (1, 0, 0), (0, 0, 1))
    assert not irradiance_per_radiance(below, X, UP).any()


def test_half_a_standing_lamp_counts() -> None:
    """By symmetry what is below the horizon mirrors what is above."""
    half = irradiance_per_radiance(Quad((-1, 0, 1), (0, 0, -2), (0, 1.5, 0)), X[:, :2], UP)
    whole = irradiance_per_radiance(Quad((-1, -1.5, 1), (0, 0, -2), (0, 3.0, 0)), X[:, :2], UP)
    np.testing.assert_allclose(whole, half, rtol=1e-13)


@pytest.mark.parametrize("lamp", [Sphere((0, 0.3, 0), 0.5), Disk((-2, 0, 0), (0, 1, 0), (0, 0, 1))])
def test_round_lamps_on_the_horizon_are_refused(lamp: Sphere | Disk) -> None:
    with pytest.raises(ValueError, match="above the plane"):
        irradiance_per_radiance(lamp, X, UP)


def test_clipping_that_differs_from_point_to_point_is_refused() -> None:
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])[..., None] + np.zeros(2)
    right = np.array([[1.0, 1.0], [0, 0], [0, 0]])
    with pytest.raises(ValueError, match="same corners"):
        clipped(square, np.array([[0.5, 2.0], [0, 0], [0, 0]]), right)
    found = clipped(square, np.array([[0.5, 0.25], [0, 0], [0, 0]]), right)
    np.testing.assert_allclose(sorted(found[:, 0, 1]), [0.25, 0.25, 1, 1])


def test_a_spot_without_a_fall_off_ends_at_once() -> None:
    spot = SpotLight((0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (1.0,), cutoff=45.0, beam=45.0)
    x = np.array([[0.99, 1.01], [0.0, 0.0], [0.0, 0.0]])
    [[inside, outside]] = irradiance_by_light(spot, x, N[:, :2])
    assert outside == 0
    assert inside == pytest.approx((1 + 0.99**2) ** -1.5)


@pytest.mark.parametrize(("row", "message"), [(0, "pole"), (7, "pole"), (4, "horizon")])
def test_texels_beside_a_pole_or_below_a_horizon_are_refused(row: int, message: str) -> None:
    pixels = np.zeros((8, 16, 1))
    pixels[row, 3] = 1
    n = np.array([[0.0], [0.0], [1.0]])
    with pytest.raises(ValueError, match=message):
        irradiance_by_light(EnvironmentMap(Image(pixels)), n, n)


def test_harmonics_beyond_degree_three_are_refused() -> None:
    light = SphericalHarmonicsEnvironment(((5.0,),) + ((0.01,),) * 24)
    with pytest.raises(ValueError, match="degree 3"):
        irradiance_by_light(light, N, N)


def altered(name: str, **shapes: Quad) -> Scene:
    scene = case(name).scene
    surfaces = (Surface(s.name, shapes.get(s.name, s.shape), s.material, s.emission) for s in scene.surfaces)
    return Scene(tuple(surfaces), scene.sensor, scene.lights).resized(4, 4)


@pytest.mark.parametrize(
    ("name", "surface", "shape", "message"),
    [
        ("quad-over-plane", "floor", Quad((0, 0, 0), (0.1, 0, 0), (0, 0, -0.1)), "nothing but the receiver"),
        ("screened-lamp", "screen", Quad((0.5, 1.2, 0), (0.35, 0, 0), (0, 0, 0.3)), "away from its edges"),
        ("wall-behind-a-shelf", "shelf", Quad((0.25, 0.4, 4), (0, 0, -8), (0.05, 0, 0)), "near edge"),
        (
            "parallel-rectangles",
            "lamp",
            Quad((0, 1.1, 0), (1, 0.1, 0), (0, 0, 1)),
            "parallel or perpendicular",
        ),
    ],
)
def test_scenes_that_an_answer_does_not_hold_for_are_refused(
    name: str, surface: str, shape: Quad, message: str
) -> None:
    found = case(name)
    with pytest.raises(ValueError, match=message):
        found.answer.truth(altered(name, **{surface: shape}), found.bounces)


@pytest.mark.parametrize("name", ["wall-by-reflection", "wall-behind-a-shelf"])
def test_reflected_light_ends_at_the_third_bounce(name: str) -> None:
    found = case(name)
    assert found.max_bounces == 3
    with pytest.raises(ValueError, match="at most 3"):
        found.answer.truth(found.scene.resized(2, 2), 4)
