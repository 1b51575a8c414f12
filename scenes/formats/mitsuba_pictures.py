"""What Mitsuba takes as pictures and we state otherwise: the same radiance, nothing is resampled away."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenes.lights import PolarRange

Array = NDArray[np.float64]

_MOST_STEPS = 3600


def environment_rows(pixels: Array) -> Array:
    """The same environment map, its rows at 2R + 1 equal steps from pole to pole.

    R rows of ours lie in the middle of as many equal zones: every other of these steps. In between the map is
    linear, beyond the first and the last row constant, and so is what Mitsuba makes of these rows: it is the same
    map, nothing is lost. Columns lie at the same longitudes.

    Args:
        pixels: ours, row 0 at the top, ``(R, columns, channels)``.

    Returns:
        Mitsuba's, ``(2 R + 1, columns, channels)``.
    """
    edges = np.concatenate([pixels[:1], (pixels[:-1] + pixels[1:]) / 2, pixels[-1:]])
    rows = np.empty((2 * len(pixels) + 1, *pixels.shape[1:]))
    rows[0::2], rows[1::2] = edges, pixels
    return rows


def zone_rows(zone: PolarRange, radiance: tuple[float, ...]) -> Array | None:
    """The emission of a zone as a texture of a sphere: one column, whose rows are equal steps of the polar angle.

    Args:
        zone: the polar angles that emit.
        radiance: there, per channel.

    Returns:
        As few steps as have a border at both limits, ``(steps, 1, channels)``. None where 3,600 are too few: the
        limits are no multiples of a twentieth of a degree.
    """
    for steps in range(1, _MOST_STEPS + 1):
        first, last = zone.low / 180 * steps, zone.high / 180 * steps
        if max(abs(first - round(first)), abs(last - round(last))) < 1e-9:
            texture = np.zeros((steps, 1, len(radiance)))
            texture[round(first) : round(last)] = radiance
            return texture
    return None
