"""Planted faults: renderers that are wrong on purpose, to prove that the checks catch what they claim to.

One file per operator that is at fault; ``fault`` says what a fault is, ``planting`` how it gets into a renderer,
``sound`` holds variants that look different and are right, which nothing may fail, and ``matrix`` runs them all.
``held_out`` has faults that the diagnosis was not tuned on.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from comparisons.faults import (
    emission,
    estimator,
    held_out,
    propagation,
    reflection,
    sampler,
    sensor,
    series,
    sound,
)
from comparisons.faults.fault import Fault, Sound

__all__ = ["FAULTS", "SOUND_VARIANTS", "Fault", "Sound"]

FAULTS: Mapping[str, Fault] = MappingProxyType(
    {
        fault.name: fault
        for module in (emission, propagation, reflection, series, estimator, sensor, sampler, held_out)
        for fault in module.FAULTS
    }
)
SOUND_VARIANTS: Mapping[str, Sound] = MappingProxyType({variant.name: variant for variant in sound.VARIANTS})
