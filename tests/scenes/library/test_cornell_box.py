"""The Cornell box is the one of Mitsuba 3: every surface, every colour, the camera."""

from __future__ import annotations

from itertools import product
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from scenes import Quad, Scene, Surface
from scenes.library import case

SINGLE = 2e-6  # Mitsuba's single precision, in a scene of size 2
WALLS = {"lamp": "light"} | {name: name for name in ("floor", "ceiling", "back", "green-wall", "red-wall")}
BLOCKS = {"small-block": "small-box", "large-block": "large-box"}


@pytest.fixture(scope="module")
def mitsuba() -> ModuleType:
    import mitsuba

    mitsuba.set_variant("scalar_rgb")
    return mitsuba


@pytest.fixture(scope="module")
def theirs(mitsuba: ModuleType) -> dict[str, Any]:
    return mitsuba.cornell_box()


@pytest.fixture(scope="module")
def ours() -> Scene:
    return case("cornell-box").scene


def named(scene: Scene, name: str) -> Surface:
    [surface] = [surface for surface in scene.surfaces if surface.name == name]
    return surface


def corners(quad: Quad) -> np.ndarray:
    corner, u, v = np.array(quad.corner), np.array(quad.edge_u), np.array(quad.edge_v)
    return np.array([corner + s * u + t * v for s, t in product((0, 1), repeat=2)])


def transformed(shape: dict[str, Any], points: Any) -> np.ndarray:
    matrix = np.array(shape["to_world"].matrix, dtype=float)
    return np.asarray(points) @ matrix[:3, :3].T + matrix[:3, 3]


def ordered(points: np.ndarray) -> np.ndarray:
    return np.array(sorted(points.tolist(), key=lambda point: np.round(point, 4).tolist()))


def colour(scene: dict[str, Any], shape: str) -> Any:
    return scene[scene[shape]["bsdf"]["id"]]["reflectance"]["value"]


@pytest.mark.parametrize("name", WALLS)
def test_walls_and_lamp(ours: Scene, theirs: dict[str, Any], name: str) -> None:
    surface, shape = named(ours, name), theirs[WALLS[name]]
    assert shape["type"] == "rectangle"
    square = [(x, y, 0) for x, y in product((-1, 1), repeat=2)]
    np.testing.assert_allclose(
        ordered(corners(surface.shape)), ordered(transformed(shape, square)), atol=SINGLE
    )
    middle, front = transformed(shape, [(0, 0, 0), (0, 0, 1)])
    normal = (front - middle) / np.linalg.norm(front - middle)
    np.testing.assert_allclose(surface.shape.normal, normal, atol=SINGLE)
    assert surface.material.albedo == tuple(colour(theirs, WALLS[name]))


@pytest.mark.parametrize("name", BLOCKS)
def test_blocks(ours: Scene, theirs: dict[str, Any], name: str) -> None:
    shape = theirs[BLOCKS[name]]
    assert shape["type"] == "cube"
    cube = transformed(shape, list(product((-1, 1), repeat=3)))
    middle = transformed(shape, [(0, 0, 0)])[0]
    faces = [surface for surface in ours.surfaces if surface.name.startswith(f"{name}.")]
    assert len(faces) == 6
    seen = set()
    for face in faces:
        distances = np.linalg.norm(cube[:, None] - corners(face.shape)[None], axis=-1)
        assert (distances.min(axis=0) < SINGLE).all()
        seen |= {frozenset(distances.argmin(axis=0).tolist())}
        assert (corners(face.shape).mean(axis=0) - middle) @ face.shape.normal > 0.1
        assert face.material.albedo == tuple(colour(theirs, BLOCKS[name]))
    assert len(seen) == 6
    assert all(len(face) == 4 for face in seen)


def test_nothing_else_is_in_the_scene(ours: Scene, theirs: dict[str, Any]) -> None:
    shapes = {name for name, part in theirs.items() if isinstance(part, dict) and "to_world" in part}
    assert shapes - {"sensor"} == {*WALLS.values(), *BLOCKS.values()}
    assert len(ours.surfaces) == len(WALLS) + 6 * len(BLOCKS)


def test_the_lamp_alone_emits(ours: Scene, theirs: dict[str, Any]) -> None:
    assert [surface.name for surface in ours.surfaces if surface.emits] == ["lamp"]
    emission = named(ours, "lamp").emission
    assert emission is not None
    assert emission.radiance == tuple(theirs["light"]["emitter"]["radiance"]["value"])


def test_bounding_box(ours: Scene, theirs: dict[str, Any], mitsuba: ModuleType) -> None:
    bounds = mitsuba.load_dict(theirs).bbox()
    points = np.concatenate([corners(surface.shape) for surface in ours.surfaces])
    np.testing.assert_allclose(points.min(axis=0), np.array(bounds.min), atol=SINGLE)
    np.testing.assert_allclose(points.max(axis=0), np.array(bounds.max), atol=SINGLE)


@pytest.mark.parametrize(("width", "height"), [(64, 64), (48, 32), (32, 48)])
def test_camera_rays(
    ours: Scene, theirs: dict[str, Any], mitsuba: ModuleType, width: int, height: int
) -> None:
    film = {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}}
    camera = mitsuba.load_dict(theirs["sensor"] | {"film": film})
    M = ours.resized(width, height).sensor.pixel_to_direction
    for x, y in [(0.5, 0.5), (0.0, 0.0), (1.0, 0.0), (0.3, 0.9), (0.77, 0.1)]:
        ray, _ = camera.sample_ray(0.0, 0.0, [x, y], [0.5, 0.5])
        d = M @ [x * width, y * height, 1]
        np.testing.assert_allclose(d / np.linalg.norm(d), np.array(ray.d), atol=SINGLE)
        back = np.array(ray.o) - np.array(ours.sensor.origin)  # it starts on the near plane, on the same line
        np.testing.assert_allclose(np.cross(back, d), 0, atol=SINGLE)


def test_its_data_are_there() -> None:
    assert case("cornell-box").answer.path.is_file()
