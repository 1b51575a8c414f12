"""Other random numbers for the reference tracer's walks: what wrong samplers and other right ones are made of."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Plant
from comparisons.faults.planting import Replacement, in_tracer
from reference_tracer import random_walk
from reference_tracer.samplers import Block, Numbers

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Blocks = Callable[[int, int, int, int, int], Iterator[Block]]
"""What a sampler is: ``(width, height, spp, seed, dimensions)`` → blocks of walks."""


def other_blocks(made_of: Callable[[Blocks], Blocks]) -> Plant:
    """The independent sampler is another one."""
    return in_tracer(
        Replacement(
            random_walk,
            "BLOCKS",
            lambda samplers: {**samplers, "independent": made_of(samplers["independent"])},
        )
    )


def changed_blocks(change: Callable[[Block], Block]) -> Plant:
    """Every block of walks is another one."""
    return other_blocks(lambda blocks: lambda *arguments: map(change, blocks(*arguments)))


def changed_numbers(change: Callable[[Array], Array]) -> Plant:
    """Every number is another one in [0, 1), those of positions within their pixels too; ``(dimensions, n)``."""

    def changed(block: Block) -> Block:
        pixel = np.floor(block.position)
        inside = change(block.position - pixel)
        return Block(pixel + inside, lambda d, lanes: change(block.numbers(d, lanes)))

    return changed_blocks(changed)


def of_all_walks(block: Block, change: Callable[[Array], Array]) -> Numbers:
    """Numbers that all walks of the block draw each time, also those that have ended; as a function of those.

    Args:
        block: the block.
        change: of ``(dimensions, walks)``.
    """
    everyone = np.arange(block.position.shape[1])

    def numbers(dimensions: int, lanes: Indices) -> Array:
        return change(block.numbers(dimensions, everyone)).take(lanes, axis=1)

    return numbers


def pixels(block: Block) -> int:
    """How many pixels have walks in a block: walk l is sample l // pixels of its pixel, counted within the block."""
    return len(np.unique(np.floor(block.position), axis=1).T)
