"""Faults of the estimator: densities, choices and weights that disagree, so that the mean is not the integral."""

from __future__ import annotations

from comparisons.faults import next_event, weights
from comparisons.faults.fault import Fault

FAULTS: tuple[Fault, ...] = weights.FAULTS + next_event.FAULTS
