"""Spherical harmonics against their definition, their orthonormality and their addition theorem."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import eval_legendre, sph_harm_y

from reference_tracer.spherical_harmonics import evaluate, index

ORDER = 9


def directions(count: int) -> np.ndarray:
    d = np.random.default_rng(5).standard_normal((3, count))
    return d / np.linalg.norm(d, axis=0)


def test_the_complex_harmonics_of_scipy_give_the_same() -> None:
    d = directions(50)
    theta, phi = np.arccos(d[2]), np.arctan2(d[1], d[0])
    found = evaluate(ORDER, d)
    for l in range(ORDER):  # noqa: E741
        for m in range(-l, l + 1):
            # (−1)^m takes SciPy's Condon–Shortley phase away
            Y = (-1) ** m * sph_harm_y(l, abs(m), theta, phi) * (1 if m == 0 else np.sqrt(2))
            np.testing.assert_allclose(found[index(l, m)], Y.imag if m < 0 else Y.real, atol=1e-12)


def test_orthonormal() -> None:
    z, w = np.polynomial.legendre.leggauss(ORDER)
    phi = 2 * np.pi * np.arange(2 * ORDER) / (2 * ORDER)
    sine = np.sqrt(1 - z**2)
    d = np.stack([np.outer(sine, np.cos(phi)), np.outer(sine, np.sin(phi)), np.outer(z, np.ones_like(phi))])
    weights = np.repeat(w * 2 * np.pi / len(phi), len(phi))
    y = evaluate(ORDER, d.reshape(3, -1))
    np.testing.assert_allclose((y * weights) @ y.T, np.eye(ORDER**2), atol=1e-12)


def test_addition_theorem() -> None:
    """Σ_m y_lm(a) y_lm(b) = (2l + 1) / 4π · P_l(a·b)."""
    a, b = directions(40).reshape(3, 2, 20).transpose(1, 0, 2)
    products = evaluate(ORDER, a) * evaluate(ORDER, b)
    cosine = np.einsum("in,in->n", a, b)
    for l in range(ORDER):  # noqa: E741
        expected = (2 * l + 1) / (4 * np.pi) * eval_legendre(l, cosine)
        np.testing.assert_allclose(products[l**2 : (l + 1) ** 2].sum(axis=0), expected, atol=1e-12)


def test_the_first_ones_and_the_poles() -> None:
    d = np.array([[0.6, 0.0, 0.0], [0.0, 0.0, 0.8], [0.8, 1.0, -0.6]])
    expected = np.vstack([np.full(3, np.sqrt(1 / (4 * np.pi))), np.sqrt(3 / (4 * np.pi)) * d[[1, 2, 0]]])
    np.testing.assert_allclose(evaluate(2, d), expected, atol=1e-15)
    with pytest.raises(ValueError, match="order = 0: expected at least 1"):
        evaluate(0, d)
