"""Both sides of a comparison on the Cornell box: the tracer, and Mitsuba 3 ``scalar_rgb`` as its adapter loads it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.renderers.mitsuba import MitsubaRenderer
from comparisons.renderers.mitsuba_colours import RGB
from comparisons.renderers.mitsuba_integrators import Pass, properties
from comparisons.renderers.mitsuba_names import Form
from comparisons.renderers.mitsuba_scene import sensor_dict
from reference_tracer.random_walk import render
from reference_tracer.samplers import SamplerName
from scenes.library.cornell_box import cornell_box

Array = NDArray[np.float64]
Side = Callable[[int], Array]

BOUNCES = 5
SCENE = cornell_box().scene

_PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31)


def ours(spp: int, sampler: SamplerName = "independent") -> Side:
    """Every bounce in one pass, ``(bounces + 1, height, width, channels)``, as a function of the seed."""
    return lambda seed: render(SCENE, BOUNCES, spp, seed, strategy="mis", sampler=sampler)


class Mitsuba:
    """Mitsuba with the scene loaded: loading is not timed."""

    def __init__(self) -> None:
        self._adapter = MitsubaRenderer("scalar_rgb")
        self._mi: Any = self._adapter._mi
        self._scene = self._adapter._load(SCENE)
        self._paths = [self._mi.load_dict(properties(Form(), Pass(d))) for d in range(1, BOUNCES + 2)]

    def sum(self, spp: int) -> Side:
        """The sum of all bounces, in one render of the full depth."""
        return lambda seed: self._render(self._paths[-1], spp=spp, seed=seed)

    def coupled(self, spp: int) -> Side:
        """Every bounce, by the adapter: differences of depths that share their paths."""
        return lambda seed: self._adapter.render(SCENE, range(BOUNCES + 1), spp, seed)

    def stratified(self, spp: int, sampler: str) -> Side:
        """Every bounce, with another of Mitsuba's samplers: all spp in one call, the same seed at every depth.

        ``orthogonal`` takes the square of a prime: the next one. Its time is that of so many.
        """
        count = next(p * p for p in _PRIMES if p * p >= spp) if sampler == "orthogonal" else spp
        description = sensor_dict(RGB(self._mi), SCENE.sensor)
        film = self._mi.load_dict(description | {"sampler": {"type": sampler, "sample_count": count}})

        def bounces(seed: int) -> Array:
            sums = [self._render(path, sensor=film, spp=count, seed=seed) for path in self._paths]
            return np.diff([np.zeros_like(sums[0]), *sums], axis=0)

        return bounces

    def _render(self, path: Any, **options: Any) -> Array:
        return np.array(self._mi.render(self._scene, integrator=path, **options), dtype=np.float64)
