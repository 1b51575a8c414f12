"""The cases of direct light, held against brute force, and what their cameras and lights must be like."""

from __future__ import annotations

import importlib.util
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenes import Quad, Scene, Sphere
from scenes.library import case, direct_light, direct_light_of_lights, rectangles


def loaded(file: str) -> Any:
    """A module beside this one."""
    spec = importlib.util.spec_from_file_location(Path(file).stem, Path(__file__).parent / file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


brute_force = loaded("brute_force.py")
BY_REFLECTION, camera_rays, distances = (
    brute_force.BY_REFLECTION,
    brute_force.camera_rays,
    brute_force.distances,
)

NAMES = [*direct_light.CASES, *direct_light_of_lights.CASES, *rectangles.CASES]
NAMES += ["cie-171-point", "cie-171-small-lamp"]
OBSTRUCTED = ("screened-lamp", "lamp-over-a-wall", "wall-behind-a-shelf", "disk-shadow")
SIZE = 32
RIM = [
    (2, 3),
    (11, 14),
    (12, 10),
    (15, 9),
    (18, 11),
    (20, 14),
    (22, 19),
    (22, 25),
    (17, 27),
    (13, 20),
    (17, 20),
]
PIXELS = [(2, 3), (13, 26), (23, 8)]  # row, column


@pytest.mark.parametrize("name", [name for name in NAMES if name not in ("hundred-tiles", "disk-shadow")])
def test_pixels_by_brute_force(name: str) -> None:
    found = case(name)
    scene, bounce = found.scene.resized(SIZE, SIZE), 2 if name in BY_REFLECTION else 1
    truth = found.answer.truth(scene, 3)
    assert truth is not None
    for k in {0, 1, 2, 3} - {bounce}:
        assert not truth.mean[k].any()
    for row, column in PIXELS:
        expected = brute_force.pixel_by_brute_force(found, scene, (row, column), 3)
        np.testing.assert_allclose(truth.mean[bounce, row, column], expected, rtol=1e-6)


def test_pixels_across_the_rim_of_a_shadow() -> None:
    """Lines through a pixel, cut by bisection where the disk begins or ends to hide the light."""
    found = case("disk-shadow")
    scene = found.scene.resized(SIZE, SIZE)
    (floor, disk), [light] = scene.surfaces, scene.lights
    image = found.answer.truth(scene, 1).mean[1]

    def at(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Irradiance were there no disk, and whether it is in the way."""
        o, d = camera_rays(scene.sensor, x, y)
        points = o + distances(floor.shape, o, d)[:, None] * d
        away = np.array(light.position) - points
        return away[:, 1] / np.linalg.norm(away, axis=1) ** 3, distances(disk.shape, points, away) > 1

    def along(column: int, y: np.ndarray) -> np.ndarray:
        """Integrals over the width of the pixel; the rim crosses none of its eighths twice."""
        total, grid = np.zeros_like(y), column + np.linspace(0, 1, 9)
        for a, b in pairwise(grid):
            start, end = at(np.full_like(y, a), y)[1], at(np.full_like(y, b), y)[1]
            low, high = np.full_like(y, a), np.full_like(y, b)
            for _ in range(45):
                middle = (low + high) / 2
                same = at(middle, y)[1] == start
                low, high = np.where(same, middle, low), np.where(same, high, middle)
            for left, right, lit in ((a, low, start), (low, b, end)):
                for x, weight in zip(*brute_force.gauss(4), strict=True):
                    total += lit * weight * (right - left) * at(left + (right - left) * x, y)[0]
        return total

    count, crossed = 2000, 0
    for row, column in RIM:
        y = row + (np.arange(count) + 0.5) / count
        expected = along(column, y).mean() * np.array(floor.material.albedo) * light.intensity / np.pi
        np.testing.assert_allclose(image[row, column], expected, rtol=1e-5, atol=1e-6 * image.max())
        _, lit = at(column + np.array([0.01, 0.99, 0.01, 0.99]), row + np.array([0.01, 0.01, 0.99, 0.99]))
        crossed += len(set(lit.tolist())) == 2
    assert crossed >= 4


def test_a_hundred_tiles_are_one_lamp() -> None:
    one, hundred = (case(name) for name in ("quad-over-plane", "hundred-tiles"))
    images = [found.answer.truth(found.scene.resized(16, 16), 1).mean for found in (one, hundred)]
    np.testing.assert_allclose(images[1], images[0], rtol=1e-11)
    panel, tiles = one.scene.surfaces[1].shape, [surface.shape for surface in hundred.scene.surfaces[1:]]
    assert len(tiles) == 100
    u, v = np.array(panel.edge_u), np.array(panel.edge_v)
    places = sorted(
        (round(d @ u / (u @ u), 9), round(d @ v / (v @ v), 9))
        for d in (np.subtract(tile.corner, panel.corner) for tile in tiles)
    )
    assert places == [(i / 10, j / 10) for i in range(10) for j in range(10)]
    for tile in tiles:
        np.testing.assert_allclose([tile.edge_u, tile.edge_v], [u / 10, v / 10], atol=1e-12)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("width", "height"), [(8, 8), (12, 8), (8, 12)])
def test_the_camera_sees_the_receiver_alone(name: str, width: int, height: int) -> None:
    """And its front: corners of pixels, so that what lies between is in view, too."""
    scene = case(name).scene.resized(width, height)
    x, y = (
        g.ravel()
        for g in np.meshgrid(np.linspace(1e-6, width - 1e-6, 25), np.linspace(1e-6, height - 1e-6, 25))
    )
    o, d = camera_rays(scene.sensor, x, y)
    first, *others = (distances(surface.shape, o, d) for surface in scene.surfaces)
    met = np.isfinite(first)
    assert met.all() or (name in rectangles.CASES and width != height)  # these have black beside the receiver
    for other in others:
        assert (other[met] > first[met] + 1e-6).all()
        assert np.isinf(other[~met]).all()
    if isinstance(scene.surfaces[0].shape, Quad):
        assert (d @ scene.surfaces[0].shape.normal < 0).all()


@pytest.mark.parametrize("name", BY_REFLECTION)
def test_the_sun_lights_the_whole_floor_and_not_the_wall(name: str) -> None:
    scene = case(name).scene
    wall, floor, *_ = scene.surfaces
    [sun] = scene.lights
    assert wall.shape.normal @ sun.direction > 0.1  # from behind
    s, t = (g.ravel() for g in np.meshgrid(np.linspace(0, 1, 41), np.linspace(0, 1, 41)))
    x = floor.shape.corner + np.outer(s, floor.shape.edge_u) + np.outer(t, floor.shape.edge_v)
    back = np.tile(-np.array(sun.direction), (len(x), 1))
    for surface in scene.surfaces:
        if surface is not floor:
            assert np.isinf(distances(surface.shape, x, back)).all()
    for surface in scene.surfaces[2:]:
        assert surface.material.albedo == (0, 0, 0)


@pytest.mark.parametrize("name", [name for name in NAMES if name not in BY_REFLECTION])
def test_nothing_but_the_receiver_reflects(name: str) -> None:
    """So nothing comes back to it, and T²E = 0: all else is black, and it is flat or a ball seen from outside."""
    receiver, *others = case(name).scene.surfaces
    assert isinstance(receiver.shape, Quad | Sphere)
    assert not getattr(receiver.shape, "inward", False)
    assert max(receiver.material.albedo) > 0
    for other in others:
        assert other.material.albedo == (0, 0, 0)


def test_obstructions_obstruct() -> None:
    """Not one of the cases is what it would be without its screen, wall or shelf."""
    for name in OBSTRUCTED:
        found = case(name)
        scene, bounce = found.scene.resized(2, 2), 2 if name in BY_REFLECTION else 1
        bare = Scene(scene.surfaces[:-1], scene.sensor, scene.lights)
        with_it = found.answer.truth(scene, bounce).mean[bounce]
        without = brute_force.pixel_by_brute_force(
            case("wall-by-reflection") if bounce == 2 else found, bare, (0, 1), 4
        )
        assert (with_it[0, 1] < 0.95 * without).all()


def test_harmonics_are_nowhere_negative_and_have_a_degree_that_must_not_show() -> None:
    [light] = case("harmonics-on-sphere").scene.lights
    d = np.random.default_rng(3).normal(size=(20_000, 3))
    assert brute_force.harmonic_radiance(light, d / np.linalg.norm(d, axis=1, keepdims=True)).min() > 0.01
    assert np.abs(light.coefficients[9:]).max() > 0.1


def test_spots_show_what_they_are_named_for() -> None:
    for name in ("spot-falloff", "spot-beam"):
        scene = case(name).scene
        [spot] = scene.lights
        x, y = (g.ravel() for g in np.meshgrid(np.linspace(0, 64, 20), np.linspace(0, 64, 20)))
        o, d = camera_rays(scene.sensor, x, y)
        away = o + distances(scene.surfaces[0].shape, o, d)[:, None] * d - spot.position
        angle = np.degrees(np.arccos(away @ spot.direction / np.linalg.norm(away, axis=1)))
        low, high = (spot.beam, spot.cutoff) if name == "spot-falloff" else (0, spot.beam)
        assert low < angle.min() < angle.max() < high


@pytest.mark.parametrize("name", NAMES)
def test_a_coarse_image_is_the_mean_of_a_fine_one(name: str) -> None:
    found = case(name)
    bounce = 2 if name in BY_REFLECTION else 1
    fine, coarse = (found.answer.truth(found.scene.resized(n, n), bounce).mean[bounce] for n in (12, 4))
    np.testing.assert_allclose(coarse, fine.reshape(4, 3, 4, 3, 3).mean(axis=(1, 3)), atol=1e-7 * fine.max())


@pytest.mark.parametrize("name", NAMES)
def test_channels_and_the_axes_of_the_image_are_told_apart(name: str) -> None:
    found = case(name)
    bounce = 2 if name in BY_REFLECTION else 1
    image = found.answer.truth(found.scene.resized(8, 8), bounce).mean[bounce]
    others = [
        image[::-1],
        image[:, ::-1],
        image.transpose(1, 0, 2),
        image[..., [1, 2, 0]],
        image[..., [2, 0, 1]],
    ]
    for other in others:
        assert np.abs(other - image).mean() > 0.02 * image.mean()
