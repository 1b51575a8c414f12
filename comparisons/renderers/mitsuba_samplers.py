"""How many samples per pixel each call of Mitsuba gets.

Samples that belong together must come from one call: a stratified sampler fills its strata once per call, and what
it gets wrong depends on how many there are. So each has its number, one that it takes: Mitsuba rounds others up.

| sampler | samples per call |
|---|---|
| ``independent`` in a scalar variant | 1, which couples depths; all of them with ``ptracer``, where nothing does |
| ``independent`` in a compiled variant | powers of two from 4 on, at most a million paths: others compile anew |
| the same with ``ptracer`` | 16; each number compiles anew |
| ``stratified``, ``multijitter`` | 16 = 4² |
| ``orthogonal`` | 25 = 5²; the root has to be a prime |
| ``ldsampler`` | 16 = 4²; a power of four |

Samples per pixel of a replicate are a multiple of ``Form.spp_unit``; for other numbers, there are more.
"""

from __future__ import annotations

import math

from comparisons.renderers.mitsuba_names import Form

_MOST_PATHS = 1 << 20


def calls(form: Form, spp: int, pixels: int) -> list[int]:
    """Samples per pixel of each call, ``spp`` together: a multiple of ``Form.spp_unit``, rounded up."""
    units = math.ceil(spp / form.spp_unit)
    if form.sampler == "independent" and form.integrator != "ptracer":
        if not form.compiled:
            return [1] * spp
        most = max(1, _MOST_PATHS // (form.spp_unit * pixels))
        return [form.spp_unit * power for power in _powers_of_two(units, most)]
    if form.spp_unit == 1:
        return [spp]
    return [form.spp_unit] * units


def _powers_of_two(number: int, most: int) -> list[int]:
    """Descending, their sum is the number, and none is above ``most``."""
    largest = 1 << (most.bit_length() - 1)
    whole, rest = divmod(number, largest)
    return [largest] * whole + [1 << i for i in reversed(range(rest.bit_length())) if rest >> i & 1]
