from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from comparisons.results import Images
from reports.images import MissingImagesError, read
from scenes.formats import exr


def written(folder: Path, truth: int, renderer: int) -> Images:
    """Files of so many bounces each."""
    for name, bounces in (("truth", truth), ("renderer", renderer)):
        means = np.arange(1.0, bounces + 1)[:, None, None, None] * np.ones((1, 4, 6, 3))
        exr.write_bounces(folder / f"{name}.exr", means, np.zeros_like(means))
    return Images(truth="truth.exr", renderer="renderer.exr")


def test_of_the_truth_as_many_bounces_as_the_renderer_has(tmp_path: Path) -> None:
    images = read(tmp_path, written(tmp_path, truth=4, renderer=2))
    assert images.truth.shape == images.truth_error.shape == images.renderer.shape == (2, 4, 6, 3)
    np.testing.assert_array_equal(images.truth, images.renderer)


def test_a_truth_of_fewer_bounces_does_not_fit(tmp_path: Path) -> None:
    with pytest.raises(MissingImagesError, match="The truth holds 2 bounces"):
        read(tmp_path, written(tmp_path, truth=2, renderer=4))
