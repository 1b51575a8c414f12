"""The reference tracer as one renderer among others."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version

from comparisons.renderers.protocol import Images
from reference_tracer.random_walk import STRATEGIES, Strategy, render
from reference_tracer.samplers import SAMPLERS, SamplerName
from scenes import Scene


class ReferenceRenderer:
    """The tracer of this project with one of its strategies and samplers: ``mis``, ``mis:sobol`` …"""

    def __init__(self, way: str) -> None:
        strategy, _, sampler = way.partition(":")
        self._strategy: Strategy = next(s for s in STRATEGIES if s == strategy)
        self._sampler: SamplerName = next(s for s in SAMPLERS if s == (sampler or "independent"))

    def version(self) -> str:
        """Of this project."""
        return version("lightproof")

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        """Every bounce from one walk; see the protocol."""
        return render(scene, max(bounces), spp, seed, self._strategy, self._sampler)[list(bounces)]
