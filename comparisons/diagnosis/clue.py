"""A clue: something that was seen, and what it speaks for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from comparisons.results import Operator

Weights = Mapping[Operator, float]
"""Roughly logarithms of how much more likely it is to be seen when that operator is at fault."""


@dataclass(frozen=True)
class Clue:
    """Something that was seen: as a sentence, and what it speaks for."""

    text: str
    weights: Weights
