"""Faults of R: what surfaces reflect."""

from __future__ import annotations

import numpy as np

from comparisons.faults.fault import Fault
from comparisons.faults.planting import Replacement, in_tracer
from reference_tracer.reflection import LambertianBSDF

FAULTS: tuple[Fault, ...] = (
    Fault(
        name="lambertian-without-pi",
        operator="R",
        what="f of a Lambertian surface is its albedo, not albedo / π",
        plant=in_tracer(
            Replacement(
                LambertianBSDF,
                "f",
                lambda f: lambda self, points, wi, wo: np.pi * f(self, points, wi, wo),
            ),
        ),
    ),
)
