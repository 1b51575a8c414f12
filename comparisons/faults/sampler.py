"""Faults of the sampler: numbers that are not independent, or not uniform.

What leaves every single walk as it should be, and only makes walks depend on each other, has the right mean: those
have nothing but more noise, which replicates measure honestly as long as the replicates are independent.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Fault
from comparisons.faults.numbers import (
    changed_blocks,
    changed_numbers,
    of_all_walks,
    pixels,
)
from comparisons.faults.planting import Replacement, in_tracer, of_request
from reference_tracer import sampling
from reference_tracer.random_walk import RandomWalk
from reference_tracer.samplers import Block
from reference_tracer.sensing import Film

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


def _same_in_every_pixel(block: Block) -> Block:
    lanes = np.arange(block.position.shape[1])
    first = lanes - lanes % pixels(block)  # the walk of the first pixel that is the same sample there
    pixel = np.floor(block.position)
    inside = (block.position - pixel).take(first, axis=1)
    return Block(pixel + inside, of_all_walks(block, lambda u: u.take(first, axis=1)))


def _at_centers(block: Block) -> Block:
    return Block(np.floor(block.position) + 0.5, block.numbers)


def _both_axes_alike(u: Array) -> Array:
    """A point of the square has the same number twice, and lies on the diagonal."""
    return np.concatenate([u[:1], u[:1], u[2:]]) if len(u) >= 2 else u


class _Repeating:
    """Numbers that are drawn once for each walk of a block and come again in every bounce."""

    def __init__(self, block: Block, calls: int, first: int) -> None:
        self._draw, self._calls, self._call = block.numbers, calls, -first
        self._everyone = np.arange(block.position.shape[1])
        self._drawn: list[Array] = []

    def __call__(self, dimensions: int, lanes: Indices) -> Array:
        self._call += 1
        if self._call <= 0:  # those of the sensor
            return self._draw(dimensions, lanes)
        if len(self._drawn) < self._calls:
            self._drawn.append(self._draw(dimensions, self._everyone))
        return self._drawn[(self._call - 1) % self._calls].take(lanes, axis=1)


def _repeating(walk: Callable[[RandomWalk, Block, int, Film], None]) -> Any:
    """Each bounce draws for next event, where there is one, and for the BSDF."""

    def substitute(self: RandomWalk, block: Block, bounces: int, film: Film) -> None:
        numbers = _Repeating(block, calls=1 + bool(self.emitters.dimensions), first=1)
        walk(self, Block(block.position, numbers), bounces, film)

    return substitute


def _of_no_place(stream: Callable[..., np.random.Generator]) -> Any:
    return lambda seed, *place: stream(seed)


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="seed-ignored",
        operator="sampler",
        what="every seed gives the same image",
        plant=of_request(lambda inner, scene, bounces, spp, seed: inner.render(scene, bounces, spp, 7)),
        happened=("https://github.com/mitsuba-renderer/mitsuba2/issues/225",),
    ),
    Fault(
        name="numbers-repeat-every-bounce",
        operator="sampler",
        what="each reflection of a walk uses the same numbers as the one before",
        plant=in_tracer(Replacement(RandomWalk, "__call__", _repeating)),
        happened=("https://github.com/straaljager/OpenCL-path-tracing-tutorial-3-Part-2/pull/1",),
    ),
    Fault(
        name="numbers-of-eight-bits",
        operator="sampler",
        what="numbers are multiples of 1 / 256",
        plant=changed_numbers(lambda u: np.floor(u * 256) / 256),
    ),
    Fault(
        name="numbers-below-one-half",
        operator="sampler",
        what="an integer is divided by twice its range: no number is above 1 / 2",
        plant=changed_numbers(lambda u: u / 2),
    ),
    Fault(
        name="one-number-for-two-axes",
        operator="sampler",
        what="both coordinates of a point of the square are the same number",
        plant=changed_numbers(_both_axes_alike),
    ),
    Fault(
        name="pixels-not-jittered",
        operator="sampler",
        what="all rays go through the centres of pixels",
        plant=changed_blocks(_at_centers),
    ),
    Fault(
        name="same-numbers-in-every-pixel",
        operator="sampler",
        what="every pixel uses the same numbers",
        plant=changed_blocks(_same_in_every_pixel),
        unseen="every pixel's mean is right; its noise is that of all others, and replicates show how large it is",
    ),
    Fault(
        name="same-numbers-in-every-block",
        operator="sampler",
        what="what is rendered in parallel starts from the same seed, and more samples repeat the first ones",
        plant=in_tracer(Replacement(sampling, "stream", _of_no_place)),
        happened=("https://github.com/JiayinCao/SORT/issues/35",),
        unseen="unbiased: what is repeated only adds no information, and replicates have seeds of their own",
    ),
    Fault(
        name="seeds-in-pairs",
        operator="sampler",
        what="the lowest bit of the seed is lost: seeds 2k and 2k + 1 give the same image",
        plant=of_request(
            lambda inner, scene, bounces, spp, seed: inner.render(scene, bounces, spp, seed // 2)
        ),
        unseen="unbiased; intervals are narrower by √2 than they should be, and no replicate is held against another",
    ),
)
