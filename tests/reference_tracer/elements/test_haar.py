"""Haar wavelets: orthonormal, and the same operator when nothing is dropped."""

from __future__ import annotations

import numpy as np
import pytest

from reference_tracer.elements import haar
from reference_tracer.finite_elements import solve
from scenes.library.cornell_box import empty_box


def test_orthonormal() -> None:
    basis = haar.inverse(np.eye(64).reshape(64, 8, 8)).reshape(64, 64)
    np.testing.assert_allclose(basis @ basis.T, np.eye(64), atol=1e-14)
    values = np.random.default_rng(3).standard_normal((2, 8, 8))
    np.testing.assert_allclose(haar.inverse(haar.transform(values)), values, atol=1e-14)


def test_the_coefficients_of_two_by_two() -> None:
    found = haar.transform(np.array([[1.0, 2.0], [3.0, 5.0]]))
    np.testing.assert_allclose(found, [[5.5, -1.5], [-2.5, 0.5]])  # sum, along t, along s, across; all halved
    np.testing.assert_allclose(haar.transform(np.ones((8, 8))), 8 * np.eye(8)[:, :1] @ np.eye(8)[:1])


def test_dropping_nothing_is_radiosity() -> None:
    constant = solve(empty_box(), 3, "constant", levels=3)
    np.testing.assert_allclose(
        solve(empty_box(), 3, "haar", levels=3, threshold=0.0).terms, constant.terms, atol=1e-12
    )


def test_dropping_more_costs_accuracy_and_saves_entries() -> None:
    constant = solve(empty_box(), 3, "constant", levels=4)
    fills, errors = [], []
    for threshold in (1e-2, 1e-3, 1e-4):
        sparse = solve(empty_box(), 3, "haar", levels=4, threshold=threshold)
        assert isinstance(sparse.F, haar.WaveletFormFactors)
        fills.append(sparse.F.fill)
        errors.append(sparse.compared(constant).surfaces.max())
    assert errors[0] > errors[1] > errors[2]
    assert fills[0] < fills[1] < fills[2] < 0.1
    assert errors[2] < 0.003
    with pytest.raises(ValueError, match="order = 2: the basis haar has order 1"):
        solve(empty_box(), 1, "haar", order=2)
