"""Warps follow their densities, frames are frames, and streams are independent."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from reference_tracer import sampling

Follows = Callable[[np.ndarray, np.ndarray], bool]
COUNT, ROWS, COLUMNS = 100_000, 12, 16
ZONES = [(-1.0, 1.0), (0.7, 1.0), (-0.9, -0.2), (-1.0, -0.999)]


def numbers(seed: int = 1, count: int = COUNT) -> np.ndarray:
    return np.random.default_rng(seed).random((2, count))


def histogram(d: np.ndarray, low: float, high: float) -> np.ndarray:
    """Counts over cells of equal height and azimuth between z = low and z = high."""
    azimuth = np.arctan2(d[1], d[0])
    limits = [(low, high), (-np.pi, np.pi)]
    counts = np.histogram2d(d[2], azimuth, bins=(ROWS, COLUMNS), range=limits)[0]
    assert counts.sum() == d.shape[1], "a direction lies outside the domain"
    return counts


def probabilities(density: Callable[[np.ndarray], np.ndarray], low: float, high: float) -> np.ndarray:
    """The integrals of a density over the same cells: dω = dz dφ."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    edges = np.linspace(low, high, ROWS + 1)
    z = edges[:-1, None] + (high - low) / ROWS * (nodes + 1) / 2
    rows = density(z) @ weights * (high - low) / ROWS / 2
    return np.repeat(rows[:, None] * 2 * np.pi / COLUMNS, COLUMNS, axis=1)


def uniform(z: np.ndarray) -> np.ndarray:
    return np.full_like(z, 1 / (2 * np.pi))


def test_cosine_hemisphere(follows: Follows) -> None:
    d = sampling.square_to_cosine_hemisphere(numbers())
    np.testing.assert_allclose(np.linalg.norm(d, axis=0), 1, atol=1e-15)
    counts = histogram(d, 0, 1)
    assert follows(counts, probabilities(sampling.square_to_cosine_hemisphere_pdf, 0, 1))
    # the same test finds a uniform density, and a lobe that is a little narrower
    assert not follows(counts, probabilities(uniform, 0, 1))
    assert not follows(counts, probabilities(lambda z: 2.15 * z**1.15 / (2 * np.pi), 0, 1))


def test_the_density_is_zero_below_the_horizon() -> None:
    assert not sampling.square_to_cosine_hemisphere_pdf(np.array([-1.0, -0.1, 0.0])).any()


@pytest.mark.parametrize(("low", "high"), ZONES)
def test_zones(follows: Follows, low: float, high: float) -> None:
    d = sampling.square_to_zone(numbers(), low, high)
    np.testing.assert_allclose(np.linalg.norm(d, axis=0), 1, atol=1e-14)

    def density(z: np.ndarray) -> np.ndarray:
        return np.broadcast_to(sampling.square_to_zone_pdf(low, high), z.shape)

    counts, expected = histogram(d, low, high), probabilities(density, low, high)
    assert follows(counts, expected)
    tilted = expected * np.linspace(0.9, 1.1, ROWS)[:, None]
    assert not follows(counts, tilted)


@pytest.mark.parametrize(
    "warp", [sampling.square_to_cosine_hemisphere, lambda u: sampling.square_to_zone(u, -1, 1)]
)
def test_the_corners_of_the_square_are_directions(warp: Callable[[np.ndarray], np.ndarray]) -> None:
    last = np.nextafter(1, 0)
    d = warp(np.array([[0, 0, last, last, 0.5], [0, last, 0, last, 0.5]]))
    np.testing.assert_allclose(np.linalg.norm(d, axis=0), 1, atol=1e-15)


def normals() -> np.ndarray:
    """±x, ±y, ±z, directions about as close to ±z as there are, and random ones."""
    special = np.concatenate([np.eye(3), -np.eye(3)], axis=1)
    near = np.array([[1e-9, 0, s * 1.0] for s in (1, -1)] + [[0, -1e-16, s * 1.0] for s in (1, -1)]).T
    signed = np.array([[1.0, 0, 0.0], [1.0, 0, -0.0], [0.6, 0.8, -1e-300]]).T
    random = np.random.default_rng(2).standard_normal((3, 10_000))
    every = np.concatenate([special, near, signed, random], axis=1)
    return every / np.linalg.norm(every, axis=0)


def test_frames_are_orthonormal_and_right_handed() -> None:
    n = normals()
    s, t = sampling.frame(n)
    axes = np.stack([s, t, n])
    products = np.einsum("ain,bin->nab", axes, axes)
    np.testing.assert_allclose(products, np.broadcast_to(np.eye(3), products.shape), atol=1e-14)
    np.testing.assert_allclose(np.cross(s.T, t.T), n.T, atol=1e-14)


def test_directions_keep_their_angle_to_the_normal() -> None:
    n = normals()
    local = sampling.square_to_cosine_hemisphere(numbers(count=n.shape[1]))
    world = sampling.to_world(local, n)
    np.testing.assert_allclose((world * n).sum(axis=0), local[2], atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(world, axis=0), 1, atol=1e-14)
    up = np.broadcast_to([[0.0], [0.0], [1.0]], n.shape)
    np.testing.assert_allclose(sampling.to_world(up, n), n, atol=1e-15)


def test_a_stream_depends_on_seed_and_place_alone() -> None:
    # of one depth, and below 2³²: SeedSequence takes larger numbers apart, and (0,) and (0, 0) for the same
    places = [(0, 0), (0, 1), (1, 0), (1, 1), (0, 2**31), (2**32 - 1, 3), (20_000_000, 0)]
    first = [tuple(sampling.stream(*place).random(4)) for place in places]
    assert first == [tuple(sampling.stream(*place).random(4)) for place in places]
    assert len(set(first)) == len(places)


def test_neighbouring_streams_are_not_correlated() -> None:
    draws = np.array([sampling.stream(seed, block).random(4000) for seed in range(8) for block in range(8)])
    correlations = np.corrcoef(draws)[np.triu_indices(64, k=1)]
    assert np.abs(correlations).max() < 6.2 / np.sqrt(4000)  # 2016 pairs at 1e-6 altogether
