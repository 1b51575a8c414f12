"""Variants of the reference tracer that look different and are right."""

from __future__ import annotations

import numpy as np

from comparisons.faults.fault import Sound
from comparisons.faults.planting import of_image

VARIANTS: tuple[Sound, ...] = (
    Sound(
        name="single-precision",
        what="images go through 32-bit floats",
        plant=of_image(lambda images: images.astype(np.float32).astype(np.float64)),
    ),
)
