"""Wrong cameras, and which of them is told; what a wrong shape changes is none."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from comparisons.faults import FAULTS
from comparisons.relations import STAGES
from comparisons.relations.other_camera import other_camera
from comparisons.renderers import create
from scenes import Scene
from scenes.first_hit import first_hits


def hits(scene: Scene, at: tuple[float, float] = (0.5, 0.5)) -> np.ndarray:
    seen = first_hits(scene, at)
    return np.stack([seen.distance, *seen.normal, seen.surface])


def reordered(order: Callable[[np.ndarray], np.ndarray]) -> Callable[[Scene], np.ndarray]:
    def wrong(scene: Scene) -> np.ndarray:
        height, width, _ = scene.shape
        return order(hits(scene).reshape(5, height, width)).reshape(5, -1)

    return wrong


def other_axis(scene: Scene) -> np.ndarray:
    """The angle holds for the larger axis: seen through the larger image and cut, it is 24 of 36 columns wide."""
    sensor = scene.sensor
    tangent = np.tan(np.radians(sensor.fov) / 2) * sensor.height / sensor.width
    fov = 2 * np.degrees(np.arctan(tangent))
    return hits(msgspec.structs.replace(scene, sensor=msgspec.structs.replace(sensor, fov=float(fov))))


WRONG: dict[str, Callable[[Scene], np.ndarray]] = {
    "as if it looked -0.5 pixels to the right and -0.5 down": lambda scene: hits(scene, (0.0, 0.0)),
    "as if it looked +0 pixels to the right and +1 down": lambda scene: hits(scene, (0.5, 1.5)),
    "as if left were right": reordered(lambda h: h[:, :, ::-1]),
    "as if the first row were the lowest": reordered(lambda h: h[:, ::-1]),
    "as if the image were turned upside down": reordered(lambda h: h[:, ::-1, ::-1]),
    "as if its angle of view were along the other axis": other_axis,
}


@pytest.mark.parametrize("what", WRONG)
@pytest.mark.parametrize("stage", ["room", "lights", "metal"])
def test_a_wrong_camera_is_told(what: str, stage: str) -> None:
    scene = STAGES[stage]().resized(36, 24)
    assert other_camera(scene, WRONG[what](scene)) == what


@pytest.mark.parametrize("stage", ["room", "lights", "metal"])
def test_the_right_camera_is_no_other(stage: str) -> None:
    scene = STAGES[stage]()
    assert other_camera(scene, hits(scene)) == ""


@pytest.mark.parametrize("fault", ["second-triangle-lost", "sphere-distance-before-scaling"])
@pytest.mark.parametrize("stage", ["lights", "metal"])
def test_a_wrong_shape_is_no_camera(fault: str, stage: str) -> None:
    scene = STAGES[stage]()
    found = FAULTS[fault].plant(create("reference")).first_hits(scene)  # type: ignore[attr-defined]
    assert not np.array_equal(found, hits(scene))
    assert other_camera(scene, found) == ""
