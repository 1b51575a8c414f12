"""Faults of the sensor, held out: how a camera is read, and how pixels are put together to an image."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from comparisons.faults.fault import Fault
from comparisons.faults.planting import of_image, of_scene
from comparisons.renderers import Images
from scenes import Orthographic, Pinhole, Scene, ThinLens

Array = NDArray[np.float64]

TILE = 32
"""Pixels along the side of what is rendered at a time."""

REC709_TO_AP1 = np.array(
    [[0.613097, 0.339523, 0.047379], [0.070194, 0.916354, 0.013452], [0.020616, 0.109570, 0.869815]]
)
"""From the primaries of ITU-R BT.709 to those of ACEScg, the white point adapted; grey stays grey."""

UP = (0.0, 1.0, 0.0)


def _twice_the_extent(scene: Scene) -> Scene:
    sensor = scene.sensor
    if not isinstance(sensor, Orthographic):
        return scene
    return msgspec.structs.replace(scene, sensor=msgspec.structs.replace(sensor, extent=2 * sensor.extent))


def _never_rolled(scene: Scene) -> Scene:
    sensor: Any = scene.sensor
    if not isinstance(sensor, Pinhole | ThinLens | Orthographic):
        return scene
    view = np.subtract(sensor.target, sensor.origin)
    if np.linalg.norm(np.cross(view, UP)) < 1e-6 * np.linalg.norm(view):
        return scene  # there is no other way to look straight down
    return msgspec.structs.replace(scene, sensor=msgspec.structs.replace(sensor, up=UP))


def _filtered_from_black(images: Images) -> Images:
    """A tent of two pixels' width, whose weights are not summed up again where it ends at a border."""
    tent = np.array([1.0, 2.0, 1.0]) / 4
    for axis in (1, 2):
        images = ndimage.convolve1d(images, tent, axis=axis, mode="constant")
    return images


def _seams_twice(images: Images) -> Images:
    """The last row and column of each tile but the outermost belong to its neighbours, too, and are added again."""
    _, height, width, _ = images.shape
    for axis, size in ((1, height), (2, width)):
        seams = np.arange(TILE - 1, size - 1, TILE)
        index: list[Any] = [slice(None)] * 4
        index[axis] = seams
        images[tuple(index)] *= 2
    return images


def _by_columns(images: Images) -> Images:
    """Pixels are written column after column, and read row after row."""
    return images.swapaxes(1, 2).reshape(images.shape)


def _of_other_primaries(images: Images) -> Images:
    return images @ REC709_TO_AP1.T if images.shape[3] == 3 else images


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="extent-for-half-of-it",
        operator="sensor",
        what="the extent of orthographic cameras is taken for half of it: they show twice as much",
        plant=of_scene(_twice_the_extent),
        happened=(
            "https://github.com/lunadigital/btoa/issues/175",
            "https://github.com/mrdoob/three.js/issues/24800",
        ),
    ),
    Fault(
        name="camera-never-rolled",
        operator="sensor",
        what="what is up for a camera is +y, whatever the scene says",
        plant=of_scene(_never_rolled),
    ),
    Fault(
        name="filter-dark-at-borders",
        operator="sensor",
        what="pixels are averaged with their neighbours, and those beyond the border of the image count as black",
        plant=of_image(_filtered_from_black),
    ),
    Fault(
        name="tile-seams-added-twice",
        operator="sensor",
        what="tiles of 32 pixels overlap by one, and what both have is added up",
        plant=of_image(_seams_twice),
    ),
    Fault(
        name="columns-for-rows",
        operator="sensor",
        what="pixels are stored column after column, and read row after row",
        plant=of_image(_by_columns),
    ),
    Fault(
        name="primaries-of-acescg",
        operator="sensor",
        what="the image is converted to the primaries of another colour space; grey stays grey",
        plant=of_image(_of_other_primaries),
    ),
)
