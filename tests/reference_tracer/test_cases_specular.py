"""The tracer against the answers of the smooth and the glossy cases, quarter of the image by quarter."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from reference_tracer.random_walk import Strategy, render
from scenes import Scene
from scenes.library import case

SEEDS = 32

SMOOTH: list[tuple[str, int, tuple[float, ...]]] = [
    # case, spp, and for each bounce how small an error is resolved, relative to that bounce's mean; 0: exactly black
    ("mirror-lamps", 512, (0.01, 0.02, 0)),
    ("two-mirrors", 512, (0.003, 0.003, 0.004, 0.01, 0.015, 0.02)),
    ("metal-angles", 32, (0, 1e-4, 0)),
    ("glass-slab", 512, (0, 0.005, 0.005, 0.03, 0.06)),
    ("glass-ball", 1024, (0, 0.003, 0.002, 0.01, 0.07)),
    ("inside-glass", 1024, (0, 0.002, 0.015, 0.1)),
    ("lamp-under-water", 256, (0, 0.003, 0)),
    ("snells-window", 128, (0, 0.003, 0)),
    ("cie-171-glass", 1024, (0, 0, 0.002, 0, 0.1)),
]
GLOSSY: list[tuple[str, Strategy, int, float]] = [
    # case, strategy, spp, and how small an error of TE is resolved, relative to its mean
    ("rough-metal-sky", "nee", 512, 0.005),
    ("rough-metal-sky", "bsdf", 128, 0.002),
    ("rough-metal-sky", "mis", 128, 0.002),
    ("blend-sky", "bsdf", 128, 0.002),
    ("blend-sky", "nee", 128, 0.002),
    ("blend-sky", "mis", 128, 0.002),
    ("rough-glass-tank", "bsdf", 128, 0.005),
    ("rough-glass-tank", "mis", 128, 0.005),
    ("rough-metal-sun", "nee", 64, 1e-3),
    ("rough-metal-sun", "bsdf", 64, 1e-3),
    ("rough-glass-sun", "mis", 64, 1e-3),
    ("blend-sun", "mis", 64, 1e-3),
    ("blend-lamp", "nee", 128, 1e-3),
    ("blend-lamp", "bsdf", 512, 0.05),
    ("blend-lamp", "mis", 256, 0.01),
]


def quarters(images: np.ndarray) -> np.ndarray:
    """``(bounces + 1, 2, 2, channels)``."""
    height, width = images.shape[1] // 2, images.shape[2] // 2
    return images.reshape(len(images), 2, height, 2, width, -1).mean(axis=(2, 4))


@cache
def answer(name: str, bounces: int) -> tuple[Scene, np.ndarray]:
    found = case(name)
    scene = found.scene.resized(8, 8)
    truth = found.answer.truth(scene, bounces)
    assert truth is not None
    return scene, quarters(truth.mean)


def replicates(name: str, bounces: int, spp: int, strategy: Strategy) -> tuple[np.ndarray, np.ndarray]:
    scene, expected = answer(name, bounces)
    images = [render(scene, bounces, spp, seed, strategy, sampler="sobol") for seed in range(SEEDS)]
    return np.stack([quarters(image) for image in images]), expected


@pytest.mark.parametrize(("name", "spp", "resolutions"), SMOOTH)
def test_smooth(
    name: str, spp: int, resolutions: tuple[float, ...], expect_means: Callable[..., None]
) -> None:
    found, expected = replicates(name, len(resolutions) - 1, spp, "bsdf")
    for k, resolution in enumerate(resolutions):
        if resolution:
            expect_means(found[:, k], expected[k], resolution)
        else:
            assert not found[:, k].any()
            assert not expected[k].any()


@pytest.mark.parametrize(("name", "strategy", "spp", "resolution"), GLOSSY)
def test_glossy(
    name: str, strategy: Strategy, spp: int, resolution: float, expect_means: Callable[..., None]
) -> None:
    found, expected = replicates(name, 2, spp, strategy)
    expect_means(found[:, 1], expected[1], resolution)
    assert not found[:, [0, 2]].any()
    assert not expected[[0, 2]].any()
