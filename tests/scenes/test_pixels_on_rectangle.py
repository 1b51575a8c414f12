"""Pixels on a rectangle: the rays of their corners, met with the plane by hand."""

from __future__ import annotations

import numpy as np
import pytest

from scenes import Orthographic, Quad
from scenes.pixel_average import rays
from scenes.pixels_on_rectangle import pixels_on

FLOOR = Quad((-1.0, 0.2, 2.0), (5.0, 0.0, 0.0), (0.0, 0.0, -4.0))
WALL = Quad((0.0, -3.0, 1.0), (0.0, 4.0, 0.0), (-3.0, 0.0, 0.0))  # faces +z; its first edge points up
SLANTWISE = Orthographic((1.3, 5.0, 4.0), (1.3, 1.0, 1.0), (0.0, 1.0, 0.0), 2.0, 6, 4)


def corners(sensor: Orthographic, height: float, axis: int) -> np.ndarray:
    """Where the rays of all corners of pixels meet the plane x[axis] = height, ``(3, height + 1, width + 1)``."""
    x, y = np.meshgrid(np.arange(sensor.width + 1.0), np.arange(sensor.height + 1.0))
    o, d = rays(sensor, x.ravel(), y.ravel())
    return (o + (height - o[axis]) / d[axis] * d).reshape(3, *x.shape)


def test_corners_of_pixels_from_straight_above() -> None:
    above = Orthographic((1.0, 3.0, 0.5), (1.0, 0.0, 0.5), (0.0, 0.0, -1.0), 1.5, 5, 3)
    found, met = pixels_on(FLOOR, above), corners(above, 0.2, 1)
    np.testing.assert_allclose(found.columns, met[0, 0] + 1, atol=1e-14)
    np.testing.assert_allclose(found.rows, 2 - met[2, :, 0], atol=1e-14)
    assert found.area == pytest.approx(0.5**2)
    np.testing.assert_allclose(found.local(np.array([[0.0, 0.7, 1.5]])), [[1], [0.5], [0.5]], atol=1e-14)


def test_corners_of_pixels_from_aside() -> None:
    """Rows lie 1/cos β apart, β the angle between ray and normal."""
    found, met = pixels_on(FLOOR, SLANTWISE), corners(SLANTWISE, 0.2, 1)
    np.testing.assert_allclose(met[0] + 1, np.broadcast_to(found.columns, met[0].shape), atol=1e-13)
    np.testing.assert_allclose(2 - met[2], np.broadcast_to(found.rows[:, None], met[2].shape), atol=1e-13)
    np.testing.assert_allclose(np.abs(np.diff(found.rows)), 0.5 / 0.8)
    assert found.area == pytest.approx(0.5**2 / 0.8)


def test_rows_along_the_second_edge_and_an_end_of_the_rectangle() -> None:
    """The wall runs from x = −3 to 0, y = −3 to 1: what is beyond takes up no width."""
    found, met = pixels_on(WALL, SLANTWISE), corners(SLANTWISE, 1.0, 2)
    np.testing.assert_allclose(found.columns, np.clip(-met[0, 0], 0, 3), atol=1e-13)
    np.testing.assert_allclose(found.rows, np.clip(met[1, :, 0] + 3, 0, 4), atol=1e-13)
    assert (np.diff(found.columns) == 0).any()
    assert (np.diff(found.rows) == 0).any()
    assert found.area == pytest.approx(0.5**2 / 0.6)
    np.testing.assert_allclose(found.frame, [[-1, 0, 0], [0, 1, 0], [0, 0, 1]], atol=1e-15)


def test_a_camera_behind_the_rectangle_is_refused() -> None:
    below = Orthographic((1.0, -3.0, 0.5), (1.0, 0.0, 0.5), (0.0, 0.0, -1.0), 1.5, 5, 3)
    with pytest.raises(ValueError, match="front"):
        pixels_on(FLOOR, below)


@pytest.mark.parametrize("target", [(1.4, 1.0, 1.0), (1.3, 5.0, 0.0)])
def test_rows_askew_and_a_view_along_the_rectangle_are_refused(target: tuple[float, float, float]) -> None:
    askew = Orthographic((1.3, 5.0, 4.0), target, (0.0, 1.0, 0.0), 2.0, 6, 4)
    with pytest.raises(ValueError, match=r"front|rows run along"):
        pixels_on(FLOOR, askew)
