"""Precomputed transfer against the closed forms of unoccluded irradiance, and against form factors and the walk."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from reference_tracer.finite_elements import nodal_albedo, solve
from reference_tracer.precomputed_transfer import precompute
from reference_tracer.random_walk import render
from reference_tracer.spherical_harmonics import evaluate
from scenes import AreaLight, Lambertian, Pinhole, Quad, Scene, SphericalHarmonicsEnvironment, Surface
from scenes.library.cornell_box import empty_box

# A_l of Ramamoorthi and Hanrahan 2001: irradiance is Σ A_l c_lm y_lm(n)
A = np.array([np.pi, 2 * np.pi / 3, np.pi / 4, 0.0, -np.pi / 24, 0.0])
ALBEDO = (0.8, 0.3)


def alone() -> Scene:
    quad = Quad((0.0, 0.0, 0.0), (1.0, 0.2, 0.1), (-0.3, 1.0, 0.6))
    camera = Pinhole((0.2, -0.4, 3.0), (0.3, 0.6, 0.35), (0.0, 1.0, 0.0), 5.0, 4, 4)
    return Scene((Surface("tile", quad, Lambertian(ALBEDO), AreaLight((1.0, 1.0))),), camera)


def test_an_unoccluded_receiver() -> None:
    scene = alone()
    found = precompute(scene, 2, len(A))
    y = evaluate(len(A), scene.surfaces[0].shape.normal[:, None])[:, 0]
    degrees = np.repeat(np.arange(len(A)), 2 * np.arange(len(A)) + 1)
    expected = np.multiply.outer(np.array(ALBEDO) / np.pi, A[degrees] * y)
    np.testing.assert_allclose(
        found.vectors[1], np.broadcast_to(expected[..., None], found.vectors[1].shape), atol=1e-12
    )
    assert not found.vectors[0].any()
    assert not found.vectors[2].any()  # a flat tile lights nothing
    light = np.random.default_rng(4).standard_normal((2, len(A) ** 2))
    radiance = (expected * light).sum(axis=1)
    np.testing.assert_allclose(
        found.terms(light)[1], np.repeat(radiance[:, None], found.F.size, axis=1), atol=1e-12
    )
    np.testing.assert_allclose(found.image(light)[1, 2, 2], radiance, atol=1e-12)


def test_a_uniform_sky_over_an_open_box() -> None:
    """What the sky does not give, the walls do: TE = ρ (1 − F1), and TᵏE follows from the same F."""
    scene = empty_box().resized(8, 8)
    found = precompute(scene, 3, 2, order=3, levels=1, directions=32)
    light = np.zeros((3, 4))
    light[:, 0] = np.sqrt(4 * np.pi)  # radiance 1 from everywhere
    terms = found.terms(light)
    albedo = nodal_albedo(scene, found.F.surfaces)
    open_share = 1 - found.F(np.ones((1, found.F.size)))
    # the rim of the opening crosses one ray in 32 × 128: the mean over the nodes is better by far
    np.testing.assert_allclose(terms[1], albedo * open_share, atol=0.01)
    np.testing.assert_allclose(terms[1].mean(axis=1), (albedo * open_share).mean(axis=1), rtol=2e-3)
    np.testing.assert_allclose(terms[2], albedo * found.F(terms[1]), rtol=1e-12)
    np.testing.assert_allclose(terms[3], albedo * found.F(albedo * found.F(terms[1])), rtol=1e-12)


def test_a_furnace_of_sky_and_walls() -> None:
    """Walls that emit 1 − ρ under a sky of radiance 1 have radiance 1, all bounces together."""
    rho = 0.5
    walls = [s for s in empty_box().surfaces if s.name in ("floor", "back", "green-wall", "red-wall")]
    scene = Scene(
        tuple(Surface(s.name, s.shape, Lambertian((rho,)), AreaLight((1 - rho,))) for s in walls),
        empty_box().sensor,
    )
    by_walls = solve(scene, 30, order=4, levels=2).terms.sum(axis=0)
    by_sky = precompute(scene, 30, 1, order=4, levels=2, directions=24).terms(
        np.full((1, 1), np.sqrt(4 * np.pi))
    )
    np.testing.assert_allclose(by_walls + by_sky.sum(axis=0), 1, atol=0.015)
    assert (by_walls + by_sky.sum(axis=0)).mean() == pytest.approx(1, abs=1e-3)


def test_the_walk_finds_the_same(expect_means: Callable[..., None], off: type[Exception]) -> None:
    """A sky with a bright side, through the open front, several bounces: by quarters of the image.

    The rim of the opening leaves 0.2 % to the nodes' rays (see above), which is below what the walk resolves.
    """
    rng = np.random.default_rng(3)
    light = rng.uniform(-0.4, 0.4, (3, 9))
    light[:, 0] = 3.0
    walls = tuple(msgspec.structs.replace(surface, emission=None) for surface in empty_box().surfaces)
    sky = SphericalHarmonicsEnvironment(light.T.tolist())
    scene = Scene(walls, empty_box().resized(8, 8).sensor, (sky,))
    found = quarters(precompute(scene, 4, 3, order=4, levels=1, directions=32).image(light))
    walks = np.array([quarters(render(scene, 4, 640, seed, "mis", "sobol")) for seed in range(16)])
    for k, resolution in ((1, 0.04), (2, 0.1), (3, 0.2), (4, 0.3)):
        expect_means(walks[:, k], found[k], resolution)
    sideways = light.copy()
    sideways[:, [1, 3]] = light[:, [3, 1]]  # y for x, as a wrong index would have it
    other = quarters(precompute(scene, 1, 3, order=4, levels=1, directions=32).image(sideways))
    with pytest.raises(off):
        expect_means(walks[:, 1], other[1], resolution=0.04)


def quarters(images: np.ndarray) -> np.ndarray:
    bounces, height, width, channels = images.shape
    return images.reshape(bounces, 2, height // 2, 2, width // 2, channels).mean(axis=(2, 4))


def test_arguments_that_cannot_be() -> None:
    with pytest.raises(ValueError, match="bounces = 0: expected 1 or more"):
        precompute(alone(), 0, 2)
    with pytest.raises(ValueError, match=r"shape \(4,\); expected \(channels, order²\) = \(2, 4\)"):
        precompute(alone(), 1, 2).terms(np.ones(4))
