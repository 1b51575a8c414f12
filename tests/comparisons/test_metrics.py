from __future__ import annotations

import numpy as np
import pytest

from comparisons.metrics import partial_sum_metrics


def test_metrics_are_of_the_partial_sums() -> None:
    rng = np.random.default_rng(1)
    truth = rng.random((3, 16, 16, 3))
    mean = truth.copy()
    mean[1] *= 1.1
    first, second, third = partial_sum_metrics(mean, truth)
    assert (first.nrmse, first.psnr, first.ssim) == (0, None, pytest.approx(1))
    error = np.sqrt(np.mean((0.1 * truth[1]) ** 2)) / np.sqrt(np.mean((truth[0] + truth[1]) ** 2))
    assert second.nrmse == pytest.approx(error)
    total = truth.sum(axis=0)
    assert third.psnr == pytest.approx(-10 * np.log10(np.mean((0.1 * truth[1]) ** 2) / total.max() ** 2))
    assert second.ssim is not None
    assert second.ssim < 1


def test_small_and_black_images_have_none() -> None:
    [small] = partial_sum_metrics(np.ones((1, 6, 16, 3)), np.full((1, 6, 16, 3), 2.0))
    assert small.ssim is None
    assert small.nrmse == pytest.approx(0.5)
    [black] = partial_sum_metrics(np.ones((1, 8, 8, 3)), np.zeros((1, 8, 8, 3)))
    assert (black.nrmse, black.psnr, black.ssim) == (None, None, None)
