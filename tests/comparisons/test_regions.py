from __future__ import annotations

import numpy as np
import pytest

from comparisons.regions import Regions


@pytest.mark.parametrize(("height", "width"), [(16, 16), (15, 22), (4, 4), (3, 2), (1, 1)])
def test_means_are_those_of_the_places(height: int, width: int) -> None:
    images = np.random.default_rng(1).random((2, height, width, 3))
    regions = Regions.of(height, width, (4, 4))
    means = regions.means(images)
    assert len(means) == 1 + min(4, height) * min(4, width)
    np.testing.assert_allclose(means[0], images.mean(axis=(1, 2)))
    covered = np.zeros((height, width))
    for region in range(1, len(means)):
        p = regions.place(region)
        np.testing.assert_allclose(means[region], images[:, p.y0 : p.y1, p.x0 : p.x1].mean(axis=(1, 2)))
        covered[p.y0 : p.y1, p.x0 : p.x1] += 1
    assert (covered == 1).all()


def test_errors_of_independent_pixels_add_in_quadrature() -> None:
    stderr = np.full((1, 8, 8, 1), 0.4)
    errors = Regions.of(8, 8, (4, 4)).stderr(stderr)
    np.testing.assert_allclose(errors[0], 0.4 / 8)
    np.testing.assert_allclose(errors[1:], 0.4 / 2)
