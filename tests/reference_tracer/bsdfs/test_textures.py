"""Textures: values at centres of pixels, between them and beyond them; squares of a board counted."""

from __future__ import annotations

import numpy as np
import pytest

from reference_tracer.points import Points
from reference_tracer.reflection import LambertianBSDF
from reference_tracer.bsdfs.textures import Albedo, evaluator
from scenes import Checkerboard, Image, ImageTexture, Lambertian

# two rows of three pixels: one channel counts the pixels in tenths, the other falls along a row
PIXELS = tuple(
    tuple((0.1 * (3 * row + column), 0.9 - 0.1 * column) for column in range(3)) for row in range(2)
)


def texture(interpolation: str) -> ImageTexture:
    return ImageTexture(Image(PIXELS), interpolation)


def centres(rows: int, columns: int) -> np.ndarray:
    """Texture coordinates of the centres of pixels, row by row from the top, ``(2, rows · columns)``."""
    row, column = (i.ravel() for i in np.mgrid[:rows, :columns])
    return np.stack([(column + 0.5) / columns, 1 - (row + 0.5) / rows])


@pytest.mark.parametrize("interpolation", ["nearest", "bilinear"])
def test_the_centre_of_a_pixel_has_its_value(interpolation: str) -> None:
    values = evaluator(texture(interpolation))(centres(2, 3))
    np.testing.assert_allclose(values, np.array(PIXELS).reshape(6, 2).T, atol=1e-15)


def test_corners_lie_where_they_should() -> None:
    """The top left corner is (0, 1), the bottom right one (1, 0); beyond them nothing changes any more."""
    corners = np.array([[0.0, 1.0, 0.0, 1.0, -0.7, 3.0], [1.0, 1.0, 0.0, 0.0, 1.2, -9.0]])
    expected = np.array(
        [PIXELS[0][0], PIXELS[0][2], PIXELS[1][0], PIXELS[1][2], PIXELS[0][0], PIXELS[1][2]]
    ).T
    for interpolation in ("nearest", "bilinear"):
        np.testing.assert_allclose(evaluator(texture(interpolation))(corners), expected, atol=1e-15)


def test_nearest_is_constant_over_a_pixel() -> None:
    inside = centres(2, 3)[:, [4]] + np.array([[-0.166, 0.166, 0.0], [0.249, -0.249, 0.1]])
    values = evaluator(texture("nearest"))(inside)
    np.testing.assert_array_equal(values, np.tile(np.array(PIXELS[1][1])[:, None], 3))


def test_bilinear_is_linear_between_centres() -> None:
    """Half way between two pixels the mean of two, between four the mean of four; a third of the way a third."""
    a, b, c, d = (np.array(PIXELS[row][column]) for row in (0, 1) for column in (0, 1))
    left, right, top, bottom = 1 / 6, 3 / 6, 3 / 4, 1 / 4
    third = left + (right - left) / 3
    uv = np.array([[1 / 3, left, 1 / 3, third], [top, 0.5, 0.5, bottom]])
    expected = np.stack([(a + b) / 2, (a + c) / 2, (a + b + c + d) / 4, (2 * c + d) / 3], axis=1)
    np.testing.assert_allclose(evaluator(texture("bilinear"))(uv), expected, atol=1e-15)


def test_bilinear_keeps_the_border_for_half_a_pixel() -> None:
    u = np.linspace(0, 1 / 6, 5)
    values = evaluator(texture("bilinear"))(np.stack([u, np.full(5, 0.75)]))
    np.testing.assert_allclose(values, np.tile(np.array(PIXELS[0][0])[:, None], 5), atol=1e-15)


def test_an_image_of_one_pixel_is_that_pixel() -> None:
    uv = np.random.default_rng(1).random((2, 50))
    for interpolation in ("nearest", "bilinear"):
        values = evaluator(ImageTexture(Image((((0.25,),),)), interpolation))(uv)
        np.testing.assert_array_equal(values, 0.25)


def test_checkerboard() -> None:
    """5 × 3 squares: 8 even ones, which the square at (0, 0) and those at all four corners belong to."""
    board = evaluator(Checkerboard((1.0, 0.5), (0.0, 0.25), columns=5, rows=3))
    values = board(centres(3, 5))
    assert values.shape == (2, 15)
    assert values[0].sum() == 8
    assert set(values[1]) == {0.5, 0.25}
    corners = board(np.array([[0.0, 0.99, 0.0, 0.99], [0.0, 0.0, 0.99, 0.99]]))
    np.testing.assert_array_equal(corners[0], 1)
    # one square on, along u or along v, is the other colour; beyond the board too
    here = np.random.default_rng(2).random((2, 500)) * 3 - 1
    for step in (np.array([[1 / 5], [0]]), np.array([[0], [1 / 3]])):
        np.testing.assert_array_equal(board(here)[0] + board(here + step)[0], 1)


def test_only_textured_surfaces_look_at_texture_coordinates() -> None:
    board, plain = Checkerboard((1.0,), (0.0,), 2, 1), (0.4,)
    albedo = Albedo([plain, board, None], channels=1)
    zeros, up = np.zeros((3, 5)), np.tile([[0.0], [0.0], [1.0]], 5)
    uv = np.array([[0.1, 0.1, 0.9, 0.1, 0.1], [0.5] * 5])
    points = Points(x=zeros, n=up, surface=np.array([0, 1, 1, 2, -1]), ns=up, uv=uv)
    np.testing.assert_array_equal(albedo(points, points.surface), [[0.4, 1.0, 0.0, 0.0, 0.0]])
    points.uv = None
    np.testing.assert_array_equal(Albedo([plain], 1)(points, np.zeros(5, dtype=int)), [[0.4] * 5])
    with pytest.raises(ValueError, match="surface 1 has a texture; expected points with uv"):
        albedo(points, points.surface)


def test_a_lambertian_takes_its_albedo_from_the_texture() -> None:
    bsdf = LambertianBSDF([Lambertian(texture("nearest"))], channels=2)
    uv = centres(2, 3)
    up = np.tile([[0.0], [0.0], [1.0]], 6)
    points = Points(x=np.zeros((3, 6)), n=up, surface=np.zeros(6, dtype=int), ns=up, uv=uv)
    expected = np.array(PIXELS).reshape(6, 2).T
    np.testing.assert_allclose(bsdf.f(points, up, up), expected / np.pi, rtol=1e-15)
    u = np.random.default_rng(1).random((2, 6))
    np.testing.assert_array_equal(bsdf.sample(points, up, u).weight, expected)
    assert not bsdf.sample(points, -up, u).weight.any()
    assert not bsdf.f(points, up, -up).any()
