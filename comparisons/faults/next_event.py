"""Faults of the estimator that lie in next event: which emitter it chooses, and with what density a direction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Fault
from comparisons.faults.planting import Replacement, in_tracer
from reference_tracer import random_walk
from reference_tracer.emission import Emitters
from reference_tracer.emitters.area_lights import EllipsoidEmitter, FlatEmitter, MeshEmitter
from reference_tracer.emitters.delta_lights import DeltaEmitter
from reference_tracer.emitters.emitter_sample import EmitterSample
from reference_tracer.emitters.environments import LatitudeLongitudeMap
from reference_tracer.points import NOWHERE, Points
from reference_tracer.vectors import norm

Array = NDArray[np.float64]

# ---- the choice of an emitter


def prepared(change: Callable[[Any], None]) -> Replacement:
    """The tables of the choice, ``_choice`` and ``_ends``, are changed when they are made."""

    def made_of(prepare: Callable[..., None]) -> Any:
        def substitute(self: Emitters, deltas: list[DeltaEmitter], delta_only: bool) -> None:
            prepare(self, deltas, delta_only)
            change(self)

        return substitute

    return Replacement(Emitters, "_prepare_choice", made_of)


def _forgotten(emitters: Any) -> None:
    emitters._choice = np.ones_like(emitters._choice)


def _uniform(emitters: Any) -> None:
    count = len(emitters._choice)
    emitters._ends = np.arange(1, count) / max(count, 1)


class _Brighter:
    """An emitter that next event finds so many times as bright."""

    def __init__(self, emitter: Any, factor: float) -> None:
        self._emitter, self._factor = emitter, factor

    def __getattr__(self, name: str) -> Any:
        return getattr(self._emitter, name)

    def sample(self, reference: Points, u: Array) -> EmitterSample:
        """The same direction and density."""
        sample: EmitterSample = self._emitter.sample(reference, u)
        return replace(sample, Li=sample.Li * self._factor)


def _outside_of_weights(emitters: Any) -> None:
    """What is divided by the probability of the choice is the radiance, and not the density."""
    if len(emitters._emitters) > 1:
        pairs = zip(emitters._emitters, emitters._choice, strict=True)
        emitters._emitters = [_Brighter(emitter, 1 / choice) for emitter, choice in pairs]
        _forgotten(emitters)


def _without_the_choice(pdf: Callable[..., Array]) -> Any:
    def substitute(self: Any, reference: Points, points: Points, wi: Array) -> Array:
        with patch.object(self, "_choice", np.ones_like(self._choice)):
            return pdf(self, reference, points, wi)

    return substitute


# ---- densities of next event


def _doubled(sample: Callable[..., EmitterSample]) -> Any:
    def substitute(self: Emitters, reference: Points, u: Array) -> EmitterSample:
        found = sample(self, reference, u)
        return replace(found, pdf=np.where(found.delta, 1, 2) * found.pdf)

    return substitute


def _as_if_it_had_an_extent(sample: Callable[..., EmitterSample]) -> Any:
    def substitute(self: DeltaEmitter, reference: Points, u: Array) -> EmitterSample:
        return replace(sample(self, reference, u), delta=False)

    return substitute


def _area_density_times(
    factor: Callable[[Array, Array], Array], only_in_weights: bool = False
) -> tuple[Replacement, ...]:
    """The density of flat emitters, where it is one by area, is multiplied by a function of cos θ and distance."""

    def by_area(self: Any, reference: Points, distance: Array) -> Array:
        offset = reference.x - self._center
        height = np.abs(self._axes[2] @ offset)
        lit = self._seen(self._axes[2] @ offset) & (reference.primitive != self.primitive)
        factors = factor(np.where(lit, height / distance, 1), np.where(lit, distance, 1))
        factors[self._by_solid_angle(offset, lit)[0]] = 1
        return factors

    def sampling(sample: Callable[..., EmitterSample]) -> Any:
        def substitute(self: Any, reference: Points, u: Array) -> EmitterSample:
            found = sample(self, reference, u)
            return replace(found, pdf=found.pdf * by_area(self, reference, found.distance))

        return substitute

    def density(pdf: Callable[..., Array]) -> Any:
        def substitute(self: Any, reference: Points, points: Points, wi: Array) -> Array:
            distance = np.maximum(norm(points.x - reference.x), 1e-300)
            return pdf(self, reference, points, wi) * by_area(self, reference, distance)

        return substitute

    both = Replacement(FlatEmitter, "_sample", sampling), Replacement(FlatEmitter, "pdf", density)
    return both[1:] if only_in_weights else both


def _as_rounded(pdf: Callable[..., Array]) -> Any:
    """A point of the sphere itself counts as outside of it where its distance from the centre is rounded up."""

    def substitute(self: Any, reference: Points, points: Points, wi: Array) -> Array:
        o = self._inverse @ (reference.x - self._center)
        anywhere = np.where((o * o).sum(axis=0) > 1, NOWHERE, reference.primitive)
        return pdf(self, replace(reference, primitive=anywhere), points, wi)

    return substitute


def _by_area_alone(pdf: Callable[..., Array]) -> Any:
    def substitute(self: FlatEmitter, reference: Points, points: Points, wi: Array) -> Array:
        with patch.object(self, "_near", None):
            return pdf(self, reference, points, wi)

    return substitute


def _of_the_triangle_alone(sample: Callable[..., EmitterSample]) -> Any:
    def substitute(self: Any, reference: Points, u: Array) -> EmitterSample:
        found = sample(self, reference, u)
        return replace(found, pdf=found.pdf / self._shares[found.primitive - self.primitive])

    return substitute


def _density_of_the_triangle_alone(pdf: Callable[..., Array]) -> Any:
    def substitute(self: Any, reference: Points, points: Points, wi: Array) -> Array:
        within: Array = pdf(self, reference, points, wi) / self._shares[points.primitive - self.primitive]
        return within

    return substitute


def _sine(environment: Any, d: Array) -> Array:
    """Of the polar angle, in which the map is narrow at its poles."""
    x, y, _ = environment._axes @ d
    sine: Array = np.hypot(x, y)
    return sine


def _directions_without_sine(square_to_direction: Callable[..., tuple[Array, Array]]) -> Any:
    def substitute(self: LatitudeLongitudeMap, u: Array) -> tuple[Array, Array]:
        d, density = square_to_direction(self, u)
        return d, density * _sine(self, d)

    return substitute


def _density_without_sine(square_to_direction_pdf: Callable[..., Array]) -> Any:
    def substitute(self: LatitudeLongitudeMap, d: Array) -> Array:
        density: Array = square_to_direction_pdf(self, d) * _sine(self, d)
        return density

    return substitute


def _ones(dot: Callable[..., Array]) -> Any:
    return lambda a, b: np.ones(a.shape[1])


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="light-choice-forgotten",
        operator="estimator",
        what="one emitter is chosen among several, and its density is not multiplied by that probability",
        plant=in_tracer(prepared(_forgotten)),
    ),
    Fault(
        name="light-choice-forgotten-in-weights",
        operator="estimator",
        what="the weight of what is found by chance forgets that next event chooses among several emitters",
        plant=in_tracer(Replacement(Emitters, "pdf", _without_the_choice)),
        happened=("https://github.com/BachiLi/redner/issues/56",),
    ),
    Fault(
        name="light-choice-uniform",
        operator="estimator",
        what="all emitters are chosen alike, and divided by probabilities that go by power",
        plant=in_tracer(prepared(_uniform)),
    ),
    Fault(
        name="light-choice-outside-of-weights",
        operator="estimator",
        what="both weights forget the choice of the emitter; the estimate itself does not",
        plant=in_tracer(prepared(_outside_of_weights)),
        unseen="unbiased: weights that sum to one give the right mean, whatever they are made of; noise grows",
    ),
    Fault(
        name="point-lights-weighted",
        operator="estimator",
        what="point, spot and directional lights share their light with chance, which never finds them",
        plant=in_tracer(Replacement(DeltaEmitter, "sample", _as_if_it_had_an_extent)),
        happened=(
            "https://github.com/nvpro-samples/vk_gltf_renderer/issues/38",
            "https://github.com/bevyengine/bevy/issues/21967",
        ),
    ),
    Fault(
        name="next-event-density-doubled",
        operator="estimator",
        what="next event divides by twice its density, as if both sides of a lamp could be chosen",
        plant=in_tracer(Replacement(Emitters, "sample", _doubled)),
    ),
    Fault(
        name="next-event-without-cosine",
        operator="estimator",
        what="next event is not multiplied by cos θ at the surface",
        plant=in_tracer(Replacement(random_walk, "dot", _ones)),
    ),
    Fault(
        name="area-density-without-cosine",
        operator="estimator",
        what="the density by area of a flat lamp becomes one of directions by t², and cos θ of the lamp is forgotten",
        plant=in_tracer(*_area_density_times(lambda cos, t: cos)),
    ),
    Fault(
        name="area-density-without-distance",
        operator="estimator",
        what="the density by area of a flat lamp becomes one of directions by 1 / cos θ, and t² is forgotten",
        plant=in_tracer(*_area_density_times(lambda cos, t: 1 / t**2)),
    ),
    Fault(
        name="area-density-converted-twice",
        operator="estimator",
        what="the density by area of a flat lamp is multiplied by t² / cos θ, and then once more",
        plant=in_tracer(*_area_density_times(lambda cos, t: t**2 / cos)),
        happened=("https://github.com/GPUOpen-LibrariesAndSDKs/RadeonProRender-Baikal/issues/82",),
    ),
    Fault(
        name="areas-weighed-against-angles",
        operator="estimator",
        what="in the weight of what is found by chance a flat lamp's density is 1 / area, the other one per sr",
        plant=in_tracer(*_area_density_times(lambda cos, t: cos / t**2, only_in_weights=True)),
        happened=("https://github.com/bevyengine/bevy/pull/24671",),
    ),
    Fault(
        name="sphere-density-from-inside",
        operator="estimator",
        what="points on a sphere that emits inwards have the density of the cone seen from outside, where rounding "
        "puts them there",
        plant=in_tracer(Replacement(EllipsoidEmitter, "pdf", _as_rounded)),
    ),
    Fault(
        name="solid-angle-in-sampling-alone",
        operator="estimator",
        what="a quad that looks large is chosen by solid angle, and the weight of chance has its density by area",
        plant=in_tracer(Replacement(FlatEmitter, "pdf", _by_area_alone)),
    ),
    Fault(
        name="triangle-for-mesh",
        operator="estimator",
        what="a triangle of a mesh is chosen, and the density is that within the triangle",
        plant=in_tracer(
            Replacement(MeshEmitter, "_sample", _of_the_triangle_alone),
            Replacement(MeshEmitter, "pdf", _density_of_the_triangle_alone),
        ),
    ),
    Fault(
        name="environment-density-without-sine",
        operator="estimator",
        what="the density of an environment map is one of texels: it is not divided by sin θ",
        plant=in_tracer(
            Replacement(LatitudeLongitudeMap, "square_to_direction", _directions_without_sine),
            Replacement(LatitudeLongitudeMap, "square_to_direction_pdf", _density_without_sine),
        ),
    ),
)
