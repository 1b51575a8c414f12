"""Image metrics of each term TᵏE and of each partial sum E + TE + … + TⁿE. They inform, they never decide.

With x the renderer's image and t the truth, scene-linear, and ⟨·⟩ the mean over pixels and channels:

    RMSE     √⟨(x − t)²⟩
    NRMSE    RMSE / √⟨t²⟩
    relMSE   ⟨(x − t)² / (t² + ε)⟩,  ε = 0.01 ⟨t⟩²                                 (Rousselle et al. 2011)
    PSNR     10 log₁₀ (r² / ⟨(x − t)²⟩) dB,  r = max t
    SSIM     mean of (2 μₓ μₜ + c₁)(2 σₓₜ + c₂) / ((μₓ² + μₜ² + c₁)(σₓ² + σₜ² + c₂)) over windows of 7 × 7
             pixels, c₁ = (0.01 r)², c₂ = (0.03 r)²                                (Wang et al. 2004, eq. 13)
    HDR-FLIP mean over pixels of the largest FLIP error (Andersson et al. 2020) over a range of exposures
             (Andersson et al. 2021), 0 to 1
    ΔE₀₀     mean over pixels of the CIEDE2000 difference                          (Sharma et al. 2005)

The usual ε = 0.01 is meant for images whose mean is about 1. Ours is relative to the mean, so that a bounce of a
thousandth of the light is measured like any other, and no unit of radiance matters.

FLIP sees the images as sRGB on a screen of 67 pixels per degree, tone-mapped by ACES. Its exposures reach from where
the brightest pixel of the truth shows at 85 % to where the median pixel does. The median is that of the pixels with
any light in them: in a term most may be black, and the paper's rule has no finite answer there.

ΔE₀₀ sees them as sRGB too, under one exposure that brings the median luminance of the truth's lit pixels to 0.18
(middle grey), clipped to what a screen can show, in CIE L*a*b* under the white of sRGB, D65.

- Rousselle, Knaus, Zwicker 2011, Adaptive sampling and reconstruction using greedy error minimization, TOG 30(6)
- Wang, Bovik, Sheikh, Simoncelli 2004, Image quality assessment: from error visibility to structural similarity
- Andersson et al. 2020, FLIP: a difference evaluator for alternating images, HPG
- Andersson et al. 2021, Visualizing errors in rendered high dynamic range images, Eurographics short papers
- Sharma, Wu, Dalal 2005, The CIEDE2000 color-difference formula, Color Research and Application 30(1)
"""

from __future__ import annotations

import warnings
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.results import Metrics

Array = NDArray[np.float64]

REL_MSE_EPSILON = 0.01
"""ε of relMSE, relative to the squared mean of the truth."""

GREY = 0.18
"""Where the exposure of ΔE₀₀ puts the median luminance of the truth's lit pixels."""

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear sRGB
_ACES_85 = 2.1188723  # where the tone mapping curve that FLIP uses reaches 0.85
_SSIM_WINDOW = 7


def term_metrics(mean: Array, truth: Array, first: int = 0) -> list[Metrics]:
    """The metrics of each term TᵏE by itself.

    Args:
        mean, truth: ``(bounces + 1, height, width, channels)``, finite.
        first: what number the first of them has.
    """
    return [image_metrics(k, x, t) for k, (x, t) in enumerate(zip(mean, truth, strict=True), start=first)]


def partial_sum_metrics(mean: Array, truth: Array) -> list[Metrics]:
    """The metrics of each partial sum; arguments as above."""
    return term_metrics(np.cumsum(mean, axis=0), np.cumsum(truth, axis=0))


def image_metrics(bounces: int, image: Array, truth: Array) -> Metrics:
    """All metrics of one image.

    None where a metric is not defined: relative ones of a truth without light, PSNR of equal images, SSIM of less
    than 7 pixels across, HDR-FLIP and ΔE₀₀ of anything but red, green and blue.

    Args:
        bounces: which bounce, or the last one in the sum.
        image, truth: ``(height, width, channels)``, finite.
    """
    rmse = float(np.sqrt(np.mean((image - truth) ** 2)))
    if truth.max() <= 0:
        return Metrics(bounces=bounces, rmse=rmse, nrmse=None, psnr=None, ssim=None)
    in_colour = truth.shape[-1] == 3
    return Metrics(
        bounces=bounces,
        rmse=rmse,
        nrmse=rmse / float(np.sqrt(np.mean(truth**2))),
        rel_mse=rel_mse(image, truth),
        psnr=_psnr(image, truth) if rmse else None,
        ssim=_ssim(image, truth) if min(truth.shape[:2]) >= _SSIM_WINDOW else None,
        flip=hdr_flip(truth, image) if in_colour else None,
        delta_e=delta_e(image, truth) if in_colour else None,
    )


def rel_mse(image: Array, truth: Array) -> float:
    """Mean squared error relative to each value of the truth, which must have a mean above zero."""
    epsilon = REL_MSE_EPSILON * truth.mean() ** 2
    return float(np.mean((image - truth) ** 2 / (truth**2 + epsilon)))


def hdr_flip(truth: Array, image: Array) -> float | None:
    """Mean HDR-FLIP error; the reference comes first, as in FLIP itself: it sets the exposures.

    Args:
        truth, image: linear sRGB, ``(height, width, 3)``. FLIP knows no negative light, which counts as none.

    Returns:
        0 for equal images, at most 1; None where no pixel of the truth is lit, or FLIP isn't installed.
    """
    lit = _lit_luminance(truth)
    if not lit.size or find_spec("flip_evaluator") is None:
        return None
    import flip_evaluator

    scale = 1 / float(lit.max())  # 32 bits hold any scene then, and FLIP doesn't depend on it
    # given explicitly, since FLIP ends the whole process where it finds no exposures by itself
    stop = float(np.log2(_ACES_85 / (scale * np.median(lit))))
    exposures = {"startExposure": min(float(np.log2(_ACES_85)), stop), "stopExposure": stop}
    reference, test = (
        np.ascontiguousarray(np.clip(scale * a, 0, np.finfo(np.float32).max), dtype=np.float32)
        for a in (truth, image)
    )
    _, error, _ = flip_evaluator.evaluate(reference, test, "HDR", applyMagma=False, parameters=exposures)
    return float(error)


def delta_e(image: Array, truth: Array) -> float | None:
    """Mean CIEDE2000 difference under the exposure of the module's docstring.

    Args:
        image, truth: linear sRGB, ``(height, width, 3)``.

    Returns:
        None where no pixel of the truth is lit.
    """
    lit = _lit_luminance(truth)
    if not lit.size:
        return None
    exposure, colour = GREY / float(np.median(lit)), _colour()
    white = colour.RGB_COLOURSPACES["sRGB"].whitepoint
    ours, theirs = (
        colour.XYZ_to_Lab(colour.RGB_to_XYZ(np.clip(exposure * a, 0, 1), "sRGB"), white)
        for a in (truth, image)
    )
    return float(np.mean(colour.delta_E(ours, theirs, method="CIE 2000")))


def _psnr(image: Array, truth: Array) -> float:
    from skimage.metrics import peak_signal_noise_ratio

    return float(peak_signal_noise_ratio(truth, image, data_range=float(truth.max())))


def _ssim(image: Array, truth: Array) -> float:
    from skimage.metrics import structural_similarity

    options = {"win_size": _SSIM_WINDOW, "data_range": float(truth.max()), "channel_axis": -1}
    return float(structural_similarity(truth, image, **options))


def _lit_luminance(truth: Array) -> Array:
    """The luminance of the pixels that have any, in one row."""
    luminance: Array = (truth @ _LUMINANCE).ravel()
    return luminance[luminance > 0]


def _colour() -> Any:
    """colour-science, imported where it is needed: it takes half a second."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it warns that Matplotlib is absent; only its plots need it
        import colour
    return colour
