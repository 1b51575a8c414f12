"""Faults of the sampler, held out: numbers that a walk has been given before, or that have run out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Fault
from comparisons.faults.numbers import changed_blocks, changed_numbers
from reference_tracer.samplers import Block

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

DIMENSIONS = 10
"""Numbers that there are for a walk."""


class _Ending:
    """Numbers that are all 1 / 2 once a walk has drawn as many as there are.

    Russian roulette's, which are drawn one at a time, come from elsewhere: walks still end.
    """

    def __init__(self, block: Block) -> None:
        self._draw, self._left = block.numbers, DIMENSIONS

    def __call__(self, dimensions: int, lanes: Indices) -> Array:
        numbers = self._draw(dimensions, lanes)
        if dimensions < 2:
            return numbers
        numbers[max(self._left, 0) :] = 0.5
        self._left -= dimensions
        return numbers


def _first_again(u: Array) -> Array:
    """What chooses among emitters or lobes is what then places a point, and is not scaled up in between."""
    return np.concatenate([u[:2], u[:1]]) if len(u) == 3 else u


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="numbers-run-out",
        operator="sampler",
        what="a walk has ten numbers, and all further ones are 1 / 2",
        plant=changed_blocks(lambda block: Block(block.position, _Ending(block))),
    ),
    Fault(
        name="choice-and-place-by-one-number",
        operator="sampler",
        what="the number that chooses among emitters or lobes is the first of the two that then choose a point",
        plant=changed_numbers(_first_again),
    ),
)
