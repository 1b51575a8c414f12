"""Fresnel's equations for the answers of cases, written in cosines on both sides.

Light is taken to be unpolarised at every boundary that it meets, as renderers do: R is the mean of the two
polarisations, also after a reflection that would have polarised it.

Born and Wolf 1999, Principles of Optics, §1.5.2 (clear media) and §14.2 (metals).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def dielectric(cos_theta: Array, eta: float) -> Array:
    """R of the boundary between two clear media, of the shape of ``cos_theta``; 1 under total internal reflection.

    With Snell's law, sin θ′ = sin θ / η: r_s = (cos θ − η cos θ′) / (cos θ + η cos θ′) and
    r_p = (η cos θ − cos θ′) / (η cos θ + cos θ′).

    Args:
        cos_theta: of the direction to the normal on its side, ≥ 0.
        eta: index on the other side over that on this one.
    """
    sin2 = (1 - cos_theta**2) / eta**2
    cos_beyond = np.sqrt(np.maximum(1 - sin2, 0))
    r_s = (cos_theta - eta * cos_beyond) / (cos_theta + eta * cos_beyond)
    r_p = (eta * cos_theta - cos_beyond) / (eta * cos_theta + cos_beyond)
    R: Array = np.where(sin2 < 1, (r_s**2 + r_p**2) / 2, 1.0)
    return R


def conductor(cos_theta: Array, eta: ArrayLike, k: ArrayLike) -> Array:
    """R of a metal, ``(channels, n)``, in real numbers.

    The wave in the metal has (a + ib)² = (η + ik)² − sin² θ, so that
    R_s = ((a − cos θ)² + b²) / ((a + cos θ)² + b²) and
    R_p = R_s ((a − sin θ tan θ)² + b²) / ((a + sin θ tan θ)² + b²).

    Args:
        cos_theta: of the direction, > 0, ``(n,)``.
        eta, k: the complex index η + ik over the index outside, ``(channels,)``.
    """
    eta, k = np.asarray(eta)[:, None], np.asarray(k)[:, None]
    sin2 = 1 - cos_theta**2
    real = eta**2 - k**2 - sin2
    modulus = np.sqrt(real**2 + (2 * eta * k) ** 2)  # a² + b²
    a, b2 = np.sqrt((modulus + real) / 2), (modulus - real) / 2
    slope = sin2 / cos_theta
    R_s = ((a - cos_theta) ** 2 + b2) / ((a + cos_theta) ** 2 + b2)
    R_p = R_s * ((a - slope) ** 2 + b2) / ((a + slope) ** 2 + b2)
    R: Array = (R_s + R_p) / 2
    return R
