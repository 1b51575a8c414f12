"""The tracer against the committed solutions of finite elements: quarters of the image, every bounce."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from reference_tracer.random_walk import render
from scenes.library import case

RESOLUTION = {
    "cornell-box-empty": (0.002, 0.01, 0.03, 0.05, 0.07),
    "facing-squares": (0.01, 0.02, 0.05, 0.12, 0.15),
}
"""Of bounces 1 to 5, relative to the mean of the bounce, in the channel with the fewest walks."""


@pytest.mark.parametrize("name", RESOLUTION)
def test_every_bounce(name: str, expect_means: Callable[..., None]) -> None:
    found = case(name)
    scene = found.scene.resized(8, 8)
    truth = found.answer.truth(scene, 5)
    assert truth is not None
    expected = quarters(truth.mean)
    means = np.array([quarters(render(scene, 5, 1024, seed, sampler="sobol")) for seed in range(24)])
    for k, channel in np.ndindex(5, 3):
        expect_means(means[:, k + 1, ..., channel], expected[k + 1, ..., channel], RESOLUTION[name][k])


def test_the_first_light_around_the_corner(expect_means: Callable[..., None]) -> None:
    """Few paths find the lamp from here: 1.6 million of them resolve 10 % of T³E, and less of it later on."""
    found = case("around-the-corner")
    scene = found.scene.resized(4, 4)
    truth = found.answer.truth(scene, 6)
    assert truth is not None
    expected = truth.mean.mean(axis=(1, 2))
    means = np.array([render(scene, 6, 4096, seed, sampler="sobol").mean(axis=(1, 2)) for seed in range(24)])
    assert not means[:, :3].any()
    for k, channel in np.ndindex(4, 3):
        expect_means(means[:, k + 3, channel], expected[k + 3, channel], (0.11, 0.07, 0.06, 0.05)[k])


def quarters(image: np.ndarray) -> np.ndarray:
    return image.reshape(-1, 2, 4, 2, 4, 3).mean(axis=(2, 4))


def test_a_bounce_taken_for_the_next_is_seen(expect_means: Callable[..., None], off: type[Exception]) -> None:
    """What the squares are for: their bounces lie on one or the other."""
    found = case("facing-squares")
    scene = found.scene.resized(8, 8)
    truth = found.answer.truth(scene, 2)
    assert truth is not None
    means = np.array([quarters(render(scene, 2, 256, seed, sampler="sobol")) for seed in range(16)])
    with pytest.raises(off):
        expect_means(means[:, 1], quarters(truth.mean)[2], resolution=1.0, scale=float(truth.mean[1].mean()))
