"""The Lambertian BSDF: reciprocity, energy, and sampling that follows its density."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from reference_tracer.propagation import NOWHERE, Points
from reference_tracer.reflection import LambertianBSDF
from scenes import Lambertian, Scene
from scenes.library import case

COUNT = 50_000


@pytest.fixture(scope="module")
def scene() -> Scene:
    return case("cornell-box").scene


@pytest.fixture(scope="module")
def bsdf(scene: Scene) -> LambertianBSDF:
    return LambertianBSDF(scene)


def unit(rng: np.random.Generator, count: int) -> np.ndarray:
    d = rng.standard_normal((3, count))
    return d / np.linalg.norm(d, axis=0)


def points(scene: Scene, count: int, seed: int = 1) -> Points:
    """Points with any normal on any surface: a BSDF asks for no more."""
    rng = np.random.default_rng(seed)
    return Points(rng.random((3, count)), unit(rng, count), rng.integers(len(scene.surfaces), size=count))


def cosine(at: Points, w: np.ndarray) -> np.ndarray:
    return (at.n * w).sum(axis=0)


def test_reciprocity(scene: Scene, bsdf: LambertianBSDF) -> None:
    at, rng = points(scene, 1000), np.random.default_rng(2)
    wi, wo = unit(rng, 1000), unit(rng, 1000)
    np.testing.assert_array_equal(bsdf.f(at, wi, wo), bsdf.f(at, wo, wi))


def test_value_on_the_front_and_on_the_back(scene: Scene, bsdf: LambertianBSDF) -> None:
    at, rng = points(scene, 1000), np.random.default_rng(2)
    wi, wo = unit(rng, 1000), unit(rng, 1000)
    albedo = np.array([surface.material.albedo for surface in scene.surfaces])[at.surface].T
    front = (cosine(at, wi) > 0) & (cosine(at, wo) > 0)
    assert 200 < front.sum() < 300
    np.testing.assert_allclose(bsdf.f(at, wi, wo), np.where(front, albedo / np.pi, 0), rtol=1e-15)
    np.testing.assert_array_equal(bsdf.weight(at, wo), np.where(cosine(at, wo) > 0, albedo, 0))


def test_nowhere_is_black(bsdf: LambertianBSDF) -> None:
    nowhere, up = Points.nowhere(np.zeros((3, 2))), np.array([[0.0, 0.0], [0.0, 0.6], [1.0, 0.8]])
    assert (nowhere.surface == NOWHERE).all()
    assert not bsdf.f(nowhere, up, up).any()
    assert not bsdf.weight(nowhere, up).any()


def test_energy_is_the_albedo(scene: Scene, bsdf: LambertianBSDF) -> None:
    """∫ f cos θ dω over the sphere of directions by quadrature in (z, φ), for each surface."""
    nodes, weights = np.polynomial.legendre.leggauss(16)
    z, phi = (grid.ravel() for grid in np.meshgrid((nodes + 1) / 2, 2 * np.pi * np.arange(12) / 12))
    r = np.sqrt(1 - z**2)
    wi = np.stack([r * np.cos(phi), r * np.sin(phi), z])
    areas = np.tile(weights / 2 * 2 * np.pi / 12, 12)
    for i, surface in enumerate(scene.surfaces):
        at = Points(np.zeros_like(wi), np.tile([[0.0], [0.0], [1.0]], len(z)), np.full(len(z), i))
        wo = np.tile([[0.48], [0.64], [0.6]], len(z))
        energy = (bsdf.f(at, wi, wo) * z * areas).sum(axis=1)
        np.testing.assert_allclose(energy, surface.material.albedo, rtol=1e-12)
        assert (bsdf.pdf(at, wi) * areas).sum() == pytest.approx(1, rel=1e-12)
        below = wi * [[1], [1], [-1]]
        assert not bsdf.f(at, below, wo).any()
        assert not bsdf.f(at, wi, -wo).any()
        assert not bsdf.pdf(at, below).any()


def test_the_weight_is_f_cos_over_pdf(scene: Scene, bsdf: LambertianBSDF) -> None:
    at = points(scene, 5000)
    wi, wo = bsdf.sample(at, np.random.default_rng(3)), unit(np.random.default_rng(4), 5000)
    assert cosine(at, wi).min() > 0
    expected = bsdf.f(at, wi, wo) * cosine(at, wi) / bsdf.pdf(at, wi)
    np.testing.assert_allclose(bsdf.weight(at, wo), expected, rtol=1e-12)


@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.6, -0.48, 0.64), (-1.0, 0.0, 0.0)])
def test_sampling_follows_the_density(
    bsdf: LambertianBSDF, normal: tuple, follows: Callable[[np.ndarray, np.ndarray], bool]
) -> None:
    """Counts over 12 × 12 cells of equal z and azimuth about the normal, in a frame made here."""
    n = np.array(normal)
    at = Points(np.zeros((3, COUNT)), np.tile(n[:, None], COUNT), np.zeros(COUNT, dtype=int))
    wi = bsdf.sample(at, np.random.default_rng(5))
    across = np.cross(n, [0.36, 0.48, 0.8])
    across /= np.linalg.norm(across)
    azimuth = np.arctan2(np.cross(n, across) @ wi, across @ wi)
    edges = np.linspace(0, 1, 13)
    counts = np.histogram2d(n @ wi, azimuth, bins=(edges, np.linspace(-np.pi, np.pi, 13)))[0]
    assert counts.sum() == COUNT
    cells = np.repeat(np.diff(edges**2)[:, None] / 12, 12, axis=1)  # ∫ z/π dz dφ
    assert follows(counts, cells)
    assert not follows(counts, np.full_like(cells, 1 / cells.size))  # uniform on the hemisphere


def test_a_black_surface_reflects_nothing(scene: Scene) -> None:
    black = [msgspec.structs.replace(surface, material=Lambertian((0.0,) * 3)) for surface in scene.surfaces]
    bsdf, at = LambertianBSDF(Scene(tuple(black), scene.sensor)), points(scene, 100)
    wi = bsdf.sample(at, np.random.default_rng(1))
    assert not bsdf.f(at, wi, wi).any()
    assert not bsdf.weight(at, wi).any()
