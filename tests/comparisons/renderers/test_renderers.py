"""What every renderer promises, asked of each of them."""

from __future__ import annotations

import numpy as np
import pytest

from comparisons.renderers import RENDERERS, canonical, create
from scenes import UnknownNameError, library


@pytest.mark.parametrize("name", RENDERERS)
def test_the_seed_decides(name: str) -> None:
    renderer, scene = create(name), library.case("cornell-box").scene.resized(8, 6)
    first, again, other = (renderer.render(scene, [0, 1, 2], 3, seed) for seed in (1, 1, 2))
    assert first.shape == (3, 6, 8, 3)
    assert first.dtype == np.float64
    np.testing.assert_array_equal(first, again)
    assert (first[1:] != other[1:]).any(axis=(1, 2, 3)).all()
    assert renderer.version()


@pytest.mark.parametrize("name", RENDERERS)
def test_consecutive_seeds_share_no_samples(name: str) -> None:
    """Their differences from the mean are uncorrelated: over 3,072 values |r| < 0.1 but once in 10⁷."""
    renderer, scene = create(name), library.case("cornell-box").scene.resized(32, 32)
    mean = renderer.render(scene, [1], 64, 99)[0]
    a, b = ((renderer.render(scene, [1], 2, seed)[0] - mean).ravel() for seed in (10, 11))
    assert abs(np.corrcoef(a, b)[0, 1]) < 0.1
    # that the check can fail: two halves of the same samples are correlated
    assert abs(np.corrcoef(a, a + b)[0, 1]) > 0.5


@pytest.mark.parametrize("name", RENDERERS)
def test_some_bounces_are_those_of_all(name: str) -> None:
    renderer, scene = create(name), library.case("cornell-box").scene.resized(8, 6)
    every = renderer.render(scene, range(4), 2, 1)
    np.testing.assert_allclose(renderer.render(scene, [1, 3], 2, 1), every[[1, 3]], atol=1e-12)
    np.testing.assert_allclose(renderer.render(scene, [0], 2, 1).shape, (1, 6, 8, 3))


def test_short_names() -> None:
    assert canonical("mitsuba") == "mitsuba:scalar_rgb"
    assert canonical("reference") == "reference:mis"
    assert canonical("reference:nee") == "reference:nee"


def test_an_unknown_renderer_is_told_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="no renderer is called 'mitsubs': did you mean mitsuba"):
        canonical("mitsubs")
