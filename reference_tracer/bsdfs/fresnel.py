"""Fresnel's equations: how much unpolarised light a smooth boundary reflects.

With the relative index η = η_i / η_o of the two sides, c = cos θo and g = η cos θi, which Snell's law makes
g² = η² − 1 + c², the amplitudes of the two polarisations are

    r_s = (c − g) / (c + g)        r_p = (η² c − g) / (η² c + g)        F = (|r_s|² + |r_p|²) / 2

Born and Wolf 1999, Principles of Optics, §1.5.2 for real η, §14.2 for the complex one of a metal. This is exact; it
is not Schlick's approximation, nor the one that takes η² + k² to be large.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


LARGEST = 1e100
"""Of an index: its square is a number, and all is reflected anyway."""


def relative_index(interior: float, exterior: float) -> float:
    """interior / exterior, within what can be squared."""
    return min(max(interior / exterior, 1 / LARGEST), LARGEST)


def refracted(cos_theta: Array, eta: Array) -> Array:
    """g = η cos θ of the refracted direction, ``(n,)``; 0 under total internal reflection.

    Args:
        cos_theta: cosine of the direction that is refracted, > 0.
        eta: index on the other side over that on the side of this direction.
    """
    return np.sqrt(np.maximum(eta**2 - 1 + cos_theta**2, 0))


def dielectric(cos_theta: Array, eta: Array) -> Array:
    """Share F that the boundary between two clear media reflects; 1 under total internal reflection.

    Args:
        cos_theta: cosine of the direction, > 0.
        eta: index on the other side over that on the side of this direction.
    """
    g = refracted(cos_theta, eta)
    r_s = (cos_theta - g) / (cos_theta + g)
    r_p = (eta**2 * cos_theta - g) / (eta**2 * cos_theta + g)
    return (r_s**2 + r_p**2) / 2


def conductor(cos_theta: Array, eta: Array, k: Array) -> Array:
    """Share F that a metal reflects.

    Args:
        cos_theta: cosine of the direction, > 0, ``(n,)``.
        eta, k: its complex index η + ik over the index outside, ``(channels, n)``.

    Returns:
        ``(channels, n)``.
    """
    n_squared = (np.minimum(eta, LARGEST) + 1j * np.minimum(k, LARGEST)) ** 2
    g = np.sqrt(n_squared - 1 + cos_theta**2)
    r_s = (cos_theta - g) / (cos_theta + g)
    r_p = (n_squared * cos_theta - g) / (n_squared * cos_theta + g)
    F: Array = (np.abs(r_s) ** 2 + np.abs(r_p) ** 2) / 2
    return F
