"""Averages over pixels against integrals that are known."""

from __future__ import annotations

import numpy as np
import pytest

from scenes import Orthographic, Pinhole
from scenes.pixel_average import NotSmoothError, pixel_average, rays

ABOVE = Orthographic((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 2.0, 6, 4)
EYE = Pinhole((0.2, 0.1, 3.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0, 6, 4)


def test_a_polynomial_on_the_ground() -> None:
    """x² y over squares of side ½: the mean of x² is c² + h²/12."""
    image = pixel_average(ABOVE, lambda o, d: np.stack([o[0] ** 2 * o[1], np.ones_like(o[0])]))
    x, y = (np.arange(6) - 2.5) / 2, -(np.arange(4) - 1.5) / 2
    np.testing.assert_allclose(image[..., 0], np.outer(y, x**2 + 0.25 / 12), atol=1e-13)
    np.testing.assert_allclose(image[..., 1], 1, rtol=1e-14)


def test_through_a_pinhole() -> None:
    """1/cos³ of the angle to the view: against a fine midpoint rule, written out."""
    forward = EYE.frame[:, 2]
    image = pixel_average(EYE, lambda o, d: (forward @ d)[None] ** -3)
    n = 200
    x, y = np.meshgrid((np.arange(6 * n) + 0.5) / n, (np.arange(4 * n) + 0.5) / n)
    d = np.einsum("ij,jrc->irc", EYE.pixel_to_direction, np.stack([x, y, np.ones_like(x)]))
    cosine = np.einsum("i,irc->rc", forward, d) / np.linalg.norm(d, axis=0)
    fine = (cosine**-3).reshape(4, n, 6, n).mean(axis=(1, 3))
    np.testing.assert_allclose(image[..., 0], fine, rtol=1e-6)


def test_an_edge_is_refused() -> None:
    with pytest.raises(NotSmoothError, match="row 0, column 3"):
        pixel_average(ABOVE, lambda o, d: (o[0] > 0.2)[None].astype(float))


def test_rays_start_and_look_as_the_sensor_says() -> None:
    origin, d = rays(EYE, np.array([3.0]), np.array([2.0]))
    np.testing.assert_allclose(origin[:, 0], EYE.origin)
    np.testing.assert_allclose(d[:, 0], EYE.frame[:, 2], atol=1e-15)
