"""The measured spectra of the Cornell box: what its walls reflect, what its lamp emits.

Cornell University Program of Computer Graphics, Cornell Box Data,
https://www.graphics.cornell.edu/online/box/data.html. Reflectances were measured from 400 to 700 nm in steps of
4 nm; of the lamp four values are given, between which the usual reading is a straight line.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WAVELENGTHS = tuple(float(nm) for nm in range(400, 701, 4))
"""Nanometres."""

# fmt: off
_PER_MILLE = {
    "white": (
        343, 445, 551, 624, 665, 687, 708, 723, 715, 710, 745, 758, 739, 767, 777, 765, 751, 745, 748, 729,
        745, 757, 753, 750, 746, 747, 735, 732, 739, 734, 725, 721, 733, 725, 732, 743, 744, 748, 728, 716,
        733, 726, 713, 740, 754, 764, 752, 736, 734, 741, 740, 732, 745, 755, 751, 744, 731, 733, 744, 731,
        712, 708, 729, 730, 727, 707, 703, 729, 750, 760, 751, 739, 724, 730, 740, 737,
    ),
    "green": (
        92, 96, 98, 97, 98, 95, 95, 97, 95, 94, 97, 98, 96, 101, 103, 104, 107, 109, 112, 115,
        125, 140, 160, 187, 229, 285, 343, 390, 435, 464, 472, 476, 481, 462, 447, 441, 426, 406, 373, 347,
        337, 314, 285, 277, 266, 250, 230, 207, 186, 171, 160, 148, 141, 136, 130, 126, 123, 121, 122, 119,
        114, 115, 117, 117, 118, 120, 122, 128, 132, 139, 144, 146, 150, 152, 157, 159,
    ),
    "red": (
        40, 46, 48, 53, 49, 50, 53, 55, 57, 56, 59, 57, 61, 61, 60, 62, 62, 62, 61, 62,
        60, 59, 57, 58, 58, 58, 56, 55, 56, 59, 57, 55, 59, 59, 58, 59, 61, 61, 63, 63,
        67, 68, 72, 80, 90, 99, 124, 154, 192, 255, 287, 349, 402, 443, 487, 513, 558, 584, 620, 606,
        609, 651, 612, 610, 650, 638, 627, 620, 630, 628, 642, 639, 657, 639, 635, 642,
    ),
}
# fmt: on

_LAMP = ((400.0, 500.0, 600.0, 700.0), (0.0, 8.0, 15.6, 18.4))


def reflectance(color: str, wavelengths: tuple[float, ...]) -> Array:
    """Of ``white``, ``green`` or ``red``, linear between the measurements, ``(len(wavelengths),)``.

    Args:
        color: which wall.
        wavelengths: in nm, 400 to 700.
    """
    return np.asarray(np.interp(wavelengths, WAVELENGTHS, np.array(_PER_MILLE[color]) / 1000))


def emission(wavelengths: tuple[float, ...]) -> Array:
    """Of the lamp, in the units of the source, ``(len(wavelengths),)``."""
    return np.asarray(np.interp(wavelengths, *_LAMP))
