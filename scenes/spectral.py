"""Radiance per wavelength → CIE XYZ → linear sRGB, by colour-science.

    X = k Σ_i x̄(λ_i) L(λ_i) Δλ,    Y and Z likewise,    k = 1 / Σ_i ȳ(λ_i) Δλ

with the colour matching functions of the CIE 1931 2° observer, so that equal energy of radiance 1 has Y = 1
(CIE 15:2018, 7.1). Everything is linear: the XYZ of TᵏE is that of its wavelengths, and bounces add up.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from scenes.channels import check_wavelengths

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # colour-science warns that Matplotlib is absent; only its plots need it
    import colour

Array = NDArray[np.float64]


def to_xyz(radiance: Array, wavelengths: Sequence[float]) -> Array:
    """CIE XYZ of radiance in equal steps of wavelength.

    Args:
        radiance: ``(…, wavelengths)``.
        wavelengths: of the last axis, nm, ascending in equal steps.

    Returns:
        ``(…, 3)``.

    Raises:
        ValueError: the steps are not equal, or there are not as many wavelengths as channels.
    """
    check_wavelengths(wavelengths, radiance.shape[-1])
    shape = _shape(wavelengths)
    cmfs = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape)
    xyz: Array = colour.msds_to_XYZ(radiance, cmfs=cmfs, method="Integration", shape=shape) / 100
    return xyz


def to_rgb(xyz: Array) -> Array:
    """Linear sRGB of CIE XYZ, ``(…, 3)`` → ``(…, 3)``; not clamped, and negative outside sRGB's gamut.

    The colour is kept as it is, not adapted to a white: that of D65 is grey, equal energy is a little reddish.
    """
    rgb: Array = colour.XYZ_to_RGB(xyz, "sRGB", illuminant=None, apply_cctf_encoding=False)
    return rgb


def linear_srgb(radiance: Array, wavelengths: Sequence[float]) -> Array:
    """Radiance as a picture shows it, ``(…, wavelengths)`` → ``(…, 3)``: ``to_rgb(to_xyz(radiance, …))``."""
    return to_rgb(to_xyz(radiance, wavelengths))


def chromaticity(xyz: Array) -> Array:
    """CIE x, y: ``(…, 3)`` → ``(…, 2)``; of no light, NaN."""
    with np.errstate(invalid="ignore"):
        xy: Array = xyz[..., :2] / xyz.sum(axis=-1, keepdims=True)
    return xy


def illuminant(name: str, wavelengths: Sequence[float]) -> Array:
    """The relative spectral power of a CIE illuminant, 1 at 560 nm, ``(len(wavelengths),)``.

    Args:
        name: ``E``, ``D65``, ….
        wavelengths: nm, ascending in equal steps.
    """
    values: Array = colour.SDS_ILLUMINANTS[name].copy().align(_shape(wavelengths)).values / 100
    return values


def _shape(wavelengths: Sequence[float]) -> colour.SpectralShape:
    check_wavelengths(wavelengths, len(wavelengths))
    return colour.SpectralShape(wavelengths[0], wavelengths[-1], wavelengths[1] - wavelengths[0])
