"""The sensor: rays through the image, and the mean over each pixel (the box filter, sampled)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference_tracer import sampling
from reference_tracer.points import Points
from reference_tracer.samplers import Block
from reference_tracer.vectors import unit
from scenes import IrradianceMeter, Orthographic, Pinhole, RadianceMeter, Sensor, ThinLens

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass
class CameraRays:
    """Rays of a sensor.

    Attributes:
        origin: where they start, n points.
        d: unit directions, ``(3, n)``.
        weight: what the radiance along a ray counts for in its pixel's mean.
    """

    origin: Points
    d: Array
    weight: float = 1.0


def sensor_dimensions(sensor: Sensor) -> int:
    """Random numbers that a ray takes beside its position in the image."""
    return 2 if isinstance(sensor, ThinLens | IrradianceMeter) else 0


def camera_rays(sensor: Sensor, block: Block) -> CameraRays:
    """The rays of a block of walks."""
    count = block.position.shape[1]
    u = block.numbers(sensor_dimensions(sensor), np.arange(count))
    image = np.stack([*block.position, np.ones(count)])
    origin = np.tile(np.array(sensor.origin)[:, None], count)
    if isinstance(sensor, Pinhole):
        return CameraRays(Points.nowhere(origin), unit(sensor.pixel_to_direction @ image))
    if isinstance(sensor, ThinLens):
        # every ray from the lens to the point of focus stands for the one through the centre
        focus = sensor.focus_distance * (sensor.pixel_to_direction @ image)
        disk = sensor.aperture_radius * sampling.square_to_disk(u)
        lens = sensor.frame[:, :2] @ disk
        return CameraRays(Points.nowhere(origin + lens), unit(focus - lens))
    if isinstance(sensor, Orthographic):
        d = np.tile(sensor.frame[:, 2:], count)
        return CameraRays(Points.nowhere(origin + sensor.pixel_to_offset @ image), d)
    if isinstance(sensor, RadianceMeter):
        return CameraRays(Points.nowhere(origin), np.tile(np.array(sensor.direction)[:, None], count))
    # ∫ Li cos θ dl with the density cos θ / π: each ray counts π times
    normal = np.tile(np.array(sensor.normal)[:, None], count)
    d = sampling.to_world(sampling.square_to_cosine_hemisphere(u), normal)
    return CameraRays(Points.nowhere(origin), d, np.pi)


class Film:
    """Sums over the walks of each pixel, for every bounce."""

    def __init__(self, bounces: int, shape: tuple[int, int, int]) -> None:
        height, width, channels = shape
        self._shape, self._sums = shape, np.zeros((bounces + 1, channels, height * width))

    def begin(self, block: Block) -> None:
        """Turn to another block of walks."""
        column, row = block.position.astype(np.intp)
        self._pixel = row * self._shape[1] + column

    def add(self, bounce: int, lanes: Indices, radiance: Array) -> None:
        """Add radiance, ``(channels, len(lanes))``, of walks of the current block."""
        pixel = self._pixel.take(lanes)
        for channel, values in zip(self._sums[bounce], radiance, strict=True):
            channel += np.bincount(pixel, values, minlength=len(channel))

    def pixel(self, lane: int) -> tuple[int, int]:
        """Row and column of a walk of the current block."""
        row, column = divmod(int(self._pixel[lane]), self._shape[1])
        return row, column

    def mean(self, spp: int) -> Array:
        """The image, ``(bounces + 1, height, width, channels)``."""
        return np.moveaxis(self._sums, 1, -1).reshape(-1, *self._shape) / spp


class SumFilm(Film):
    """One image, ``(1, height, width, channels)``, that takes all bounces together."""

    def __init__(self, shape: tuple[int, int, int]) -> None:
        super().__init__(0, shape)

    def add(self, bounce: int, lanes: Indices, radiance: Array) -> None:
        """As a film, whatever the bounce."""
        super().add(0, lanes, radiance)
