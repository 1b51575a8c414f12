"""Outlines of spheres, circles and caps against polygons: projected point by point, area by the shoelace formula."""

from __future__ import annotations

import math

import numpy as np
import pytest

from scenes import Pinhole, PolarRange, Sphere
from scenes.round_coverage import cap_coverage, circle_coverage, sphere_coverage

CORNERS = 200_000  # an inscribed polygon lacks the share 2π²/3N² of an ellipse's area: 2e-10
EYE = Pinhole((1.0, 2.0, 3.0), (-1.0, 1.0, 5.0), (0.2, 0.1, 1.0), 60.0, 36, 28)


def unit(*vector: float) -> np.ndarray:
    return np.array(vector) / np.linalg.norm(vector)


def ahead(distance: float, right: float, up: float) -> np.ndarray:
    """A point so far along the view, and beside it."""
    forward = unit(*np.subtract(EYE.target, EYE.origin))
    across = unit(*np.cross(forward, EYE.up))
    return np.array(EYE.origin) + distance * forward + right * across + up * np.cross(across, forward)


def circle(center: np.ndarray, axis: np.ndarray, radius: float) -> np.ndarray:
    across = unit(*np.cross(axis, [0.3, -0.5, 0.81]))
    phi = np.linspace(0, 2 * np.pi, CORNERS, endpoint=False)
    ring = np.outer(across, np.cos(phi)) + np.outer(np.cross(axis, across), np.sin(phi))
    return center[:, None] + radius * ring


def in_pixels(points: np.ndarray) -> np.ndarray:
    d = points - np.array(EYE.origin)[:, None]
    forward = unit(*np.subtract(EYE.target, EYE.origin))
    right = unit(*np.cross(forward, EYE.up))
    pixels = min(EYE.width, EYE.height) / 2 / math.tan(math.radians(EYE.fov / 2))
    x = EYE.width / 2 + pixels * (right @ d) / (forward @ d)
    y = EYE.height / 2 - pixels * (np.cross(right, forward) @ d) / (forward @ d)
    return np.stack([x, y])


def area_and_middle(polygon: np.ndarray) -> tuple[float, np.ndarray]:
    first = polygon[:, :1]
    (x, y), (x1, y1) = polygon - first, np.roll(polygon, -1, axis=1) - first
    cross = x * y1 - x1 * y
    middle = np.array([((x + x1) * cross).sum(), ((y + y1) * cross).sum()]) / (3 * cross.sum())
    return abs(float(cross.sum())) / 2, middle + first[:, 0]


def check(found: np.ndarray, outline: np.ndarray) -> None:
    """The same area in all, and the same place: to 1/20 of a pixel, which does not know where in it."""
    polygon = in_pixels(outline)
    assert polygon.min() > 0, "this check is for outlines inside the image"
    assert (polygon.max(axis=1) < [EYE.width, EYE.height]).all()
    area, middle = area_and_middle(polygon)
    assert found.sum() == pytest.approx(area, rel=1e-9)
    y, x = (np.indices(found.shape) + 0.5) * found / found.sum()
    np.testing.assert_allclose([x.sum(), y.sum()], middle, atol=0.05)
    empty = ~np.isin(
        np.arange(found.size), np.ravel_multi_index(np.floor(polygon[::-1]).astype(int), found.shape)
    )
    assert set(np.round(found.ravel()[empty], 12)) <= {0.0, 1.0}  # whole or not at all, off the outline


PLACES = [(4.0, 0.3, -0.2, 1.0), (2.0, -0.4, 0.3, 0.5), (10.0, 3.0, 2.0, 1.3)]


@pytest.mark.parametrize(("distance", "right", "up", "radius"), PLACES)
def test_spheres(distance: float, right: float, up: float, radius: float) -> None:
    center = ahead(distance, right, up)
    w = center - EYE.origin
    d2 = float(w @ w)
    # rays touch a sphere in a circle nearer to the eye than its centre
    touching = circle(
        np.array(EYE.origin) + w * (1 - radius**2 / d2),
        w / math.sqrt(d2),
        radius * math.sqrt(1 - radius**2 / d2),
    )
    check(sphere_coverage(Sphere(tuple(center), radius), EYE), touching)


@pytest.mark.parametrize(("distance", "right", "up", "radius"), PLACES)
@pytest.mark.parametrize("axis", [unit(1.0, 0.2, 0.1), unit(-0.3, 0.5, -0.8)])
def test_circles(distance: float, right: float, up: float, radius: float, axis: np.ndarray) -> None:
    center = ahead(distance, right, up)
    found = circle_coverage(center, axis, radius, EYE)
    check(found, circle(center, axis, radius))
    np.testing.assert_allclose(circle_coverage(center, -axis, radius, EYE), found, atol=1e-14)


@pytest.mark.parametrize("high", [15.0, 25.0])
def test_caps(high: float) -> None:
    center, radius, axis = ahead(0.5, 0.2, 0.1), 2.0, unit(*(ahead(1.0, 0.1, -0.2) - EYE.origin))
    cosine, sine = math.cos(math.radians(high)), math.sin(math.radians(high))
    outline = circle(center + radius * cosine * axis, axis, radius * sine)
    sphere = Sphere(tuple(center), radius, inward=True)
    found = cap_coverage(sphere, PolarRange(0.0, high, tuple(axis)), EYE)
    check(found, outline)
    other_end = cap_coverage(sphere, PolarRange(180.0 - high, 180.0, tuple(-axis)), EYE)
    np.testing.assert_allclose(other_end, found, atol=1e-12)


def test_what_is_refused() -> None:
    sphere = Sphere(EYE.origin, 1.0, inward=True)
    with pytest.raises(ValueError, match="outside the sphere"):
        sphere_coverage(sphere, EYE)
    with pytest.raises(ValueError, match="plane of the circle"):
        circle_coverage(EYE.origin, (0.0, 0.0, 1.0), 1.0, EYE)
    with pytest.raises(ValueError, match="two rims"):
        cap_coverage(sphere, PolarRange(10.0, 20.0), EYE)
    with pytest.raises(ValueError, match="through its rim"):
        cap_coverage(sphere, PolarRange(0.0, 120.0), EYE)
