"""Faults of E: what is emitted, and what the sensor and next event see of it."""

from __future__ import annotations

from comparisons.faults.fault import Fault
from comparisons.faults.planting import of_request

FAULTS: tuple[Fault, ...] = (
    Fault(
        name="lamps-invisible",
        operator="E",
        what="the sensor does not see emitters: bounce 0 is black",
        plant=of_request(
            lambda inner, scene, bounces, spp, seed: (
                inner.render(scene, bounces, spp, seed) * [[[[float(k > 0)]]] for k in bounces]
            )
        ),
    ),
)
