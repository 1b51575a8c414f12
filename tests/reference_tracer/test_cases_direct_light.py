"""The reference tracer against the cases of direct light, bounce by bounce, quarter by quarter."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from reference_tracer.random_walk import render
from scenes.library import case, cie_171, direct_light, direct_light_of_lights, rectangles, textures

NAMES = [*direct_light.CASES, *direct_light_of_lights.CASES, *rectangles.CASES, *textures.CASES]
NAMES += [name for name in cie_171.CASES if name != "cie-171-glass"]
SIZE, REPLICATES = 8, 16

SPP = {
    "wall-by-reflection": 6144,
    "wall-behind-a-shelf": 3072,
    "hundred-tiles": 512,
    "cie-171-opening": 4096,
    "lamp-turned-away": 2048,  # half of them choose the lamp that gives nothing
    "perpendicular-rectangles": 512,
    **dict.fromkeys(("parallel-rectangles", "cie-171-panel", "four-points"), 256),
    **dict.fromkeys(("disk-shadow", "harmonics-on-sphere"), 128),
}
"""Samples per pixel, where they are not 1024."""

SPP |= dict.fromkeys(
    (
        "point-over-plane",
        "spot-falloff",
        "spot-beam",
        "directional-on-sphere",
        "cie-171-point",
        "cie-171-flux",
    ),
    64,
)
"""Only the place in the pixel is left to chance: a quarter of the resolution at most."""

RESOLUTION = 0.008
"""Relative error that all of them resolve (see ``expect_means``), but for the sky in an opening."""

THROUGH_AN_OPENING = 0.02
"""Most directions, of paths and of the sky, end on black walls."""


def quarters(images: np.ndarray) -> np.ndarray:
    """Means over the four quarters of each image, ``(…, 2, 2, channels)``."""
    *rest, height, width, channels = images.shape
    return images.reshape(*rest, 2, height // 2, 2, width // 2, channels).mean(axis=(-4, -2))


@pytest.mark.parametrize("name", NAMES)
def test_every_bounce(name: str, expect_means: Callable[..., None]) -> None:
    found = case(name)
    scene = found.scene.resized(SIZE, SIZE)
    truth = found.answer.truth(scene, found.bounces)
    assert truth is not None
    images = np.array(
        [
            quarters(render(scene, found.bounces, SPP.get(name, 1024), seed, "mis", "sobol"))
            for seed in range(REPLICATES)
        ]
    )
    for k, expected in enumerate(quarters(truth.mean)):
        if expected.any():
            resolution = THROUGH_AN_OPENING if name == "cie-171-opening" else RESOLUTION
            expect_means(images[:, k], expected, resolution)
        else:
            assert not images[:, k].any()


def test_a_wrong_answer_is_found(expect_means: Callable[..., None], off: type[Exception]) -> None:
    """What a case would be with a lamp 1 % brighter, its image upside down, or two channels exchanged."""
    found = case("quad-over-plane")
    scene = found.scene.resized(SIZE, SIZE)
    truth = found.answer.truth(scene, 1)
    assert truth is not None
    images = np.array(
        [quarters(render(scene, 1, 1024, seed, "mis", "sobol"))[1] for seed in range(REPLICATES)]
    )
    for wrong in (1.01 * truth.mean[1], truth.mean[1, ::-1], truth.mean[1][..., [1, 0, 2]]):
        with pytest.raises(off):
            expect_means(images, quarters(wrong), RESOLUTION)
