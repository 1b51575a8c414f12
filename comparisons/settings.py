"""How to validate, and who wants to see it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from comparisons.known import Deviation
from comparisons.results import Comparison, RelationResult
from comparisons.sequential import FIRST_LOOK
from comparisons.statistics.intervals import alpha_of_look

DEFAULT_BUDGET = 75.0
DEFAULT_ALPHA = 1e-3


@dataclass(frozen=True)
class Settings:
    """How to validate. What is None is left to the case.

    Attributes:
        bounces: the last bounce.
        tolerance, tile_tolerance: relative, one per bounce; the last one holds for all later bounces.
        size: (width, height) in pixels.
        alpha: probability of a wrong verdict in a comparison.
        budget: seconds per case × renderer.
        seed: of the user.
        jobs: processes that render at the same time.
        known: declared deviations.
        early_stop: whether to stop as soon as every bounce is decided; if not, there is one look, at the end of
            the budget.
        first_look: seconds that the least number of replicates should take; less, for less.
        total: whether to hold the renderer's own sum of all bounces against the truth, too; it gets half of the
            budget, beside it.
    """

    bounces: int | None = None
    tolerance: tuple[float, ...] | None = None
    tile_tolerance: tuple[float, ...] | None = None
    size: tuple[int, int] | None = None
    alpha: float = DEFAULT_ALPHA
    budget: float = DEFAULT_BUDGET
    seed: int = 0
    jobs: int = 1
    known: tuple[Deviation, ...] = ()
    early_stop: bool = True
    first_look: float = FIRST_LOOK
    total: bool = True

    def alpha_of(self, look: int) -> float:
        """What a look may spend: all of α where it is the only one."""
        return alpha_of_look(self.alpha, look) if self.early_stop else self.alpha


class Silent:
    """An observer that looks away."""

    def started(self, case: str, renderer: str) -> None:
        """Not of interest."""

    def progressed(self, share: float, message: str) -> None:
        """Not of interest."""

    def finished(self, comparison: Comparison) -> None:
        """Not of interest."""

    def related(self, results: list[RelationResult]) -> None:
        """Not of interest."""


class Observer(Protocol):
    """Who wants to see how a run goes on."""

    def started(self, case: str, renderer: str) -> None:
        """A comparison begins, or a relation."""

    def progressed(self, share: float, message: str) -> None:
        """So much of its budget is used; the message says what is done or what is still open."""

    def finished(self, comparison: Comparison) -> None:
        """A comparison has its verdict."""

    def related(self, results: list[RelationResult]) -> None:
        """A relation has the verdicts of its claims."""
