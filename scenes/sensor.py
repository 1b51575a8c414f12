"""Sensors: where the radiance is measured. A pixel is the mean over its square: the box reconstruction filter.

Pixel coordinates: (0, 0) is the outer corner of the top left pixel, (width, height) that of the bottom right one.
"""

from __future__ import annotations

import math
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from scenes.validation import SceneError, Vector, number, path, positive, sine, unit_vector, vector, whole

Array = NDArray[np.float64]


class Pinhole(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="pinhole",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """An ideal pinhole camera.

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
        _check_camera(self)
        _check_fov(self)

    @property
    def frame(self) -> Array:
        """Columns right, up, forward of the camera in world coordinates, orthonormal, ``(3, 3)``."""
        return _frame(self)

    @property
    def pixel_to_direction(self) -> Array:
        """The matrix ``(3, 3)`` that takes (x, y, 1) in pixels to a direction in world coordinates.

        The directions are not normalised: their component along the view is 1.
        """
        matrix: Array = self.frame @ _pixel_to_plane(self, 2 * math.tan(math.radians(self.fov) / 2))
        return matrix


class ThinLens(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="thin_lens",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """A camera with a thin lens: rays from all over its aperture meet in the plane of focus.

    A pixel is the mean over its square and over the aperture, both uniform.

    Attributes:
        origin: the centre of the lens, world coordinates.
        target, up, fov, width, height: as of a pinhole, for the rays through the centre of the lens.
        aperture_radius: of the lens, > 0.
        focus_distance: from the lens to the plane of focus, along the view, > 0.
    """

    origin: Vector
    target: Vector
    up: Vector
    fov: float
    width: int
    height: int
    aperture_radius: float
    focus_distance: float

    def __post_init__(self) -> None:
        _check_camera(self)
        _check_fov(self)
        positive(self, "aperture_radius", "focus_distance")

    @property
    def frame(self) -> Array:
        """Columns right, up, forward of the camera in world coordinates, orthonormal, ``(3, 3)``."""
        return _frame(self)

    @property
    def pixel_to_direction(self) -> Array:
        """As of a pinhole in the centre of the lens."""
        matrix: Array = self.frame @ _pixel_to_plane(self, 2 * math.tan(math.radians(self.fov) / 2))
        return matrix


class Orthographic(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="orthographic",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """A camera whose rays are parallel; they start in the plane through the origin.

    Attributes:
        origin, target, up, width, height: as of a pinhole; the origin is the middle of the image plane.
        extent: length of the smaller image axis, world units, > 0.
    """

    origin: Vector
    target: Vector
    up: Vector
    extent: float
    width: int
    height: int

    def __post_init__(self) -> None:
        _check_camera(self)
        positive(self, "extent")

    @property
    def frame(self) -> Array:
        """Columns right, up, forward of the camera in world coordinates, orthonormal, ``(3, 3)``."""
        return _frame(self)

    @property
    def pixel_to_offset(self) -> Array:
        """The matrix ``(3, 3)`` that takes (x, y, 1) in pixels to where the ray starts, less the origin."""
        plane = _pixel_to_plane(self, self.extent)
        plane[2] = 0
        matrix: Array = self.frame @ plane
        return matrix


class RadianceMeter(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="radiance_meter",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """One ray: the image is one pixel, the radiance that comes in along it.

    Attributes:
        origin: world coordinates.
        direction: where it looks; normalised.
    """

    origin: Vector
    direction: Vector
    width: int = 1
    height: int = 1

    def __post_init__(self) -> None:
        vector(self, "origin")
        unit_vector(self, "direction")
        _check_one_pixel(self)


class IrradianceMeter(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="irradiance_meter",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """A small flat sensor: the image is one pixel, ∫ Li cos θ dl over the half space of its normal.

    A point, spot or directional light has no Li: the meter sees what surfaces make of it, from bounce 1 on.

    Attributes:
        origin: world coordinates, on no surface.
        normal: normalised.
    """

    origin: Vector
    normal: Vector
    width: int = 1
    height: int = 1

    def __post_init__(self) -> None:
        vector(self, "origin")
        unit_vector(self, "normal")
        _check_one_pixel(self)


Camera = Pinhole | ThinLens | Orthographic
Meter = RadianceMeter | IrradianceMeter
Sensor = Camera | Meter


def _check_camera(camera: Any) -> None:
    origin, target, up = vector(camera, "origin"), vector(camera, "target"), vector(camera, "up")
    for field in ("width", "height"):
        expected = "a whole number of pixels, at least 1"
        if whole(camera, field, expected) < 1:
            raise SceneError(path(camera, field), getattr(camera, field), expected)
    distance = math.dist(origin, target)
    if not 0 < distance < math.inf:
        expected = f"a point other than the origin {origin}, at a finite distance"
        raise SceneError(path(camera, "target"), target, expected)
    if not sine(np.subtract(target, origin), np.asarray(up)) > 1e-9:
        raise SceneError(path(camera, "up"), up, "a direction that is not parallel to the view")


def _check_fov(camera: Pinhole | ThinLens) -> None:
    if not 0 < number(camera, "fov", "degrees in (0, 180)") < 180:
        raise SceneError(path(camera, "fov"), camera.fov, "degrees in (0, 180)")


def _check_one_pixel(meter: Meter) -> None:
    for field in ("width", "height"):
        if whole(meter, field, "1: a meter has one pixel") != 1:
            raise SceneError(path(meter, field), getattr(meter, field), "1: a meter has one pixel")


def _frame(camera: Camera) -> Array:
    forward = np.subtract(camera.target, camera.origin)
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, camera.up)
    right = right / np.linalg.norm(right)
    return np.stack([right, np.cross(right, forward), forward], axis=1)


def _pixel_to_plane(camera: Camera, extent: float) -> Array:
    """The matrix ``(3, 3)`` that takes (x, y, 1) in pixels to (right, up, 1) of a plane across the view.

    ``extent`` is the length of the smaller image axis in that plane.
    """
    scale = extent / min(camera.width, camera.height)
    return np.array(
        [[scale, 0, -scale * camera.width / 2], [0, -scale, scale * camera.height / 2], [0, 0, 1]]
    )
