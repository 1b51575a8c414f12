"""The tracer against the spectral cases: per wavelength, and the chromaticity of what it finds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from reference_tracer.random_walk import render
from scenes.library import case
from scenes.spectral import chromaticity, to_xyz

RESOLUTION = (0.002, 0.01, 0.02, 0.04, 0.05)
"""Of bounces 1 to 5 in the wavelength with the fewest walks."""


def test_the_cornell_box_per_wavelength_and_in_xyz(expect_means: Callable[..., None]) -> None:
    found = case("cornell-box-spectral")
    scene = found.scene.resized(8, 8)
    truth = found.answer.truth(scene, 5)
    assert truth is not None
    assert found.wavelengths is not None
    expected = truth.mean.mean(axis=(1, 2))
    means = np.array([render(scene, 5, 512, seed, sampler="sobol").mean(axis=(1, 2)) for seed in range(16)])
    for k in range(1, 6):
        for i in range(len(found.wavelengths)):
            expect_means(means[:, k, i], expected[k, i], RESOLUTION[k - 1])
    wanted, xyz = (to_xyz(values, found.wavelengths) for values in (expected, means))
    for k, c in np.ndindex(5, 3):
        expect_means(xyz[:, k + 1, c], wanted[k + 1, c], RESOLUTION[k])


@pytest.mark.parametrize("name", ["furnace-equal-energy", "furnace-d65"])
@pytest.mark.parametrize("strategy", ["bsdf", "mis"])
def test_every_path_has_the_chromaticity_of_the_illuminant(
    name: str, strategy: str, expect_means: Callable[..., None]
) -> None:
    """Every path carries all wavelengths: no noise in chromaticity, whatever noise there is in Y."""
    found = case(name)
    scene = found.scene.resized(4, 4)
    truth = found.answer.truth(scene, 5)
    assert truth is not None
    assert found.wavelengths is not None
    images = np.array([render(scene, 5, 128, seed, strategy) for seed in range(16)])
    xy = chromaticity(to_xyz(images, found.wavelengths))
    expected = chromaticity(to_xyz(truth.mean, found.wavelengths))
    np.testing.assert_allclose(xy, np.broadcast_to(expected, xy.shape), rtol=1e-9)
    for k in range(6):
        expect_means(images[:, k].mean(axis=(1, 2)), truth.mean[k].mean(axis=(0, 1)), resolution=0.03)
