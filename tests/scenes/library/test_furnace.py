"""TE = ρe in a closed scene, by quadrature over its walls; the rest by induction."""

from __future__ import annotations

import numpy as np
import pytest

from scenes import Case, Quad, Surface
from scenes.library import case

NODES, WEIGHTS = np.polynomial.legendre.leggauss(64)
NODES, WEIGHTS = (NODES + 1) / 2, WEIGHTS / 2  # on [0, 1]
INSIDE = [(0.5, 0.5), (0.21, 0.66), (0.8, 0.3)]


def place(quad: Quad, s: np.ndarray, t: np.ndarray) -> np.ndarray:
    return np.array(quad.corner) + np.multiply.outer(s, quad.edge_u) + np.multiply.outer(t, quad.edge_v)


def kernel(x: np.ndarray, n: np.ndarray, y: np.ndarray, m: np.ndarray) -> np.ndarray:
    """cos θ cos θ′ / π|x − y|² between x with normal n and the points y with normals m; 0 from behind."""
    d = y - x
    squared = (d**2).sum(axis=-1)
    return np.maximum(d @ n, 0) * np.maximum(-(d * m).sum(axis=-1), 0) / (np.pi * squared**2)


def form_factor(x: np.ndarray, n: np.ndarray, wall: Quad) -> float:
    y = place(wall, *np.meshgrid(NODES, NODES))
    return float((kernel(x, n, y, wall.normal) * np.outer(WEIGHTS, WEIGHTS)).sum() * wall.area)


def uniform(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    assert surface.emission is not None
    return np.array(surface.emission.radiance), np.array(surface.material.albedo)


def check_series(found: Case, irradiance_per_radiance: float) -> None:
    """TE = (ρ/π) · irradiance must be the case's bounce 1, and T the same multiple of every uniform field."""
    e, rho = uniform(found.scene.surfaces[0])
    assert all(uniform(surface)[0].tolist() == e.tolist() for surface in found.scene.surfaces)
    assert all(uniform(surface)[1].tolist() == rho.tolist() for surface in found.scene.surfaces)
    T = rho / np.pi * irradiance_per_radiance
    truth = found.answer.truth(found.scene, 6)
    assert truth is not None
    np.testing.assert_allclose(truth.mean[0], np.broadcast_to(e, found.scene.shape))
    for previous, image in zip(truth.mean, truth.mean[1:], strict=False):
        np.testing.assert_allclose(image, T * previous, rtol=1e-6)


@pytest.mark.parametrize("at", range(6))
@pytest.mark.parametrize("point", INSIDE)
def test_the_box_sees_itself_everywhere(at: int, point: tuple[float, float]) -> None:
    found = case("furnace-box")
    walls = [surface.shape for surface in found.scene.surfaces]
    x = place(walls[at], *point)
    factors = [form_factor(x, walls[at].normal, wall) for wall in walls]
    assert factors[at] == 0
    assert sum(factors) == pytest.approx(1, abs=1e-6)
    check_series(found, np.pi * sum(factors))


def test_the_wall_opposite_the_middle_has_its_known_form_factor() -> None:
    """The quadrature itself: four quarters, each (1/π)(a/√(1+a²)) atan(a/√(1+a²)), a = ½ (Howell, B-4)."""
    walls = [surface.shape for surface in case("furnace-box").scene.surfaces]
    a = 0.5 / np.sqrt(1.25)
    expected = 4 / np.pi * a * np.arctan(a)
    found = form_factor(place(walls[0], 0.5, 0.5), walls[0].normal, walls[1])
    assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("x", [(0, 0, 1), (0.6, 0.0, -0.8), (1, 0, 0)])
def test_the_sphere_sees_itself_everywhere(x: tuple[float, float, float]) -> None:
    found = case("furnace-sphere")
    sphere = found.scene.surfaces[0].shape
    z, phi = np.meshgrid(2 * NODES - 1, 2 * np.pi * (np.arange(96) + 0.25) / 96)
    outward = np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z], axis=-1)
    area = 4 * np.pi * sphere.radius**2 * WEIGHTS / 96
    point = np.array(sphere.center) + sphere.radius * np.array(x)
    F = kernel(point, -np.array(x, float), np.array(sphere.center) + sphere.radius * outward, -outward) * area
    assert F.sum() == pytest.approx(1, abs=1e-9)
    check_series(found, np.pi * F.sum())


@pytest.mark.parametrize("name", ["furnace-box", "furnace-sphere"])
def test_the_camera_is_inside(name: str) -> None:
    scene = case(name).scene
    origin = np.array(scene.sensor.origin)
    for surface in scene.surfaces:
        if isinstance(surface.shape, Quad):
            assert (origin - surface.shape.corner) @ surface.shape.normal > 0.1
        else:
            assert surface.shape.inward
            assert np.linalg.norm(origin - surface.shape.center) < surface.shape.radius
