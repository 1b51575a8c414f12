"""Sound variants of the sampler: other random numbers, independent from one replicate to the next."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Plant, Sound
from comparisons.faults.numbers import (
    Blocks,
    changed_blocks,
    changed_numbers,
    of_all_walks,
    other_blocks,
    pixels,
)
from comparisons.faults.planting import Replacement, in_tracer
from reference_tracer import samplers, sampling
from reference_tracer.samplers import Block

Array = NDArray[np.float64]

BELOW_ONE = np.nextafter(1.0, 0.0)


def _streams_of(bits: Callable[[np.random.SeedSequence], np.random.BitGenerator]) -> Plant:
    def made_of(stream: Callable[..., np.random.Generator]) -> Any:
        def substitute(seed: int, *place: int) -> np.random.Generator:
            return np.random.Generator(bits(np.random.SeedSequence(seed, spawn_key=place)))

        return substitute

    return in_tracer(Replacement(sampling, "stream", made_of))


def _blocks_of(walks: int) -> Plant:
    return in_tracer(Replacement(samplers, "BLOCK", lambda usual: walks))


def _in_reverse(blocks: Blocks) -> Blocks:
    return lambda *arguments: iter(list(blocks(*arguments))[::-1])


def _from_the_other_end(u: Array) -> Array:
    return np.minimum(1 - u, BELOW_ONE)


def _second_half_mirrored(u: Array) -> Array:
    """Walks of the second half of a block have what is left to 1 of those of the first."""
    half = u.shape[1] // 2
    return np.concatenate([u[:, : u.shape[1] - half], _from_the_other_end(u[:, :half])], axis=1)


def _antithetic(block: Block) -> Block:
    return Block(block.position, of_all_walks(block, _second_half_mirrored))


def _stratified(block: Block) -> Block:
    """The samples of a pixel in a block lie in as many upright strips of it."""
    count = pixels(block)
    strips = block.position.shape[1] // count
    pixel = np.floor(block.position)
    x, y = block.position - pixel
    strip = np.arange(block.position.shape[1]) // count
    return Block(pixel + np.stack([(strip + x) / strips, y]), block.numbers)


def _columns_first(block: Block) -> Block:
    """Walks that start in the same places, and draw their numbers in another order."""
    order = np.lexsort(block.position[::-1])
    return Block(block.position.take(order, axis=1), block.numbers)


VARIANTS: tuple[Sound, ...] = (
    Sound(
        name="permuted-congruential-generator",
        what="numbers from PCG64 instead of SFC64",
        plant=_streams_of(np.random.PCG64),
    ),
    Sound(
        name="counter-based-generator",
        what="numbers from Philox instead of SFC64",
        plant=_streams_of(np.random.Philox),
    ),
    Sound(
        name="small-blocks",
        what="blocks of 1024 walks",
        plant=_blocks_of(1024),
    ),
    Sound(
        name="large-blocks",
        what="blocks of 65536 walks",
        plant=_blocks_of(65536),
    ),
    Sound(
        name="blocks-in-reverse-order",
        what="the last block is walked first",
        plant=other_blocks(_in_reverse),
    ),
    Sound(
        name="walks-in-another-order",
        what="the walks of a block go column by column",
        plant=changed_blocks(_columns_first),
    ),
    Sound(
        name="antithetic-numbers",
        what="half of the walks of a block use 1 − u where the other half uses u",
        plant=changed_blocks(_antithetic),
    ),
    Sound(
        name="stratified-pixels",
        what="the samples of a pixel lie in strips of it",
        plant=changed_blocks(_stratified),
    ),
    Sound(
        name="numbers-from-the-other-end",
        what="1 − u in place of u",
        plant=changed_numbers(_from_the_other_end),
    ),
    Sound(
        name="numbers-turned",
        what="u + 0.37 in place of u, modulo 1",
        plant=changed_numbers(lambda u: np.minimum((u + 0.37) % 1, BELOW_ONE)),
    ),
    Sound(
        name="single-precision-numbers",
        what="numbers with the 24 bits of a 32-bit float",
        plant=changed_numbers(lambda u: np.floor(u * 2.0**24) / 2.0**24),
    ),
)
