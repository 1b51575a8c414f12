"""The integrating sphere by quadrature over its cap and its wall, and E by intersecting camera rays."""

from __future__ import annotations

import math
from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from scenes import Case, PolarRange, Scene
from scenes.library import case

DIRECTIONS = [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.6, 0.0, 0.8), (0.48, 0.64, -0.6), (-1.0, 0.0, 0.0)]


@pytest.fixture(scope="module")
def sphere() -> Case:
    return case("integrating-sphere")


def belt(cos_low: float, cos_high: float, shift: float) -> tuple[np.ndarray, np.ndarray]:
    """Points of the unit sphere ``(n, 3)`` and the areas they stand for: Gauss in z, equal steps in azimuth."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    z = cos_low + (cos_high - cos_low) * (nodes + 1) / 2
    phi = 2 * np.pi * (np.arange(48) + shift) / 48
    z, phi = (grid.ravel() for grid in np.meshgrid(z, phi))
    r = np.sqrt(1 - z**2)
    areas = np.tile(weights * (cos_high - cos_low) / 2 * 2 * np.pi / 48, 48)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1), areas


def exchange(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """cos θ cos θ′ / π|x − y|² between points of the unit sphere seen from inside, ``(len(x), len(y))``."""
    d = y[None] - x[:, None]
    squared = (d**2).sum(axis=-1)
    cosines = -(d @ x[:, :, None])[..., 0], (d * y[None]).sum(axis=-1)
    return cosines[0] * cosines[1] / (np.pi * squared**2)


def test_the_scene_is_the_one_integrated_here(sphere: Case) -> None:
    [surface] = sphere.scene.surfaces
    assert surface.shape.center == (0, 0, 0)
    assert surface.shape.radius == 1
    assert surface.emission.polar_range.axis == (0, 0, 1)
    assert (surface.emission.polar_range.low, surface.emission.polar_range.high) == (0, 45)


def test_direct_light_and_the_first_indirect_one(sphere: Case) -> None:
    """TE at points of the wall by quadrature over the cap; T²E from those values, by one over the wall."""
    surface = sphere.scene.surfaces[0]
    e, rho = np.array(surface.emission.radiance), np.array(surface.material.albedo)
    here, (cap, cap_areas) = np.array(DIRECTIONS), belt(math.cos(math.pi / 4), 1.0, shift=0.3)
    wall, wall_areas = belt(-1.0, 1.0, shift=0.6)
    truth = sphere.answer.truth(sphere.scene, 3)
    assert truth is not None

    TE_here = np.outer(exchange(here, cap) @ cap_areas, rho * e)
    TE_wall = np.outer(exchange(wall, cap) @ cap_areas, rho * e)
    np.testing.assert_allclose(TE_here, np.broadcast_to(truth.mean[1, 0, 0], TE_here.shape), rtol=1e-9)
    TTE_here = rho * (exchange(here, wall) * wall_areas @ TE_wall)
    np.testing.assert_allclose(TTE_here, np.broadcast_to(truth.mean[2, 0, 0], TTE_here.shape), rtol=1e-9)
    # both are uniform, so that T is a factor from here on
    np.testing.assert_allclose(truth.mean[3], rho * truth.mean[2], rtol=1e-12)
    for image in truth.mean[1:]:
        np.testing.assert_array_equal(image, np.broadcast_to(image[0, 0], image.shape))


def upside_down(scene: Scene) -> Scene:
    """A cap at the other pole, of another size, and the camera turned to it."""
    [surface] = scene.surfaces
    emission = msgspec.structs.replace(surface.emission, polar_range=PolarRange(140.0, 180.0))
    camera = msgspec.structs.replace(scene.sensor, origin=(0.1, 0.2, 0.4), target=(0.2, 0.0, -0.9))
    return Scene((msgspec.structs.replace(surface, emission=emission),), camera)


@pytest.mark.parametrize(("width", "height"), [(16, 16), (14, 10)])
@pytest.mark.parametrize("change", [lambda scene: scene, upside_down], ids=["as it is", "upside down"])
def test_emission_by_camera_rays(
    sphere: Case, width: int, height: int, change: Callable[[Scene], Scene]
) -> None:
    """128 × 128 rays through each pixel, each met with the sphere by hand; N² rays leave about N^(−3/2)."""
    fine, scene = 128, change(sphere.scene).resized(width, height)
    camera, surface = scene.sensor, scene.surfaces[0]
    forward = np.subtract(camera.target, camera.origin)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, camera.up)
    right /= np.linalg.norm(right)
    extent = math.tan(math.radians(camera.fov / 2)) / min(width, height)
    x = extent * (2 * (np.arange(width * fine) + 0.5) / fine - width)
    y = extent * (height - 2 * (np.arange(height * fine) + 0.5) / fine)
    d = forward + x[None, :, None] * right + y[:, None, None] * np.cross(right, forward)
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    o = np.array(camera.origin)
    t = -(d @ o) + np.sqrt((d @ o) ** 2 - o @ o + 1)
    z, zone = (o + t[..., None] * d)[..., 2], surface.emission.polar_range
    on_cap = (z <= math.cos(math.radians(zone.low))) & (z >= math.cos(math.radians(zone.high)))
    expected = on_cap.reshape(height, fine, width, fine).mean(axis=(1, 3))

    truth = sphere.answer.truth(scene, 0)
    assert truth is not None
    share = truth.mean[0] / np.array(surface.emission.radiance)
    np.testing.assert_allclose(share, np.repeat(expected[..., None], 3, axis=2), atol=2e-3)
    assert share[..., 0].mean() == pytest.approx(expected.mean(), abs=1e-5)
    partly = (share > 0.01) & (share < 0.99)
    assert partly.sum() > 10  # the rim is in the image


def test_a_coarse_image_is_the_mean_of_a_fine_one(sphere: Case) -> None:
    fine, coarse = (sphere.answer.truth(sphere.scene.resized(n, n), 1) for n in (48, 12))
    assert fine is not None
    assert coarse is not None
    blocks = fine.mean.reshape(2, 12, 4, 12, 4, 3).mean(axis=(2, 4))
    np.testing.assert_allclose(coarse.mean, blocks, atol=1e-9)
