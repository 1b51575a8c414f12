"""Averages across a cone against integrals that are known, and against nested adaptive quadrature."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from msgspec.structs import replace
from scipy.integrate import quad_vec

from scenes import Pinhole
from scenes.cone_average import average_across_cone
from scenes.pixel_average import NotSmoothError, pixel_average, rays

EYE = Pinhole((0.2, -0.3, 0.1), (0.4, 0.9, -0.6), (0.3, 1.0, 0.2), 60.0, 7, 5)
AXIS = np.array([0.1, 0.9, -0.3]) / np.linalg.norm([0.1, 0.9, -0.3])
COSINE = math.cos(math.radians(31.0))
CONE = np.outer(AXIS, AXIS) - COSINE**2 * np.eye(3)


def bent(o: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Two channels, both with the slope of a square root inside the rim, one with something outside as well."""
    root = np.sqrt(np.maximum(((CONE @ d) * d).sum(axis=0), 0) * (AXIS @ d > 0))
    return np.stack([root * (1 + d[0]), 2 + d[1] - root / (1 + 2 * root)])


def tanh_sinh(low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights that crowd at both ends, where there may be roots (Takahasi and Mori 1974)."""
    t = np.linspace(-3.2, 3.2, 81)
    u, du = np.tanh(np.pi / 2 * np.sinh(t)), np.pi / 2 * np.cosh(t) / np.cosh(np.pi / 2 * np.sinh(t)) ** 2
    return (low + high) / 2 + (high - low) / 2 * u, (high - low) / 2 * du * (t[1] - t[0])


def nested(pixel: tuple[int, int]) -> np.ndarray:
    """∫∫ over a pixel, the outer one adaptive; where the rim crosses a row is found by bisection."""
    row, column = pixel

    def inside(x: np.ndarray, y: float) -> np.ndarray:
        return AXIS @ rays(EYE, x, np.full_like(x, y))[1] > COSINE

    def along(y: float) -> np.ndarray:
        ends = column + np.arange(9) / 8
        state = inside(ends, y)
        crossed = np.flatnonzero(state[:-1] != state[1:])
        low, high = ends[crossed], ends[crossed + 1]
        for _ in range(50):
            middle = (low + high) / 2
            still = inside(middle, y) == state[crossed]
            low, high = np.where(still, middle, low), np.where(still, high, middle)
        breaks = [column, *low, column + 1]
        x, dx = np.concatenate([tanh_sinh(a, b) for a, b in pairwise(breaks)], axis=1)
        return bent(*rays(EYE, x, np.full_like(x, y))) @ dx

    return quad_vec(along, row, row + 1, epsabs=1e-8)[0]


def test_pixels_by_nested_quadrature() -> None:
    """Two that the rim crosses, one beside it, one far away."""
    found = average_across_cone(EYE, bent, CONE, AXIS)
    x, y = np.meshgrid(np.arange(8.0), np.arange(6.0))
    _, d = rays(EYE, x.ravel(), y.ravel())
    corners = (AXIS @ d > COSINE).reshape(6, 8)
    count = corners[:-1, :-1].astype(int) + corners[1:, :-1] + corners[:-1, 1:] + corners[1:, 1:]
    pixels = [tuple(np.argwhere((count > 0) & (count < 4))[i]) for i in (0, 4)]
    pixels += [tuple(np.argwhere(count == kind)[0]) for kind in (4, 0)]
    for pixel in pixels:
        np.testing.assert_allclose(found[pixel], nested(pixel), atol=1e-7)


@pytest.mark.parametrize("size", [1, 3, 8, 33])
@pytest.mark.parametrize("degrees", [0.4, 12.0, 29.0])
def test_half_an_ellipsoid(size: int, degrees: float) -> None:
    """About the view a cone is a circle in the image; √(ρ² − r²) over it is ⅔ πρ³."""
    eye = replace(EYE, width=size, height=size)
    forward = eye.frame[:, 2]
    rho = size / 2 * math.tan(math.radians(degrees)) / math.tan(math.radians(30.0))

    def dome(o: np.ndarray, d: np.ndarray) -> np.ndarray:
        tangent2 = 1 / (forward @ d) ** 2 - 1
        return np.sqrt(np.maximum(math.tan(math.radians(degrees)) ** 2 - tangent2, 0))[None]

    cone = np.outer(forward, forward) - math.cos(math.radians(degrees)) ** 2 * np.eye(3)
    image = average_across_cone(eye, dome, cone, forward)
    per_pixel = size / 2 / math.tan(math.radians(30.0))
    assert image.sum() * per_pixel == pytest.approx(2 / 3 * math.pi * rho**3, rel=1e-6)
    assert image.min() >= -1e-12


def test_a_coarse_image_is_the_mean_of_a_fine_one() -> None:
    fine = average_across_cone(replace(EYE, width=35, height=25), bent, CONE, AXIS)
    blocks = fine.reshape(5, 5, 7, 5, 2).mean(axis=(1, 3))
    np.testing.assert_allclose(average_across_cone(EYE, bent, CONE, AXIS), blocks, atol=1e-7)


def test_a_cone_out_of_sight_changes_nothing() -> None:
    def smooth(o: np.ndarray, d: np.ndarray) -> np.ndarray:
        return np.stack([1 + d[0], d[1] ** 2])

    expected = pixel_average(EYE, smooth)
    for axis in (AXIS, -AXIS):
        cone = np.outer(axis, axis) - math.cos(math.radians(31.0)) ** 2 * np.eye(3)
        np.testing.assert_allclose(average_across_cone(EYE, smooth, cone, axis), expected, atol=1e-7)


def test_another_edge_is_refused() -> None:
    def edge(o: np.ndarray, d: np.ndarray) -> np.ndarray:
        return bent(o, d) + (d[0] > 0.31)

    with pytest.raises(NotSmoothError, match="row"):
        average_across_cone(EYE, edge, CONE, AXIS)


def test_what_is_no_ellipse_is_refused() -> None:
    across = EYE.frame[:, 0]
    with pytest.raises(ValueError, match="ellipse"):
        average_across_cone(EYE, bent, np.outer(across, across) - 0.5 * np.eye(3), across)
