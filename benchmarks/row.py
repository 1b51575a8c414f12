"""One row of the table: a ratio, and what it must reach."""

from __future__ import annotations

from typing import Literal

import msgspec

from benchmarks.statistics import Ratio

Verdict = Literal["below must", "must", "aim"]


class Row(msgspec.Struct, frozen=True):
    """A measured ratio; the larger, the better for us.

    Attributes:
        name: short, for programs.
        title: what is divided by what.
        ratio, low, high: the ratio and its interval; 0 where a condition on the answer is not met.
        must, aim: what the ratio must reach, and what it should.
        decides: whether the exit code depends on it; otherwise the row informs.
        note: how it was measured.
    """

    name: str
    title: str
    ratio: float
    low: float
    high: float
    must: float
    aim: float
    decides: bool = True
    note: str = ""

    @property
    def verdict(self) -> Verdict:
        """What the ratio has reached."""
        return "below must" if not self.ratio >= self.must else "must" if self.ratio < self.aim else "aim"

    def filled(self, ratio: Ratio, note: str) -> Row:
        """The row with what was measured."""
        return msgspec.structs.replace(self, ratio=ratio.value, low=ratio.low, high=ratio.high, note=note)


def asked(name: str, title: str, must: float, aim: float, decides: bool = True) -> Row:
    """A row that is still to be measured."""
    nan = float("nan")
    return Row(name, title, nan, nan, nan, must, aim, decides)


def as_json(rows: list[Row]) -> bytes:
    """A list of objects with the fields of the rows and their verdicts."""
    return msgspec.json.format(msgspec.json.encode([_object(row) for row in rows]), indent=2)


def _object(row: Row) -> dict[str, object]:
    return msgspec.structs.asdict(row) | {"verdict": row.verdict}
