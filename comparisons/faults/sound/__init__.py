"""Variants of the reference tracer that look different and are right: no check may fail any of them."""

from __future__ import annotations

from comparisons.faults.fault import Sound
from comparisons.faults.sound import estimators, images, numbers, scenes

VARIANTS: tuple[Sound, ...] = (
    *images.VARIANTS,
    *scenes.VARIANTS,
    *estimators.VARIANTS,
    *numbers.VARIANTS,
)
