"""Sound variants of the estimator: other choices, densities and weights, told alike wherever they are used."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import ArrayLike, NDArray

from comparisons.faults.fault import Plant, Sound
from comparisons.faults.next_event import prepared
from comparisons.faults.planting import Replacement, in_tracer
from comparisons.faults.throughput import ended, late, spare
from reference_tracer import propagation, sampling
from reference_tracer.bsdfs.bsdf import BSDFSample, cosine, front
from reference_tracer.emitters import area_lights
from reference_tracer.points import NOWHERE, Points
from reference_tracer.random_walk import RandomWalk
from reference_tracer.reflection import LambertianBSDF
from reference_tracer.shapes import hierarchy, parallelepipeds

Array = NDArray[np.float64]

# ---- weights


def _power_heuristic_by_chance(found: Callable[..., Array]) -> Any:
    def substitute(self: RandomWalk, previous: Points, vertex: Points, d: Array, pdf: Array) -> Array:
        if self.strategy != "mis":
            return found(self, previous, vertex, d, pdf)
        ratio = self.emitters.pdf(previous, vertex, d) / pdf
        radiance: Array = self.emitters.Le(vertex, -d) / (1 + ratio**2)
        return radiance

    return substitute


def _power_heuristic_in_next_event(next_event: Callable[..., Any]) -> Any:
    def substitute(self: RandomWalk, vertex: Points, wo: Array, u: Array) -> Any:
        if self.strategy != "mis":
            return next_event(self, vertex, wo, u)
        with patch.object(self, "strategy", "nee"):
            lanes, Ld = next_event(self, vertex, wo, u)
        light = self.emitters.sample(vertex, u)[lanes]  # the same ones: the numbers are the same
        of_chance = ~light.delta * self.bsdf.pdf(vertex[lanes], light.wi, wo[:, lanes])
        return lanes, Ld / (1 + (of_chance / light.pdf) ** 2)

    return substitute


# ---- the choice of an emitter


def _chosen_by(probability: Callable[[Array], ArrayLike]) -> Plant:
    """By a function of the share of the power that each emitter has."""

    def change(emitters: Any) -> None:
        weights = np.asarray(probability(emitters._choice))
        emitters._choice = weights / weights.sum()
        emitters._ends = np.cumsum(emitters._choice)[:-1]

    return in_tracer(prepared(change))


# ---- directions


def _uniform_directions(sample: Callable[..., BSDFSample]) -> Any:
    def substitute(self: Any, points: Points, wo: Array, u: Array) -> BSDFSample:
        wi = sampling.to_world(sampling.square_to_zone(u, 0.0, 1.0), points.ns)
        surface = front(points, wo, wi)
        albedo = self._albedo(points, surface)
        return BSDFSample(
            wi, 2 * albedo * np.maximum(cosine(points, wi), 0), (surface != NOWHERE) / (2 * np.pi)
        )

    return substitute


def _uniform_density(pdf: Callable[..., Array]) -> Any:
    def substitute(self: LambertianBSDF, points: Points, wi: Array, wo: Array) -> Array:
        seen: Array = (cosine(points, wi) > 0) * (cosine(points, wo) > 0) / (2 * np.pi)
        return seen

    return substitute


def _lifted_disk(sample: Callable[..., BSDFSample]) -> Any:
    def substitute(self: Any, points: Points, wo: Array, u: Array) -> BSDFSample:
        wi = sampling.to_world(sampling.square_to_cosine_hemisphere(u), points.ns)
        surface = front(points, wo, wi)
        density = sampling.square_to_cosine_hemisphere_pdf(cosine(points, wi)) * (surface != NOWHERE)
        return BSDFSample(wi, self._albedo(points, surface), density)

    return substitute


# ---- Russian roulette


def _ended(goes_on: float) -> Callable[[BSDFSample, Array], BSDFSample]:
    return lambda sample, u: ended(sample, spare(u) >= goes_on, 1 / goes_on)


def _ended_by_brightness(sample: BSDFSample, u: Array) -> BSDFSample:
    goes_on = np.clip(sample.weight.max(axis=0), 0.05, 1)
    return ended(sample, spare(u) >= goes_on, 1 / goes_on)


# ---- shapes


def _looks_large_from(size: float) -> Plant:
    return in_tracer(Replacement(area_lights, "LOOKS_LARGE", lambda usual: size))


def _everything_occludes(occluders: Callable[..., Any]) -> Any:
    return lambda primitives, scene: np.arange(len(primitives))


VARIANTS: tuple[Sound, ...] = (
    Sound(
        name="power-heuristic",
        what="weights by the squares of the densities, on both sides",
        plant=in_tracer(
            Replacement(RandomWalk, "_found", _power_heuristic_by_chance),
            Replacement(RandomWalk, "_next_event", _power_heuristic_in_next_event),
        ),
    ),
    Sound(
        name="lights-chosen-alike",
        what="every emitter is chosen with the same probability",
        plant=_chosen_by(lambda choice: np.ones(len(choice))),
    ),
    Sound(
        name="lights-chosen-by-root-of-power",
        what="emitters are chosen by the square root of their power",
        plant=_chosen_by(np.sqrt),
    ),
    Sound(
        name="lights-chosen-anyhow",
        what="emitters are chosen by their place in the scene",
        plant=_chosen_by(lambda choice: 1.0 + np.arange(len(choice)) % 3),
    ),
    Sound(
        name="uniform-directions",
        what="diffuse surfaces sample directions uniformly over the half space, and not by the cosine",
        plant=in_tracer(
            Replacement(LambertianBSDF, "sample", _uniform_directions),
            Replacement(LambertianBSDF, "pdf", _uniform_density),
        ),
    ),
    Sound(
        name="lifted-disk",
        what="diffuse surfaces sample directions in a frame about the normal, as points of a disk that are lifted",
        plant=in_tracer(Replacement(LambertianBSDF, "sample", _lifted_disk)),
    ),
    Sound(
        name="roulette",
        what="from bounce 3 on walks go on with the probability that their brightest channel has, and count as much "
        "more",
        plant=late(3, _ended_by_brightness),
    ),
    Sound(
        name="roulette-from-the-start",
        what="six walks of ten go on at every bounce, and count as much more",
        plant=late(1, _ended(0.6)),
    ),
    Sound(
        name="quads-by-area",
        what="quads are always sampled by area, also where they look large",
        plant=_looks_large_from(1e300),
    ),
    Sound(
        name="quads-by-solid-angle",
        what="quads are sampled by solid angle from a tenth of the usual size on",
        plant=_looks_large_from(0.05),
    ),
    Sound(
        name="no-boxes",
        what="quads are met one by one, also where they make a box",
        plant=in_tracer(Replacement(parallelepipeds, "find", lambda find: lambda centers, axes: [])),
    ),
    Sound(
        name="small-leaves",
        what="a hierarchy with two shapes in a leaf",
        plant=in_tracer(
            Replacement(hierarchy, "LEAF", lambda leaf: 2), Replacement(propagation, "LEAF", lambda leaf: 2)
        ),
    ),
    Sound(
        name="everything-occludes",
        what="every shape is asked whether it hides a light, also those that can't",
        plant=in_tracer(Replacement(propagation, "_occluders", _everything_occludes)),
    ),
)
