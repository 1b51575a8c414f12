"""A renderer that knows the answer, and small cases for it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from comparisons.renderers import Images
from comparisons.whole_sum import Series
from scenes import Case, Scene, library

NOISE = 0.01  # of a pixel, relative, one sample per pixel


class Oracle:
    """Knows the answer, and adds noise: what it gets wrong is what a test plants, and nothing else."""

    name = "oracle"

    def __init__(
        self,
        case: Case,
        of_total: Callable[[Images], Images] = lambda image: image,
        factors: Callable[[int], float] = lambda k: 1.0,
    ) -> None:
        truth = case.answer.truth(case.scene, case.bounces)
        assert truth is not None
        self._terms, self._sum = truth.mean, Series.of(case, truth).total().mean
        self._of_total, self._factors = of_total, factors

    def version(self) -> str:
        return "1"

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        if scene.shape != self._sum.shape:  # the probe
            return np.random.default_rng(seed).random((len(bounces), *scene.shape))
        return np.stack([self._noisy(self._factors(k) * self._terms[k], spp, seed + 7 * k) for k in bounces])

    def total(self, scene: Scene, spp: int, seed: int) -> Images:
        return self._noisy(self._of_total(self._sum), spp, seed)

    def _noisy(self, image: Images, spp: int, seed: int) -> Images:
        noise = np.random.default_rng(seed).normal(size=image.shape) * NOISE / np.sqrt(spp)
        return np.asarray(image * (1 + noise))


def small(name: str, size: int = 8, **changes: Any) -> Case:
    case = library.case(name)
    return replace(case, scene=case.scene.resized(size, size), **changes)
