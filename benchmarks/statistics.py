"""Ratios of times, and of costs at equal error, with their intervals.

Times are taken in pairs, one run of each side right after the other, so that a ratio r_i = a_i / b_i has little
of what slows the machine down for a while. The ratio is the median of all r_i; its interval are two of them,

    [r₍ₖ₎, r₍ₙ₊₁₋ₖ₎]   covers the median with probability 1 − 2 P(Bin(n, ½) < k)     (David and Nagaraja 2003, § 7.1)

whatever the distribution; k is the largest with at least 95 %. Fewer than six pairs don't reach that: their
interval is the whole range, 93.75 % for five.

The cost of an estimator is time × variance (Hammersley and Handscomb 1964, § 2.5): with independent samples, the
time to a variance of 1. Over bounces k costs are compared by the geometric mean of their ratios.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]

LEVEL = 0.95
RESAMPLES = 2000

FEWEST = 8
"""Trials for a bootstrap; with fewer, some resamples hold one trial alone and have no variance."""


@dataclass(frozen=True)
class Ratio:
    """A ratio and its interval."""

    value: float
    low: float
    high: float

    def __mul__(self, factor: float) -> Ratio:
        return Ratio(self.value * factor, self.low * factor, self.high * factor)


def median_ratio(over: Array, under: Array) -> Ratio:
    """The median of ratios of pairs, with its interval by order statistics; see the module.

    Args:
        over, under: positive, ``(pairs,)`` each.
    """
    ratios = np.sort(over / under)
    k = max(1, int(stats.binom.ppf((1 - LEVEL) / 2, len(ratios), 0.5)))
    return Ratio(float(np.median(ratios)), float(ratios[k - 1]), float(ratios[-k]))


@dataclass(frozen=True)
class CostRatio:
    """Costs at equal error, divided.

    Attributes:
        ratio: the geometric mean over bounces, with its interval.
        bounces: of each bounce, ``(bounces,)``.
        way: which of their ways it is.
    """

    ratio: Ratio
    bounces: Array
    way: str


@dataclass(frozen=True)
class Trials:
    """Repeated estimates of the same by one side.

    Attributes:
        seconds: that each took, ``(trials,)``.
        estimates: one seed each, ``(trials, bounces, regions, channels)``.
    """

    seconds: Array
    estimates: Array


def variances(estimates: Array, counts: Array) -> Array:
    """Relative variances of one estimate, for resamples of the trials.

    Args:
        estimates: of n trials, ``(n, bounces, regions, channels)``.
        counts: how often each trial is in each resample, ``(resamples, n)``; n in all.

    Returns:
        ``(resamples, bounces)``: the mean over regions and channels of the variance, relative to the squared mean
        over all trials and regions of that bounce and channel.
    """
    n, bounces = estimates.shape[:2]
    x = (estimates - estimates.mean(axis=0)) / estimates.mean(axis=(0, 2), keepdims=True)
    x = x.reshape(n, -1)
    mean, square = counts @ x / n, counts @ x**2 / n
    variance: Array = ((square - mean**2) * (n / (n - 1))).reshape(len(counts), bounces, -1).mean(axis=2)
    return variance


def cost_ratio(theirs: Mapping[str, Trials], ours: Trials, seed: int = 0) -> CostRatio:
    """Cost at equal error, theirs ÷ ours: the geometric mean over bounces, with a bootstrap interval.

    Of several ways that they have, the one with the smallest ratio counts; it is chosen anew in every resample, so
    that the choice can't flatter us. Trials are drawn with replacement, the same ones for the times of both
    sides, which were taken in pairs, and others for the estimates, which are independent (Efron and Tibshirani
    1993, § 13.3, percentiles).

    Args:
        theirs: their ways by name, each with as many trials as ``ours``.
        ours: our trials.
        seed: of the resamples.

    Raises:
        ValueError: there are too few trials.
    """
    if len(ours.seconds) < FEWEST:
        raise ValueError(f"{len(ours.seconds)} trials: expected at least {FEWEST}")
    n, rng = len(ours.seconds), np.random.default_rng(seed)
    # the first row of each is the sample itself
    pairs = np.concatenate([np.arange(n)[None], rng.integers(n, size=(RESAMPLES, n))])
    in_theirs, in_ours = (
        np.concatenate([np.ones((1, n)), rng.multinomial(n, np.full(n, 1 / n), size=RESAMPLES)])
        for _ in range(2)
    )
    our_variance = variances(ours.estimates, in_ours)
    ratios = {}
    for name, trials in theirs.items():
        seconds = np.median((trials.seconds / ours.seconds)[pairs], axis=1)
        ratios[name] = seconds[:, None] * variances(trials.estimates, in_theirs) / our_variance
    means = {name: np.exp(np.log(ratio).mean(axis=1)) for name, ratio in ratios.items()}
    least = np.min(list(means.values()), axis=0)
    low, high = np.quantile(least[1:], [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    way = min(means, key=lambda name: float(means[name][0]))
    return CostRatio(Ratio(float(least[0]), float(low), float(high)), ratios[way][0], way)
