"""Interpolation against the function itself, along one axis and over two."""

from __future__ import annotations

import numpy as np
import pytest

from scenes.interpolation import interpolated


def test_along_one_axis() -> None:
    calls = []

    def f(x: np.ndarray) -> np.ndarray:
        calls.append(x.shape[1])
        return np.stack([np.exp(x[0]), 1 / (3 + x[0])])

    x = np.random.default_rng(1).uniform(-1, 2, (1, 5000))
    np.testing.assert_allclose(interpolated(f, x), f(x), rtol=1e-8)
    assert sum(calls[:-1]) < 100


def test_over_two_axes() -> None:
    def f(x: np.ndarray) -> np.ndarray:
        return np.stack([np.sin(x[0] + 2 * x[1] ** 2), x[0] - x[1]])

    x = np.random.default_rng(2).uniform([[0.1], [-0.7]], [[1.0], [0.4]], (2, 3000))
    np.testing.assert_allclose(interpolated(f, x), f(x), atol=1e-9)


def test_one_point() -> None:
    x = np.array([[0.3], [0.2]])
    np.testing.assert_allclose(interpolated(lambda x: x[:1] * x[1:], x), [[0.06]], rtol=1e-9)


def test_an_edge_is_refused() -> None:
    with pytest.raises(ValueError, match="smooth"):
        interpolated(lambda x: np.abs(x - 0.1), np.linspace(-1, 1, 50)[None])
