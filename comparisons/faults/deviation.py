"""How far off a bounce is, beside what could have been seen of it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from comparisons.results import BounceResult, Comparison


class Deviation(NamedTuple):
    """Of the whole image, or of the worst tile."""

    bounce: int
    bias: float
    detectable_bias: float

    @property
    def clearness(self) -> float:
        """About 1 where it is just seen."""
        return abs(self.bias) / self.detectable_bias


def deviations(comparison: Comparison) -> Iterator[Deviation]:
    """Of every bounce, both of the image and of the worst tile."""
    for bounce in comparison.bounces:
        yield Deviation(bounce.bounce, bounce.bias, bounce.detectable_bias)
        yield Deviation(bounce.bounce, bounce.worst_tile.bias, bounce.worst_tile.detectable_bias)


def decisive(bounce: BounceResult) -> Deviation:
    """The one that its verdict is about."""
    measured = bounce.worst_tile if bounce.decided_by == "tile" else bounce
    return Deviation(bounce.bounce, measured.bias, measured.detectable_bias)
