"""All TᵏE from one walk: the fused, fast form of the operator algebra.

A walk x₀ (the pinhole), x₁, x₂, … carries the throughput ∏ f cos / pdf. Emission found at x_{k+1} belongs to
TᵏE, so one walk estimates every bounce. The strategies differ in how they find emission:

    bsdf   by chance, where the sampled direction meets an emitter
    nee    next event: at every vertex a point of an emitter is chosen and its visibility tested
    mis    both, weighted by the balance heuristic (Veach and Guibas 1995, eq. 14)

E itself is always found by the camera ray.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from reference_tracer import sampling
from reference_tracer.emission import Emitters
from reference_tracer.points import NOWHERE, Points
from reference_tracer.propagation import RayCaster
from reference_tracer.reflection import LambertianBSDF
from reference_tracer.sensing import camera_rays
from scenes import Scene

Array = NDArray[np.float64]
Strategy = Literal["bsdf", "nee", "mis"]
STRATEGIES: tuple[Strategy, ...] = get_args(Strategy)

BLOCK = 4096
"""Rays that travel together: their arrays stay in the second-level cache; fewer lose to call overhead."""


class NonFiniteRadianceError(ArithmeticError):
    """A walk made NaN or infinity."""


def render(
    scene: Scene,
    bounces: int,
    spp: int,
    seed: int,
    strategy: Strategy = "mis",
    on_block: Callable[[float], None] = lambda done: None,
) -> Array:
    """Estimate E, TE, …, TⁿE, n = ``bounces``.

    Args:
        scene: what to render.
        bounces: the last bounce.
        spp: samples per pixel, at least 1.
        seed: ≥ 0; the image is a function of the arguments up to here and nothing else.
        strategy: how emission is found.
        on_block: called with the finished share of the work, for progress.

    Returns:
        ``(bounces + 1, height, width, channels)``, radiance, unclamped.

    Raises:
        NonFiniteRadianceError: naming pixel and bounce.
    """
    height, width, channels = scene.shape
    walk = RandomWalk(scene, strategy)
    image = np.zeros((bounces + 1, channels, height * width))
    done = 0
    for block, (pixels, samples) in enumerate(_blocks(height * width, spp)):
        rng = sampling.stream(seed, block)
        L = walk(np.tile(pixels, samples), bounces, rng)
        image[..., pixels] += L.reshape(bounces + 1, channels, samples, len(pixels)).sum(axis=2)
        done += samples * len(pixels)
        on_block(done / (spp * height * width))
    if not np.isfinite(image).all():
        k, _, pixel = np.argwhere(~np.isfinite(image))[0]
        raise NonFiniteRadianceError(f"bounce {k}, row {pixel // width}, column {pixel % width}")
    return np.moveaxis(image, 1, -1).reshape(bounces + 1, height, width, channels) / spp


def _blocks(pixels: int, spp: int) -> Iterator[tuple[NDArray[np.intp], int]]:
    """Split pixels × spp rays into blocks: ranges of pixels, and how many samples each of them gets at once."""
    for start in range(0, pixels, BLOCK):
        part = np.arange(start, min(start + BLOCK, pixels))
        at_once = max(1, BLOCK // len(part))
        for done in range(0, spp, at_once):
            yield part, min(at_once, spp - done)


class RandomWalk:
    """Walks through one scene."""

    def __init__(self, scene: Scene, strategy: Strategy) -> None:
        self.scene, self.strategy = scene, strategy
        self.cast, self.emitters, self.bsdf = RayCaster(scene), Emitters(scene), LambertianBSDF(scene)

    def __call__(self, pixels: NDArray[np.intp], bounces: int, rng: np.random.Generator) -> Array:
        """One walk through each pixel given: its estimates of every TᵏE, ``(bounces + 1, channels, n)``."""
        L = np.zeros((bounces + 1, self.scene.channels, len(pixels)))
        lanes = np.arange(len(pixels))
        throughput = np.ones((self.scene.channels, len(pixels)))
        vertex, d = camera_rays(self.scene.sensor, pixels, rng)
        pdf = np.full(len(pixels), np.inf)  # of the direction d; the pinhole's is a delta

        for k in range(bounces + 1):
            previous, vertex = vertex, self.cast(vertex, d)
            wo = -d

            # ---- emission that the walk has found by chance: TᵏE
            Le = self.emitters.Le(vertex, wo)
            if k == 0 or self.strategy == "bsdf":
                L[k][:, lanes] += throughput * Le
            elif self.strategy == "mis":
                L[k][:, lanes] += throughput * Le * self._chance_weight(previous, vertex, wo, pdf)
            if k == bounces:
                break

            # ---- the walk ends where there is no surface, and on backs, which are black
            alive = (vertex.surface != NOWHERE) & (np.einsum("in,in->n", vertex.n, wo) > 0)
            if not alive.all():
                vertex, wo, lanes = vertex[alive], wo[:, alive], lanes[alive]
                throughput = throughput[:, alive]

            # ---- next event: one term of Tᵏ⁺¹E
            if self.strategy != "bsdf":
                L[k + 1][:, lanes] += throughput * self._next_event(vertex, wo, rng)

            # ---- reflection: a direction with density pdf, throughput · f cos / pdf
            d = self.bsdf.sample(vertex, rng)
            pdf = self.bsdf.pdf(vertex, d)
            throughput = throughput * self.bsdf.weight(vertex, wo)
        return L

    def _next_event(self, vertex: Points, wo: Array, rng: np.random.Generator) -> Array:
        """Le · f · cos / pdf · V of one point of an emitter, ``(channels, n)``, weighted for mis."""
        light = self.emitters.sample(rng, len(vertex))
        segment = light.x - vertex.x
        distance_squared = np.einsum("in,in->n", segment, segment)
        with np.errstate(invalid="ignore"):  # the vertex itself was chosen: no direction, no light
            wi = segment / np.sqrt(distance_squared)
        cosine = np.einsum("in,in->n", vertex.n, wi)
        pdf = self.emitters.pdf(light, -wi, distance_squared)

        # only pairs that face each other are worth a shadow ray
        facing = np.flatnonzero((cosine > 0) & (pdf > 0))
        light, wi, cosine, pdf = light[facing], wi[:, facing], cosine[facing], pdf[facing]
        vertex = vertex[facing]
        hit = self.cast(vertex, wi)
        # from outside, the back of an inward sphere hides its inside: the same surface, met from the wrong side
        visible = (hit.surface == light.surface) & (np.einsum("in,in->n", hit.n, wi) < 0)

        if self.strategy == "mis":
            pdf = pdf + self.bsdf.pdf(vertex, wi)  # balance heuristic: w / p = 1 / (p + p_bsdf)
        Ld = self.emitters.Le(light, -wi) * self.bsdf.f(vertex, wi, wo[:, facing]) * (cosine * visible / pdf)
        all_lanes = np.zeros((self.scene.channels, wo.shape[1]))
        all_lanes[:, facing] = Ld
        return all_lanes

    def _chance_weight(self, previous: Points, vertex: Points, wo: Array, pdf: Array) -> Array:
        """Balance heuristic for emission found by chance: p_bsdf / (p_bsdf + p_next_event)."""
        distance_squared = ((vertex.x - previous.x) ** 2).sum(axis=0)
        return pdf / (pdf + self.emitters.pdf(vertex, wo, distance_squared))
