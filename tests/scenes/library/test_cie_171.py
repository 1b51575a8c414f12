"""The cases of CIE 171: pixels by brute force, what the images add up to, and the values that the report prints."""

from __future__ import annotations

import importlib.util
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from scenes import Case, ConstantEnvironment, Orthographic, Quad, Scene
from scenes.library import case
from scenes.library.cie_room import hole_of, room


def loaded(file: str) -> Any:
    """A module beside this one."""
    spec = importlib.util.spec_from_file_location(Path(file).stem, Path(__file__).parent / file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


brute_force = loaded("brute_force.py")

ON_THE_FLOOR = ("cie-171-point", "cie-171-small-lamp")
IN_THE_ROOM = ("cie-171-panel", "cie-171-flux", "cie-171-opening")
OPENING = Quad((0.5, 3.0, 0.5), (3.0, 0.0, 0.0), (0.0, 0.0, 3.0))


# ---- every pixel


def illuminance(scene: Scene, x: np.ndarray, n: np.ndarray) -> np.ndarray:
    """By lamps, the opening and points, between which and floor and wall there is nothing (see below)."""
    E, bare = np.zeros(3), case("point-over-plane").scene  # a floor alone hides nothing
    for surface in scene.surfaces:
        if surface.emission is not None:
            E += np.array(surface.emission.radiance) * brute_force.by_lamp(bare, x, n, surface.shape, 4)
    for light in scene.lights:
        if isinstance(light, ConstantEnvironment):
            E += np.array(light.radiance) * brute_force.by_lamp(bare, x, n, OPENING, 4)
        else:
            E += brute_force.by_light(light, x, n)
    return E


def first(scene: Scene, x: float, y: float) -> tuple[int, np.ndarray]:
    """The floor (0) or the wall (1) that a ray of the camera meets, and where."""
    o, d = brute_force.camera_rays(scene.sensor, np.array([x]), np.array([y]))
    distances = [brute_force.distances(surface.shape, o, d)[0] for surface in scene.surfaces[:2]]
    nearest = int(np.argmin(distances))
    return nearest, (o + distances[nearest] * d)[0]


def pixel(scene: Scene, row: int, column: int, count: int) -> np.ndarray:
    """The mean of TE, above and below the height in which the camera begins to see another surface."""
    low, high = row + 1e-9, row + 1 - 1e-9
    ends = [row, row + 1]
    if first(scene, column + 0.5, low)[0] != first(scene, column + 0.5, high)[0]:
        for _ in range(50):
            middle = (low + high) / 2
            same = first(scene, column + 0.5, middle)[0] == first(scene, column + 0.5, row + 1e-9)[0]
            low, high = (middle, high) if same else (low, middle)
        ends.insert(1, low)
    total = np.zeros(3)
    for top, bottom in pairwise(ends):
        for y, dy in zip(*brute_force.gauss(count, top, bottom), strict=True):
            for x, dx in zip(*brute_force.gauss(count, column, column + 1), strict=True):
                which, point = first(scene, x, y)
                seen = scene.surfaces[which]
                E = illuminance(scene, point, seen.shape.normal)
                total += dx * dy * np.array(seen.material.albedo) / np.pi * E
    return total


@pytest.mark.parametrize("name", IN_THE_ROOM)
@pytest.mark.parametrize(("width", "height"), [(16, 20), (13, 16)])
def test_pixels_of_floor_and_wall(name: str, width: int, height: int) -> None:
    """And one that sees both: at neither resolution does the edge lie between rows."""
    found = case(name)
    scene = found.scene.resized(width, height)
    truth = found.answer.truth(scene, 1)
    assert truth is not None
    assert not truth.mean[0].any()
    tops = [first(scene, 4.5, row + 1e-6)[0] for row in range(height)]
    [edge] = np.flatnonzero(np.diff(tops))
    for row, column in ((2, 3), (height - 4, width - 3), (edge, 4)):
        np.testing.assert_allclose(truth.mean[1, row, column], pixel(scene, row, column, 4), rtol=1e-7)


@pytest.mark.parametrize("name", IN_THE_ROOM)
def test_nothing_stands_between_light_and_what_is_lit(name: str) -> None:
    scene = case(name).scene
    rng = np.random.default_rng(6)
    lamp = scene.surfaces[-1].shape if name == "cie-171-panel" else OPENING
    s, t = rng.random((2, 60, 1))
    lights = lamp.corner + s * lamp.edge_u + t * np.array(lamp.edge_v)
    if name == "cie-171-flux":
        lights = np.array([scene.lights[0].position])
    for receiver in scene.surfaces[:2]:
        for s, t in rng.random((60, 2)):
            x = (
                receiver.shape.corner
                + s * np.array(receiver.shape.edge_u)
                + t * np.array(receiver.shape.edge_v)
            )
            assert brute_force.seen(scene, x, lights, lamp).all()


@pytest.mark.parametrize("name", IN_THE_ROOM)
def test_floor_and_wall_are_all_that_the_camera_sees(name: str) -> None:
    scene = case(name).scene
    x = np.linspace(1e-6, scene.sensor.width - 1e-6, 40)
    y = np.linspace(1e-6, scene.sensor.height - 1e-6, 40)
    o, d = brute_force.camera_rays(scene.sensor, *(g.ravel() for g in np.meshgrid(x, y)))
    distances = np.array([brute_force.distances(surface.shape, o, d) for surface in scene.surfaces])
    assert np.isfinite(distances.min(axis=0)).all()
    assert set(distances.argmin(axis=0)) == {0, 1}
    assert [surface.name for surface in scene.surfaces[:2]] == ["floor", "wall"]


@pytest.mark.parametrize("name", IN_THE_ROOM)
def test_no_answer_to_the_second_bounce(name: str) -> None:
    found = case(name)
    assert found.max_bounces == 1
    with pytest.raises(ValueError, match="at most 1"):
        found.answer.truth(found.scene, 2)


@pytest.mark.parametrize("name", IN_THE_ROOM)
def test_a_coarse_image_is_the_mean_of_a_fine_one(name: str) -> None:
    found = case(name)
    fine, coarse = (found.answer.truth(found.scene.resized(n, n), 1).mean[1] for n in (15, 5))
    np.testing.assert_allclose(coarse, fine.reshape(5, 3, 5, 3, 3).mean(axis=(1, 3)), rtol=1e-11)


# ---- what the images add up to


@pytest.mark.parametrize("name", ["cie-171-flux", "cie-171-opening"])
@pytest.mark.parametrize("size", [(64, 80), (4, 5), (1, 1)])
def test_the_image_adds_up_to_the_flux(name: str, size: tuple[int, int]) -> None:
    """0.12 Φ / 20π in red; a square image shows a part of the room."""
    found = case(name)
    scene = found.scene.resized(*size)
    if size == (1, 1):
        scene = replace(scene, sensor=replace(scene.sensor, extent=20.0))  # all of it in one pixel of 400 m²
    truth = found.answer.truth(scene, 1)
    assert truth is not None
    area = 400 if size == (1, 1) else 20
    expected = 0.12 * 10_000 / (np.pi * area) * np.array([1, 0.5, 0.25])
    np.testing.assert_allclose(truth.mean[1].mean(axis=(0, 1)), expected, rtol=1e-12)


def test_the_flux_on_every_face() -> None:
    """I Ω by quadrature over floor and wall, and what the light and the opening send out."""
    nodes, weights = brute_force.gauss(40, -2, 2)
    floor = (weights @ (1.5 / (nodes**2 + nodes[:, None] ** 2 + 1.5**2) ** 1.5)) @ weights
    y, dy = brute_force.gauss(40, -1.5, 1.5)
    wall = dy @ (2 / (nodes**2 + y[:, None] ** 2 + 2**2) ** 1.5) @ weights
    assert 2 * floor + 4 * wall == pytest.approx(4 * np.pi, rel=1e-9)
    found = case("cie-171-flux")
    [light] = found.scene.lights
    assert 4 * np.pi * light.intensity[0] == pytest.approx(10_000)
    truth = found.answer.truth(found.scene, 1)
    assert truth is not None
    pixel_area = (4 / 64) ** 2
    on_wall = truth.mean[1][:, :, 0] * np.pi * pixel_area
    bottom_of_wall = round(1.8 / (4 / 64))  # 28.8 rows: one row sees both
    whole = np.array([0.8 * 0.6 * wall, 0.3 * 0.8 * floor]) * light.intensity[0]
    assert on_wall.sum() == pytest.approx(whole.sum(), rel=1e-10)
    assert on_wall[: bottom_of_wall - 1].sum() < whole[0] < on_wall[:bottom_of_wall].sum()
    sky = case("cie-171-opening").scene.environment
    assert np.pi * sky.radiance[0] * OPENING.area == pytest.approx(10_000)


def test_an_opening_is_as_good_as_a_panel() -> None:
    """The panel's answer for the sky's, and the other way round."""
    panel, opening = case("cie-171-panel"), case("cie-171-opening")
    scene = panel.scene
    lamp = scene.surfaces[-1]
    assert hole_of(scene.surfaces) == lamp.shape
    open_roof = Scene(
        scene.surfaces[:-1], scene.sensor, (ConstantEnvironment(lamp.emission.radiance),)
    ).resized(8, 8)
    expected = panel.answer.truth(scene.resized(8, 8), 1).mean
    np.testing.assert_allclose(opening.answer.truth(open_roof, 1).mean, expected, rtol=1e-13)


def test_the_hole_of_a_ceiling() -> None:
    hole = Quad((0.5, 3.0, 1.0), (2.0, 0.0, 0.0), (0.0, 0.0, 1.5))
    surfaces = room(0.5, 0.5, hole)
    assert hole_of(surfaces) == hole
    ceiling = [surface.shape for surface in surfaces if surface.name.startswith("ceiling")]
    assert sum(shape.area for shape in ceiling) == pytest.approx(16 - hole.area)
    assert sum(surface.shape.area for surface in room(0.5, 0.5)) == pytest.approx(80)


# ---- what the report prints, as transcribed


def at(found: Case, scene: Scene, x: np.ndarray, n: np.ndarray) -> float:
    """Illuminance at a point of the floor or the wall, from one pixel of a millimetre."""
    origin = x + 0.05 * np.array([0.0, 0.8, 0.6])
    eye = Orthographic(tuple(origin.tolist()), tuple(x.tolist()), (0.0, 1.0, 0.0), 1e-3, 1, 1)
    truth = found.answer.truth(replace(scene, sensor=eye), 1)
    assert truth is not None
    albedo = next(s.material.albedo for s in scene.surfaces if np.allclose(s.shape.normal, n))
    return float(np.pi / albedo[0] * truth.mean[1, 0, 0, 0])


TABLE_11 = {
    (0.0, 0.0): 111.11,
    (0.5, 0.0): 105.21,
    (1.0, 0.0): 90.02,
    (1.5, 0.0): 71.11,
    (0.5, 0.5): 99.73,
    (1.0, 0.5): 85.64,
    (1.5, 0.5): 68.06,
    (1.0, 1.0): 74.36,
    (1.5, 1.0): 59.98,
    (1.5, 1.5): 49.39,
}
UP, INTO_THE_ROOM = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])


def test_point_light_sources() -> None:
    """1000 cd cos θ at 3 m, and 1000 cd: a cosine more."""
    lamp, point = case("cie-171-small-lamp"), case("cie-171-point")
    for (x, z), printed in TABLE_11.items():
        d = math.sqrt(x**2 + z**2 + 9)
        found = at(lamp, lamp.scene, np.array([x, 0.0, z]), UP)
        assert found == pytest.approx(1000 * 9 / d**4, rel=2e-5)
        assert found == pytest.approx(printed, abs=0.025)
        assert at(point, point.scene, np.array([x, 0.0, z]), UP) == pytest.approx(1000 * 3 / d**3, rel=1e-7)
    for place in TABLE_11:  # all of them are in view
        assert abs(place[0] - 0.9) < 1 > abs(place[1] - 0.6)


ON_WALL = {2.75: (32.68, 32.68), 2.25: (75.09, 75.19), 1.75: (81.38, 81.32)}
ON_WALL |= {1.25: (69.12, 69.06), 0.75: (53.41, 53.40), 0.25: (39.90, 40.00)}
ON_FLOOR = {0.25: (61.27, 61.42), 0.75: (79.18, 79.26), 1.25: (95.52, 95.67), 1.75: (105.89, 105.78)}


def test_area_light_sources() -> None:
    """Height or distance from the wall: what the report prints (table 12), and what the case says."""
    found = case("cie-171-panel")
    places = [(np.array([2.0, y, 0.0]), INTO_THE_ROOM, *values) for y, values in ON_WALL.items()]
    places += [(np.array([2.0, 0.0, z]), UP, *values) for z, values in ON_FLOOR.items()]
    for x, n, printed, ours in places:
        value = at(found, found.scene, x, n)
        assert value == pytest.approx(illuminance(found.scene, x, n)[0], rel=1e-6)
        assert value == pytest.approx(ours, abs=0.005)
        assert value == pytest.approx(printed, rel=0.003)
        assert f"{ours:.2f}" in found.derivation


def slab(degrees: float, polarisations: bool) -> float:
    """Transmittance of a pane by a series of twenty reflections, Fresnel's formulas in sines and tangents."""
    theta = math.radians(max(degrees, 1e-4))
    beyond = math.asin(math.sin(theta) / 1.52)
    s = (math.sin(theta - beyond) / math.sin(theta + beyond)) ** 2
    p = (math.tan(theta - beyond) / math.tan(theta + beyond)) ** 2
    each = [s, p] if polarisations else [(s + p) / 2]
    return sum(sum((1 - R) ** 2 * R ** (2 * j) for j in range(40)) for R in each) / len(each)


@pytest.mark.parametrize(
    ("degrees", "stated"), [(0.0, "0.918"), (60.0, "0.831"), (80.0, "0.438")], ids=["normal", "60°", "80°"]
)
def test_transmittance_of_clear_glass(degrees: float, stated: str) -> None:
    """All bounces together, along a ray under that angle."""
    found = case("cie-171-glass")
    theta = math.radians(degrees)
    target = (0.3, 1.0 - math.cos(theta), 0.4 - math.sin(theta))
    ray = replace(found.scene.sensor, target=target, up=(1.0, 0.0, 0.0), fov=1e-4, width=1, height=1)
    truth = found.answer.truth(replace(found.scene, sensor=ray), 60)
    assert truth is not None
    assert not truth.mean[1::2].any()
    tau = truth.mean[:, 0, 0].sum(axis=0) / found.scene.surfaces[-1].emission.radiance
    np.testing.assert_allclose(tau, slab(degrees, polarisations=False), rtol=1e-6)
    assert stated == f"{tau[0]:.3f}"
    assert stated in found.derivation


def test_what_polarisation_would_change() -> None:
    derivation = case("cie-171-glass").derivation
    for degrees in (60.0, 80.0):
        assert f"{slab(degrees, polarisations=True):.3f} at {degrees:.0f}°" in derivation
    c = np.cos(np.radians([0.0, 60.0, 80.0]))
    fit = np.polyval([-1.775827, 4.014235, -1.428919, -3.058376, 3.156075, -0.028378], c)
    assert "{:.2f}, {:.2f} and {:.2f}".format(*fit) in derivation
