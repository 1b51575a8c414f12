"""Faults of the sensor and of the image: where radiance lands, and what becomes of it there.

All but three can be planted in any renderer: in the scene's camera, or in the finished image of each bounce.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from comparisons.faults.fault import Fault, Plant
from comparisons.faults.planting import Replacement, in_tracer, of_image, of_request, of_scene
from comparisons.renderers import Images, Renderer, reference
from reference_tracer import random_walk
from reference_tracer.samplers import Block
from reference_tracer.sensing import Film
from scenes import Orthographic, Pinhole, Scene, Sensor, ThinLens

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

# ---- the camera


def _of_sensor(change: Callable[[Any], Sensor]) -> Plant:
    return of_scene(lambda scene: msgspec.structs.replace(scene, sensor=change(scene.sensor)))


def _wider(sensor: Sensor, factor: float) -> Sensor:
    """The picture shows so many times as much in each direction, around its middle."""
    if isinstance(sensor, Orthographic):
        return msgspec.structs.replace(sensor, extent=factor * sensor.extent)
    if isinstance(sensor, Pinhole | ThinLens):
        half = np.arctan(factor * np.tan(np.radians(sensor.fov) / 2))
        return msgspec.structs.replace(sensor, fov=float(np.degrees(2 * half)))
    return sensor


def _across_the_larger_axis(sensor: Sensor) -> Sensor:
    return _wider(sensor, min(sensor.width, sensor.height) / max(sensor.width, sensor.height))


def _edge_to_edge(sensor: Sensor) -> float:
    """How much wider the view is where the centres of the first and the last pixel lie on its edges."""
    smaller = min(sensor.width, sensor.height)
    return smaller / (smaller - 1) if smaller > 1 else 1.0


def _aperture_by_diameter(sensor: Sensor) -> Sensor:
    if not isinstance(sensor, ThinLens):
        return sensor
    return msgspec.structs.replace(sensor, aperture_radius=2 * sensor.aperture_radius)


def _half_a_pixel_off(camera_rays: Callable[..., Any]) -> Any:
    def substitute(sensor: Sensor, block: Block) -> Any:
        return camera_rays(sensor, replace(block, position=block.position - 0.5))

    return substitute


def _vignetted(inner: Renderer, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    images, sensor = inner.render(scene, bounces, spp, seed), scene.sensor
    if not isinstance(sensor, Pinhole | ThinLens):
        return images
    row, column = np.mgrid[: sensor.height, : sensor.width] + 0.5
    d = np.einsum("ij,jyx->iyx", sensor.pixel_to_direction, np.stack([column, row, np.ones_like(row)]))
    cosine = 1 / np.linalg.norm(d, axis=0)  # along the view, d is 1
    vignetted: Images = images * cosine[..., None] ** 4
    return vignetted


# ---- the image


def _one_row_low(images: Images) -> Images:
    return np.concatenate([images[:, :1], images[:, :-1]], axis=1)


def _blurred(images: Images) -> Images:
    blurred: Images = ndimage.gaussian_filter(images, sigma=(0, 1, 1, 0), mode="nearest")
    return blurred


def _denoised(images: Images) -> Images:
    denoised: Images = ndimage.median_filter(images, size=(1, 3, 3, 1), mode="nearest")
    return denoised


def _srgb(images: Images) -> Images:
    """IEC 61966-2-1, not clamped above."""
    positive = np.maximum(images, 0)
    return np.where(positive <= 0.0031308, 12.92 * positive, 1.055 * positive ** (1 / 2.4) - 0.055)


def _with_hot_pixel(images: Images) -> Images:
    images[:, images.shape[1] // 3, images.shape[2] // 3] *= 10
    return images


def _with_black_column(images: Images) -> Images:
    images[:, :, images.shape[2] // 3] = 0
    return images


def _of_eight_bits(images: Images) -> Images:
    return np.floor(np.clip(images, 0, 1) * 255) / 255


# ---- the film


def _walks_clamped(add: Callable[..., None]) -> Any:
    def substitute(self: Film, bounce: int, lanes: Indices, radiance: Array) -> None:
        add(self, bounce, lanes, np.minimum(radiance, 10))

    return substitute


def _divided_by_one_more(mean: Callable[..., Array]) -> Any:
    return lambda self, spp: mean(self, spp + 1)


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="image-one-row-low",
        operator="sensor",
        what="every row of the image is what the row above it should be",
        plant=of_image(_one_row_low),
    ),
    Fault(
        name="half-a-pixel-off",
        operator="sensor",
        what="pixel (0, 0) is looked at around its corner, half a pixel up and to the left",
        plant=in_tracer(
            Replacement(random_walk, "camera_rays", _half_a_pixel_off),
            Replacement(reference, "camera_rays", _half_a_pixel_off),
        ),
        happened=(
            "https://github.com/raysect/source/issues/391",
            "https://github.com/NVIDIA/VisRTX/pull/327",
        ),
    ),
    Fault(
        name="angle-of-the-other-axis",
        operator="sensor",
        what="the angle of view, or the extent, is that of the larger image axis",
        plant=_of_sensor(_across_the_larger_axis),
        happened=(
            "https://github.com/tunabrain/tungsten/issues/23",
            "https://github.com/mitsuba-renderer/mitsuba-blender/issues/25",
            "https://github.com/TzuChieh/Photon-v2/issues/46",
        ),
    ),
    Fault(
        name="view-too-wide",
        operator="sensor",
        what="pixel centres go from edge to edge of the view: it is 1 part in 63 too wide for 64 pixels",
        plant=_of_sensor(lambda sensor: _wider(sensor, _edge_to_edge(sensor))),
    ),
    Fault(
        name="image-upside-down",
        operator="sensor",
        what="the first row of the image is the lowest",
        plant=of_image(lambda images: images[:, ::-1]),
    ),
    Fault(
        name="image-mirrored",
        operator="sensor",
        what="right is left",
        plant=of_image(lambda images: images[:, :, ::-1]),
    ),
    Fault(
        name="wide-filter",
        operator="sensor",
        what="pixels are averaged by a Gaussian with a standard deviation of one pixel, not over their squares",
        plant=of_image(_blurred),
    ),
    Fault(
        name="clamped-at-10",
        operator="sensor",
        what="pixels are cut off at 10",
        plant=of_image(lambda images: np.minimum(images, 10)),
    ),
    Fault(
        name="clamped-at-1",
        operator="sensor",
        what="pixels are cut off at 1",
        plant=of_image(lambda images: np.minimum(images, 1)),
    ),
    Fault(
        name="fireflies-clamped",
        operator="sensor",
        what="what a single walk finds is cut off at 10",
        plant=in_tracer(Replacement(Film, "add", _walks_clamped)),
    ),
    Fault(
        name="eight-bits",
        operator="sensor",
        what="the image goes through 8 bits, linear and rounded down",
        plant=of_image(_of_eight_bits),
    ),
    Fault(
        name="srgb-applied",
        operator="sensor",
        what="the image is encoded for a screen",
        plant=of_image(_srgb),
    ),
    Fault(
        name="channels-swapped",
        operator="sensor",
        what="red is blue: channels come in reverse order",
        plant=of_image(lambda images: images[..., ::-1]),
        happened=("https://github.com/tempo-sim/Tempo/pull/69",),
    ),
    Fault(
        name="denoised",
        operator="sensor",
        what="every pixel is the median of the 3 × 3 around it",
        plant=of_image(_denoised),
    ),
    Fault(
        name="exposure-too-high",
        operator="sensor",
        what="all is 0.7 % too bright",
        plant=of_image(lambda images: 1.007 * images),
    ),
    Fault(
        name="vignetting",
        operator="sensor",
        what="a camera's image falls off as the cos⁴ of the angle to the view, as irradiance on a film does",
        plant=of_request(_vignetted),
    ),
    Fault(
        name="hot-pixel",
        operator="sensor",
        what="one pixel is ten times as bright",
        plant=of_image(_with_hot_pixel),
    ),
    Fault(
        name="black-column",
        operator="sensor",
        what="one column of pixels is black",
        plant=of_image(_with_black_column),
    ),
    Fault(
        name="one-sample-too-many",
        operator="sensor",
        what="sums are divided by another number than that of their samples: by n + 1",
        plant=in_tracer(Replacement(Film, "mean", _divided_by_one_more)),
        happened=("https://github.com/RayTracing/raytracing.github.io/issues/1370",),
    ),
    Fault(
        name="aperture-by-diameter",
        operator="sensor",
        what="the radius of a thin lens is twice what it should be, as if a diameter had been given",
        plant=_of_sensor(_aperture_by_diameter),
        unseen="no case of the library has a thin lens",
    ),
)
