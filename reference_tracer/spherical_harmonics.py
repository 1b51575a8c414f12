"""Real spherical harmonics: the orthonormal basis of functions of a direction.

    y_lm = √2 N_lm P_l^m(z) · cos mφ        m > 0
         =    N_l0 P_l(z)                   m = 0
         = √2 N_lm P_l^|m|(z) · sin |m|φ    m < 0        N_lm² = (2l + 1) / 4π · (l − |m|)! / (l + |m|)!

P_l^m is taken without the Condon–Shortley phase (−1)^m, so that the first ones are √(1/4π), √(3/4π) (y, z, x): the
signs of Ramamoorthi and Hanrahan 2001, An efficient representation for irradiance environment maps. The
harmonic of degree l and order m has the index l (l + 1) + m.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def index(l: int, m: int) -> int:  # noqa: E741  the degree is called l
    """Where y_lm stands: l (l + 1) + m."""
    return l * (l + 1) + m


def evaluate(order: int, directions: Array) -> Array:
    """All y_lm with l < ``order``.

    With P_l^m = sin^m θ · Π_l^m(z), the powers of the sine go to (x + iy)^m = sin^m θ e^{imφ}, and there is no
    division at the poles. Π rises in l by (l − m) Π_l = (2l − 1) z Π_{l−1} − (l + m − 1) Π_{l−2}, from
    Π_m^m = (2m − 1)!!.

    Args:
        order: how many degrees, ≥ 1.
        directions: unit vectors, ``(3, n)``.

    Returns:
        ``(order², n)``.

    Raises:
        ValueError: the order is below 1.
    """
    if order < 1:
        raise ValueError(f"order = {order}: expected at least 1, which is the constant alone")
    x, y, z = directions
    values = np.empty((order**2, len(z)))
    azimuthal = np.ones(len(z), dtype=complex)  # (x + iy)^m
    sectoral = 1.0  # (2m − 1)!!
    for m in range(order):
        before, legendre = np.zeros(len(z)), np.full(len(z), sectoral)
        for l in range(m, order):  # noqa: E741
            norm = (2 * l + 1) / (4 * math.pi) * math.factorial(l - m) / math.factorial(l + m)
            scaled = math.sqrt(norm * (1 if m == 0 else 2)) * legendre
            values[index(l, -m)] = scaled * azimuthal.imag
            values[index(l, m)] = scaled * azimuthal.real  # last, so that m = 0 keeps the cosine
            before, legendre = legendre, ((2 * l + 1) * z * legendre - (l + m) * before) / (l + 1 - m)
        azimuthal, sectoral = azimuthal * (x + 1j * y), sectoral * (2 * m + 1)
    return values
