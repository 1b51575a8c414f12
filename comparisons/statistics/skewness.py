"""What skewness does to an interval of a mean, and how much of it there is.

Where a few paths carry much of the light, means of replicates lean: a long tail of bright ones, and many that
are too dark with too small a spread. A t-interval far out in the tails, where simultaneous ones live, then misses
many times more often than it says. Hall 1992 (On the removal of skewness by transformation, Journal of the Royal
Statistical Society B 54(1)) makes (m̂ − m) / s symmetric by a cubic in it. Inverted and expanded, a limit that
lies q standard errors away on the side of the tail moves out to q · ``stretch(u)``:

    stretch(u) = 1 + u / 3 + 5 u² / 27 + …,    u = |λ| (q + |λ| / 6),    λ = γ / √n

with γ the skewness of a replicate, λ that of the mean of n of them. (In full it is (q + λ/6) · ``stretch(u)``; the
sixth, a hundredth of q at most where this is any good, is left out.) Two terms are taken: all of them together are
a cube root that turns back at u = 1, where it is steepest. The limit on the other side could move in; it
stays, since γ is an estimate itself.

A region that no bright path has hit yet has no sign of its tail. So λ is the larger of the region's own and of
that of all tiles of the bounce together (weighted by the noise), divided by the square root of their number for
the whole image. What no region has seen of a tail, nobody can correct for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from comparisons.statistics.moments import Moments

Array = NDArray[np.float64]


def stretch(u: Array) -> Array:
    """By how much a limit moves out on the side of the tail; see above."""
    return 1 + u / 3 + 5 * u**2 / 27


def of_the_mean(moments: Moments) -> Array:
    """λ of each element by itself; 0 where there is no spread."""
    return _ratio(moments.m3, moments.m2**1.5)


def both_ways(moments: Moments) -> tuple[Array, Array]:
    """λ of a tail below and of one above, each ≥ 0, with what the tiles have in common.

    Args:
        moments: of means over regions, ``(regions, channels)``, region 0 the whole image.
    """
    own = of_the_mean(moments)
    tiles = len(own) - 1
    if not tiles:
        return np.maximum(-own, 0), np.maximum(own, 0)
    common = _ratio(np.sum(moments.m3[1:], keepdims=True), np.sum(moments.m2[1:] ** 1.5, keepdims=True))
    shared = np.where(np.arange(tiles + 1) > 0, 1.0, 1 / np.sqrt(tiles))[:, None] * common
    return np.maximum(0, np.maximum(-own, -shared)), np.maximum(0, np.maximum(own, shared))


def spread_of_the_error(moments: Moments) -> Array:
    """Variance of the standard error relative to itself, (κ − 1) / 4n with κ the kurtosis of the tiles together.

    Never less than that of normal replicates, 1 / 2 (n − 1).

    Args:
        moments: of means over regions, ``(regions, channels)``, region 0 the whole image.
    """
    n, some = moments.count, slice(1, None) if len(moments.mean) > 1 else slice(None)
    total = np.sum(moments.m2[some] ** 2)
    kurtosis = n * np.sum(moments.m4[some]) / total if total > 0 else 3.0
    return np.full_like(moments.mean, max((kurtosis - 1) / (4 * n), 1 / (2 * max(n - 1, 1))))


def _ratio(m3: Array, m2_cubed_root: Array) -> Array:
    # M₃/n over (M₂/n)^1.5 is γ; divided by √n it is λ, and n drops out
    return np.divide(m3, m2_cubed_root, out=np.zeros_like(m3), where=m2_cubed_root > 0)
