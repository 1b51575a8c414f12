"""Radiance per wavelength → CIE XYZ → linear sRGB, by the observers and colour spaces of colour-science.

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
        wavelengths: of the last axis, nm, ascending in equal steps within 360 to 830.

    Returns:
        ``(…, 3)``.

    Raises:
        ValueError: the wavelengths are not such, or not as many as channels.
    """
    check_wavelengths(wavelengths, radiance.shape[-1])
    table = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]  # from 360 to 830 nm, in steps of 1
    sampled = [np.interp(wavelengths, table.wavelengths, column) for column in table.values.T]
    matching = np.stack(sampled, axis=-1)
    xyz: Array = radiance @ matching / matching[:, 1].sum()
    return xyz


def to_rgb(xyz: Array) -> Array:
    """Linear sRGB of CIE XYZ, ``(…, 3)`` → ``(…, 3)``; not clamped, and negative outside sRGB's gamut.

    The colour is kept as it is, not adapted to a white: that of D65 is grey, equal energy is a little reddish.
    """
    rgb: Array = colour.XYZ_to_RGB(xyz, "sRGB", illuminant=None, apply_cctf_encoding=False)
    return rgb


def linear_srgb(radiance: Array, wavelengths: Sequence[float]) -> Array:
    """Radiance as a picture shows it, ``(…, wavelengths)`` → ``(…, 3)``: ``to_rgb(to_xyz(radiance, …))``."""
    with np.errstate(invalid="ignore"):  # what is not finite stays so
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
    check_wavelengths(wavelengths, len(wavelengths))
    shape = colour.SpectralShape(wavelengths[0], wavelengths[-1], wavelengths[1] - wavelengths[0])
    values: Array = colour.SDS_ILLUMINANTS[name].copy().align(shape).values / 100
    return values
