"""Cone coverage against the areas of a polygon: the rim, projected point by point and clipped by each pixel."""

from __future__ import annotations

import math

import numpy as np
import pytest

from scenes import Pinhole
from scenes.coverage import cone_coverage, half_space_coverage

CORNERS = 100_000  # an inscribed polygon lacks the share 2π²/3N² of an ellipse's area: 7e-10
TIGHT = 1e-7  # in pixels; the largest ellipse below covers some 40 of them


def unit(*vector: float) -> np.ndarray:
    return np.array(vector) / np.linalg.norm(vector)


def rim(axis: np.ndarray, half_angle: float, camera: Pinhole) -> np.ndarray:
    """The rim of a circular cone as a polygon in the image, ``(2, CORNERS)``, by plain perspective."""
    across = unit(*np.cross(axis, [0.3, -0.5, 0.81]))
    phi = np.linspace(0, 2 * np.pi, CORNERS, endpoint=False)
    circle = np.outer(across, np.cos(phi)) + np.outer(np.cross(axis, across), np.sin(phi))
    d = math.cos(half_angle) * axis[:, None] + math.sin(half_angle) * circle
    forward = unit(*np.subtract(camera.target, camera.origin))
    right = unit(*np.cross(forward, camera.up))
    pixels = min(camera.width, camera.height) / 2 / math.tan(math.radians(camera.fov / 2))
    x = camera.width / 2 + pixels * (right @ d) / (forward @ d)
    y = camera.height / 2 - pixels * (np.cross(right, forward) @ d) / (forward @ d)
    return np.stack([x, y])


def clip(polygon: np.ndarray, axis: int, sign: int, limit: float) -> np.ndarray:
    """The part of a convex polygon on one side of a line (Sutherland and Hodgman)."""
    if not polygon.size:
        return polygon
    depth = sign * (polygon[axis] - limit)
    after, depth_after = np.roll(polygon, -1, axis=1), np.roll(depth, -1)
    crosses = np.flatnonzero((depth > 0) != (depth_after > 0))
    share = depth[crosses] / (depth[crosses] - depth_after[crosses])
    points = polygon[:, crosses] + share * (after[:, crosses] - polygon[:, crosses])
    order = np.argsort(np.concatenate([np.flatnonzero(depth > 0), crosses + 0.5]), kind="stable")
    return np.concatenate([polygon[:, depth > 0], points], axis=1)[:, order]


def area(polygon: np.ndarray) -> float:
    if not polygon.size:
        return 0.0
    (x, y), (x1, y1) = polygon - polygon[:, :1], np.roll(polygon, -1, axis=1) - polygon[:, :1]
    return abs(float(np.sum(x * y1 - x1 * y))) / 2


def polygon_coverage(polygon: np.ndarray, camera: Pinhole) -> np.ndarray:
    image = np.zeros((camera.height, camera.width))
    for row in range(camera.height):
        strip = clip(clip(polygon, 1, 1, row), 1, -1, row + 1)
        for column in range(camera.width):
            image[row, column] = area(clip(clip(strip, 0, 1, column), 0, -1, column + 1))
    return image


def coverage(axis: np.ndarray, half_angle: float, camera: Pinhole) -> np.ndarray:
    return cone_coverage(np.outer(axis, axis) - math.cos(half_angle) ** 2 * np.eye(3), axis, camera)


def camera(width: int = 8, height: int = 6, fov: float = 60.0) -> Pinhole:
    return Pinhole((1.0, 2.0, 3.0), (-1.0, 1.0, 5.0), (0.2, 0.1, 1.0), fov, width, height)


def through(x: float, y: float, eye: Pinhole) -> np.ndarray:
    return unit(*(eye.pixel_to_direction @ [x, y, 1]))


PLACES = [
    pytest.param((4.0, 3.0), 20.0, id="in the middle, whole pixels inside"),
    pytest.param((3.3, 2.6), 14.0, id="off the middle"),
    pytest.param((7.2, 0.4), 15.0, id="clipped by two borders"),
    pytest.param((-1.5, 3.0), 25.0, id="centre outside the image"),
    pytest.param((2.4, 1.7), 1.0, id="tiny, within one pixel"),
    pytest.param((4.0, 3.0), 1e-2, id="very tiny, on a corner of four pixels"),
    pytest.param((-9.0, -9.0), 3.0, id="outside the image"),
]


@pytest.mark.parametrize(("middle", "degrees"), PLACES)
@pytest.mark.parametrize("shape", [(8, 6), (5, 7)], ids=["landscape", "portrait"])
def test_every_pixel_against_the_polygon(
    middle: tuple[float, float], degrees: float, shape: tuple[int, int]
) -> None:
    eye = camera(*shape)
    axis, half_angle = through(*middle, eye), math.radians(degrees)
    found, expected = coverage(axis, half_angle, eye), polygon_coverage(rim(axis, half_angle, eye), eye)
    np.testing.assert_allclose(found, expected, atol=TIGHT)
    assert found.min() >= 0
    assert found.max() <= 1 + 1e-12


def test_tangential_to_pixel_edges() -> None:
    """On the axis the ellipse is a circle; of radius 2 pixels, it touches lines between pixels."""
    eye = camera(8, 8, 90.0)
    half_angle = math.atan(2 / 4)
    axis = through(4, 4, eye)
    found = coverage(axis, half_angle, eye)
    np.testing.assert_allclose(found, polygon_coverage(rim(axis, half_angle, eye), eye), atol=TIGHT)
    assert np.count_nonzero(found > 1e-12) == 16
    assert found[3:5, 3:5].min() == pytest.approx(1, abs=1e-12)
    assert found.sum() == pytest.approx(4 * np.pi, rel=1e-12)


@pytest.mark.parametrize("degrees", [0.01, 1.0, 9.0])
@pytest.mark.parametrize("middle", [(4.0, 3.0), (3.3, 2.6), (2.9, 3.7)])
def test_the_pixels_sum_to_the_area_of_the_ellipse(middle: tuple[float, float], degrees: float) -> None:
    """A cone α about an axis at β to the view cuts the plane at 1 in π sin²α cos α / (cos²β − sin²α)^(3/2)."""
    eye = camera()
    axis, alpha = through(*middle, eye), math.radians(degrees)
    cos_beta = axis @ unit(*np.subtract(eye.target, eye.origin))
    ellipse = math.pi * math.sin(alpha) ** 2 * math.cos(alpha) / (cos_beta**2 - math.sin(alpha) ** 2) ** 1.5
    pixel = (2 * math.tan(math.radians(30)) / 6) ** 2
    assert coverage(axis, alpha, eye).sum() == pytest.approx(ellipse / pixel, rel=1e-9)


@pytest.mark.parametrize("corner", [(1, 1), (7, 1), (1, 7), (7, 7)])
def test_every_corner_of_a_wide_image(corner: tuple[int, int]) -> None:
    """Opposite corners look more than 90° apart; the image is symmetric, so all four are alike."""
    eye = camera(8, 8, 110.0)
    assert through(1, 1, eye) @ through(7, 7, eye) < 0
    found = coverage(through(*corner, eye), 0.1, eye)
    expected = coverage(through(1, 1, eye), 0.1, eye)
    flipped = expected[:: -1 if corner[1] > 4 else 1, :: -1 if corner[0] > 4 else 1]
    np.testing.assert_allclose(found, flipped, atol=1e-12)
    assert found.sum() > 0.1


def test_a_cone_behind_the_camera_covers_nothing() -> None:
    eye = camera()
    assert not coverage(-through(4, 3, eye), 0.3, eye).any()


@pytest.mark.parametrize("side", [0, 1], ids=["right", "up"])
@pytest.mark.parametrize("half_angle", [0.3, 1.2])
def test_what_is_no_ellipse_is_refused(side: int, half_angle: float) -> None:
    eye = camera()
    with pytest.raises(ValueError, match="ellipse"):
        coverage(eye.frame[:, side], half_angle, eye)


@pytest.mark.parametrize(
    "line", [(1.0, 0.3, -3.2), (-0.2, 1.0, -1.1), (0.0, 1.0, -2.25), (1.0, 1e-12, -1.5), (-1.0, -2.0, 7.0)]
)
def test_a_half_space(line: tuple[float, float, float]) -> None:
    """a x + b y + c > 0 in pixels, against lines through every pixel, on which it is a segment."""
    sensor = Pinhole((0.2, 0.1, 3.0), (0.3, 0.0, 0.0), (0.1, 1.0, 0.0), 50.0, 6, 4)
    a, b, c = line
    normal = np.linalg.solve(sensor.pixel_to_direction.T, line)
    fine = 2000
    y = (np.arange(4 * fine) + 0.5) / fine
    x = np.arange(6)
    with np.errstate(divide="ignore"):
        edge = -(b * y + c) / a if a else np.where(b * y + c > 0, -np.inf, np.inf)
    share = np.clip(x[None] + 1 - edge[:, None], 0, 1)
    share = 1 - share if a < 0 else share
    expected = share.reshape(4, fine, 6).mean(axis=1)
    np.testing.assert_allclose(half_space_coverage(normal, sensor), expected, atol=1e-6)
