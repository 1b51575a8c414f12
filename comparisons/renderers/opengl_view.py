"""A sensor as pyrender's cameras have it.

A pixel (x, y), y downwards, is seen in direction ((x − cₓ) s, (c_y − y) s, 1) along right, up, forward, and s is the
size of a pixel at distance 1: that is ``IntrinsicsCamera`` with the focal length 1 / s, in pixels. A parallel view
starts there instead; s is a length then: ``OrthographicCamera``. pyrender looks along −z.

Its world is ours, moved to the sensor and scaled until all of it lies within a distance of 1: single precision is
finest there, whatever the scene's units.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.renderers.protocol import Unsupported
from scenes import IrradianceMeter, Orthographic, RadianceMeter, Sensor

Array = NDArray[np.float64]

_PIXEL_OF_METER = 1e-3
"""Size of the one pixel of a radiance meter, at distance 1: any will do, since only its middle is looked at."""


@dataclass(frozen=True)
class View:
    """What OpenGL has to know of a sensor.

    Attributes:
        origin: world coordinates, ``(3,)``.
        frame: columns right, up, forward, ``(3, 3)``.
        width, height: pixels.
        pixel: the size of one, at distance 1, or everywhere if the view is parallel.
        parallel: whether all rays go forward.
    """

    origin: Array
    frame: Array
    width: int
    height: int
    pixel: float
    parallel: bool

    @classmethod
    def of(cls, sensor: Sensor) -> View:
        """The rays of a sensor, one through the middle of each pixel; of a lens those through its centre.

        Raises:
            Unsupported: an irradiance meter.
        """
        if isinstance(sensor, IrradianceMeter):
            raise Unsupported("irradiance_meter sensor: its pixel is no ray")
        origin, size = np.array(sensor.origin), (sensor.width, sensor.height)
        if isinstance(sensor, RadianceMeter):
            return cls(origin, _frame_along(np.array(sensor.direction)), *size, _PIXEL_OF_METER, False)
        if isinstance(sensor, Orthographic):
            return cls(origin, sensor.frame, *size, sensor.extent / min(size), True)
        across = 2 * math.tan(math.radians(sensor.fov) / 2)
        return cls(origin, sensor.frame, *size, across / min(size), False)

    @property
    def smallest_pixel(self) -> float:
        """As ``pixel``, but measured across its ray, at the corner of the image, where it is smallest."""
        if self.parallel:
            return self.pixel
        return self.pixel / (1 + (math.hypot(self.width, self.height) / 2 * self.pixel) ** 2)

    def finer(self, times: int) -> View:
        """The same view with so many pixels for one, in both directions."""
        return View(
            self.origin,
            self.frame,
            times * self.width,
            times * self.height,
            self.pixel / times,
            self.parallel,
        )

    def camera(self, pyrender: Any, near: float, far: float, scale: float, shift: tuple[float, float]) -> Any:
        """pyrender's camera for distances from near to far along the view, all in its own units.

        Args:
            scale: of the scene in pyrender's world.
            shift: which point of each pixel is looked at, from its middle, in pixels, right and down.
        """
        if self.parallel:
            size = scale * self.pixel / 2
            return pyrender.OrthographicCamera(size * self.width, size * self.height, znear=near, zfar=far)
        focal, (x, y) = 1 / self.pixel, shift
        return pyrender.IntrinsicsCamera(
            focal, focal, self.width / 2 - x, self.height / 2 - y, znear=near, zfar=far
        )

    def pose(self, scale: float, shift: tuple[float, float]) -> Array:
        """Where that camera stands and looks, ``(4, 4)``."""
        right, up, forward = self.frame.T
        pose = np.eye(4)
        pose[:3, :3] = np.stack([right, up, -forward], axis=1)
        if self.parallel:
            pose[:3, 3] = scale * self.pixel * (shift[0] * right - shift[1] * up)
        return pose

    def along_the_view(self, depth: Array, near: float, far: float) -> Array:
        """Distances along the view from the depths that pyrender returns.

        The buffer holds, as z goes from near to far, (1 − near/z) / (1 − near/far) for a perspective and
        (z − near) / (far − near) for a parallel view. pyrender solves the first for z, of either view.
        """
        return far + near - near * far / depth if self.parallel else depth

    def per_view(self) -> Array:
        """Distance along the ray of each pixel's middle, per unit along the view, ``(height, width)``."""
        if self.parallel:
            return np.ones((self.height, self.width))
        y, x = np.mgrid[: self.height, : self.width] + 0.5
        length: Array = np.hypot(1, self.pixel * np.hypot(x - self.width / 2, y - self.height / 2))
        return length


def _frame_along(forward: Array) -> Array:
    """Right, up, forward, for a direction that has no up of its own, ``(3, 3)``."""
    right = np.cross(forward, np.eye(3)[np.abs(forward).argmin()])
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(right, forward), forward], axis=1)
