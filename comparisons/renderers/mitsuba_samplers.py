"""How many samples per pixel one call of Mitsuba gets, and how often it is called.

Samples that belong together must come from one call: a stratified sampler fills its strata once per call, and what
it gets wrong depends on how many there are. So each has its number, one that it takes: Mitsuba rounds others up.

| sampler | samples per call |
|---|---|
| ``independent`` in a scalar variant | 1, which couples depths; all of them with ``ptracer``, where nothing does |
| ``independent`` in a compiled variant | as many as are asked for, in calls of at most a million paths |
| ``stratified``, ``multijitter`` | 64 = 8² |
| ``orthogonal`` | 49 = 7²; the root has to be a prime |
| ``ldsampler`` | 64 = 4³; a power of four |

So a replicate has at least that many, also where fewer are asked for.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from comparisons.renderers.mitsuba_names import Form

PER_CALL = {"stratified": 64, "multijitter": 64, "orthogonal": 49, "ldsampler": 64}
"""Samples per pixel and call of the samplers whose samples belong together."""

_MOST_PATHS = 1 << 20


class Calls(NamedTuple):
    """How often Mitsuba is called, and with how many samples per pixel each time."""

    number: int
    spp: int


def calls(form: Form, spp: int, pixels: int) -> Calls:
    """The calls that make at least ``spp`` samples per pixel."""
    if form.sampler in PER_CALL:
        per_call = PER_CALL[form.sampler]
        return Calls(math.ceil(spp / per_call), per_call)
    if not form.compiled and form.integrator != "ptracer":
        return Calls(spp, 1)
    number = math.ceil(spp * pixels / _MOST_PATHS)
    return Calls(number, math.ceil(spp / number))
