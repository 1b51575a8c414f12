"""The reference tracer as one renderer among others."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version

import numpy as np

from comparisons.renderers.protocol import Hits, Images, Unsupported
from reference_tracer.propagation import RayCaster
from reference_tracer.random_walk import STRATEGIES, Strategy, render, total
from reference_tracer.samplers import SAMPLERS, Block, SamplerName
from reference_tracer.sensing import camera_rays
from scenes import IrradianceMeter, Pinhole, Scene, ThinLens
from scenes.formats.support import expressible


def supports() -> dict[str, Sequence[str]]:
    """Every scene there is."""
    images = ("bounces", *(["total"] if hasattr(ReferenceRenderer, "total") else []), "first hits")
    return {**expressible("json"), "images": images, "seed": ("yes",)}


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

    def total(self, scene: Scene, spp: int, seed: int) -> Images:
        """All bounces from walks that end by Russian roulette; see the protocol.

        On independent numbers, whatever the sampler: of Sobol' points there are so many dimensions and no more.
        """
        return total(scene, spp, seed, self._strategy)

    def first_hits(self, scene: Scene) -> Hits:
        """Rays through the centres of pixels; see the protocol."""
        sensor = scene.sensor
        if isinstance(sensor, IrradianceMeter):
            raise Unsupported("irradiance_meter sensor: its pixel is no ray")
        if isinstance(sensor, ThinLens):  # through the centre of its lens, it is a pinhole
            sensor = Pinhole(*(getattr(sensor, field) for field in Pinhole.__struct_fields__))
        height, width, _ = scene.shape
        row, column = np.mgrid[:height, :width].reshape(2, -1)
        centers = Block(np.stack([column, row]) + 0.5, lambda d, lanes: np.zeros((d, len(lanes))))
        rays, cast = camera_rays(sensor, centers), RayCaster(scene)
        hits, distance = cast(rays.origin, rays.d), cast.distance(rays.origin, rays.d)
        return np.stack([distance, *np.where(np.isfinite(distance), hits.n, 0.0), hits.surface])
