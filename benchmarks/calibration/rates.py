"""Counts of verdicts, held against what was promised."""

from __future__ import annotations

from dataclasses import dataclass

from scipy import stats

LEVEL = 0.95


@dataclass(frozen=True)
class Rate:
    """How often something happened, and how often it should.

    Attributes:
        what: in a line.
        count, runs: how often, of how many.
        least, most: the rate that was promised.
    """

    what: str
    count: int
    runs: int
    least: float
    most: float

    @property
    def kept(self) -> bool:
        """Whether the count is one that a rate within the promise gives, by the binomial bound at 95 %."""
        too_many = self.count > stats.binom.ppf(LEVEL, self.runs, self.most)
        too_few = self.count < stats.binom.ppf(1 - LEVEL, self.runs, self.least)
        return not (too_many or too_few)

    @property
    def shown(self) -> tuple[str, str]:
        """The rate that was found, and the one that was promised."""
        promised = f"≤ {self.most:.1%}" if self.least == 0 else f"{self.least:.0%} to {self.most:.0%}"
        return f"{self.count / self.runs:.2%} ({self.count} of {self.runs})", promised
