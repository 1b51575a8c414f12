"""Warps from the unit square to directions, each with its density right below, and random streams.

Arrays lie by component: a block of n vectors is ``(3, n)``, a block of n points of the unit square ``(2, n)``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def stream(seed: int, *place: int) -> np.random.Generator:
    """A random stream that depends on the seed and on its place (block, replicate …) and on nothing else."""
    # SFC64 is the fastest of NumPy's bit generators; SeedSequence makes streams of nearby seeds independent
    return np.random.Generator(np.random.SFC64(np.random.SeedSequence(seed, spawn_key=place)))


def square_to_cosine_hemisphere(u: Array) -> Array:
    """Directions about +z with density cos θ / π: a disk, lifted (Malley)."""
    radius, phi = np.sqrt(u[0]), 2 * np.pi * u[1]
    return np.stack([radius * np.cos(phi), radius * np.sin(phi), np.sqrt(1 - u[0])])


def square_to_cosine_hemisphere_pdf(cos_theta: Array) -> Array:
    """Solid angle density cos θ / π of the above."""
    return np.maximum(cos_theta, 0) / np.pi


def square_to_zone(u: Array, cos_low: Array, cos_high: Array) -> Array:
    """Points of the unit sphere, uniform on the zone cos_low ≤ z ≤ cos_high (Archimedes: uniform in z)."""
    z = cos_low + (cos_high - cos_low) * u[0]
    radius, phi = np.sqrt(np.maximum(1 - z**2, 0)), 2 * np.pi * u[1]
    return np.stack([radius * np.cos(phi), radius * np.sin(phi), z])


def square_to_zone_pdf(cos_low: Array, cos_high: Array) -> Array:
    """Density per area of the unit sphere, 1 / 2π(cos_high − cos_low), of the above."""
    return 1 / (2 * np.pi * (cos_high - cos_low))


def frame(n: Array) -> tuple[Array, Array]:
    """Two unit vectors that form a right-handed frame (s, t, n) with each normal, ``(3, n)`` each.

    Duff et al. 2017, Building an orthonormal basis, revisited, JCGT 6(1), listing 3.
    """
    sign = np.copysign(1.0, n[2])
    a = -1 / (sign + n[2])
    b = n[0] * n[1] * a
    s = np.stack([1 + sign * n[0] ** 2 * a, sign * b, -sign * n[0]])
    t = np.stack([b, sign + n[1] ** 2 * a, -n[1]])
    return s, t


def to_world(local: Array, n: Array) -> Array:
    """Directions given in the frame about n, in world coordinates, ``(3, n)``."""
    s, t = frame(n)
    world: Array = local[0] * s + local[1] * t + local[2] * n
    return world
