"""Means and variances of replicates that merge exactly, however the work was split.

Chan, Golub and LeVeque 1983, Algorithms for computing the sample variance, The American Statistician 37(3),
eq. 2.1: for two sets a and b with δ = mean_b − mean_a,

    n = n_a + n_b,   mean = mean_a + δ n_b / n,   M₂ = M₂_a + M₂_b + δ² n_a n_b / n
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Moments:
    """Moments of a number of arrays of one shape, element by element.

    Attributes:
        count: how many replicates.
        mean: their mean.
        m2: the sum of their squared deviations from the mean.
    """

    count: int
    mean: Array
    m2: Array

    @classmethod
    def of(cls, replicate: Array) -> Moments:
        """The moments of one replicate."""
        return cls(1, replicate, np.zeros_like(replicate))

    def __add__(self, other: Moments) -> Moments:
        """The moments of both sets together.

        Raises:
            ValueError: the arrays differ in shape.
        """
        if self.mean.shape != other.mean.shape:
            raise ValueError(
                f"moments of shape {self.mean.shape} can't take some of shape {other.mean.shape}"
            )
        count, delta = self.count + other.count, other.mean - self.mean
        mean = self.mean + delta * (other.count / count)
        return Moments(count, mean, self.m2 + other.m2 + delta**2 * (self.count * other.count / count))

    @property
    def variance(self) -> Array:
        """Unbiased variance of a single replicate; NaN for fewer than two."""
        return self.m2 / (self.count - 1) if self.count > 1 else np.full_like(self.m2, np.nan)

    @property
    def standard_error(self) -> Array:
        """Of the mean."""
        return np.sqrt(self.variance / self.count)
