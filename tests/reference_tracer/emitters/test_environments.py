"""Environments: radiance as documented, sampling by the stated density, and the right irradiance from it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from reference_tracer.emitters import environments
from reference_tracer import spherical_harmonics
from reference_tracer.emission import Emitters, NegativeRadianceError
from reference_tracer.points import NOWHERE, Points
from scenes import (
    ConstantEnvironment,
    Environment,
    EnvironmentMap,
    Image,
    Pinhole,
    Scene,
    SphericalHarmonicsEnvironment,
)

CAMERA = Pinhole((0.0, 0.0, 9.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0, 4, 4)
COUNT = 60_000
TURNED = ((0.6, 0.8, 0.0), (0.0, 0.0, 1.0), (0.8, -0.6, 0.0))  # right-handed
MIRRORED = (TURNED[1], TURNED[0], TURNED[2])
UP = (0.0, 0.0, 1.0)


def emitters_of(light: Environment) -> Emitters:
    return Emitters(Scene((), CAMERA, (light,)))


def nowhere(count: int, n: tuple = UP) -> Points:
    return Points(np.zeros((3, count)), np.tile(np.array(n)[:, None], count), np.full(count, NOWHERE))


def radiance(light: Environment, d: np.ndarray) -> np.ndarray:
    return emitters_of(light).Le(nowhere(d.shape[1]), -d)


def directions(rows: int = 400, columns: int = 800) -> tuple[np.ndarray, float]:
    """Midpoints of cells of equal solid angle, and that solid angle."""
    z = 1 - 2 * (np.arange(rows) + 0.5) / rows
    phi = 2 * np.pi * (np.arange(columns) + 0.5) / columns - np.pi
    z, phi = (grid.ravel() for grid in np.meshgrid(z, phi, indexing="ij"))
    r = np.sqrt(1 - z**2)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z]), 4 * np.pi / (rows * columns)


def random_map(
    rows: int, columns: int, channels: int = 3, axes: tuple = TURNED, dark: float = 0.5
) -> EnvironmentMap:
    rng = np.random.default_rng(1)
    image = rng.random((rows, columns, channels)) * (rng.random((rows, columns, 1)) > dark)
    return EnvironmentMap(Image(image), axes)


def one_bright_texel(axes: tuple = TURNED) -> EnvironmentMap:
    image = np.zeros((8, 16, 2))
    image[2, 15] = 3.0, 6.0  # its hat reaches across the seam
    return EnvironmentMap(Image(image), axes)


def hat(d: np.ndarray, axes: tuple) -> np.ndarray:
    """The one bright texel's radiance: a tent of width 1 in pixels about its centre, (15.5, 2.5)."""
    x, y, z = np.array(axes) @ d
    column, row = np.arctan2(y, x) % (2 * np.pi) / (2 * np.pi) * 16, np.arccos(np.clip(z, -1, 1)) / np.pi * 8
    across = np.abs((column - 15.5 + 8) % 16 - 8)
    return np.array([[3.0], [6.0]]) * np.maximum(1 - across, 0) * np.maximum(1 - np.abs(row - 2.5), 0)


def harmonics(axes: tuple = TURNED, channels: int = 2) -> SphericalHarmonicsEnvironment:
    """Ten times as bright on one side as on the other, nowhere negative."""
    c = np.random.default_rng(5).uniform(-0.25, 0.25, (16, channels))
    c[0] = 3.0, 2.8
    return SphericalHarmonicsEnvironment(tuple(map(tuple, c.tolist())), axes)


ENVIRONMENTS = {
    "constant": ConstantEnvironment((2.0, 3.0)),
    "map": random_map(7, 12),
    "mirrored map": random_map(5, 9, axes=MIRRORED),
    "one row": random_map(1, 6, dark=0.2),
    "one column": random_map(6, 1, dark=0.2),
    "one texel": one_bright_texel(),
    "harmonics": harmonics(),
    "harmonics, mirrored": harmonics(MIRRORED),
}


# ---- radiance


def test_a_constant_environment() -> None:
    d, _ = directions(4, 8)
    np.testing.assert_array_equal(radiance(ENVIRONMENTS["constant"], d), np.tile([[2.0], [3.0]], 32))


@pytest.mark.parametrize("axes", [TURNED, MIRRORED])
def test_a_map_between_the_centres_of_pixels(axes: tuple) -> None:
    """At centres the pixel; half way the mean of neighbours, across the seam too; constant towards the poles."""
    image = np.random.default_rng(2).random((4, 6, 3))
    light, frame = EnvironmentMap(Image(image), axes), np.array(axes).T

    def at(row: float, column: float) -> np.ndarray:
        theta, phi = np.pi * row / 4, 2 * np.pi * column / 6
        d = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
        return radiance(light, (frame @ d)[:, None])[:, 0]

    for i, j in np.ndindex(4, 6):
        np.testing.assert_allclose(at(i + 0.5, j + 0.5), image[i, j], rtol=1e-12)
        np.testing.assert_allclose(at(i + 0.5, j), (image[i, j] + image[i, j - 1]) / 2, rtol=1e-12)
    np.testing.assert_allclose(at(2.0, 1.5), (image[1, 1] + image[2, 1]) / 2, rtol=1e-12)
    np.testing.assert_allclose(at(1.75, 5.75), np.average(image[[1, 1, 2, 2], [5, 0, 5, 0]], axis=0,
        weights=np.outer([0.75, 0.25], [0.75, 0.25]).ravel()), rtol=1e-12)  # fmt: skip
    np.testing.assert_allclose(at(0.1, 2.5), image[0, 2], rtol=1e-12)
    np.testing.assert_allclose(at(3.9, 2.5), image[3, 2], rtol=1e-12)


@pytest.mark.parametrize("axes", [TURNED, MIRRORED])
def test_one_bright_texel_is_a_tent(axes: tuple) -> None:
    d, _ = directions(100, 200)
    np.testing.assert_allclose(radiance(one_bright_texel(axes), d), hat(d, axes), atol=1e-12)


def test_the_radiance_of_harmonics_is_their_sum() -> None:
    """Of l = 0 and 1, in Cartesian form: √(1/4π), √(3/4π) (y, z, x) of the local axes."""
    d, _ = directions(10, 20)
    light = SphericalHarmonicsEnvironment(((5.0, 4.0), (1.0, 0.0), (0.5, -0.7), (-2.0, 0.3)), TURNED)
    local = np.array(TURNED) @ d
    one, three = np.sqrt(1 / (4 * np.pi)), np.sqrt(3 / (4 * np.pi))
    expected = np.array([[5.0], [4.0]]) * one
    for c, axis in zip(((1.0, 0.0), (0.5, -0.7), (-2.0, 0.3)), (1, 2, 0), strict=True):
        expected = expected + np.array(c)[:, None] * three * local[axis]
    np.testing.assert_allclose(radiance(light, d), expected, rtol=1e-12)


@pytest.mark.parametrize("axes", [TURNED, MIRRORED])
def test_negative_radiance_is_an_error_with_its_direction(axes: tuple) -> None:
    """√(1/4π) + c √(3/4π) z is least at local −z."""
    coefficients = ((2.0, 1.0), (0.0, 0.0), (0.5, 0.7), (0.0, 0.0))
    with pytest.raises(NegativeRadianceError) as caught:
        emitters_of(SphericalHarmonicsEnvironment(coefficients, axes))
    np.testing.assert_allclose(caught.value.direction, -np.array(axes[2]), atol=1e-12)
    expected = np.sqrt(1 / (4 * np.pi)) - 0.7 * np.sqrt(3 / (4 * np.pi))
    assert caught.value.radiance == pytest.approx(expected)
    assert "expected none below 0" in str(caught.value)


def test_radiance_that_touches_zero_is_no_error() -> None:
    """1 + z, and with a millionth more z: that is one."""
    edge = ((np.sqrt(3.0),), (0.0,), (1.0,), (0.0,))
    assert emitters_of(SphericalHarmonicsEnvironment(edge)).dimensions == 2
    with pytest.raises(NegativeRadianceError):
        emitters_of(SphericalHarmonicsEnvironment((*edge[:2], (1.000001,), edge[3])))


def test_where_harmonics_are_zero_at_the_corners_of_cells_there_is_some_density() -> None:
    """z² = 1/3 + 2/3 P₂(z), on the equator."""
    c = np.zeros((9, 1))
    c[0], c[6] = np.sqrt(4 * np.pi) / 3, 2 / 3 * np.sqrt(4 * np.pi / 5)
    light = SphericalHarmonicsEnvironment(tuple(map(tuple, c.tolist())))
    d = np.array([[1.0, 0.6, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(radiance(light, d), [[0, 0, 1]], atol=1e-12)
    pdf = emitters_of(light).pdf(nowhere(3), nowhere(3), d)
    assert pdf.min() == pytest.approx(environments.LEAST / (4 * np.pi), rel=0.01)
    assert pdf[2] == pytest.approx(3 / (4 * np.pi), rel=0.01)


# ---- sampling


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_directions_follow_the_density(name: str, follows: Callable) -> None:
    """Counts over 12 × 16 cells of the world's directions against the integrated density."""
    emitters, reference = emitters_of(ENVIRONMENTS[name]), nowhere(COUNT)
    sample = emitters.sample(reference, np.random.default_rng(3).random((2, COUNT)))
    np.testing.assert_allclose((sample.wi**2).sum(axis=0), 1, rtol=1e-12)
    np.testing.assert_allclose(sample.pdf, emitters.pdf(reference, reference, sample.wi), rtol=1e-12)
    np.testing.assert_allclose(sample.Li, emitters.Le(reference, -sample.wi), rtol=1e-12)
    assert np.isinf(sample.distance).all()
    assert not np.any(sample.delta)

    d, solid_angle = directions(12 * 80, 16 * 80)
    density = emitters.pdf(nowhere(d.shape[1]), nowhere(d.shape[1]), d)
    assert density.sum() * solid_angle == pytest.approx(1, abs=2e-3)
    assert (density[radiance(ENVIRONMENTS[name], d).max(axis=0) > 0] > 0).all()
    expected = density.reshape(12, 80, 16, 80).sum(axis=(1, 3)).ravel() * solid_angle
    phi = np.arctan2(sample.wi[1], sample.wi[0])
    limits = [(-1, 1), (-np.pi, np.pi)]
    counts = np.histogram2d(sample.wi[2], phi, (12, 16), limits)[0][::-1].ravel()
    assert counts[expected == 0].sum() == 0
    full = expected * COUNT > 30
    share = expected[full] / expected[full].sum()
    assert follows(counts[full], share)
    tilted = share * np.linspace(0.85, 1.15, full.sum())
    assert not follows(counts[full], tilted / tilted.sum())


@pytest.mark.parametrize("name", ["map", "one texel", "harmonics"])
def test_the_density_is_near_the_radiance(name: str) -> None:
    """Sampling by importance is worth its while: the weights vary far less than from uniform directions."""
    emitters, reference = emitters_of(ENVIRONMENTS[name]), nowhere(COUNT)
    sample = emitters.sample(reference, np.random.default_rng(3).random((2, COUNT)))
    weights = sample.Li.mean(axis=0) / sample.pdf
    d, _ = directions(100, 200)
    uniform = radiance(ENVIRONMENTS[name], d).mean(axis=0)
    assert weights.std() / weights.mean() < 0.3 * uniform.std() / uniform.mean()


# ---- irradiance


def batches(light: Environment, n: tuple) -> np.ndarray:
    emitters, count = emitters_of(light), 64 * 2000
    sample = emitters.sample(nowhere(count, n), np.random.default_rng(4).random((2, count)))
    values = sample.Li * np.maximum(np.array(n) @ sample.wi, 0) / sample.pdf
    return values.reshape(len(values), 64, 2000).mean(axis=2).T


def test_irradiance_of_a_constant_environment(expect_means: Callable[..., None]) -> None:
    expect_means(
        batches(ENVIRONMENTS["constant"], (0.6, 0.0, 0.8)), np.pi * np.array([2, 3]), resolution=0.03
    )


@pytest.mark.parametrize("axes", [TURNED, MIRRORED])
def test_irradiance_of_one_bright_texel(
    axes: tuple, expect_means: Callable[..., None], off: type[Exception]
) -> None:
    d, solid_angle = directions(800, 1600)
    L = hat(d, axes)
    n = d[:, L[0].argmax()] + np.array([0.0, 0.3, 0.5])
    n = tuple(n / np.linalg.norm(n))
    expected = (L * np.maximum(np.array(n) @ d, 0)).sum(axis=1) * solid_angle
    found = batches(one_bright_texel(axes), n)
    expect_means(found, expected, resolution=0.02)
    with pytest.raises(off):
        expect_means(1.02 * found, expected, resolution=0.02)


@pytest.mark.parametrize("n", [UP, (0.6, 0.0, -0.8), (-0.36, 0.48, 0.8)])
def test_irradiance_of_harmonics(n: tuple, expect_means: Callable[..., None]) -> None:
    """E(n) = Σ A_l c_lm Y_lm(n), A_l = π, 2π/3, π/4, 0 (Ramamoorthi and Hanrahan 2001, eq. 7 to 9)."""
    light = harmonics()
    Y = spherical_harmonics.evaluate(4, (np.array(TURNED) @ np.array(n))[:, None])[:, 0]
    A = np.repeat([np.pi, 2 * np.pi / 3, np.pi / 4, 0.0], [1, 3, 5, 7])
    expected = (A * Y) @ np.array(light.coefficients)
    expect_means(batches(light, n), expected, resolution=0.03)


def test_the_power_of_an_environment() -> None:
    """4π · mean radiance · π R²; the mean of harmonics is that of the first."""
    two, R = (2.0, 3.0), 3.0
    scene = Scene((), CAMERA, (ConstantEnvironment(two),))
    assert environments.environment(scene, R).power == pytest.approx(4 * np.pi * 2.5 * np.pi * 9)
    scene = Scene((), CAMERA, (harmonics(),))
    mean = 2.9 / np.sqrt(4 * np.pi)
    assert environments.environment(scene, R).power == pytest.approx(4 * np.pi * mean * np.pi * 9, rel=1e-4)
    assert environments.environment(Scene((), CAMERA, (one_bright_texel(),)), R).power > 0


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_nothing_is_undefined_at_poles_and_corners(name: str) -> None:
    last = np.nextafter(1, 0)
    u = np.array([[0, 0, last, last, 0.5], [0, last, 0, last, 0.5]])
    axes = np.concatenate([np.array(TURNED).T, -np.array(TURNED).T, np.eye(3), -np.eye(3)], axis=1)
    emitters = emitters_of(ENVIRONMENTS[name])
    sample = emitters.sample(nowhere(5), u)
    for values in (sample.wi, sample.Li, sample.pdf):
        assert np.isfinite(values).all()
    assert (sample.pdf > 0).all()
    assert np.isfinite(emitters.Le(nowhere(12), axes)).all()
    assert np.isfinite(emitters.pdf(nowhere(12), nowhere(12), axes)).all()


@pytest.mark.parametrize("channels", [1, 5])
def test_any_number_of_channels(channels: int) -> None:
    one = random_map(4, 6, channels)
    assert radiance(one, directions(4, 8)[0]).shape == (channels, 32)
