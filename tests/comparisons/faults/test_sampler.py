"""Each fault of the sampler makes the numbers that it says, and leaves the tracer as it was."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from comparisons.faults import sampler
from comparisons.faults.fault import Fault
from comparisons.faults.planting import Replacement, in_tracer
from comparisons.renderers import Renderer, create
from reference_tracer import random_walk
from reference_tracer.random_walk import RandomWalk
from reference_tracer.samplers import Block
from scenes import library

Array = NDArray[np.float64]

BY_NAME = {fault.name: fault for fault in sampler.FAULTS}
BOUNCES = range(4)
SIZE, SPP = 8, 512  # two blocks of walks
SCENE = library.case("cornell-box").scene.resized(SIZE, SIZE)
FIRST_CHANGED = {
    "numbers-repeat-every-bounce": 1,
    "same-numbers-in-every-block": 1,
    "numbers-of-eight-bits": 1,
}


def image_of(renderer: Renderer, spp: int = SPP, seed: int = 3) -> Array:
    return renderer.render(SCENE, BOUNCES, spp, seed)


def drawn(fault: Fault) -> list[Block]:
    """The blocks that walks get, with all of their numbers of six dimensions in place of what gives them."""
    blocks: list[Block] = []

    def recording(walk: Callable[..., None]) -> Callable[..., None]:
        def substitute(self: RandomWalk, block: Block, bounces: int, film: object) -> None:
            everyone = np.arange(block.position.shape[1])
            numbers = np.concatenate([block.numbers(2, everyone) for _ in range(3)])
            blocks.append(Block(block.position, lambda d, lanes: numbers))

        return substitute

    planted = fault.plant(in_tracer(Replacement(RandomWalk, "__call__", recording))(create("reference")))
    planted.render(SCENE, [1], SPP, 3)
    return blocks


def numbers_of(block: Block) -> Array:
    return block.numbers(6, np.arange(1))


@pytest.mark.parametrize("fault", sampler.FAULTS, ids=lambda fault: fault.name)
def test_it_changes_the_image(fault: Fault) -> None:
    plain = create("reference")
    right, wrong = image_of(plain), image_of(fault.plant(plain))
    claimed = list(BOUNCES)[FIRST_CHANGED.get(fault.name, 0) :]
    assert {k for k in BOUNCES if not np.array_equal(right[k], wrong[k])} >= set(claimed)


@pytest.mark.parametrize("fault", sampler.FAULTS, ids=lambda fault: fault.name)
def test_the_tracer_is_left_as_it_was(fault: Fault) -> None:
    plain = create("reference")
    before, planted = image_of(plain, 4), fault.plant(plain)
    image_of(planted, 4)
    np.testing.assert_array_equal(image_of(plain, 4), before)
    with pytest.raises(ValueError, match="spp"):
        image_of(planted, spp=0)
    np.testing.assert_array_equal(image_of(plain, 4), before)


def test_seeds() -> None:
    plain = create("reference")
    ignored, pairs = (BY_NAME[name].plant(plain) for name in ("seed-ignored", "seeds-in-pairs"))
    np.testing.assert_array_equal(image_of(ignored, 4, 1), image_of(ignored, 4, 99))
    np.testing.assert_array_equal(image_of(pairs, 4, 6), image_of(pairs, 4, 7))
    assert not np.array_equal(image_of(pairs, 4, 7), image_of(pairs, 4, 8))


@pytest.mark.parametrize(
    ("name", "holds"),
    [
        (
            "numbers-of-eight-bits",
            lambda u: (256 * u == np.floor(256 * u)).all() and len(np.unique(u)) == 256,
        ),
        ("numbers-below-one-half", lambda u: 0.49 < u.max() < 0.5),
        ("one-number-for-two-axes", lambda u: (u[0] == u[1]).all() and not (u[0] == u[2]).any()),
    ],
)
def test_the_numbers(name: str, holds: Callable[[Array], bool]) -> None:
    for block in drawn(BY_NAME[name]):
        assert holds(numbers_of(block))


def test_positions_are_made_of_the_same_numbers() -> None:
    for block in drawn(BY_NAME["numbers-of-eight-bits"]):
        np.testing.assert_array_equal(256 * block.position, np.floor(256 * block.position))
    for block in drawn(BY_NAME["numbers-below-one-half"]):
        assert 0.49 < (block.position % 1).max() < 0.5
    for block in drawn(BY_NAME["one-number-for-two-axes"]):
        np.testing.assert_allclose(*block.position % 1, atol=1e-14)


def test_all_rays_through_the_centres() -> None:
    for block in drawn(BY_NAME["pixels-not-jittered"]):
        np.testing.assert_array_equal(block.position % 1, 0.5)


def test_every_pixel_alike() -> None:
    blocks = drawn(BY_NAME["same-numbers-in-every-pixel"])
    assert len(blocks) > 1
    for block in blocks:
        u = np.concatenate([block.position % 1, numbers_of(block)]).reshape(8, -1, SIZE * SIZE)
        np.testing.assert_allclose(u, u[:, :, :1] * np.ones(SIZE * SIZE), atol=1e-14)
        assert len(np.unique(u[2, :, 0])) == u.shape[1]


def test_every_block_alike() -> None:
    first, second = drawn(BY_NAME["same-numbers-in-every-block"])
    np.testing.assert_array_equal(first.position, second.position)
    np.testing.assert_array_equal(numbers_of(first), numbers_of(second))


def test_every_bounce_has_the_numbers_of_the_first() -> None:
    """What next event and the BSDFs are given in each bounce, of walks in a furnace, where none ends."""
    given: list[Array] = []

    def recording(next_event: Callable[..., object]) -> Callable[..., object]:
        def substitute(self: RandomWalk, vertex: object, wo: Array, u: Array) -> object:
            given.append(u)
            return next_event(self, vertex, wo, u)

        return substitute

    inner = in_tracer(Replacement(random_walk.RandomWalk, "_next_event", recording))(create("reference"))
    BY_NAME["numbers-repeat-every-bounce"].plant(inner).render(
        library.case("furnace-box").scene.resized(4, 4), BOUNCES, 1, 1
    )
    assert len(given) == 3
    for later in given[1:]:
        np.testing.assert_array_equal(later, given[0])


@pytest.mark.parametrize("name", [fault.name for fault in sampler.FAULTS if fault.unseen])
def test_what_is_called_unbiased_is(name: str) -> None:
    """Direct light, within four standard errors of 64 replicates; those of pairs count once."""
    case = library.case("quad-over-plane")
    scene = case.scene.resized(SIZE, SIZE)
    truth = case.answer.truth(scene, 1)
    assert truth is not None
    planted = BY_NAME[name].plant(create("reference"))
    found = np.array([planted.render(scene, [1], 8, 2 * seed)[0].mean() for seed in range(64)])
    error, expected = found.std() / np.sqrt(63), truth.mean[1].mean()
    assert abs(found.mean() - expected) < 4 * error < 0.1 * expected
