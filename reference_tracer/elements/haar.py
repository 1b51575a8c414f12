"""Haar wavelets: the constants on 2^L × 2^L equal patches, written as one mean and differences at every scale.

A smooth kernel has small differences, so most entries of T in this basis may be dropped and T becomes sparse
(Beylkin, Coifman and Rokhlin 1991, Fast wavelet transforms and numerical algorithms I; Gortler et al. 1993, Wavelet
radiosity, SIGGRAPH; Schröder et al. 1993, Wavelet projections for radiosity). The transform is the non-standard one:
both axes are halved at the same time.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

if TYPE_CHECKING:
    from reference_tracer.finite_elements import FormFactors

Array = NDArray[np.float64]


def transform(values: Array) -> Array:
    """Coefficients of values on n × n equal patches, n a power of two; orthonormal, so that it keeps the L² norm.

    With a, b, c, d the four values of a 2 × 2 square: (a + b + c + d)/2 goes on to the next scale, and the three
    differences (a + b − c − d)/2, (a − b + c − d)/2, (a − b − c + d)/2 stay.

    Args:
        values: ``(…, n, n)``.

    Returns:
        The same shape: the mean in the corner, then ever finer differences.
    """
    result = values.copy()
    n = values.shape[-1]
    while n > 1:
        result[..., :n, :n] = _along(_along(result[..., :n, :n], -1), -2)
        n //= 2
    return result


def inverse(coefficients: Array) -> Array:
    """The values that ``transform`` takes to these coefficients."""
    result, n = coefficients.copy(), 1
    while n < coefficients.shape[-1]:
        n *= 2
        result[..., :n, :n] = _back(_back(result[..., :n, :n], -2), -1)
    return result


def _along(values: Array, axis: int) -> Array:
    """Sums and differences of neighbours, over √2: the sums first."""
    moved = np.moveaxis(values, axis, -1)
    a, b = moved[..., ::2], moved[..., 1::2]
    return np.moveaxis(np.concatenate([a + b, a - b], axis=-1) / np.sqrt(2), -1, axis)


def _back(values: Array, axis: int) -> Array:
    """The inverse of ``_along``."""
    sums, differences = np.split(np.moveaxis(values, axis, -1), 2, axis=-1)
    pairs = np.stack([sums + differences, sums - differences], axis=-1) / np.sqrt(2)
    return np.moveaxis(pairs.reshape(*sums.shape[:-1], -1), -1, axis)


class WaveletFormFactors:
    """F in Haar wavelets, small entries dropped: a drop-in for the operator it is made from.

    Attributes:
        sparse: the matrix that is left, wavelets to wavelets.
        fill: share of its entries that are left.
    """

    def __init__(self, F: FormFactors, threshold: float) -> None:
        self.surfaces, self.slices, self.size = F.surfaces, F.slices, F.size
        # between coefficients of unit norm: √A_i F_ij / √A_j, with the areas of the patches
        self._root_area = np.sqrt(np.concatenate([patches.weights for patches in F.surfaces]))
        matrix = F.matrix() * self._root_area[:, None] / self._root_area
        matrix = self._each(transform, self._each(transform, matrix).T).T
        matrix[np.abs(matrix) < threshold * np.abs(matrix).max()] = 0.0
        self.sparse = scipy.sparse.csr_array(matrix)
        self.fill = self.sparse.nnz / self.size**2

    def __call__(self, values: Array) -> Array:
        """Fields ``(fields, nodes)`` → ``(fields, nodes)``."""
        coefficients = self._each(transform, values * self._root_area)
        return np.asarray(self._each(inverse, (self.sparse @ coefficients.T).T) / self._root_area)

    def _each(self, change: Callable[[Array], Array], values: Array) -> Array:
        """Transform the last axis, surface by surface."""
        result = np.empty_like(values)
        for patches, part in zip(self.surfaces, self.slices, strict=True):
            field = values[..., part].reshape(*values.shape[:-1], *patches.shape)
            result[..., part] = change(field).reshape(*values.shape[:-1], -1)
        return result
