"""Where the random numbers of walks come from.

    independent   every number by itself: the error falls as n^−1/2
    sobol         scrambled Sobol' points, one per walk, over the whole image: all walks together cover positions,
                  lens, emitters and directions evenly (Owen 1995; Matoušek 1998). Each point by itself is uniform,
                  so every estimate stays unbiased; one seed is one randomisation, and variances come from several
                  seeds, never from the walks of one

Walks come in blocks that stay in the second-level cache.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal, Protocol, get_args

import numpy as np
from numpy.typing import NDArray

from reference_tracer import sampling

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
SamplerName = Literal["independent", "sobol"]
SAMPLERS: tuple[SamplerName, ...] = get_args(SamplerName)

BLOCK = 16384
"""Walks that go together: their arrays stay in the second-level cache; fewer lose to call overhead."""

MOST_DIMENSIONS, MOST_POINTS = 21201, 2**30
"""Of Sobol' points: as many as there are direction numbers (Joe and Kuo 2008), of 30 bits each."""


class Numbers(Protocol):
    """The numbers of a block of walks, dimension after dimension."""

    def __call__(self, dimensions: int, lanes: Indices) -> Array:
        """The next numbers in [0, 1) for the walks of these lanes, ``(dimensions, len(lanes))``."""


@dataclass
class Block:
    """A block of n walks.

    Attributes:
        position: where they start in the image, in pixels from its top left corner, ``(2, n)``.
        numbers: what they draw from.
    """

    position: Array
    numbers: Numbers


def independent(width: int, height: int, spp: int, seed: int, dimensions: int) -> Iterator[Block]:
    """Independent numbers; the same count of walks starts in every pixel. Their dimensions are not limited."""
    for number, (start, end, samples) in enumerate(_parts(width * height, spp)):
        rng = sampling.stream(seed, number)
        rows, columns = np.divmod(np.tile(np.arange(start, end), samples), width)
        position = np.stack([columns, rows]) + rng.random((2, len(rows)))
        yield Block(position, lambda d, lanes, rng=rng: rng.random((d, len(lanes))))


def _parts(pixels: int, spp: int) -> Iterator[tuple[int, int, int]]:
    """Split pixels × spp walks into blocks: ranges of pixels, and how many samples each of them gets at once."""
    for start in range(0, pixels, BLOCK):
        end = min(start + BLOCK, pixels)
        at_once = max(1, BLOCK // (end - start))
        for done in range(0, spp, at_once):
            yield start, end, min(at_once, spp - done)


def sobol(width: int, height: int, spp: int, seed: int, dimensions: int) -> Iterator[Block]:
    """Scrambled Sobol' points of so many dimensions, beside the two of the image.

    The first two dimensions lie over a rectangle of 2ᵃ × 2ᵇ pixels that holds the image. They are a
    (0, 2)-sequence: of 2ᵃ⁺ᵇ consecutive points each pixel gets exactly one. Points beside the image are left out.

    Raises:
        ValueError: more points or dimensions than there are.
    """
    from scipy.stats import qmc  # here alone: the rest of the tracer needs NumPy and nothing else

    columns, rows = (1 << (size - 1).bit_length() for size in (width, height))
    count = columns * rows * spp
    for name, found, most in (
        ("points", count, MOST_POINTS),
        ("dimensions", 2 + dimensions, MOST_DIMENSIONS),
    ):
        if found > most:
            expected = f"at most {most}; the sampler independent has no limit"
            raise ValueError(
                f"sobol: {width} × {height} pixels, {spp} spp take {found} {name}, expected {expected}"
            )
    engine = qmc.Sobol(2 + dimensions, scramble=True, rng=sampling.stream(seed))
    for start in range(0, count, BLOCK):
        points = engine.random(BLOCK)[
            : count - start
        ]  # always a power of two is drawn, as Sobol' points want
        position = points[:, :2].T * [[columns], [rows]]
        inside = np.flatnonzero((position[0] < width) & (position[1] < height))
        if len(inside):
            # by component, as all arrays of walks lie
            yield Block(position.take(inside, axis=1), _Rows(points[inside, 2:].T.copy()))


class _Rows:
    """Numbers that lie ready, one row per dimension."""

    def __init__(self, rows: Array) -> None:
        self._rows, self._next = rows, 0

    def __call__(self, dimensions: int, lanes: Indices) -> Array:
        rows = self._rows[self._next : self._next + dimensions]
        self._next += dimensions
        return rows if len(lanes) == rows.shape[1] else rows.take(lanes, axis=1)


BLOCKS: dict[SamplerName, Callable[[int, int, int, int, int], Iterator[Block]]] = {
    "independent": independent,
    "sobol": sobol,
}
