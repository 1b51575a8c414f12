"""Sensors: which pixel looks where."""

from __future__ import annotations

import math

import numpy as np
import pytest

from scenes import (
    ConstantEnvironment,
    IrradianceMeter,
    Orthographic,
    Pinhole,
    RadianceMeter,
    Scene,
    SceneError,
    ThinLens,
)

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


def test_a_thin_lens_is_a_pinhole_about_its_centre() -> None:
    lens, hole = ThinLens(ORIGIN, TARGET, UP, 50.0, 12, 8, 0.3, 2.0), Pinhole(ORIGIN, TARGET, UP, 50.0, 12, 8)
    np.testing.assert_array_equal(lens.pixel_to_direction, hole.pixel_to_direction)
    np.testing.assert_array_equal(lens.frame, hole.frame)


@shapes
@eyes
def test_an_orthographic_image_plane(eye: tuple, width: int, height: int) -> None:
    """Its smaller axis has the length of the extent; pixels are square, rows count downwards, right is right."""
    camera, extent = Orthographic(*eye, 2.5, width, height), 2.5
    M = camera.pixel_to_offset
    corners = [M @ [x, y, 1] for x, y in ((0, 0), (width, 0), (0, height), (width, height))]
    pixel = extent / min(width, height)
    assert np.linalg.norm(corners[1] - corners[0]) == pytest.approx(pixel * width)
    assert np.linalg.norm(corners[2] - corners[0]) == pytest.approx(pixel * height)
    np.testing.assert_allclose(M @ [width / 2, height / 2, 1], 0, atol=1e-14)
    view = np.subtract(eye[1], eye[0])
    np.testing.assert_allclose(view @ np.transpose(corners), 0, atol=1e-13)
    assert (corners[0] - corners[2]) @ np.array(eye[2]) > 0
    assert (corners[1] - corners[0]) @ np.cross(view, eye[2]) > 0


def test_meters_have_one_pixel() -> None:
    meters = RadianceMeter(ORIGIN, (0, 3, 4)), IrradianceMeter(ORIGIN, (0, 3, 4))
    assert meters[0].direction == meters[1].normal == pytest.approx((0, 0.6, 0.8))
    for meter in meters:
        scene = Scene((), meter, (ConstantEnvironment((1.0, 2.0)),))
        assert scene.shape == (1, 1, 2)
        assert scene.resized(1, 1) == scene
        with pytest.raises(SceneError, match=r"Meter\.width = 4: expected 1: a meter has one pixel"):
            scene.resized(4, 1)


def test_resized_scenes_keep_the_field_of_view() -> None:
    sky = (ConstantEnvironment((1.0,)),)
    for camera in (
        Pinhole(ORIGIN, TARGET, UP, 50.0, 12, 8),
        ThinLens(ORIGIN, TARGET, UP, 50.0, 12, 8, 0.3, 2.0),
    ):
        small, large = Scene((), camera, sky).sensor, Scene((), camera, sky).resized(24, 16).sensor
        np.testing.assert_allclose(
            small.pixel_to_direction @ [12, 8, 1], large.pixel_to_direction @ [24, 16, 1], rtol=1e-14
        )
