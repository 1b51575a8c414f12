"""The least noise of a dim region, from how the light of the whole image comes.

Where hardly any light arrives, it comes in rare events: a ray that just misses a rim, say. Replicates that have
met few of them have a mean that is too small, and a spread that is too small for the same reason; a t-interval
then says with confidence that light is missing.

A sum of independent events of random size S has the variance q m, with its mean m and q = E[S²] / E[S] (compound
Poisson; Feller 1971, An Introduction to Probability Theory and Its Applications II, §VI.4). The size is learnt
where there is light, from single samples X of the pixels of the whole image, and the light of the region is that
of the truth, t. So the mean over a region of P pixels with N samples each has at least the standard error

    s = √(q t / (P N)),    q = Σ E[X²] / Σ E[X]

Only regions dimmer than ``FLOOR`` times the image take it. In brighter ones there are events enough, and where
they hardly differ (a furnace) the spread is rightly smaller than that.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from comparisons.statistics.moments import Moments

Array = NDArray[np.float64]

FLOOR = 0.05
"""A region is dim, and its denominator is this share of the mean of the bounce's image, if its truth is less."""


def event_size(pixels: Moments, spp: int) -> Array:
    """q, ``(channels,)``; 0 where there is no light.

    Args:
        pixels: of replicates, ``(height, width, channels)``, at least two.
        spp: samples per pixel of each replicate; their variances add.
    """
    first = pixels.mean.sum(axis=(0, 1))
    second = (spp * pixels.variance + pixels.mean**2).sum(axis=(0, 1))
    size: Array = np.divide(second, first, out=np.zeros_like(first), where=first > 0)
    return size


def least_error(size: Array, truth: Array, samples: Array) -> Array:
    """s, the least standard error of dim regions; 0 for all others, ``(regions, channels)``.

    Args:
        size: q, ``(channels,)``.
        truth: means over regions, ``(regions, channels)``, region 0 the whole image.
        samples: P N, of all replicates together, ``(regions, 1)``.
    """
    dim = (truth > 0) & (truth < FLOOR * truth[:1])
    return np.sqrt(np.where(dim, size * truth, 0.0) / samples)
