"""Faults of the sampler."""

from __future__ import annotations

from comparisons.faults.fault import Fault

FAULTS: tuple[Fault, ...] = ()
