"""Mitsuba 3, variant ``scalar_rgb``, integrator ``path``.

Conventions that are translated here, and nowhere else:

- ``max_depth = d`` holds bounces 0 … d − 1, so TᵏE is the difference of depths k + 1 and k. Both are rendered
  one sample at a time with the sampler ``independent`` and the same seed: each pixel then restarts the same
  stream of random numbers at every depth, the two share their paths, and the difference is the single term
  with the noise of that term alone.
- A sphere whose front is its inside has ``flip_normals``. A zone of emission is a texture of one column whose
  rows are equal steps of the polar angle.
- Mitsuba's camera looks along +z with x to the left, ``look_at`` takes care of it.

Switched off, because it makes an image inexact on purpose: Russian roulette (``rr_depth``), the Gaussian
reconstruction filter (``box``) and half-precision output.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from comparisons.renderers.protocol import Images, Unsupported
from scenes import AreaLight, Lambertian, Material, Pinhole, Quad, Scene, Sensor, Sphere, Surface

Array = NDArray[np.float64]

_NO_ROULETTE = 1 << 30


class MitsubaRenderer:
    """Mitsuba 3 in one of its variants."""

    def __init__(self, variant: str) -> None:
        import drjit
        import mitsuba

        mitsuba.set_variant(variant)
        mitsuba.set_log_level(mitsuba.LogLevel.Warn)
        drjit.set_thread_count(1)  # work is split over processes, by replicate
        self._mi: Any = mitsuba
        self._load = lru_cache(maxsize=1)(self._load_scene)

    def version(self) -> str:
        """Of Mitsuba."""
        return str(self._mi.__version__)

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        """Coupled differences of depths, averaged over one-sample renders; see the protocol.

        Mitsuba's scalar sampler starts the stream of a pixel at the state pixel + seed × pixels, modulo 2³².
        Streams of consecutive states begin alike: with consecutive seeds, a sample each, the errors of TE form
        a lattice over the image. So seeds are drawn at random; now and then one comes twice, which does no
        harm.
        """
        mi_scene = self._load(scene)
        depths = sorted({d for k in bounces for d in (k, k + 1)} - {0})  # depth 0 holds nothing
        paths = {d: self._path(d) for d in depths}
        height, width, _ = scene.shape
        streams = np.random.default_rng(seed).integers(2**32 // (height * width), size=spp)
        total, sums = np.zeros((len(bounces), *scene.shape)), np.zeros(len(bounces))
        for stream in map(int, streams):
            partial_sums = {0: np.zeros(scene.shape)} | {
                d: np.array(self._mi.render(mi_scene, integrator=path, spp=1, seed=stream), dtype=np.float64)
                for d, path in paths.items()
            }
            total += np.array([partial_sums[k + 1] - partial_sums[k] for k in bounces])
            sums += np.array([partial_sums[k + 1].mean() for k in bounces])
        _refuse_cancellation(bounces, total.mean(axis=(1, 2, 3)), sums)
        return total / spp

    def _path(self, depth: int) -> Any:
        return self._mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": _NO_ROULETTE})

    def _load_scene(self, scene: Scene) -> Any:
        return self._mi.load_dict(scene_dict(self._mi, scene))


def _refuse_cancellation(bounces: Sequence[int], terms: Array, sums: Array) -> None:
    """Refuse terms so small that single precision can't hold them as a difference of two sums.

    A sum is rounded to 2⁻²⁴ of itself, so a term of 2⁻¹³ of the sum is exact to 2⁻¹¹, a twentieth of a percent.
    A term that is exactly 0 is judged: a lost bounce must fail, not be refused.

    Raises:
        Unsupported: naming the bounce.
    """
    for k, term, partial_sum in zip(bounces, terms, sums, strict=True):
        if 0 < abs(term) < 2**-13 * partial_sum:
            share = term / partial_sum
            raise Unsupported(
                f"bounce {k}, {share:.0e} of the sum: too little for a difference in single precision"
            )


def scene_dict(mi: Any, scene: Scene) -> dict[str, Any]:
    """The scene as Mitsuba's dictionary.

    Raises:
        Unsupported: naming the feature that Mitsuba, in this variant, does not have.
    """
    if scene.channels != 3:
        raise Unsupported(f"{scene.channels} channels: scalar_rgb has 3")
    for light in scene.lights:
        raise Unsupported(f"{_type(light)} light: {_NOT_YET}")
    return {
        "type": "scene",
        "sensor": _sensor(mi, scene.sensor),
        # numbered, since Mitsuba does not take every name
        **{f"surface{i}": _surface(mi, surface) for i, surface in enumerate(scene.surfaces)},
    }


_NOT_YET = "the adapter does not translate it yet"


def _type(part: msgspec.Struct) -> str:
    """What a part of a scene is called in JSON."""
    return str(part.__struct_config__.tag)


def _sensor(mi: Any, sensor: Sensor) -> dict[str, Any]:
    if not isinstance(sensor, Pinhole):
        raise Unsupported(f"{_type(sensor)} sensor: {_NOT_YET}")
    return {
        "type": "perspective",
        "fov_axis": "smaller",
        "fov": sensor.fov,
        "near_clip": 1e-6 * math.dist(sensor.origin, sensor.target),
        "to_world": mi.ScalarTransform4f().look_at(
            origin=list(sensor.origin), target=list(sensor.target), up=list(sensor.up)
        ),
        "film": {
            "type": "hdrfilm",
            "width": sensor.width,
            "height": sensor.height,
            "rfilter": {"type": "box"},
            "pixel_format": "rgb",
            "component_format": "float32",
        },
        "sampler": {"type": "independent"},
    }


def _surface(mi: Any, surface: Surface) -> dict[str, Any]:
    if surface.two_sided:
        raise Unsupported(f"two-sided surface: {_NOT_YET}")
    match surface.shape:
        case Quad():
            shape = _quad(mi, surface.shape)
        case Sphere():
            shape = _sphere(mi, surface)
        case _:
            raise Unsupported(f"{_type(surface.shape)} shape: {_NOT_YET}")
    shape["bsdf"] = _bsdf(surface.material)
    if surface.emission is not None:
        shape["emitter"] = {"type": "area", "radiance": _radiance(mi, surface.emission)}
    return shape


def _bsdf(material: Material) -> dict[str, Any]:
    if not isinstance(material, Lambertian):
        raise Unsupported(f"{_type(material)} material: {_NOT_YET}")
    if not isinstance(material.albedo, tuple):
        raise Unsupported(f"{_type(material.albedo)} texture: {_NOT_YET}")
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(material.albedo)}}


def _quad(mi: Any, quad: Quad) -> dict[str, Any]:
    """Mitsuba's rectangle is [−1, 1]² with normal +z."""
    if not quad.is_rectangle:
        raise Unsupported("a parallelogram that is no rectangle: Mitsuba's rectangle refuses shear")
    u, v = np.asarray(quad.edge_u) / 2, np.asarray(quad.edge_v) / 2
    matrix = np.eye(4)
    matrix[:3] = np.stack([u, v, quad.normal, np.asarray(quad.corner) + u + v], axis=1)
    return {"type": "rectangle", "to_world": mi.ScalarTransform4f(matrix)}


def _sphere(mi: Any, surface: Surface) -> dict[str, Any]:
    """A sphere, its polar axis turned to that of the zone that emits."""
    assert isinstance(surface.shape, Sphere)
    zone = surface.emission.polar_range if surface.emission else None
    z = np.asarray(zone.axis if zone else (0.0, 0.0, 1.0))
    x = np.cross(np.eye(3)[np.abs(z).argmin()], z)
    x /= np.linalg.norm(x)
    matrix = np.eye(4)
    matrix[:3, :3] = surface.shape.radius * np.stack([x, np.cross(z, x), z], axis=1)
    matrix[:3, 3] = surface.shape.center
    return {
        "type": "sphere",
        "to_world": mi.ScalarTransform4f(matrix),
        "flip_normals": surface.shape.inward,
    }


def _radiance(mi: Any, light: AreaLight) -> dict[str, Any]:
    if light.polar_range is None:
        return {"type": "rgb", "value": list(light.radiance)}
    return {
        "type": "bitmap",
        "bitmap": mi.Bitmap(zone_texture(light)),
        "raw": True,
        "filter_type": "nearest",
        "wrap_mode": "clamp",
    }


def zone_texture(light: AreaLight) -> np.ndarray[Any, np.dtype[np.float32]]:
    """Radiance over the polar angle, in as few equal steps as have a border at both limits, ``(steps, 1, 3)``.

    Raises:
        Unsupported: no number of steps up to 3,600 has; the limits are no multiples of a twentieth degree.
    """
    zone = light.polar_range
    assert zone is not None
    for steps in range(1, 3601):
        first, last = zone.low / 180 * steps, zone.high / 180 * steps
        if max(abs(first - round(first)), abs(last - round(last))) < 1e-9:
            texture = np.zeros((steps, 1, 3), dtype=np.float32)
            texture[round(first) : round(last)] = light.radiance
            return texture
    raise Unsupported(f"emission between {zone.low}° and {zone.high}°: no texture has borders there")
