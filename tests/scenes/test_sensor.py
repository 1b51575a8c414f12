"""The pinhole: which pixel looks where."""

from __future__ import annotations

import math

import numpy as np
import pytest

from scenes import Pinhole

ORIGIN, TARGET, UP = (1.0, 2.0, 3.0), (-2.0, 0.5, 4.0), (0.3, 0.1, 1.0)
SHAPES = [(8, 8), (12, 8), (8, 12), (1, 1), (7, 3)]
EYES = [(ORIGIN, TARGET, UP), ((0.0, 0.0, 4.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))]

RIGHTWARD, UPWARD = np.array([0.3, 0.0]), np.array([0.0, 0.3])  # in pixels; rows count downwards

shapes = pytest.mark.parametrize(("width", "height"), SHAPES)
eyes = pytest.mark.parametrize("eye", EYES, ids=["oblique", "along an axis"])


def look(camera: Pinhole, x: float, y: float) -> np.ndarray:
    d = camera.pixel_to_direction @ [x, y, 1]
    return d / np.linalg.norm(d)


def angle(a: np.ndarray, b: np.ndarray) -> float:
    return math.degrees(math.atan2(np.linalg.norm(np.cross(a, b)), a @ b))


@shapes
@eyes
def test_the_middle_of_the_image_looks_at_the_target(eye: tuple, width: int, height: int) -> None:
    camera = Pinhole(*eye, 50.0, width, height)
    view = np.subtract(eye[1], eye[0])
    np.testing.assert_allclose(look(camera, width / 2, height / 2), view / np.linalg.norm(view), atol=1e-14)


@shapes
@eyes
def test_up_is_up_and_right_is_right(eye: tuple, width: int, height: int) -> None:
    camera = Pinhole(*eye, 50.0, width, height)
    view, up = np.subtract(eye[1], eye[0]), np.array(eye[2])
    middle = np.array([width / 2, height / 2])
    above, right = look(camera, *(middle - UPWARD)), look(camera, *(middle + RIGHTWARD))
    assert above @ up > look(camera, *middle) @ up
    assert right @ np.cross(view, up) > 0  # right-handed: view × up points to the right
    assert right @ up == pytest.approx(look(camera, *middle) @ up, rel=0.05)


@shapes
@pytest.mark.parametrize("fov", [1.0, 39.3077, 90.0, 150.0])
def test_the_field_of_view_spans_the_smaller_axis(width: int, height: int, fov: float) -> None:
    camera, small = Pinhole(ORIGIN, TARGET, UP, fov, width, height), min(width, height)
    middle = np.array([width / 2, height / 2])
    for axis in np.eye(2):
        ends = look(camera, *(middle - axis * small / 2)), look(camera, *(middle + axis * small / 2))
        assert angle(*ends) == pytest.approx(fov)


def test_pixels_are_square_and_lie_in_a_plane() -> None:
    camera = Pinhole(ORIGIN, TARGET, UP, 70.0, 6, 4)
    M = camera.pixel_to_direction
    assert np.linalg.norm(M[:, 0]) == pytest.approx(np.linalg.norm(M[:, 1]))
    np.testing.assert_allclose(M[:, :2].T @ camera.frame[:, 2], 0, atol=1e-15)
    assert M[:, 2] @ camera.frame[:, 2] == pytest.approx(1)


@eyes
def test_the_frame_is_orthonormal(eye: tuple) -> None:
    frame = Pinhole(*eye, 50.0, 4, 4).frame
    np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(np.cross(frame[:, 0], frame[:, 1]), -frame[:, 2], atol=1e-14)
