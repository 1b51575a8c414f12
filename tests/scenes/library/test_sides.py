"""Which side is lit and which is seen: pixels by brute force, and that the scenes show what they are named for."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from scenes import Mesh, Scene
from scenes.library import case, sides


def loaded(file: str) -> Any:
    """A module beside this one."""
    spec = importlib.util.spec_from_file_location(Path(file).stem, Path(__file__).parent / file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


brute_force = loaded("brute_force.py")

SHEETS = ("shading-normals", "shading-normals-from-behind")
SIZE = 32
PIXELS = {
    "lit-from-behind": [(2, 0), (9, 4), (20, 12), (5, 16), (30, 20), (11, 24)],
    "shading-normals": [(2, 1), (9, 3), (20, 5), (5, 6), (30, 7), (7, 16), (11, 22), (23, 27), (29, 31)],
    "shading-normals-from-behind": [(2, 1), (9, 3), (20, 5), (5, 6), (30, 7), (11, 22), (23, 27)],
}
"""Row, column: inside of boards and strips, and across the borders of both and of what is black."""


# ---- by brute force

Seen = tuple[Any, np.ndarray]
"""What changes where radiance bends, and the radiance."""


def board(scene: Scene, o: np.ndarray, d: np.ndarray) -> Seen:
    """Of a board that shows its front, by every lamp that it shows its front to."""
    distances = [float(brute_force.distances(s.shape, o[None], d[None])[0]) for s in scene.surfaces]
    met, L = int(np.argmin(distances)), np.zeros(3)
    surface = scene.surfaces[met]
    n, x = surface.shape.normal, o + distances[met] * d
    if n @ d < 0:
        for lamp in scene.surfaces:
            if lamp.emission is not None:
                Li = np.array(lamp.emission.radiance)
                empty = Scene(
                    scene.surfaces[:1], scene.sensor, scene.lights or case("point-over-plane").scene.lights
                )
                L += Li * brute_force.by_lamp(empty, x, n, lamp.shape, 4)
    return met, L * np.array(surface.material.albedo) / np.pi


def sheet(scene: Scene, o: np.ndarray, d: np.ndarray) -> Seen:
    """Of a triangle with interpolated normals, by light that both normals have before them."""
    mesh, state, L = scene.surfaces[0].shape, [], np.zeros(3)
    for triangle in mesh.triangles:
        corners = np.array(mesh.vertices)[list(triangle)]
        g = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        x = o + ((corners[0] - o) @ g) / (d @ g) * d
        weights = np.linalg.lstsq(np.vstack([corners.T, np.ones(3)]), np.append(x, 1), rcond=None)[0]
        if weights.min() < -1e-12:
            continue
        ns = weights @ np.array(mesh.normals)[list(triangle)]
        ns /= np.linalg.norm(ns)
        assert min(g @ d, ns @ d, key=abs) < 0
        for light in scene.lights:
            cosine = -(ns @ light.direction)
            lit = cosine > 0 and g @ light.direction < 0
            state.append(lit)
            L += np.array(light.irradiance) * cosine * lit
        return (min(triangle), *state), L * np.array(scene.surfaces[0].material.albedo) / np.pi
    raise AssertionError("a ray that misses the sheet")


def pixel(
    scene: Scene, row: int, column: int, seen: Callable[[Scene, np.ndarray, np.ndarray], Seen]
) -> np.ndarray:
    """The mean over a pixel, row by row, in pieces that end where what is seen changes."""

    def at(x: float, y: float) -> Seen:
        o, d = brute_force.camera_rays(scene.sensor, np.array([x]), np.array([y]))
        return seen(scene, o[0], d[0])

    total = np.zeros(3)
    for y, dy in zip(*brute_force.gauss(3, row, row + 1), strict=True):
        grid = np.linspace(column + 1e-9, column + 1 - 1e-9, 5)
        ends = [column]
        for a, b in pairwise(grid):
            low, high, before = a, b, at(a, y)[0]
            if before != at(b, y)[0]:
                for _ in range(45):
                    middle = (low + high) / 2
                    low, high = (middle, high) if at(middle, y)[0] == before else (low, middle)
                ends.append(low)
        for left, right in pairwise([*ends, column + 1]):
            for x, dx in zip(*brute_force.gauss(4, left, right), strict=True):
                total += dx * dy * at(x, y)[1]
    return total


@pytest.mark.parametrize("name", sides.CASES)
def test_pixels_by_brute_force(name: str) -> None:
    found = case(name)
    scene = found.scene.resized(SIZE, SIZE)
    truth = found.answer.truth(scene, 3).mean
    assert not truth[[0, 2, 3]].any()
    for row, column in PIXELS[name]:
        expected = pixel(scene, row, column, sheet if name in SHEETS else board)
        np.testing.assert_allclose(truth[1, row, column], expected, rtol=1e-6, atol=1e-9)


# ---- what the scenes are like


def test_boards_are_lit_and_seen_in_all_four_ways() -> None:
    scene = case("lit-from-behind").scene
    *boards, above, below = scene.surfaces
    forward = scene.sensor.frame[:, 2]
    ways = set()
    for surface in boards:
        middle = np.add(surface.shape.corner, np.add(surface.shape.edge_u, surface.shape.edge_v) / 2)
        for lamp in (above, below):
            before = np.array(lamp.shape.corner) - middle
            assert before @ lamp.shape.normal < 0  # it shines on this side
            ways.add((bool(before @ surface.shape.normal > 0), bool(forward @ surface.shape.normal < 0)))
    assert len(ways) == 4


def test_half_of_each_tile_is_a_back() -> None:
    """Or a tile would be black but for its edge, of which a few samples say little."""
    found = case("lit-from-behind")
    image = found.answer.truth(found.scene, 1).mean[1, ..., 0]
    lit = (image > 0).reshape(4, 16, 4, 16).mean(axis=(1, 3))
    assert 0.4 < lit.min() < lit.max() < 0.6


@pytest.mark.parametrize("name", sides.CASES)
def test_what_reflects_lies_in_one_plane(name: str) -> None:
    """So nothing lights anything else."""
    for surface in case(name).scene.surfaces:
        if max(surface.material.albedo) > 0:
            shape = surface.shape
            if isinstance(shape, Mesh):
                assert not np.array(shape.vertices)[:, 1].any()
            else:
                assert shape.corner[1] == shape.edge_u[1] == shape.edge_v[1] == 0
        else:
            assert surface.emission is not None


@pytest.mark.parametrize("name", sides.CASES)
@pytest.mark.parametrize(("width", "height"), [(8, 8), (12, 8), (8, 12)])
def test_no_lamp_is_in_view(name: str, width: int, height: int) -> None:
    scene = case(name).scene.resized(width, height)
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(0, width, 25), np.linspace(0, height, 25)))
    o, d = brute_force.camera_rays(scene.sensor, x, y)
    for surface in scene.surfaces:
        if surface.emission is not None:
            first = np.min(
                [brute_force.distances(s.shape, o, d) for s in scene.surfaces if s is not surface], axis=0
            )
            met = brute_force.distances(surface.shape, o, d)
            assert (np.isinf(met) | (met > first) | (d @ surface.shape.normal > 0)).all()
            assert surface.name != "lamp-above" or np.isinf(met).all()


def test_light_from_behind_adds_nothing_where_shading_normals_lean_to_it() -> None:
    one, both = (case(name) for name in SHEETS)
    images = [found.answer.truth(found.scene.resized(SIZE, SIZE), 1).mean[1] for found in (one, both)]
    np.testing.assert_array_equal(*images)
    shape, lights = both.scene.surfaces[0].shape, both.scene.lights
    assert one.scene.lights == lights[:1]
    assert lights[0].direction[1] < 0 < lights[1].direction[1]  # from above, from below
    normals = np.array(shape.normals)
    assert ((normals @ lights[1].direction < 0) & (normals @ lights[0].direction > 0)).sum() == 4
    black = (images[0] == 0).all(axis=2).mean()
    assert 0.1 < black < 0.3


def test_strips_are_told_from_flat_ones() -> None:
    """What each mistake about normals would make of the sheet is far away."""
    found = case("shading-normals")
    scene = found.scene.resized(8, 8)
    truth = found.answer.truth(scene, 1).mean[1]
    shape = scene.surfaces[0].shape
    flat = scene.lights[0].direction[1] * -np.array(scene.lights[0].irradiance) * [0.8, 0.5, 0.3] / np.pi
    assert np.abs(truth / flat - 1).max() > 0.5
    turned = replace(shape, normals=tuple((-x, y, -z) for x, y, z in shape.normals))
    other = found.answer.truth(
        Scene((replace(scene.surfaces[0], shape=turned),), scene.sensor, scene.lights), 1
    )
    assert np.abs(other.mean[1] - truth).mean() > 0.2 * truth.mean()


@pytest.mark.parametrize("name", sides.CASES)
@pytest.mark.parametrize(("width", "height"), [(4, 4), (6, 4), (4, 6)])
def test_a_coarse_image_is_the_mean_of_a_fine_one(name: str, width: int, height: int) -> None:
    """Also where an image of another form reaches beyond what there is to see."""
    found = case(name)
    fine, coarse = (found.answer.truth(found.scene.resized(n * width, n * height), 1).mean[1] for n in (3, 1))
    np.testing.assert_allclose(
        coarse, fine.reshape(height, 3, width, 3, 3).mean(axis=(1, 3)), atol=1e-9 * fine.max()
    )
