"""Means, variances, skewness and kurtosis of replicates that merge exactly, however the work was split.

For two sets a and b with δ = mean_b − mean_a and n = n_a + n_b (Chan, Golub and LeVeque 1983, Algorithms for
computing the sample variance, The American Statistician 37(3), eq. 2.1; M₃ and M₄: Pébay 2008, Formulas for robust,
one-pass parallel computation of covariances and arbitrary-order statistical moments, SAND2008-6212, § 2):

    mean = mean_a + δ n_b / n
    M₂   = M₂_a + M₂_b + δ² n_a n_b / n
    M₃   = M₃_a + M₃_b + δ³ n_a n_b (n_a − n_b) / n² + 3 δ (n_a M₂_b − n_b M₂_a) / n
    M₄   = M₄_a + M₄_b + δ⁴ n_a n_b (n_a² − n_a n_b + n_b²) / n³
           + 6 δ² (n_a² M₂_b + n_b² M₂_a) / n² + 4 δ (n_a M₃_b − n_b M₃_a) / n
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ROUNDING = 2.0**-24  # relative, of 32-bit numbers


@dataclass(frozen=True)
class Moments:
    """Moments of a number of arrays of one shape, element by element.

    Attributes:
        count: how many replicates.
        mean: their mean.
        m2, m3, m4: the sums of powers of their deviations from the mean.
        lowest, highest: the extremes.
    """

    count: int
    mean: Array
    m2: Array
    m3: Array
    m4: Array
    lowest: Array
    highest: Array

    @classmethod
    def of(cls, replicate: Array) -> Moments:
        """The moments of one replicate."""
        zero = np.zeros_like(replicate)
        return cls(1, replicate, zero, zero, zero, replicate, replicate)

    @classmethod
    def of_all(cls, replicates: Array) -> Moments:
        """The moments of replicates that are all at hand, along the first axis."""
        mean = replicates.mean(axis=0)
        off = replicates - mean
        return cls(
            count=len(replicates),
            mean=mean,
            m2=(off**2).sum(axis=0),
            m3=(off**3).sum(axis=0),
            m4=(off**4).sum(axis=0),
            lowest=replicates.min(axis=0),
            highest=replicates.max(axis=0),
        )

    def __add__(self, other: Moments) -> Moments:
        """The moments of both sets together.

        Raises:
            ValueError: the arrays differ in shape.
        """
        if self.mean.shape != other.mean.shape:
            raise ValueError(
                f"moments of shape {self.mean.shape} can't take some of shape {other.mean.shape}"
            )
        a, b, delta = self.count, other.count, other.mean - self.mean
        n = a + b
        return Moments(
            count=n,
            mean=self.mean + delta * (b / n),
            m2=self.m2 + other.m2 + delta**2 * (a * b / n),
            m3=self.m3
            + other.m3
            + delta**3 * (a * b * (a - b) / n**2)
            + 3 * delta * (a * other.m2 - b * self.m2) / n,
            m4=self.m4
            + other.m4
            + delta**4 * (a * b * (a**2 - a * b + b**2) / n**3)
            + 6 * delta**2 * (a**2 * other.m2 + b**2 * self.m2) / n**2
            + 4 * delta * (a * other.m3 - b * self.m3) / n,
            lowest=np.minimum(self.lowest, other.lowest),
            highest=np.maximum(self.highest, other.highest),
        )

    def including(self, replicate: Array) -> Moments:
        """The moments of these and one more: what ``+`` gives for n_b = 1, nine times as fast.

        Raises:
            ValueError: it is of another shape.
        """
        if self.mean.shape != replicate.shape:
            raise ValueError(f"moments of shape {self.mean.shape} can't take one of shape {replicate.shape}")
        a, n = self.count, self.count + 1
        delta = replicate - self.mean
        step = delta / n
        square = delta * step * a  # δ² n_a n_b / n
        return Moments(
            count=n,
            mean=self.mean + step,
            m2=self.m2 + square,
            m3=self.m3 + step * (square * (n - 2) - 3 * self.m2),
            m4=self.m4 + step * step * (square * (n * n - 3 * n + 3) + 6 * self.m2) - 4 * step * self.m3,
            lowest=np.minimum(self.lowest, replicate),
            highest=np.maximum(self.highest, replicate),
        )

    @property
    def variance(self) -> Array:
        """Unbiased variance of a single replicate; NaN for fewer than two."""
        return self.m2 / (self.count - 1) if self.count > 1 else np.full_like(self.m2, np.nan)

    @property
    def standard_error(self) -> Array:
        """Of the mean."""
        return np.sqrt(self.variance / self.count)

    @property
    def dominance(self) -> Array:
        """Share of the squared deviations that is one replicate's, the furthest off; 0 where there is no spread.

        Of n normal replicates it is about 2 ln n / n. What 32-bit numbers round away is no spread.
        """
        furthest = np.maximum(self.highest - self.mean, self.mean - self.lowest)
        spread = self.m2 > self.count * (_ROUNDING * self.mean) ** 2
        share: Array = np.divide(furthest**2, self.m2, out=np.zeros_like(self.m2), where=spread)
        return share
