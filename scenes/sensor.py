"""Sensors: where the radiance is measured."""

from __future__ import annotations

import math

import msgspec
import numpy as np
from numpy.typing import NDArray

from scenes.validation import SceneError, Vector, number, path, vector


class Pinhole(msgspec.Struct, frozen=True, tag_field="type", tag="pinhole", forbid_unknown_fields=True):
    """An ideal pinhole camera with a box reconstruction filter: a pixel is the mean radiance over its square.

    Attributes:
        origin: the pinhole, world coordinates.
        target: the point in the middle of the image.
        up: a direction whose image points up; not parallel to the view.
        fov: full angle of view in degrees across the smaller image axis, in (0, 180).
        width, height: pixels.
    """

    origin: Vector
    target: Vector
    up: Vector
    fov: float
    width: int
    height: int

    def __post_init__(self) -> None:
        origin, target, up = vector(self, "origin"), vector(self, "target"), vector(self, "up")
        if not 0 < number(self, "fov", "degrees in (0, 180)") < 180:
            raise SceneError(path(self, "fov"), self.fov, "degrees in (0, 180)")
        for field in ("width", "height"):
            pixels = getattr(self, field)
            if not isinstance(pixels, int) or isinstance(pixels, bool) or pixels < 1:
                raise SceneError(path(self, field), pixels, "a whole number of pixels, at least 1")
        view = np.subtract(target, origin)
        if not np.linalg.norm(view) > 0:
            raise SceneError(path(self, "target"), target, f"a point other than the origin {origin}")
        if not np.linalg.norm(np.cross(view, up)) > 1e-9 * np.linalg.norm(view) * np.linalg.norm(up):
            raise SceneError(path(self, "up"), up, "a direction that is not parallel to the view")

    @property
    def frame(self) -> NDArray[np.float64]:
        """Columns right, up, forward of the camera in world coordinates, orthonormal, ``(3, 3)``."""
        forward = np.subtract(self.target, self.origin)
        forward = forward / np.linalg.norm(forward)
        right = np.cross(forward, self.up)
        right = right / np.linalg.norm(right)
        return np.stack([right, np.cross(right, forward), forward], axis=1)

    @property
    def pixel_to_direction(self) -> NDArray[np.float64]:
        """The matrix ``(3, 3)`` that takes (x, y, 1) in pixels to a direction in world coordinates.

        (0, 0) is the outer corner of the top left pixel, (width, height) that of the bottom right one. The
        directions are not normalised: their component along the view is 1.
        """
        scale = 2 * math.tan(math.radians(self.fov) / 2) / min(self.width, self.height)
        to_camera = np.array(
            [[scale, 0, -scale * self.width / 2], [0, -scale, scale * self.height / 2], [0, 0, 1]]
        )
        matrix: NDArray[np.float64] = self.frame @ to_camera
        return matrix


Sensor = Pinhole
