"""Faults of the sensor."""

from __future__ import annotations

from comparisons.faults.fault import Fault

FAULTS: tuple[Fault, ...] = ()
