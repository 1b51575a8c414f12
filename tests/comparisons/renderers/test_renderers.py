"""What every renderer promises, asked of each of them."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from comparisons.renderers import RENDERERS, canonical, create
from scenes import UnknownNameError, library

FULL = sorted(name for name, entry in RENDERERS.items() if entry.last_bounce is None)
"""Who renders every bounce; what ends early has tests of its own."""


@pytest.mark.parametrize("name", FULL)
def test_the_seed_decides(name: str) -> None:
    renderer, scene = create(name), library.case("cornell-box").scene.resized(8, 6)
    first, again, other = (renderer.render(scene, [0, 1, 2], 3, seed) for seed in (1, 1, 2))
    assert first.shape == (3, 6, 8, 3)
    assert first.dtype == np.float64
    np.testing.assert_array_equal(first, again)
    assert (first[1:] != other[1:]).any(axis=(1, 2, 3)).all()
    assert renderer.version()


# where light is found by chance alone, what a path carries is a product of albedos, and many are alike
@pytest.mark.parametrize("name", [name for name in FULL if name != "reference:bsdf"])
def test_seeds_share_no_samples(name: str) -> None:
    """A pixel that two seeds gave the same sample has the same value in both, which chance does not do."""
    renderer, scene = create(name), library.case("cornell-box").scene.resized(16, 16)
    images = [renderer.render(scene, [2], 4, seed)[0, ..., 1] for seed in range(8)]
    for one, other in itertools.combinations(images, 2):
        lit = (one > 0) & (other > 0)
        assert lit.any()
        assert not (one == other)[lit].any()


@pytest.mark.parametrize("name", FULL)
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
