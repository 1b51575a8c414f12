"""The reference tracer against spheres of constant radiance, bounce by bounce, in quarters of the image."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from reference_tracer.emitters.area_lights import AreaEmitter
from reference_tracer.emitters.emitter_sample import EmitterSample
from reference_tracer.points import Points
from reference_tracer.random_walk import Strategy, render
from scenes import Scene
from scenes.library import case

SEEDS, SIZE, BOUNCES = 16, 8, 5
SPP_AND_RESOLUTION: list[tuple[str, Strategy, int, float]] = [
    # how small an error is resolved, relative to the mean of each bounce
    ("mirror", "bsdf", 64, 5e-4),
    ("mirror", "nee", 64, 5e-4),
    ("mirror", "mis", 64, 5e-4),
    ("rough", "bsdf", 256, 0.02),
    ("rough", "nee", 512, 0.06),
    ("rough", "mis", 512, 0.02),
    ("blend", "bsdf", 512, 0.04),
    ("blend", "nee", 256, 0.04),
    ("blend", "mis", 256, 0.04),
]


def quarters(images: np.ndarray) -> np.ndarray:
    """``(bounces + 1, 2, 2, channels)``."""
    half = SIZE // 2
    return images.reshape(len(images), 2, half, 2, half, -1).mean(axis=(2, 4))


@cache
def answer(name: str) -> tuple[Scene, np.ndarray]:
    found = case(f"constant-radiance-{name}")
    scene = found.scene.resized(SIZE, SIZE)
    truth = found.answer.truth(scene, BOUNCES)
    assert truth is not None
    return scene, quarters(truth.mean)


def check(
    name: str, strategy: Strategy, spp: int, resolution: float, expect_means: Callable[..., None]
) -> None:
    scene, expected = answer(name)
    found = [quarters(render(scene, BOUNCES, spp, seed, strategy, "sobol")) for seed in range(SEEDS)]
    for k in range(BOUNCES + 1):
        for channel in range(scene.channels):  # each relative to its own mean
            expect_means(np.array(found)[:, k, ..., channel], expected[k, ..., channel], resolution)


@pytest.mark.parametrize(("name", "strategy", "spp", "resolution"), SPP_AND_RESOLUTION)
def test_every_bounce(
    name: str, strategy: Strategy, spp: int, resolution: float, expect_means: Callable[..., None]
) -> None:
    check(name, strategy, spp, resolution, expect_means)


def without_profile(self: AreaEmitter, reference: Points, u: np.ndarray) -> EmitterSample:
    return self._sample(reference, u)


@pytest.mark.parametrize("name", ["rough", "blend"])
def test_next_event_without_the_profile_is_found(
    name: str, expect_means: Callable[..., None], off: type[Exception], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(AreaEmitter, "sample", without_profile)
    with pytest.raises(off):
        check(name, "mis", 64, 0.2, expect_means)
