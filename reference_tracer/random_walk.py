"""All TᵏE from one walk: the fused, fast form of the operator algebra.

A walk x₀ (the sensor), x₁, x₂, … carries the throughput ∏ f cos / pdf. Emission found at x_{k+1} belongs to
TᵏE, so one walk estimates every bounce. The strategies differ in how they find emission:

    bsdf   by chance, where the sampled direction meets an emitter
    nee    next event: at every vertex a direction to an emitter is chosen and its visibility tested
    mis    both, weighted by the balance heuristic (Veach and Guibas 1995, eq. 14)

What only one strategy can find is left to it: E itself and what a mirror shows to chance, point, spot and
directional lights to next event. A walk ends at the last bounce, where it leaves the scene, or on what reflects
nothing. Only a walk without a last bounce, which is summed whole (``total``), ends by Russian roulette.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from reference_tracer.arguments import check_choice, check_scene, check_whole
from reference_tracer.emission import Emitters
from reference_tracer.points import NOWHERE, Points
from reference_tracer.propagation import RayCaster
from reference_tracer.reflection import bsdf_of
from reference_tracer.roulette import roulette
from reference_tracer.samplers import BLOCKS, SAMPLERS, Block, SamplerName
from reference_tracer.sensing import Film, SumFilm, camera_rays, sensor_dimensions
from reference_tracer.vectors import dot
from scenes import Scene

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Strategy = Literal["bsdf", "nee", "mis"]
STRATEGIES: tuple[Strategy, ...] = get_args(Strategy)


class NonFiniteRadianceError(ArithmeticError):
    """A walk made NaN or infinity."""


def render(
    scene: Scene,
    bounces: int,
    spp: int,
    seed: int,
    strategy: Strategy = "mis",
    sampler: SamplerName = "independent",
    on_block: Callable[[float], None] = lambda done: None,
) -> Array:
    """Estimate E, TE, …, TⁿE, n = ``bounces``.

    Args:
        scene: what to render.
        bounces: the last bounce, at least 0, which is E alone.
        spp: samples per pixel, at least 1.
        seed: ≥ 0; the image is a function of the arguments up to ``sampler`` and nothing else.
        strategy: how emission is found.
        sampler: where the random numbers come from.
        on_block: called with the finished share of the work, for progress.

    Returns:
        ``(bounces + 1, height, width, channels)``, radiance, unclamped.

    Raises:
        TypeError, ValueError: an argument that can't be.
        NonFiniteRadianceError: naming pixel, bounce and surface.
        NegativeRadianceError: a spherical-harmonics environment is negative somewhere.
    """
    check_scene(scene)
    check_whole(0, bounces=bounces)
    return _walked(scene, bounces, spp, seed, strategy, sampler, on_block, Film(bounces, scene.shape))


def total(
    scene: Scene,
    spp: int,
    seed: int,
    strategy: Strategy = "mis",
    on_block: Callable[[float], None] = lambda done: None,
) -> Array:
    """Estimate the whole sum E + TE + T²E + …, ended by Russian roulette and not by a last bounce.

    Its numbers are independent ones, whose dimensions are not limited.

    Args:
        scene, spp, seed, strategy, on_block: as of ``render``.

    Returns:
        ``(height, width, channels)``, radiance, unclamped.

    Raises:
        TypeError, ValueError, NonFiniteRadianceError, NegativeRadianceError: as ``render``.
    """
    check_scene(scene)
    film = SumFilm(scene.shape)
    return np.asarray(_walked(scene, None, spp, seed, strategy, "independent", on_block, film)[0])


def _walked(
    scene: Scene,
    bounces: int | None,
    spp: int,
    seed: int,
    strategy: Strategy,
    sampler: SamplerName,
    on_block: Callable[[float], None],
    film: Film,
) -> Array:
    """All walks, up to a last bounce or without one (None), and the film's mean of them."""
    check_whole(0, seed=seed)
    check_whole(1, spp=spp)
    check_choice(SAMPLERS, sampler=sampler)
    height, width, _ = scene.shape
    # One large array, made and let go, tells glibc to keep freed memory (M_MMAP_THRESHOLD in mallopt(3)). Without
    # it the arrays of every block are fetched from the kernel anew, page by page.
    np.empty(1 << 22)
    done = 0
    with np.errstate(invalid="ignore", over="ignore"):  # what is not finite is refused by the walk itself
        walk = RandomWalk(scene, strategy)
    for block in BLOCKS[sampler](width, height, spp, seed, walk.dimensions(bounces or 0)):
        film.begin(block)
        with np.errstate(invalid="ignore", over="ignore"):
            walk(block, bounces, film)
        done += block.position.shape[1]
        on_block(done / (spp * height * width))
    images = film.mean(spp)
    if not np.isfinite(images).all():
        bounce, row, column, _ = np.argwhere(~np.isfinite(images))[0]
        raise NonFiniteRadianceError(f"{f'bounce {bounce}' if bounces is not None else 'the total'}, row {row}, "
                                     f"column {column}: the sum of its walks is "
                                     "beyond all floats; scale the emission down")  # fmt: skip
    return images


class RandomWalk:
    """Walks through one scene."""

    def __init__(self, scene: Scene, strategy: Strategy) -> None:
        check_choice(STRATEGIES, strategy=strategy)  # an unknown one would mix the weights of two
        self.scene, self.strategy = scene, strategy
        self.cast, self.bsdf = RayCaster(scene), bsdf_of(scene)
        self.emitters = Emitters(scene, delta_only=strategy == "bsdf")
        self._lobe_dimensions = 3 if self.bsdf.needs_choice else 2

    def dimensions(self, bounces: int) -> int:
        """Random numbers that a walk takes, beside its position in the image."""
        return sensor_dimensions(self.scene.sensor) + bounces * (
            self.emitters.dimensions + self._lobe_dimensions
        )

    def __call__(self, block: Block, bounces: int | None, film: Film) -> None:
        """A block of walks, one from each position: adds their estimates of every TᵏE to the film.

        Without a last bounce, chance ends them.
        """
        rays = camera_rays(self.scene.sensor, block)
        vertex, d = rays.origin, rays.d
        lanes = np.arange(len(vertex))
        throughput = np.full((self.scene.channels, len(vertex)), rays.weight)
        pdf = np.full(len(vertex), np.inf)  # of the direction d; no other strategy finds what a sensor sees

        for k in count():
            previous, vertex = vertex, self.cast(vertex, d)

            # ---- emission that the walk has found by chance: TᵏE
            lit = np.flatnonzero(self.emitters.emits.take(vertex.surface))
            if len(lit):
                Le = self._found(previous[lit], vertex[lit], d.take(lit, axis=1), pdf.take(lit))
                self._record(film, k, lanes.take(lit), throughput.take(lit, axis=1) * Le, vertex[lit])
            if k == bounces:
                break

            # ---- the walk ends where there is no surface
            alive = np.flatnonzero(vertex.surface != NOWHERE)
            if len(alive) < len(vertex):
                vertex, d, lanes = vertex[alive], d.take(alive, axis=1), lanes.take(alive)
                throughput = throughput.take(alive, axis=1)
            wo = -d

            # ---- next event: one term of Tᵏ⁺¹E
            if self.emitters.dimensions:
                u = block.numbers(self.emitters.dimensions, lanes)
                seen, Ld = self._next_event(vertex, wo, u)
                self._record(film, k + 1, lanes.take(seen), throughput.take(seen, axis=1) * Ld, vertex[seen])

            # ---- reflection: a direction with density pdf, throughput · f cos / pdf
            sample = self.bsdf.sample(vertex, wo, block.numbers(self._lobe_dimensions, lanes))
            d, pdf, throughput = sample.wi, sample.pdf, throughput * sample.weight

            # ---- without a last bounce, chance ends the walk, and what goes on counts for more
            if bounces is None:
                throughput = roulette(throughput, k + 1, block.numbers(1, lanes)[0])
                pdf = np.where(throughput.any(axis=0), pdf, 0.0)

            # ---- the walk ends where nothing is reflected, as on backs
            alive = np.flatnonzero(pdf > 0)
            if not len(alive):
                break
            if len(alive) < len(vertex):
                vertex, d, lanes = vertex[alive], d.take(alive, axis=1), lanes.take(alive)
                pdf, throughput = pdf.take(alive), throughput.take(alive, axis=1)

    def _found(self, previous: Points, vertex: Points, d: Array, pdf: Array) -> Array:
        """Le of emitters met by chance, ``(channels, n)``, with the weight of having been found that way."""
        if self.strategy == "nee":
            weight: Array = np.isinf(pdf).astype(float)  # all but what a delta lobe has found is next event's
        else:
            weight = 1 / (1 + self.emitters.pdf(previous, vertex, d) / pdf)  # p / (p + p_next_event)
        return self.emitters.Le(vertex, -d) * weight

    def _next_event(self, vertex: Points, wo: Array, u: Array) -> tuple[Indices, Array]:
        """The lanes that see what they have chosen of an emitter, and f · cos · Li / pdf there."""
        light = self.emitters.sample(vertex, u)
        f = self.bsdf.f(vertex, light.wi, wo)
        # only pairs that see each other's front are worth a shadow ray
        facing = np.flatnonzero((f * light.Li).any(axis=0))
        vertex, light = vertex[facing], light[facing]
        visible = self.cast.visible(vertex, light.wi, light.distance, light.primitive)
        seen = np.flatnonzero(visible)
        vertex, light, lanes = vertex[seen], light[seen], facing.take(seen)
        f, wo = f.take(lanes, axis=1), wo.take(lanes, axis=1)

        pdf = light.pdf
        if self.strategy == "mis":
            pdf = pdf + ~light.delta * self.bsdf.pdf(vertex, light.wi, wo)  # w / p = 1 / (p + p_bsdf)
        cosine = np.abs(dot(vertex.ns, light.wi))
        return lanes, f * light.Li * (cosine / pdf)

    def _record(self, film: Film, bounce: int, lanes: Indices, radiance: Array, vertex: Points) -> None:
        """Add radiance to the film; refuse what is none."""
        # one sum is the cheaper test; it may overflow where no term does
        if not np.isfinite(radiance.sum()) and not np.isfinite(radiance).all():
            at = int(np.argmax(~np.isfinite(radiance).all(axis=0)))
            row, column = film.pixel(int(lanes[at]))
            i = int(vertex.surface[at])
            surface = self.scene.surfaces[i].name if i != NOWHERE else "the environment"
            raise NonFiniteRadianceError(f"bounce {bounce}, row {row}, column {column}, at {surface}: "
                                         f"found {radiance[:, at]}")  # fmt: skip
        film.add(bounce, lanes, radiance)
