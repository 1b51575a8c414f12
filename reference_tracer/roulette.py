"""Russian roulette: how a walk without a last bounce ends, and stays unbiased.

A walk of throughput β goes on with probability q and is then worth 1/q as much; else it ends:

    E[β′] = q · (β / q) + (1 − q) · 0 = β      for every 0 < q ≤ 1

so every TᵏE keeps its expectation, whatever q is made of, as long as it is known before the dice are thrown (Arvo
and Kirk 1990, Particle transport and image synthesis, SIGGRAPH, §5). Here q is what the walk's brightest channel
still carries, and never 1 from ``FIRST`` on: where everything is reflected, a walk must end too.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FIRST = 8
"""The bounce before which no walk ends by chance: those before it carry most of the light."""

MOST = 0.95
"""Largest probability to go on: a walk has 20 more bounces on average, at most."""


def roulette(throughput: Array, bounce: int, u: Array) -> Array:
    """What the walks are worth that go on to this bounce; 0 for those that end.

    Args:
        throughput: ``(channels, n)``.
        bounce: that the walks are about to find.
        u: numbers in [0, 1), ``(n,)``.

    Returns:
        ``(channels, n)``.
    """
    if bounce < FIRST:
        return throughput
    q = np.clip(throughput.max(axis=0), 0.0, MOST)
    worth: Array = throughput * np.divide(u < q, q, out=np.zeros_like(q), where=q > 0)
    return worth
