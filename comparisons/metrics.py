"""Image metrics of the partial sums E + TE + … + TⁿE, by scikit-image. They inform, they never decide."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from skimage.metrics import normalized_root_mse, peak_signal_noise_ratio, structural_similarity

from comparisons.results import Metrics

Array = NDArray[np.float64]

_SSIM_WINDOW = 7


def partial_sum_metrics(mean: Array, truth: Array) -> list[Metrics]:
    """NRMSE, PSNR and SSIM of each partial sum, scene-linear.

    NRMSE is relative to the root mean square of the truth; PSNR (dB) and SSIM take the truth's largest value as
    the range of the data. None where a metric is not defined: equal or black images, or less than 7 pixels
    across for SSIM.

    Args:
        mean, truth: ``(bounces + 1, height, width, channels)``.
    """
    sums, truths = np.cumsum(mean, axis=0), np.cumsum(truth, axis=0)
    return [_metrics(n, image, answer) for n, (image, answer) in enumerate(zip(sums, truths, strict=True))]


def _metrics(bounces: int, image: Array, truth: Array) -> Metrics:
    data_range = float(truth.max())
    if data_range <= 0:
        return Metrics(bounces=bounces, nrmse=None, psnr=None, ssim=None)
    psnr = (
        math.inf
        if np.array_equal(image, truth)
        else float(peak_signal_noise_ratio(truth, image, data_range=data_range))
    )
    ssim = None
    if min(image.shape[:2]) >= _SSIM_WINDOW:
        ssim = float(
            structural_similarity(truth, image, win_size=_SSIM_WINDOW, data_range=data_range, channel_axis=-1)
        )
    nrmse = float(normalized_root_mse(truth, image))
    return Metrics(bounces=bounces, nrmse=nrmse, psnr=psnr if math.isfinite(psnr) else None, ssim=ssim)
