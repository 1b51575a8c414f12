"""Scene-linear radiance → pixels of a screen: one exposure per column, then the sRGB encoding."""

from __future__ import annotations

import math
import warnings

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float64]
Pixels = NDArray[np.uint8]

NOT_FINITE = (255, 0, 255)
"""Magenta, which no other picture of a report contains, marks pixels that are NaN or infinite."""

_PERCENTILE, _TARGET = 90.0, 0.8


def automatic(*candidates: Image) -> float:
    """The factor that shows an image, two digits.

    It brings the 90th percentile of the lit values to 0.8, so that a lamp in the picture does not
    darken the rest.

    Args:
        candidates: radiance; the first one with any light in it decides.

    Returns:
        The factor; 1 where there is no light at all.
    """
    for image in candidates:
        lit = image[np.isfinite(image) & (image > 0)]
        if lit.size:
            factor = _TARGET / float(np.percentile(lit, _PERCENTILE))
            if math.isfinite(factor):
                return float(f"{factor:.1e}")
    return 1.0


def encode(image: Image, exposure: float) -> Pixels:
    """Expose and encode an image for the screen.

    Args:
        image: radiance, ``(height, width, channels)``. Three channels are linear sRGB; any other number is
            shown as the grey of their mean. Spectra must be taken to linear sRGB before: ``scenes.spectral``.
        exposure: the factor to apply.

    Returns:
        sRGB, ``(height, width, 3)``; pixels that are not finite are magenta.
    """
    radiance = image if image.shape[-1] == 3 else np.repeat(image.mean(axis=-1, keepdims=True), 3, axis=-1)
    finite = np.asarray(np.isfinite(radiance).all(axis=-1))
    linear = np.clip(np.where(finite[..., None], radiance, 0.0) * exposure, 0.0, 1.0)
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore"
        )  # colour-science warns that Matplotlib is absent; only its plots need it
        import colour  # half a second, which only those wait for who draw pictures
    encoded = np.asarray(colour.cctf_encoding(linear, function="sRGB"))
    pixels: Pixels = np.round(255 * encoded).astype(np.uint8)
    pixels[~finite] = NOT_FINITE
    return pixels
