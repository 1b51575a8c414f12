"""Blocks of n vectors, by component: ``(3, n)``."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TINY = 1e-150
"""Stands for a zero that something is divided by; its square is no zero yet."""


def dot(a: Array, b: Array) -> Array:
    """Scalar products of n pairs of vectors, ``(n,)``."""
    product: Array = np.einsum("in,in->n", a, b)
    return product


def norm(v: Array) -> Array:
    """Their lengths, ``(n,)``."""
    length: Array = np.sqrt(dot(v, v))
    return length


def unit(v: Array) -> Array:
    """The vectors scaled to length 1; a zero stays one."""
    return v / np.maximum(norm(v), TINY)
