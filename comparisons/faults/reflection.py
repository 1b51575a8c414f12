"""Faults of R: what surfaces reflect. Those of glass and metal are in ``glass_and_metal``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from comparisons.faults import glass_and_metal
from comparisons.faults.fault import Fault, Plant
from comparisons.faults.planting import Replacement, in_tracer, of_request
from comparisons.faults.scene_changes import of_albedos, of_materials, replace
from reference_tracer.bsdfs.bsdf import cosine
from reference_tracer.points import Points
from reference_tracer.reflection import BlendBSDF, LambertianBSDF
from reference_tracer.shapes.coordinates import Coordinates
from reference_tracer.vectors import TINY
from scenes import Blend, ImageTexture, Lambertian, Mirror
from scenes.materials import has_dielectric

Array = NDArray[np.float64]
Method = Callable[..., Any]
Factor = Callable[[Points, Array, Array], Array]

LEAST_COSINE = 0.1

# ---- f of a Lambertian surface, where next event evaluates it, and where a walk goes on


def _lambertian(factor: Factor) -> Plant:
    """f is a factor of (points, wi, wo) off, and with it the weight f cos / pdf of samples."""

    def evaluate(f: Method) -> Method:
        return lambda self, points, wi, wo: f(self, points, wi, wo) * factor(points, wi, wo)

    def draw(sample: Method) -> Method:
        def drawn(self: LambertianBSDF, points: Points, wo: Array, u: Array) -> Any:
            made = sample(self, points, wo, u)
            made.weight *= factor(points, made.wi, wo)
            return made

        return drawn

    return in_tracer(Replacement(LambertianBSDF, "f", evaluate), Replacement(LambertianBSDF, "sample", draw))


def _one_over_cos_i(points: Points, wi: Array, wo: Array) -> Array:
    return 1 / np.maximum(cosine(points, wi), TINY)


def _cos_i(points: Points, wi: Array, wo: Array) -> Array:
    return np.maximum(cosine(points, wi), 0)


def _cos_o_over_cos_i(points: Points, wi: Array, wo: Array) -> Array:
    return cosine(points, wo) / np.maximum(cosine(points, wi), TINY)


def _clamped_cos_i(points: Points, wi: Array, wo: Array) -> Array:
    cos_i = np.maximum(cosine(points, wi), TINY)
    return np.maximum(cos_i, LEAST_COSINE) / cos_i


# ---- albedos


def _encoded(linear: Array) -> Array:
    """The sRGB curve (IEC 61966-2-1)."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def _decoded(encoded: Array) -> Array:
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def _first_channel_high(albedo: Array) -> Array:
    albedo = albedo.copy()
    albedo[..., 0] = np.minimum(1.01 * albedo[..., 0], 1)
    return albedo


def _upside_down(material: Lambertian) -> Lambertian:
    if not isinstance(material.albedo, ImageTexture):
        return material
    image = replace(material.albedo.image, pixels=material.albedo.image.pixels[::-1])
    return Lambertian(replace(material.albedo, image=image))


def _blurred(material: Lambertian) -> Lambertian:
    if not isinstance(material.albedo, ImageTexture):
        return material
    return Lambertian(replace(material.albedo, interpolation="bilinear"))


# ---- which side reflects


def _both_sides(init: Method) -> Method:
    """What is met from behind turns its normal round, as two-sided surfaces do; lamps stay as they are."""

    def made(self: Coordinates, scene: Any, primitives: Any) -> None:
        init(self, scene, primitives)
        self._two_sided[:-1] |= [not s.emits and not has_dielectric(s.material) for s in scene.surfaces]

    return made


# ---- blends


def _density_of_one_lobe(sample: Method) -> Method:
    """The direction is drawn as it should be, but the walk knows the density of the lobe alone that drew it."""

    def drawn(self: BlendBSDF, points: Points, wo: Array, u: Array) -> Any:
        made = sample(self, points, wo, u)
        lanes = np.flatnonzero((made.pdf > 0) & np.isfinite(made.pdf))
        at, wi, wo = points[lanes], made.wi[:, lanes], wo[:, lanes]
        second = u[2, lanes] < self._w.take(at.surface)
        pdf = np.where(second, self._second.pdf(at, wi, wo), self._first.pdf(at, wi, wo))
        made.weight[:, lanes] *= made.pdf[lanes] / pdf
        made.pdf[lanes] = pdf
        return made

    return drawn


def _value_of_one_lobe(f: Method) -> Method:
    """Next event sees the first of the two alone."""

    def first(self: BlendBSDF, points: Points, wi: Array, wo: Array) -> Any:
        return (1 - self._w.take(points.surface)) * self._first.f(points, wi, wo)

    return first


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="lambertian-without-pi",
        operator="R",
        what="f of a Lambertian surface is its albedo, not albedo / π",
        plant=_lambertian(lambda points, wi, wo: np.full(len(points), np.pi)),
        happened=("https://github.com/Patryk27/strolle/pull/34",),
    ),
    Fault(
        name="cosine-missing",
        operator="R",
        what="the cosine at the surface is forgotten",
        plant=_lambertian(_one_over_cos_i),
        happened=("https://github.com/godotengine/godot/pull/11748",),
    ),
    Fault(
        name="cosine-squared",
        operator="R",
        what="f of a Lambertian surface has the cosine in it, and is multiplied by it again",
        plant=_lambertian(_cos_i),
        happened=("https://github.com/RayTracing/raytracing.github.io/issues/145",),
    ),
    Fault(
        name="cosine-of-wo",
        operator="R",
        what="the cosine is that of the direction to the viewer, not to the light",
        plant=_lambertian(_cos_o_over_cos_i),
    ),
    Fault(
        name="cosine-clamped",
        operator="R",
        what="cosines below 0.1 are taken to be 0.1, which makes energy",
        plant=_lambertian(_clamped_cos_i),
    ),
    Fault(
        name="albedo-gamma-encoded",
        operator="R",
        what="albedos go through the sRGB curve, and come out brighter",
        plant=of_albedos(_encoded),
    ),
    Fault(
        name="albedo-gamma-decoded",
        operator="R",
        what="albedos are taken for sRGB codes, and come out darker",
        plant=of_albedos(_decoded),
        happened=("https://github.com/decentraland/godot-explorer/issues/2900",),
    ),
    Fault(
        name="albedo-of-next-channel",
        operator="R",
        what="each channel has the albedo of the one before it",
        plant=of_albedos(lambda albedo: np.roll(albedo, 1, axis=-1)),
    ),
    Fault(
        name="albedo-of-first-channel-high",
        operator="R",
        what="albedos are 1 % too high in the first channel",
        plant=of_albedos(_first_channel_high),
    ),
    Fault(
        name="albedo-slightly-low",
        operator="R",
        what="albedos are 0.5 % too low",
        plant=of_albedos(lambda albedo: 0.995 * albedo),
    ),
    Fault(
        name="albedo-in-8-bits",
        operator="R",
        what="albedos are cut down to multiples of 1/255",
        plant=of_albedos(lambda albedo: np.floor(255 * albedo) / 255),
    ),
    Fault(
        name="late-reflections-low",
        operator="R",
        what="from the third bounce on, 1 % is lost",
        plant=of_request(
            lambda inner, scene, bounces, spp, seed: (
                inner.render(scene, bounces, spp, seed) * [[[[0.99 if k >= 3 else 1.0]]] for k in bounces]
            )
        ),
    ),
    Fault(
        name="texture-upside-down",
        operator="R",
        what="v grows downwards in textures that are images",
        plant=of_materials(Lambertian, change=_upside_down),
        happened=("https://github.com/mitsuba-renderer/mitsuba-blender/issues/50",),
    ),
    Fault(
        name="texture-blurred",
        operator="R",
        what="textures are interpolated where the nearest pixel was asked for",
        plant=of_materials(Lambertian, change=_blurred),
    ),
    Fault(
        name="surfaces-reflect-behind",
        operator="R",
        what="one-sided surfaces reflect on both sides",
        plant=in_tracer(Replacement(Coordinates, "__init__", _both_sides)),
    ),
    Fault(
        name="mirror-reflectance-twice",
        operator="R",
        what="the reflectance of mirrors is applied twice",
        plant=of_materials(
            Mirror, change=lambda mirror: Mirror(tuple(share * share for share in mirror.reflectance))
        ),
    ),
    Fault(
        name="blend-weights-swapped",
        operator="R",
        what="the weight of a blend is that of its first material",
        plant=of_materials(
            Blend, change=lambda blend: msgspec.structs.replace(blend, weight=1 - blend.weight)
        ),
        happened=("https://github.com/mitsuba-renderer/mitsuba3/issues/106",),
    ),
    Fault(
        name="blend-density-of-one-lobe",
        operator="R",
        what="a direction that a blend has drawn has the density of the lobe that drew it, not of the blend",
        plant=in_tracer(Replacement(BlendBSDF, "sample", _density_of_one_lobe)),
        happened=("https://github.com/mitsuba-renderer/mitsuba3/pull/1681",),
    ),
    Fault(
        name="blend-value-of-one-lobe",
        operator="R",
        what="next event evaluates the first material of a blend alone",
        plant=in_tracer(Replacement(BlendBSDF, "f", _value_of_one_lobe)),
    ),
    *glass_and_metal.FAULTS,
)
