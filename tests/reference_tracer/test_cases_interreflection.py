"""The reference tracer against interreflection in spheres, bounce by bounce, in quarters of the image."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from reference_tracer.random_walk import render
from scenes.library import case

SEEDS, SIZE = 16, 8
SPP_AND_RESOLUTION = {
    # 0.6 to 0.95 of a resolution is used, but where there is no noise, and in the first one: its walks find one
    # of two values, and of fewer all replicates may find the same number of each, which is no error of a mean
    "integrating-sphere": (512, 0.02),
    "sphere-two-caps": (2048, 0.015),
    "sphere-flat-port": (512, 0.025),
    "concentric-spheres": (1024, 0.02),
    "sphere-zones": (1024, 0.02),
    "dome-on-mirror": (1024, 0.015),
    "point-in-sphere": (256, 0.002),
    "cie-171-sphere": (64, 1e-9),
}


def quarters(images: np.ndarray) -> np.ndarray:
    """``(bounces + 1, 2, 2, channels)``."""
    half = SIZE // 2
    return images.reshape(len(images), 2, half, 2, half, -1).mean(axis=(2, 4))


@pytest.mark.parametrize("name", SPP_AND_RESOLUTION)
def test_spheres(name: str, expect_means: Callable[..., None]) -> None:
    found, (spp, resolution) = case(name), SPP_AND_RESOLUTION[name]
    scene = found.scene.resized(SIZE, SIZE)
    truth = found.answer.truth(scene, found.bounces)
    assert truth is not None
    replicates = np.array(
        [quarters(render(scene, found.bounces, spp, seed, "mis", "sobol")) for seed in range(SEEDS)]
    )
    for k, expected in enumerate(quarters(truth.mean)):
        for channel in range(scene.channels):  # each relative to its own mean
            expect_means(replicates[:, k, ..., channel], expected[..., channel], resolution)
