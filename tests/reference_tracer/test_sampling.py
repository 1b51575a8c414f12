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


def alternating(count: int) -> np.ndarray:
    """A fault of a tenth, up and down."""
    return np.where(np.arange(count) % 2, 0.9, 1.1)


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


@pytest.mark.parametrize("versine", [2.0, 1.0, 0.03, 1e-9, 1e-20])
def test_cones(follows: Follows, versine: float) -> None:
    d = sampling.square_to_cone(numbers(), versine)
    np.testing.assert_allclose(np.linalg.norm(d, axis=0), 1, atol=1e-15)
    # 1 − cos θ as half the squared chord, sin² θ/2 · 2, which keeps its digits
    found = 2 * np.sin(np.arctan2(np.hypot(d[0], d[1]), d[2]) / 2) ** 2 / versine
    counts = np.histogram2d(found, np.arctan2(d[1], d[0]), (ROWS, COLUMNS), [(0, 1), (-np.pi, np.pi)])[0]
    assert counts.sum() > 0.9999 * COUNT
    assert follows(counts, np.full(counts.shape, 1 / counts.size))
    tilted = np.repeat(np.linspace(0.9, 1.1, ROWS)[:, None], COLUMNS, axis=1) / counts.size
    assert not follows(counts, tilted)
    solid_angle = 2 * np.pi * versine
    assert sampling.square_to_cone_pdf(versine) * solid_angle == pytest.approx(1)


def test_disk(follows: Follows) -> None:
    x, y = sampling.square_to_disk(numbers())
    counts = np.histogram2d(x * x + y * y, np.arctan2(y, x), (ROWS, COLUMNS), [(0, 1), (-np.pi, np.pi)])[0]
    assert counts.sum() == COUNT
    assert follows(counts, np.full(counts.shape, 1 / counts.size))  # rings of equal area
    assert sampling.square_to_disk_pdf() * np.pi == pytest.approx(1)


def test_triangle(follows: Follows) -> None:
    """Each of 10 × 10 cells of a grid on the triangle: those on the diagonal hold half."""
    s, t = sampling.square_to_triangle(numbers())
    assert (s >= 0).all()
    assert (t >= 0).all()
    assert (s + t).max() <= 1 + 1e-15
    counts = np.histogram2d(s, t, (10, 10), [(0, 1), (0, 1)])[0]
    i, j = np.indices((10, 10))
    area = np.where(i + j < 9, 0.01, np.where(i + j == 9, 0.005, 0)) * sampling.square_to_triangle_pdf()
    inside = area > 0
    assert not counts[~inside].any()
    assert follows(counts[inside], area[inside])


@pytest.mark.parametrize(("a", "b"), [(1.0, 1.0), (0.0, 2.0), (3.0, 0.0), (1.0, 1.0001), (1e-200, 5.0)])
def test_linear(follows: Follows, a: float, b: float) -> None:
    ends = np.full((2, COUNT), [[a], [b]])
    t = sampling.unit_to_linear(numbers()[0], *ends)
    counts = np.histogram(t, 20, (0, 1))[0]
    assert counts.sum() == COUNT
    middles = (np.arange(20) + 0.5) / 20
    share = sampling.unit_to_linear_pdf(middles, np.array(a), np.array(b)) / 20
    assert follows(counts, share)
    assert not follows(counts, share * alternating(20) / (share * alternating(20)).sum())
    assert sampling.unit_to_linear(np.array([0.0, 0.5]), np.zeros(2), np.zeros(2)).tolist() == [0, 0]


def seen_from_the_origin(x0: float, x1: float, y0: float, y1: float, h: float) -> float:
    """Solid angle of a rectangle by Gauss's rule: ∫ h / r³ dA, in panels that grow with the distance."""
    nodes, weights = np.polynomial.legendre.leggauss(40)

    def panels(low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
        limits = np.arcsinh(np.array([low, high]) / h)  # the substitution x = h sinh s evens the peak out
        s = limits[0] + (limits[1] - limits[0]) * (nodes + 1) / 2
        return h * np.sinh(s), weights / 2 * (limits[1] - limits[0]) * h * np.cosh(s)

    (x, wx), (y, wy) = panels(x0, x1), panels(y0, y1)
    return float((np.outer(wx, wy) * h / (x[:, None] ** 2 + y**2 + h**2) ** 1.5).sum())


RECTANGLES = [
    (-1.0, 2.0, -0.5, 0.7, 1.0),
    (-1.0, 2.0, -0.5, 0.7, 0.05),
    (0.3, 2.0, 0.2, 0.7, 0.1),
    (-2.0, -0.5, -3.0, 4.0, 0.3),
    (0.0, 1.0, 0.0, 1.0, 0.5),
    (-0.2, 0.2, -0.1, 0.1, 1.0),
]


@pytest.mark.parametrize("rectangle", RECTANGLES)
def test_spherical_rectangles(follows: Follows, rectangle: tuple[float, ...]) -> None:
    """The share of each of 8 × 8 cells of the rectangle is its share of the solid angle."""
    x0, x1, y0, y1, h = rectangle
    low, high = np.full((2, COUNT), [[x0], [y0]]), np.full((2, COUNT), [[x1], [y1]])
    x, y = sampling.square_to_spherical_rectangle(numbers(), low, high, np.full(COUNT, h))
    counts = np.histogram2d(x, y, (8, 8), [(x0, x1), (y0, y1)])[0]
    assert counts.sum() == COUNT
    xs, ys = np.linspace(x0, x1, 9), np.linspace(y0, y1, 9)
    angles = np.array(
        [[seen_from_the_origin(xs[i], xs[i + 1], ys[j], ys[j + 1], h) for j in range(8)] for i in range(8)]
    )
    whole = seen_from_the_origin(x0, x1, y0, y1, h)
    pdf = sampling.square_to_spherical_rectangle_pdf(low[:, :1], high[:, :1], np.array([h]))[0]
    assert pdf == pytest.approx(1 / whole, rel=1e-9)
    shares = angles * pdf
    full = shares * COUNT > 30
    grouped = [np.append(values[full], values[~full].sum()) for values in (counts, shares)]
    if grouped[1][-1] * COUNT < 30:
        grouped = [values[:-1] for values in grouped]
    share = grouped[1] / grouped[1].sum()
    assert follows(grouped[0], share)
    wrong = share * alternating(len(share))
    assert not follows(grouped[0], wrong / wrong.sum())


@pytest.mark.filterwarnings("error")
def test_spherical_rectangles_nearly_in_the_plane() -> None:
    """Down to heights where a right angle is all that is left: on the rectangle, and nothing undefined."""
    last = np.nextafter(1, 0)
    u = np.array([[0, 0, last, last, 0.5, 0.3], [0, last, 0, last, 0.5, 0.8]])
    for x0, x1, y0, y1, _ in RECTANGLES:
        low, high = np.full((2, 6), [[x0], [y0]]), np.full((2, 6), [[x1], [y1]])
        for h in (1e-3, 1e-9, 1e-30):
            xy = sampling.square_to_spherical_rectangle(u, low, high, np.full(6, h))
            assert np.isfinite(xy).all()
            assert (xy >= low).all()
            assert (xy <= high).all()
            pdf = sampling.square_to_spherical_rectangle_pdf(low, high, np.full(6, h))
            if x0 < 0 < x1 and y0 < 0 < y1:  # above it: half of all directions
                np.testing.assert_allclose(pdf, 1 / (2 * np.pi), rtol=1.5 * h / min(-x0, x1, -y0, y1) + 1e-12)


TRIANGLES = [
    ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    ((1, 0, 0.2), (0.1, 1, 0), (-1, -0.3, 0.1)),
    ((1, 0, 5), (0, 1, 5), (-0.3, -0.4, 5)),
    ((1, 0, 0), (0.999, 0.01, 0.001), (0.9, 0, 0.5)),
]


@pytest.mark.parametrize("corners", TRIANGLES)
def test_spherical_triangles(corners: tuple) -> None:
    """∫ ω dω = ½ Σ βᵢ (vᵢ × vᵢ₊₁) / |…| around the corners, and ∫ ω ωᵀ dω as over the flat triangle.

    By Gauss's rule, once over the unit square of random numbers and once over the flat triangle.
    """
    v = np.array(corners, dtype=float)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    nodes, weights = (nodes + 1) / 2, weights / 2
    u, w = np.stack(np.meshgrid(nodes, nodes)).reshape(2, -1), np.outer(weights, weights).ravel()
    a, b, c = (np.tile((p / np.linalg.norm(p))[:, None], u.shape[1]) for p in v)
    d = sampling.square_to_spherical_triangle(u, a, b, c)
    np.testing.assert_allclose(np.linalg.norm(d, axis=0), 1, atol=1e-12)
    angle = 1 / sampling.square_to_spherical_triangle_pdf(a, b, c)[0]

    s, t = u[0], u[1] * (1 - u[0])
    x = v[:1].T + np.outer(v[1] - v[0], s) + np.outer(v[2] - v[0], t)
    volume = abs(np.linalg.det(v))
    solid_angles = w * (1 - u[0]) * volume / (x**2).sum(axis=0) ** 1.5  # h dA / r³ = |det| ds dt / r³
    assert angle == pytest.approx(solid_angles.sum(), rel=1e-6)
    e = x / np.linalg.norm(x, axis=0)
    np.testing.assert_allclose(angle * (d * w) @ d.T, (e * solid_angles) @ e.T, atol=1e-5 * angle)
    edges = np.stack([v, np.roll(v, -1, axis=0)]) / np.linalg.norm(v, axis=1)[:, None]
    edges[1] = np.roll(edges[0], -1, axis=0)
    cross = np.cross(*edges)
    sine = np.linalg.norm(cross, axis=1)
    beta = np.arctan2(sine, (edges[0] * edges[1]).sum(axis=1))
    flux = (beta / sine) @ cross / 2 * np.sign(np.linalg.det(v))
    np.testing.assert_allclose(angle * d @ w, flux, atol=1e-5 * angle)


@pytest.mark.filterwarnings("error")
def test_spherical_triangles_without_an_area() -> None:
    """Two corners in one place, or three on one arc: directions all the same."""
    u = np.array([[0, 0, 0.9, 0.9, 0.5], [0, 0.9, 0, 0.9, 0.5]])
    for corners in (np.eye(3)[[0, 1, 1]], np.array([[1, 0, 0], [0.6, 0.8, 0], [0, 1, 0]])):
        a, b, c = (np.tile(p[:, None], 5) for p in corners)
        d = sampling.square_to_spherical_triangle(u, a, b, c)
        np.testing.assert_allclose(np.linalg.norm(d, axis=0), 1, atol=1e-12)


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
