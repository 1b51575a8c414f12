"""A point light in a sphere, by quadrature over its wall and over pixels."""

from __future__ import annotations

import math

import numpy as np
import pytest

from scenes import Scene
from scenes.library import case


def irradiance(scene: Scene, n: np.ndarray) -> np.ndarray:
    """At wall points in directions n ``(…, 3)`` from the centre: cos θ / d² of the light."""
    [wall], [light] = scene.surfaces, scene.lights
    x = wall.shape.center + wall.shape.radius * n
    w = light.position - x
    return -(w * n).sum(axis=-1) / (w**2).sum(axis=-1) ** 1.5


def by_rays(scene: Scene, fine: int) -> np.ndarray:
    """Means over pixels by fine² rays, ``(height, width)``; they leave 1 / fine²."""
    [wall], camera, (height, width, _) = scene.surfaces, scene.sensor, scene.shape
    x, y = (np.arange(width * fine) + 0.5) / fine, (np.arange(height * fine) + 0.5) / fine
    image = np.stack([*np.meshgrid(x, y), np.ones((height * fine, width * fine))], axis=-1)
    d = image @ camera.pixel_to_direction.T
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    w = np.subtract(camera.origin, wall.shape.center)
    t = -(d @ w) + np.sqrt((d @ w) ** 2 - w @ w + wall.shape.radius**2)
    n = (w + t[..., None] * d) / wall.shape.radius
    return irradiance(scene, n).reshape(height, fine, width, fine).mean(axis=(1, 3))


@pytest.mark.parametrize("name", ["point-in-sphere", "cie-171-sphere"])
def test_direct_light(name: str) -> None:
    """Two numbers of rays, combined so that their leading errors cancel (Richardson)."""
    found = case(name)
    scene = found.scene.resized(6, 4)
    expected = (4 * by_rays(scene, 96) - by_rays(scene, 48)) / 3
    factor = np.array(scene.surfaces[0].material.albedo) / np.pi * scene.lights[0].intensity
    truth = found.answer.truth(scene, 1)
    assert truth is not None
    assert not truth.mean[0].any()
    np.testing.assert_allclose(truth.mean[1], np.multiply.outer(expected, factor), rtol=1e-6)


@pytest.mark.parametrize("name", ["point-in-sphere", "cie-171-sphere"])
def test_indirect_light(name: str) -> None:
    """T²E at points of the wall from TE all over it, with the exchange of two points written out; then again."""
    found = case(name)
    [wall], rho = found.scene.surfaces, np.array(found.scene.surfaces[0].material.albedo)
    R = wall.shape.radius
    nodes, weights = np.polynomial.legendre.leggauss(120)
    z, phi = (g.ravel() for g in np.meshgrid(nodes, 2 * np.pi * (np.arange(240) + 0.4) / 240))
    n = np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z], axis=1)
    areas = np.tile(weights * 2 * np.pi / 240, 240) * R**2
    previous = np.outer(irradiance(found.scene, n), rho / np.pi * found.scene.lights[0].intensity)
    truth = found.answer.truth(found.scene.resized(2, 2), 4)
    assert truth is not None
    for k in (2, 3, 4):
        for x in np.array([(0.6, 0.0, 0.8), (-0.48, 0.64, -0.6), (0.0, 1.0, 0.0)]):
            d = R * (n - x)
            squared = (d**2).sum(axis=1)
            kernel = -(d @ x) * (d * n).sum(axis=1) / (np.pi * squared**2)
            TTE = rho * ((kernel * areas) @ previous)
            np.testing.assert_allclose(truth.mean[k], np.broadcast_to(TTE, truth.mean[k].shape), rtol=1e-9)
        previous = np.broadcast_to(TTE, previous.shape)


def test_the_illuminances_of_cie_171() -> None:
    """Φ/S directly, (Φ/S) ρ / (1 − ρ) by interreflection: illuminance is π/ρ times radiance."""
    found = case("cie-171-sphere")
    [wall], [light] = found.scene.surfaces, found.scene.lights
    flux, area = 4 * math.pi * light.intensity[0], wall.shape.area
    assert (flux, area) == (pytest.approx(10_000), pytest.approx(96))
    rho = np.array(wall.material.albedo)
    truth = found.answer.truth(found.scene.resized(1, 1), 200)
    assert truth is not None
    illuminance = np.pi / rho * truth.mean[:, 0, 0]
    np.testing.assert_allclose(illuminance[1], flux / area, rtol=1e-9)
    np.testing.assert_allclose(illuminance[2:].sum(axis=0), flux / area * rho / (1 - rho), rtol=1e-9)


def test_a_light_in_the_middle_and_one_beside_it() -> None:
    """The nearer the wall the brighter its direct light there, and no difference from the second bounce on."""
    found = case("point-in-sphere")
    light = found.scene.lights[0]
    middle = type(light)((0.0, 0.0, 0.0), light.intensity)
    beside, centred = (
        found.answer.truth(Scene(found.scene.surfaces, found.scene.sensor, (one,)).resized(5, 5), 3)
        for one in (light, middle)
    )
    assert beside is not None
    assert centred is not None
    rho = np.array(found.scene.surfaces[0].material.albedo)
    np.testing.assert_allclose(
        centred.mean[1], np.broadcast_to(rho / np.pi * light.intensity, (5, 5, 3)), rtol=1e-9
    )
    assert np.ptp(beside.mean[1, ..., 0]) > 0.5 * beside.mean[1, ..., 0].mean()
    np.testing.assert_array_equal(beside.mean[2:], centred.mean[2:])


@pytest.mark.parametrize("size", [(1, 1), (3, 2), (5, 30)])
def test_a_coarse_image_is_the_mean_of_a_fine_one(size: tuple[int, int]) -> None:
    found, (width, height) = case("point-in-sphere"), size
    coarse = found.answer.truth(found.scene.resized(width, height), 2)
    fine = found.answer.truth(found.scene.resized(12 * width, 12 * height), 2)
    assert coarse is not None
    assert fine is not None
    blocks = fine.mean.reshape(3, height, 12, width, 12, 3).mean(axis=(2, 4))
    np.testing.assert_allclose(coarse.mean, blocks, rtol=1e-7)
