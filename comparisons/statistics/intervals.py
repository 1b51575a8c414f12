"""Confidence intervals of relative biases, and what they could have shown.

With m̂ the mean of n replicates and s its standard error, t the truth and s_t its own standard error, D the
denominator of a region:

    bias      b   = (m̂ − t) / D
    error     s_b = √(s² + (s_t g)²) / D,   g = m̂ / t where D = t, else 1      (delta method)
    freedom   ν   = (n − 1) (s² + (s_t g)²)² / s⁴                              (Welch 1947, Satterthwaite 1946)
    interval  b ± t_{1 − α/2, ν} s_b

``own`` intervals have the level of one look each: an intersection–union test passes if all of them lie inside
the tolerance (Berger 1982). ``simultaneous`` ones hold together over all m intervals of a comparison, α / m
each (Bonferroni). Looks are sequential: look j spends α / (j (j + 1)), which sums to α over any number of them.

All of this takes the means of replicates for normal. In dim regions they are not: there the simultaneous
interval takes no standard error for smaller than that of rare events, see ``rare_events.py``. An estimator of
infinite variance (next-event estimation alone between walls that meet, say) has no means that are normal, and can
be failed wrongly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from comparisons.statistics.moments import Moments
from comparisons.statistics.rare_events import FLOOR

Array = NDArray[np.float64]

_POWER_90 = float(stats.norm.ppf(0.9))


def alpha_of_look(alpha: float, look: int) -> float:
    """α / (j (j + 1)) for look j = 1, 2, …."""
    return alpha / (look * (look + 1))


@dataclass(frozen=True)
class Biases:
    """Relative biases of one bounce with their intervals; every array is ``(regions, channels)``.

    Attributes:
        bias: (mean − truth) / denominator.
        error: its standard error.
        own: half the width of each interval by itself.
        simultaneous: half the width of intervals that hold together.
    """

    bias: Array
    error: Array
    own: Array
    simultaneous: Array

    @property
    def resolution(self) -> Array:
        """The |bias| that would have failed a tolerance of 0 with 90 % power: (q + 1.28) standard errors."""
        return self.simultaneous + _POWER_90 * self.error

    def inside(self, tolerance: Array, center: Array | float = 0.0) -> NDArray[np.bool_]:
        """Where the own interval lies inside center ± tolerance."""
        inside: NDArray[np.bool_] = np.abs(self.bias - center) + self.own <= tolerance
        return inside

    def outside(self, tolerance: Array, center: Array | float = 0.0) -> NDArray[np.bool_]:
        """Where the simultaneous interval lies outside center ± tolerance."""
        outside: NDArray[np.bool_] = np.abs(self.bias - center) - self.simultaneous > tolerance
        return outside


def denominators(truth: Array) -> Array:
    """What biases are relative to: max(truth, 5 % of the bounce's image mean).

    Where that mean is zero, the image mean of the whole sum; where that is zero too, 1: the bias is absolute.

    Args:
        truth: means over regions, ``(regions, bounces + 1, channels)``, region 0 the whole image.
    """
    image = truth[:1]
    floor = np.maximum(truth, FLOOR * image)
    whole_sum = image.sum(axis=1, keepdims=True)
    return np.where(image > 0, floor, np.where(whole_sum > 0, whole_sum, 1.0))


def biases(
    replicates: Moments,
    truth: Array,
    truth_error: Array,
    denominator: Array,
    alpha: float,
    family: int,
    least_error: Array | float = 0.0,
) -> Biases:
    """Intervals for the relative bias of each region and channel of one bounce.

    Args:
        replicates: moments of means over regions, at least two of them, ``(regions, channels)``.
        truth, truth_error: the truth's means and standard errors, of the same shape.
        denominator: what biases are relative to, of the same shape; see ``denominators``.
        alpha: of this look.
        family: how many intervals hold together: regions × bounces × channels.
        least_error: standard errors of the mean that simultaneous intervals take for the least, of the same shape.
    """
    s = replicates.standard_error
    with np.errstate(divide="ignore", invalid="ignore"):
        g = np.where(denominator == truth, replicates.mean / truth, 1.0)
        variance = s**2 + (truth_error * g) ** 2
        freedom = (replicates.count - 1) * variance**2 / s**4
    freedom = np.where(s > 0, freedom, np.inf)
    error = np.sqrt(variance) / denominator
    return Biases(
        bias=(replicates.mean - truth) / denominator,
        error=error,
        own=stats.t.isf(alpha / 2, freedom) * error,
        simultaneous=stats.t.isf(alpha / 2 / family, freedom) * np.maximum(error, least_error / denominator),
    )
