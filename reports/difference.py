"""How two images differ: signed, from blue (renderer darker) over white to red (renderer brighter)."""

from __future__ import annotations

import numpy as np
from bokeh.palettes import RdBu11, interp_palette
from numpy.typing import NDArray

from reports.exposure import NOT_FINITE, Image, Pixels

Field = NDArray[np.float64]

PALETTE: tuple[str, ...] = tuple(RdBu11)
"""From blue over white to red, as CSS colours."""

SIGMAS = 4.0
"""Where the map of differences in standard errors saturates."""

_FLOOR = 1e-4  # below ±0.01 % there is only the rounding of 32-bit images, which must not look like an effect
_COLOURS = np.array(
    [[int(c[i : i + 2], 16) for i in (1, 3, 5)] for c in interp_palette(PALETTE, 255)], np.uint8
)


def relative(truth: Image, renderer: Image, fallback: float = 0.0) -> tuple[Field, bool]:
    """The mean over channels of renderer − truth, divided by the mean of the truth.

    Args:
        truth: radiance, ``(height, width, channels)``.
        renderer: radiance of the same shape.
        fallback: the mean to divide by where this truth is dark: that of the whole sum.

    Returns:
        The differences, ``(height, width)``, and whether they are relative; where there is no light to
        divide by they are radiance.
    """
    mean = float(truth.mean()) or fallback
    divisor = abs(mean) if np.isfinite(mean) and mean else 0.0
    difference: Field = (renderer - truth).mean(axis=-1)
    return difference / (divisor or 1.0), bool(divisor)


def in_standard_errors(truth: Image, renderer: Image, truth_error: Image, renderer_error: Image) -> Field:
    """The difference of the channel means divided by its standard error.

    The channels of a path share their random numbers, so their errors are taken as fully correlated: the
    error of the mean is the mean of the errors.

    Args:
        truth: radiance, ``(height, width, channels)``; the three others have its shape.
        renderer: radiance.
        truth_error: the truth's standard error.
        renderer_error: the renderer's standard error.

    Returns:
        Dimensionless, ``(height, width)``.
    """
    # images are stored in 32 bits; without their rounding, a pixel free of noise would be infinitely wrong
    rounding = np.finfo(np.float32).eps * np.maximum(np.abs(truth), np.abs(renderer))
    error = np.sqrt(truth_error**2 + renderer_error**2 + rounding**2).mean(axis=-1)
    difference = (renderer - truth).mean(axis=-1)
    ratio: Field = np.divide(difference, error, out=np.zeros_like(difference), where=error > 0)
    return ratio


def automatic_scale(field: Field) -> float:
    """The value at which a map saturates: the 99th percentile of its magnitudes, at least 0.01 %.

    Pixels without any difference don't count, or a small lamp in a dark image would always be saturated.
    """
    finite = np.abs(field[np.isfinite(field) & (field != 0)])
    return max(float(np.percentile(finite, 99)), _FLOOR) if finite.size else _FLOOR


def colours(field: Field, scale: float) -> Pixels:
    """A signed field as colours.

    Args:
        field: ``(height, width)``.
        scale: the magnitude of the ends of the map.

    Returns:
        sRGB, ``(height, width, 3)``; pixels that are not finite are magenta.
    """
    finite = np.isfinite(field)
    position = np.clip(np.where(finite, field, 0.0) / scale, -1.0, 1.0)
    pixels: Pixels = _COLOURS[np.round((position + 1) / 2 * (len(_COLOURS) - 1)).astype(np.intp)]
    pixels[~finite] = NOT_FINITE
    return pixels
