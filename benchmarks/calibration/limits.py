"""A figure, and how large it may be."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Limit:
    """What was measured, in a line; the figure, the most it may be, and its unit: ``%`` of 1, ``s``, or none."""

    what: str
    figure: float
    most: float
    unit: str

    @property
    def kept(self) -> bool:
        """Whether it is as small as it must be."""
        return self.figure <= self.most

    @property
    def shown(self) -> tuple[str, str]:
        """Figure and limit, with their unit."""
        scale = 100 if self.unit == "%" else 1
        found, most = (f"{scale * number:.3g} {self.unit}".strip() for number in (self.figure, self.most))
        return found, f"≤ {most}"
