"""The reference tracer as one renderer among others."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version

from comparisons.renderers.protocol import Images
from reference_tracer.random_walk import STRATEGIES, Strategy, render
from scenes import Scene


class ReferenceRenderer:
    """The tracer of this project with one of its strategies."""

    def __init__(self, strategy: str) -> None:
        self._strategy: Strategy = next(s for s in STRATEGIES if s == strategy)

    def version(self) -> str:
        """Of this project."""
        return version("lightproof")

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        """Every bounce from one walk; see the protocol."""
        return render(scene, max(bounces), spp, seed, self._strategy)[list(bounces)]
