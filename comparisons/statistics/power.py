"""How large a bias must be to be failed with 90 % power.

An interval that reaches w standard errors out fails a bias of c standard errors if c + Z > w, with Z the noise of
the mean. That c = w + 1.28 holds where the standard error is known. Here it is estimated, twice: by the run that
states its resolution, and by the run of the same length that the statement is about. Both w and c are then
multiples of random numbers, and the noise of the mean goes with that of its standard error where replicates are
skewed:

    c = w + 1.28 √(1 + (c² + w²) v ± w λ + 2 d²)

    v    variance of a standard error relative to itself, ``skewness.spread_of_the_error``
    ± λ  covariance of mean and standard error: + where the limit lies on the side of the tail, − on the other
    d    what the uncertainty of λ makes of w: its derivative times half the sampling error of γ (half, because
         tiles share theirs), √((6 + 9 γ²) / n) and up to √5 times that for heavier tails

The half and the √5 are not derived: they were chosen on the six shapes of noise in ``benchmarks/calibration``, on
which 83 to 96 % of the runs then failed, and are no better known than that.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import special

Array = NDArray[np.float64]

_Z = float(special.ndtri(0.9))


def resolution(limits: Sequence[Array], tails: Sequence[Array], spread: Array, freedom: Array) -> Array:
    """c, the larger of both signs, in standard errors; infinite where there are too few replicates to say.

    Args:
        limits: how far the interval reaches down and up, in standard errors.
        tails: skewness of the mean on these sides, λ ≥ 0.
        spread: variance of the standard error relative to itself.
        freedom: its degrees of freedom.
    """
    (down, up), (tail_down, tail_up) = limits, tails
    # a bias upwards is failed by the lower limit, one downwards by the upper limit
    return np.maximum(
        _detectable(down, tail_down - tail_up, tail_down, spread, freedom),
        _detectable(up, tail_up - tail_down, tail_up, spread, freedom),
    )


def _detectable(w: Array, covariance: Array, tail: Array, v: Array, freedom: Array) -> Array:
    with np.errstate(invalid="ignore"):
        heavier = np.clip(2 * freedom * v, 1, 5)  # than normal noise, by the variance of its own variance
    n = freedom + 1
    # derivative of q · stretch by γ; w² / 3 is near enough to it for this second-order term
    d = np.where(tail > 0, w**2 * np.sqrt((6 / n + 9 * tail**2) / n * heavier) / 6, 0.0)
    variance = np.maximum(1 + w**2 * v + w * covariance + 2 * d**2, 0.2)
    # (c − w)² = z² (variance + v c²), solved for the larger c
    a = 1 - _Z**2 * v
    with np.errstate(invalid="ignore", divide="ignore"):
        c = (w + np.sqrt(w**2 - a * (w**2 - _Z**2 * variance))) / a
    return np.where(a > 0, c, np.inf)
