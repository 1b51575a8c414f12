"""Which texel is where: pixels by points of them, each looked up by hand."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from scenes import Orthographic, Scene
from scenes.library import case


def loaded(file: str) -> Any:
    """A module beside this one."""
    spec = importlib.util.spec_from_file_location(Path(file).stem, Path(__file__).parent / file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


brute_force = loaded("brute_force.py")
POINTS = 200
"""Along each side of a pixel: the area of a texel in it is right to 1 / 200 for each of its sides."""


def by_points(scene: Scene, row: int, column: int) -> np.ndarray:
    """The mean of many points, whose texels are found one by one."""
    steps = (np.arange(POINTS) + 0.5) / POINTS
    x, y = (g.ravel() for g in np.meshgrid(column + steps, row + steps))
    o, d = brute_force.camera_rays(scene.sensor, x, y)
    board, [light] = scene.surfaces[0], scene.lights
    points = o - o[:, 1:2] / d[:, 1:2] * d - board.shape.corner
    u, v = (points @ np.array(edge) / np.dot(edge, edge) for edge in (board.shape.edge_u, board.shape.edge_v))
    on_board = (u > 0) & (u < 1) & (v > 0) & (v < 1)
    rows = board.material.albedo.image.pixels
    albedos = [
        rows[int((1 - b) * len(rows))][int(a * len(rows[0]))]
        for a, b in zip(u[on_board], v[on_board], strict=True)
    ]
    irradiance = np.array(light.irradiance) * -light.direction[1] / np.linalg.norm(light.direction)
    return np.sum(albedos, axis=0) / POINTS**2 * irradiance / np.pi


def cameras(scene: Scene) -> dict[str, Orthographic]:
    """That of the case; one that lies on its side; one that sees beyond the board."""
    return {
        "as it is": scene.sensor,
        "on its side": replace(scene.sensor, up=(1.0, 0.0, 0.0)),
        "from far": replace(scene.sensor, extent=2.9),
    }


@pytest.mark.parametrize("camera", ["as it is", "on its side", "from far"])
def test_pixels_by_points(camera: str) -> None:
    found = case("printed-board").scene
    scene = replace(found, sensor=cameras(found)[camera]).resized(16, 12)
    truth = case("printed-board").answer.truth(scene, 2).mean
    assert not truth[[0, 2]].any()
    assert truth[1].any()
    for row in range(12):
        for column in range(0, 16, 3):
            np.testing.assert_allclose(
                truth[1, row, column], by_points(scene, row, column), rtol=0.02, atol=0.004
            )


def test_every_texel_is_seen_and_no_two_are_alike() -> None:
    scene = case("printed-board").scene
    pixels = [texel for row in scene.surfaces[0].material.albedo.image.pixels for texel in row]
    assert len(set(pixels)) == 15
    image = case("printed-board").answer.truth(scene, 1).mean[1]
    light = scene.lights[0]
    whole = np.array(light.irradiance) * -light.direction[1] / np.linalg.norm(light.direction) / np.pi
    seen = {tuple(np.round(albedo, 6)) for albedo in (image / whole).reshape(-1, 3)}
    assert {tuple(np.round(texel, 6)) for texel in pixels} <= seen
