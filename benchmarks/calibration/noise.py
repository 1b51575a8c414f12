"""Noise of tiles, from well-behaved to what bright, rare paths make of it. Each has mean 1 by itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Noise = Callable[[np.random.Generator, tuple[int, ...]], Array]


def _normal(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    return rng.normal(1.0, 0.1, shape)


def _gamma(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    return rng.gamma(4.0, 0.25, shape)


def _lognormal(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    return rng.lognormal(-0.125, 0.5, shape)


def _fireflies(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    """Every third replicate of a tile has one, a tenth of the tile's light on average."""
    rate, size = 0.3, 0.1
    number = rng.poisson(rate, shape)
    light = np.where(number > 0, rng.gamma(np.maximum(number, 1), size), 0.0)
    return rng.normal(1.0 - rate * size, 0.05, shape) + light


def _rare_fireflies(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    """One replicate in thirty has one, as bright as a third of the tile."""
    rate, size = 0.03, 0.3
    hit = rng.random(shape) < rate
    return rng.normal(1.0 - rate * size, 0.05, shape) + np.where(hit, rng.exponential(size, shape), 0.0)


def _pareto(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    """Of tail index 3: a variance, but no skewness to be estimated."""
    return 1.0 + 0.1 * (rng.pareto(3.0, shape) - 0.5)


SHAPES: Mapping[str, Noise] = {
    "normal": _normal,
    "gamma, skewness 1": _gamma,
    "lognormal, skewness 1.75": _lognormal,
    "fireflies": _fireflies,
    "rare fireflies": _rare_fireflies,
    "Pareto, tail index 3": _pareto,
}
