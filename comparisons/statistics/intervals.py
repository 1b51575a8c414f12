"""Confidence intervals of relative biases.

With m̂ the mean of n replicates and s its standard error, t the truth and s_t its own standard error, D the
denominator of a region:

    bias      b   = (m̂ − t) / D
    error     s_b = √(s² + (s_t g)²) / D,   g = m̂ / t where D = t, else 1      (delta method)
    freedom   ν   = (s² + (s_t g)²)² / (s⁴ / ν_m + (s_t g)⁴ / ν_t)             (Welch 1947, Satterthwaite 1946)
    interval  b − q s_b … b + q s_b,   q = t_{1 − α/2, ν}, stretched on the side of a tail: ``skewness.py``

``own`` intervals have the level of one look each: an intersection–union test passes if all of them lie inside
the tolerance (Berger 1982). ``simultaneous`` ones hold together over all intervals of a comparison, by a weighted
Bonferroni bound (Genovese, Roeder and Wasserman 2006, Biometrika 93(3)): half of α is for the whole image, which
sees the smallest biases and is one region of many, the other half for its tiles, each in equal parts over bounces
and channels. Looks are sequential: look j spends α / (j (j + 1)), which sums to α over any number of them.

A tile that no bright path has hit yet has too small a spread, or none at all, beside a mean that is too low. So,
unless its mean is the truth, its error is at least half of what tiles have on average (root mean square), less in
proportion to the root of its light. In dim regions the simultaneous interval takes no standard error for smaller
than that of rare events: ``rare_events.py``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special  # scipy.stats would take longer to import than many a command takes

from comparisons.statistics import power, skewness
from comparisons.statistics.moments import Moments
from comparisons.statistics.rare_events import FLOOR

Array = NDArray[np.float64]

SHARE = 0.5
"""Of the tiles' standard error (root mean square) that each of them has at least."""

_ROUNDING = 2.0**-24  # of 32-bit images, by which a noiseless bias of just the tolerance is not outside
_NO_DEVIATION = 1e-4  # relative: rounding in single precision stays far below it, a tolerance far above


def alpha_of_look(alpha: float, look: int) -> float:
    """α / (j (j + 1)) for look j = 1, 2, …."""
    return alpha / (look * (look + 1))


def alpha_of_regions(alpha: float, regions: int, others: int) -> Array:
    """What each simultaneous interval may miss, ``(regions, 1)``: half of α for region 0, half for all others.

    Args:
        alpha: of this look.
        regions: the whole image and its tiles, if there are any.
        others: how many intervals each region has, bounces × channels.
    """
    if regions == 1:
        return np.full((1, 1), alpha / others)
    share = np.full((regions, 1), 0.5 / (regions - 1))
    share[0] = 0.5
    return alpha * share / others


@dataclass(frozen=True)
class Means:
    """What is known of one side; every array is ``(regions, channels)``.

    Attributes:
        mean, error: means over regions, and their standard errors.
        tail_below, tail_above: skewness of the mean to either side, λ ≥ 0.
        spread: variance of the errors relative to themselves.
        freedom: degrees of freedom of the errors.
    """

    mean: Array
    error: Array
    tail_below: Array
    tail_above: Array
    spread: Array
    freedom: float

    @classmethod
    def known(cls, mean: Array, error: Array) -> Means:
        """Of a truth: its error, if it has one, is taken for known and normal."""
        none = np.zeros_like(mean)
        return cls(mean, error, none, none, none, np.inf)

    @classmethod
    def of(cls, replicates: Moments) -> Means:
        """Of means over regions that were sampled, at least twice."""
        below, above = skewness.both_ways(replicates)
        spread = skewness.spread_of_the_error(replicates)
        return cls(
            mean=replicates.mean,
            error=replicates.standard_error,
            tail_below=below,
            tail_above=above,
            spread=spread,
            freedom=replicates.count - 1,
        )


@dataclass(frozen=True)
class Range:
    """From low to high, element by element."""

    low: Array
    high: Array

    def inside(self, tolerance: Array, center: Array | float = 0.0) -> NDArray[np.bool_]:
        """Where all of it lies inside center ± tolerance, up to rounding."""
        tolerance = tolerance + _ROUNDING
        inside: NDArray[np.bool_] = (self.low >= center - tolerance) & (self.high <= center + tolerance)
        return inside

    def outside(self, tolerance: Array, center: Array | float = 0.0) -> NDArray[np.bool_]:
        """Where all of it lies outside center ± tolerance, and by more than rounding."""
        tolerance = tolerance + _ROUNDING
        outside: NDArray[np.bool_] = (self.low > center + tolerance) | (self.high < center - tolerance)
        return outside


@dataclass(frozen=True)
class Biases:
    """Relative biases of one bounce with their intervals; every array is ``(regions, channels)``.

    Attributes:
        bias: (mean − truth) / denominator.
        error: its standard error.
        own: each interval by itself.
        simultaneous: intervals that hold together.
        resolution: the |bias| that would have failed a tolerance of 0 with 90 % power, whatever its sign.
        p_value: of no bias at all, each by itself; 1 where there is no noise.
    """

    bias: Array
    error: Array
    own: Range
    simultaneous: Range
    resolution: Array
    p_value: Array


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
    measured: Means,
    truth: Means,
    denominator: Array,
    alpha: float,
    others: int,
    least_error: Array | float = 0.0,
) -> Biases:
    """Intervals for the relative bias of each region and channel of one bounce.

    Args:
        measured, truth: both sides, ``(regions, channels)``.
        denominator: what biases are relative to, of the same shape; see ``denominators``.
        alpha: of this look.
        others: how many intervals each region has in this comparison: bounces × channels.
        least_error: of the measured means, that simultaneous intervals take for the least; see ``rare_events.py``.
    """
    s = _at_least_shared(measured, truth, denominator)
    with np.errstate(divide="ignore", invalid="ignore"):
        g = np.where(denominator == truth.mean, measured.mean / truth.mean, 1.0)
        s_t = truth.error * np.abs(g)
        variance = s**2 + s_t**2
        freedom = variance**2 / (s**4 / measured.freedom + s_t**4 / truth.freedom)
        # third cumulants add; the truth's enters with the other sign
        tails = [
            np.where(variance > 0, (a * s**3 + b * s_t**3) / variance**1.5, 0.0)
            for a, b in (
                (measured.tail_below, truth.tail_above),
                (measured.tail_above, truth.tail_below),
            )
        ]
        spread = np.where(variance > 0, (s**4 * measured.spread + s_t**4 * truth.spread) / variance**2, 0.0)
    freedom = np.where(np.isfinite(freedom) & (variance > 0), freedom, np.inf)
    bias, error = (measured.mean - truth.mean) / denominator, np.sqrt(variance) / denominator
    each = alpha_of_regions(alpha, len(bias), others)
    own, simultaneous = (
        [q * skewness.stretch(tail * (q + tail / 6)) for tail in tails]
        for q in (-special.stdtrit(freedom, alpha / 2), -special.stdtrit(freedom, each / 2))
    )
    cautious = np.maximum(error, least_error / denominator)
    return Biases(
        bias=bias,
        error=error,
        own=Range(bias - own[0] * error, bias + own[1] * error),
        simultaneous=Range(bias - simultaneous[0] * cautious, bias + simultaneous[1] * cautious),
        resolution=power.resolution(simultaneous, tails, spread, freedom) * cautious,
        p_value=p_values(bias, error, freedom),
    )


def _at_least_shared(measured: Means, truth: Means, denominator: Array) -> Array:
    """Standard errors; where a tile's mean is not the truth, at least a share of what tiles have on average."""
    tiles = measured.error[1:]
    if not len(tiles):
        return measured.error
    off_the_truth = np.abs(measured.mean - truth.mean) > _NO_DEVIATION * denominator
    average = np.sqrt(np.mean(tiles**2, axis=0))
    # events of one size at a rate in proportion to the light have an error in proportion to its root
    image = truth.mean[:1]
    light = np.divide(truth.mean, image, out=np.ones_like(truth.mean), where=image > 0)
    least = SHARE * average * np.sqrt(np.clip(light, 0, 1))
    least[0] = 0.0  # the whole image is what all of them have met; its own spread is the best there is
    return np.where(off_the_truth, np.maximum(measured.error, least), measured.error)


def p_values(bias: Array, error: Array, freedom: Array) -> Array:
    """Of no bias at all, two-sided; 1 where there is no noise."""
    noisy = error > 0
    t = np.divide(np.abs(bias), error, out=np.zeros_like(bias), where=noisy)
    return np.where(noisy, 2 * special.stdtr(freedom, -t), 1.0)
