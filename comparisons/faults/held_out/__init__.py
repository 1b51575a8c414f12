"""Planted faults that nothing was tuned on: written by someone who had not seen the diagnosis.

One file per operator that is at fault, as in the catalogue. They are part of it; ``FAULTS`` tells which they are.
Whoever tunes the diagnosis with them in view moves them into the catalogue's own files, and has others written.
"""

from __future__ import annotations

from comparisons.faults.fault import Fault
from comparisons.faults.held_out import (
    emission,
    estimator,
    propagation,
    reflection,
    sampler,
    sensor,
    series,
)

__all__ = ["FAULTS"]

FAULTS: tuple[Fault, ...] = tuple(
    fault
    for module in (emission, propagation, reflection, series, estimator, sensor, sampler)
    for fault in module.FAULTS
)
