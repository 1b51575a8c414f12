"""Faults of E: what is emitted, and what the sensor and next event see of it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Fault
from comparisons.faults.planting import Replacement, in_tracer, of_request, of_scene
from comparisons.faults.scene_changes import of_area_lights, of_lights, replace
from reference_tracer import emission
from reference_tracer.emission import Emitters
from reference_tracer.emitters.area_lights import EllipsoidEmitter, FlatEmitter, ZoneEmitter
from reference_tracer.emitters.delta_lights import DeltaEmitter
from reference_tracer.emitters.environments import EnvironmentEmitter, LatitudeLongitudeMap
from reference_tracer.points import Points
from reference_tracer.vectors import dot, norm
from scenes import (
    AreaLight,
    DirectionalLight,
    Disk,
    EnvironmentMap,
    Image,
    PointLight,
    Scene,
    SpotLight,
    Surface,
)
from scenes.variations import brighter

Array = NDArray[np.float64]
Method = Callable[..., Any]


# ---- how much is emitted


def _last_channel_low(light: AreaLight) -> AreaLight:
    *others, last = light.radiance
    return replace(light, radiance=(*others, 0.99 * last))


def _by_the_cosine(light: AreaLight) -> AreaLight:
    dark, full = ((value,) * len(light.radiance) for value in (0.0, 1.0))
    return replace(light, angular_profile=(dark, full)) if light.angular_profile is None else light


def _at_most_one(light: EnvironmentMap) -> EnvironmentMap:
    return replace(light, image=Image(np.minimum(light.image.array, 1).tolist()))


# ---- lamps that emit behind


def _two_sided(area_lights: Method) -> Method:
    def made(scene: Scene) -> Any:
        lamps = area_lights(scene)
        for lamp in lamps.values():
            lamp.two_sided = True
            if isinstance(lamp, EllipsoidEmitter | ZoneEmitter):
                lamp._lit_inside = lamp._lit_outside = True
        return lamps

    return made


def _facing(points: Points, wo: Array) -> Points:
    return dataclasses.replace(points, n=points.n * np.where(dot(points.n, wo) < 0, -1, 1))


# ---- densities of lamps by the area that they had before they were scaled


def _area_before_scaling(init: Method) -> Method:
    def made(self: FlatEmitter, surface: Surface, primitive: int, shape: Any) -> None:
        init(self, surface, primitive, shape)
        if isinstance(shape, Disk):
            self.area = np.pi

    return made


def _area_by_the_scale(init: Method) -> Method:
    def made(self: FlatEmitter, surface: Surface, primitive: int, shape: Any) -> None:
        init(self, surface, primitive, shape)
        if isinstance(shape, Disk):
            self.area = float(np.sqrt(np.pi * shape.area))  # π r

    return made


def _area_of_one_radius(init: Method) -> Method:
    def made(self: FlatEmitter, surface: Surface, primitive: int, shape: Any) -> None:
        init(self, surface, primitive, shape)
        if isinstance(shape, Disk):
            self.area = np.pi * float(np.dot(shape.axis_u, shape.axis_u))

    return made


def _sample_of_the_unit_sphere(sample: Method) -> Method:
    def sampled(self: EllipsoidEmitter, reference: Any, u: Array) -> Any:
        made = sample(self, reference, u)
        made.pdf /= _stretch(self, made.wi)
        return made

    return sampled


def _pdf_of_the_unit_sphere(pdf: Method) -> Method:
    return lambda self, reference, points, wi: pdf(self, reference, points, wi) / _stretch(self, wi)


def _stretch(emitter: EllipsoidEmitter, wi: Array) -> Array:
    """The density over directions in the world over that where the ellipsoid is the unit sphere."""
    stretch: Array = 1 / (norm(emitter._inverse @ wi) ** 3 * emitter._volume)
    return stretch


# ---- environments


def _half_a_texel_off(radiance: Method) -> Method:
    """φ C / 2π counts columns from their edge; without the − ½ it is taken to count them from their centre."""

    def off(self: LatitudeLongitudeMap, d: Array) -> Any:
        x, y, z = self._axes @ d
        c, s = np.cos(np.pi / self._columns), np.sin(np.pi / self._columns)
        return radiance(self, self._axes.T @ np.stack([c * x - s * y, s * x + c * y, z]))

    return off


def _turning_the_other_way(d: Array, axes: Array) -> Array:
    turned: Array = axes.T @ (np.array([[1.0], [-1.0], [1.0]]) * (axes @ d))
    return turned


def _mirrored_sample(sample: Method) -> Method:
    def mirrored(self: LatitudeLongitudeMap, u: Array) -> tuple[Array, Array]:
        d, density = sample(self, u)
        return _turning_the_other_way(d, self._axes), density

    return mirrored


def _mirrored_look(look: Method) -> Method:
    return lambda self, d: look(self, _turning_the_other_way(d, self._axes))


def _never_chosen(sample: Method) -> Method:
    def missed(self: Any, reference: Any, u: Array) -> Any:
        made = sample(self, reference, u)
        made.Li *= ~np.isinf(made.distance)
        return made

    return missed


# ---- point, spot and directional lights


def _arriving(change: Callable[[Any, Any, Array, Array], Array | float]) -> Replacement:
    """What arrives from a light is a factor of (light, reference, wi, distance) off."""

    def changed(incident: Method) -> Method:
        def arriving(self: DeltaEmitter, reference: Any) -> tuple[Array, Array, Array]:
            wi, distance, Li = incident(self, reference)
            return wi, distance, Li * change(self.light, reference, wi, distance)

        return arriving

    return Replacement(DeltaEmitter, "incident", changed)


def _its_distance(light: Any, reference: Any, wi: Array, distance: Array) -> Array | float:
    return 1.0 if isinstance(light, DirectionalLight) else distance


def _sun_by_the_cosine(light: Any, reference: Any, wi: Array, distance: Array) -> Array | float:
    return np.maximum(dot(reference.ns, wi), 0) if isinstance(light, DirectionalLight) else 1.0


def _linear_in_the_cosine(falloff: Method) -> Method:
    def linear(self: DeltaEmitter, wi: Array) -> Any:
        light = self.light
        if not isinstance(light, SpotLight) or light.beam == light.cutoff:
            return falloff(self, wi)
        outer, inner = np.cos(np.radians([light.cutoff, light.beam]))
        return np.clip((-(np.array(light.direction) @ wi) - outer) / (inner - outer), 0, 1)

    return linear


def _smooth(falloff: Method) -> Method:
    def smooth(self: DeltaEmitter, wi: Array) -> Any:
        t = falloff(self, wi)
        return t * t * (3 - 2 * t)

    return smooth


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="lamps-invisible",
        operator="E",
        what="the sensor does not see emitters: bounce 0 is black",
        plant=of_request(
            lambda inner, scene, bounces, spp, seed: (
                inner.render(scene, bounces, spp, seed) * [[[[float(k > 0)]]] for k in bounces]
            )
        ),
    ),
    Fault(
        name="emission-high",
        operator="E",
        what="everything emits 2 % too much",
        plant=of_scene(lambda scene: brighter(scene, 1.02)),
    ),
    Fault(
        name="emission-slightly-low",
        operator="E",
        what="everything emits 0.5 % too little",
        plant=of_scene(lambda scene: brighter(scene, 0.995)),
        unseen="no case's tolerance is less than 0.5 % of the whole image: what is off by as much may pass",
    ),
    Fault(
        name="emission-of-last-channel-low",
        operator="E",
        what="lamps emit 1 % too little in their last channel",
        plant=of_area_lights(_last_channel_low),
    ),
    Fault(
        name="radiance-taken-for-exitance",
        operator="E",
        what="the radiance of lamps is taken for their exitance, and divided by π",
        plant=of_area_lights(lambda lamp: replace(lamp, radiance=tuple(L / np.pi for L in lamp.radiance))),
    ),
    Fault(
        name="lamps-emit-behind",
        operator="E",
        what="one-sided lamps emit on both sides",
        plant=in_tracer(
            Replacement(emission, "area_lights", _two_sided),
            Replacement(
                Emitters, "Le", lambda Le: lambda self, points, wo: Le(self, _facing(points, wo), wo)
            ),
            Replacement(
                Emitters,
                "pdf",
                lambda pdf: (
                    lambda self, reference, points, wi: pdf(self, reference, _facing(points, -wi), wi)
                ),
            ),
        ),
        happened=("https://github.com/gkjohnson/three-gpu-pathtracer/issues/379",),
    ),
    Fault(
        name="lamps-emit-by-the-cosine",
        operator="E",
        what="the radiance of lamps falls with the cosine of the angle, which geometry already accounts for",
        plant=of_area_lights(_by_the_cosine),
    ),
    Fault(
        name="lamp-profile-ignored",
        operator="E",
        what="lamps with an angular profile emit the same in every direction",
        plant=of_area_lights(lambda lamp: replace(lamp, angular_profile=None)),
    ),
    Fault(
        name="disk-area-before-scaling",
        operator="E",
        what="points of a disk have the density of the unit disk that it was before it was scaled",
        plant=in_tracer(Replacement(FlatEmitter, "__init__", _area_before_scaling)),
        happened=("https://github.com/mmp/pbrt-v4/issues/494",),
    ),
    Fault(
        name="disk-area-by-the-scale",
        operator="E",
        what="the area of a disk that was scaled by r is π r",
        plant=in_tracer(Replacement(FlatEmitter, "__init__", _area_by_the_scale)),
    ),
    Fault(
        name="disk-area-of-one-radius",
        operator="E",
        what="the area of a disk is that of a circle, whose radius is the first of its axes",
        plant=in_tracer(Replacement(FlatEmitter, "__init__", _area_of_one_radius)),
    ),
    Fault(
        name="ellipsoid-density-before-scaling",
        operator="E",
        what="directions to an ellipsoid have the density that they have where it is the unit sphere",
        plant=in_tracer(
            Replacement(EllipsoidEmitter, "_sample", _sample_of_the_unit_sphere),
            Replacement(EllipsoidEmitter, "pdf", _pdf_of_the_unit_sphere),
        ),
    ),
    Fault(
        name="environment-half-texel-off",
        operator="E",
        what="environment maps are looked up half a column too far",
        plant=in_tracer(Replacement(LatitudeLongitudeMap, "radiance", _half_a_texel_off)),
        happened=("https://github.com/gkjohnson/three-gpu-pathtracer/issues/369",),
    ),
    Fault(
        name="environment-mirrored",
        operator="E",
        what="the longitude of environment maps grows the other way round",
        plant=in_tracer(
            Replacement(LatitudeLongitudeMap, "radiance", _mirrored_look),
            Replacement(LatitudeLongitudeMap, "square_to_direction", _mirrored_sample),
            Replacement(LatitudeLongitudeMap, "square_to_direction_pdf", _mirrored_look),
        ),
        happened=("https://github.com/Hi-Rez/Satin/issues/50",),
    ),
    Fault(
        name="environment-clamped-at-1",
        operator="E",
        what="environment maps are read as pictures, whose values end at 1",
        plant=of_lights(EnvironmentMap, change=_at_most_one),
        happened=("https://github.com/KhronosGroup/glTF-Sample-Viewer/issues/174",),
    ),
    Fault(
        name="infinite-lights-missed",
        operator="E",
        what="next event never looks at what is infinitely far, though weights take it to",
        plant=in_tracer(
            Replacement(EnvironmentEmitter, "sample", _never_chosen),
            Replacement(DeltaEmitter, "sample", _never_chosen),
        ),
    ),
    Fault(
        name="point-intensity-taken-for-power",
        operator="E",
        what="the intensity of point lights is taken for their power, and divided by 4π",
        plant=of_lights(
            PointLight,
            change=lambda light: replace(
                light,
                intensity=tuple(I / (4 * np.pi) for I in light.intensity),  # noqa: E741
            ),
        ),
        happened=("https://github.com/PearCoding/Ignis/issues/27",),
    ),
    Fault(
        name="point-falls-with-distance",
        operator="E",
        what="light of point and spot lights falls with the distance, not with its square",
        plant=in_tracer(_arriving(_its_distance)),
    ),
    Fault(
        name="spot-linear-in-cosine",
        operator="E",
        what="the fall-off of spots is linear in the cosine of the angle, not in the angle",
        plant=in_tracer(Replacement(DeltaEmitter, "_falloff", _linear_in_the_cosine)),
    ),
    Fault(
        name="spot-smooth",
        operator="E",
        what="the fall-off of spots is a smooth step, not linear",
        plant=in_tracer(Replacement(DeltaEmitter, "_falloff", _smooth)),
        happened=("https://github.com/KhronosGroup/glTF-Sample-Viewer/issues/486",),
    ),
    Fault(
        name="spot-half-as-wide",
        operator="E",
        what="the half angles of spots are taken for full ones",
        plant=of_lights(
            SpotLight,
            change=lambda spot: replace(spot, cutoff=spot.cutoff / 2, beam=spot.beam / 2),
        ),
        happened=("https://github.com/google/filament/pull/2340",),
    ),
    Fault(
        name="sun-with-two-cosines",
        operator="E",
        what="the irradiance of directional lights is multiplied by the cosine at the surface twice",
        plant=in_tracer(_arriving(_sun_by_the_cosine)),
    ),
)
