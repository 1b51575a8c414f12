"""Interreflection in spheres by quadrature over walls, lamps and bodies, and what pixels see by rays written out."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import msgspec
import numpy as np
import pytest

from scenes import AreaLight, Disk, Image, ImageTexture, Lambertian, Scene, Sphere, Surface
from scenes.library import case

BOUNCES, WIDTH, HEIGHT, FINE = 4, 10, 8, 64


# ---- quadrature over parts of spheres and over disks


def frame(axis: np.ndarray) -> np.ndarray:
    """Columns: two directions across the axis, and the axis."""
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    across = np.cross(axis, [0.6, -0.48, 0.64])
    across /= np.linalg.norm(across)
    return np.stack([across, np.cross(axis, across), axis], axis=1)


def zone(axis: np.ndarray, low: float, high: float, radius: float = 1.0) -> tuple[np.ndarray, ...]:
    """Points, outward normals and areas of a zone about an axis, angles in radians: Gauss in z, steps in azimuth."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    top, bottom = math.cos(low), math.cos(high)
    z = bottom + (top - bottom) * (nodes + 1) / 2
    phi = 2 * np.pi * (np.arange(96) + 0.3) / 96
    z, phi = (grid.ravel() for grid in np.meshgrid(z, phi))
    n = (
        np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z], axis=1)
        @ frame(axis).T
    )
    return radius * n, n, np.tile(weights * (top - bottom) / 2 * 2 * np.pi / 96, 96) * radius**2


def plate(disk: Disk) -> tuple[np.ndarray, ...]:
    """Points, front normals and areas of a disk: Gauss in the squared radius, steps in azimuth."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    r, phi = np.meshgrid(np.sqrt((nodes + 1) / 2), 2 * np.pi * (np.arange(160) + 0.3) / 160)
    r, phi = r.ravel(), phi.ravel()
    y = disk.center + np.outer(r * np.cos(phi), disk.axis_u) + np.outer(r * np.sin(phi), disk.axis_v)
    front = np.cross(disk.axis_u, disk.axis_v)
    area = np.linalg.norm(front)
    return y, np.tile(front / area, (len(y), 1)), np.tile(weights * np.pi * area / 2 / 160, 160)


def factor(x: np.ndarray, n: np.ndarray, y: np.ndarray, m: np.ndarray, areas: np.ndarray) -> np.ndarray:
    """cos θ cos θ′ / π|x − y|² times area, from one point to each; nothing from or to behind."""
    d = y - x
    squared = (d**2).sum(axis=1)
    return np.maximum(d @ n, 0) * np.maximum(-(d * m).sum(axis=1), 0) / (np.pi * squared**2) * areas


def wall_points(scene: Scene, away: float = 0.25) -> np.ndarray:
    """Points of the unit sphere that are inside of all disks and not near to any of their planes."""
    n = np.random.default_rng(2).normal(size=(300, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    for surface in scene.surfaces:
        if isinstance(surface.shape, Disk):
            n = n[(n - surface.shape.center) @ surface.shape.normal > away]
    assert len(n) > 20
    return n[:8]


# ---- what a pixel sees


def seen(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Of FINE² rays through each pixel, and one more all round: index of the nearest surface and place ``(n, 3)``."""
    camera = scene.sensor
    forward = np.subtract(camera.target, camera.origin)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, camera.up)
    right /= np.linalg.norm(right)
    extent = math.tan(math.radians(camera.fov / 2)) / min(camera.width, camera.height)
    x = extent * (2 * (np.arange(-1, camera.width * FINE + 1) + 0.5) / FINE - camera.width)
    y = extent * (camera.height - 2 * (np.arange(-1, camera.height * FINE + 1) + 0.5) / FINE)
    d = (forward + x[None, :, None] * right + y[:, None, None] * np.cross(right, forward)).reshape(-1, 3)
    d /= np.linalg.norm(d, axis=1)[:, None]
    o, best, index = np.array(camera.origin), np.full(len(d), np.inf), np.zeros(len(d), int)
    for i, shape in enumerate(surface.shape for surface in scene.surfaces):
        if isinstance(shape, Disk):
            n = np.cross(shape.axis_u, shape.axis_v)
            t = (np.subtract(shape.center, o) @ n) / (d @ n)
            inside = ((o + t[:, None] * d - shape.center) ** 2).sum(axis=1) <= np.dot(
                shape.axis_u, shape.axis_u
            )
            t = np.where(inside & (t > 0), t, np.inf)
        else:
            w = o - shape.center
            b, c = d @ w, w @ w - shape.radius**2
            root = np.sqrt(np.where(b * b > c, b * b - c, np.nan))
            t = np.nan_to_num(-b + root if shape.inward else -b - root, nan=np.inf)
        index[t < best], best[t < best] = i, t[t < best]
    return index, o + best[:, None] * d


Radiance = Callable[[np.ndarray, np.ndarray], np.ndarray]


def check_images(name: str, radiance: Radiance, rel: float) -> None:
    """Every bounce against ``radiance(surface index, places)``, ``(bounces + 1, n, channels)``.

    A pixel whose rays, and those next to it, all find the same must agree to ``rel``, one with an edge to what so
    many rays leave.
    """
    found = case(name)
    scene = found.scene.resized(WIDTH, HEIGHT)
    truth = found.answer.truth(scene, BOUNCES)
    assert truth is not None
    values = radiance(*seen(scene)).reshape(BOUNCES + 1, HEIGHT * FINE + 2, WIDTH * FINE + 2, -1)
    expected, spread = np.empty_like(truth.mean), np.empty_like(truth.mean)
    for row, column in np.ndindex(HEIGHT, WIDTH):
        window = values[:, row * FINE : (row + 1) * FINE + 2, column * FINE : (column + 1) * FINE + 2]
        expected[:, row, column] = window[:, 1:-1, 1:-1].mean(axis=(1, 2))
        spread[:, row, column] = np.ptp(window, axis=(1, 2))
    for k, image in enumerate(expected):
        scale = max(values[k].max(), 1e-300)
        smooth = spread[k] <= rel * scale
        assert smooth.mean() > 0.3
        np.testing.assert_allclose(truth.mean[k][smooth], image[smooth], rtol=0, atol=2 * rel * scale)
        np.testing.assert_allclose(truth.mean[k], image, rtol=0, atol=4e-3 * scale)
        np.testing.assert_allclose(truth.mean[k].mean(), image.mean(), rtol=0, atol=2e-4 * scale)


def albedo(surface: Surface) -> np.ndarray:
    return np.array(surface.material.albedo)


def radiance(surface: Surface) -> np.ndarray:
    return np.array(surface.emission.radiance) if surface.emission else np.zeros(3)


def per_surface(T: np.ndarray, E: np.ndarray) -> Radiance:
    """Radiance that is uniform on each surface: powers of a matrix per channel, ``(channels, to, from)``."""
    series = [E]
    for _ in range(BOUNCES):
        series.append(np.einsum("cij,jc->ic", T, series[-1]))
    return lambda index, places: np.array(series)[:, index]


# ---- bodies in a sphere


@pytest.mark.parametrize("name", ["sphere-two-caps", "sphere-flat-port"])
def test_flat_lamps_in_a_sphere(name: str) -> None:
    """Form factors from many points of the wall to each disk and to each cap behind, and back."""
    scene = case(name).scene
    wall, *lamps = scene.surfaces
    assert wall.shape.center == (0, 0, 0)
    assert wall.shape.radius == 1
    F = np.zeros((1 + len(lamps), 1 + len(lamps)))
    sees_wall = 1.0
    for i, lamp in enumerate(lamps, 1):
        axis, half = np.array(lamp.shape.center), math.acos(np.linalg.norm(lamp.shape.center))
        to_lamp = [factor(x, -x, *plate(lamp.shape)).sum() for x in wall_points(scene)]
        cap, normals, areas = zone(axis, 0, half)
        to_cap = [factor(x, -x, cap, -normals, areas).sum() for x in wall_points(scene)]
        np.testing.assert_allclose(to_lamp, to_lamp[0], rtol=1e-8)
        np.testing.assert_allclose(to_cap, to_lamp[0], rtol=1e-8)
        F[0, i] = to_lamp[0]
        sees_wall -= to_cap[0]
        y, front, _ = plate(lamp.shape)
        rest, normals, areas = zone(axis, half, np.pi)
        inner = np.flatnonzero(np.linalg.norm(y - lamp.shape.center, axis=1) < 0.8 * math.sin(half))[::97]
        back = [factor(y[j], front[j], rest, -normals, areas).sum() for j in inner]
        np.testing.assert_allclose(back, 1, rtol=1e-7)
        F[i, 0] = 1
    sphere, normals, areas = zone(np.array([0.0, 0.0, 1.0]), 0, np.pi)
    assert factor(
        wall_points(scene)[0], -wall_points(scene)[0], sphere, -normals, areas
    ).sum() == pytest.approx(1)
    F[0, 0] = sees_wall
    rho = np.array([albedo(surface) for surface in scene.surfaces])
    T = np.einsum("ic,ij->cij", rho, F)
    check_images(name, per_surface(T, np.array([radiance(surface) for surface in scene.surfaces])), rel=1e-7)


def test_concentric_spheres() -> None:
    """Form factors over what each point sees: the ball hides the shell beyond twice arccos r/R."""
    scene = case("concentric-spheres").scene
    shell, ball = scene.surfaces
    assert shell.shape.radius == 1
    limit = math.acos(ball.shape.radius)
    x = np.array([0.48, -0.6, 0.64])
    y, n, areas = zone(x, 0, limit, ball.shape.radius)
    to_ball = factor(x, -x, y, n, areas).sum()
    y, n, areas = zone(x, 0, 2 * limit)
    to_shell = factor(x, -x, y, -n, areas).sum()
    y, n, areas = zone(x, 0, limit)
    from_ball = factor(ball.shape.radius * x, x, y, -n, areas).sum()
    assert to_ball + to_shell == pytest.approx(1, abs=1e-9)
    F = np.array([[to_shell, to_ball], [from_ball, 0.0]])
    T = np.einsum("ic,ij->cij", np.array([albedo(shell), albedo(ball)]), F)
    check_images("concentric-spheres", per_surface(T, np.array([radiance(shell), radiance(ball)])), rel=1e-8)


@pytest.mark.parametrize("name", ["concentric-spheres", "sphere-flat-port"])
def test_emission_of_what_is_not_reflected_sums_to_one(name: str) -> None:
    """E = 1 − ρ on every surface makes radiance 1 everywhere, whatever the geometry (Szirmay-Kalos 2001)."""
    found = case(name)
    surfaces = tuple(
        msgspec.structs.replace(s, emission=AreaLight(tuple((1 - albedo(s)).tolist())))
        for s in found.scene.surfaces
    )
    truth = found.answer.truth(Scene(surfaces, found.scene.sensor).resized(6, 5), 200)
    assert truth is not None
    np.testing.assert_allclose(truth.mean.sum(axis=0), 1, rtol=1e-9)
    assert np.ptp(truth.mean[1, ..., 0]) > 0.05  # though no bounce is uniform


def test_what_is_no_enclosure_is_refused() -> None:
    found = case("sphere-two-caps")
    wall, large, small = found.scene.surfaces
    grey = msgspec.structs.replace(small, material=Lambertian((0.5, 0.5, 0.5)))
    with pytest.raises(ValueError, match="unevenly"):
        found.answer.truth(Scene((wall, large, grey), found.scene.sensor), 2)
    aside = Surface("aside", Sphere((0.1, 0.0, 0.5), 0.2), large.material, large.emission)
    with pytest.raises(ValueError, match="neither"):
        found.answer.truth(Scene((wall, aside), found.scene.sensor), 2)


# ---- a sphere of several albedos


def test_zones_of_several_albedos() -> None:
    """TE from the lamp, T²E and so on from zone to zone: what each point of the wall gets, by quadrature."""
    scene = case("sphere-zones").scene
    wall, lamp = scene.surfaces
    rows = np.array(wall.material.albedo.image.pixels)[:, 0]
    edges = np.linspace(0, np.pi, len(rows) + 1)
    points = wall_points(scene)

    def irradiance_over_pi(y: np.ndarray, front: np.ndarray, areas: np.ndarray) -> float:
        found = [factor(x, -x, y, front, areas).sum() for x in points]
        np.testing.assert_allclose(found, found[0], rtol=1e-8)
        return found[0]

    shares = []
    for low, high in pairwise(edges):
        y, n, areas = zone(np.array([0.0, 0.0, 1.0]), low, high)
        shares.append(irradiance_over_pi(y, -n, areas))
    to_lamp = irradiance_over_pi(*plate(lamp.shape))
    y, n, areas = zone(np.array(lamp.shape.center), 0, math.acos(np.linalg.norm(lamp.shape.center)))
    assert set(rows[(np.arccos(y[:, 2]) / np.pi * len(rows)).astype(int), 0]) == {rows[-1, 0]}
    hidden = irradiance_over_pi(y, -n, areas) * rows[-1]  # of what the zones would give

    series = [np.zeros_like(rows), rows * to_lamp * radiance(lamp)]
    for _ in range(BOUNCES - 1):
        last = series[-1] / rows
        series.append(rows * ((np.array(shares) @ rows - hidden) * last[0]))

    def seen_radiance(index: np.ndarray, places: np.ndarray) -> np.ndarray:
        row = np.minimum((np.arccos(places[:, 2].clip(-1, 1)) / np.pi * len(rows)).astype(int), len(rows) - 1)
        images = np.array(series)[:, row]
        images[:, index == 1] = 0
        images[0, index == 1] = radiance(lamp)
        return images

    check_images("sphere-zones", seen_radiance, rel=1e-7)


def test_zones_of_one_albedo_are_a_plain_wall() -> None:
    """By another formula: one lamp in a sphere."""
    plain, found = case("sphere-two-caps"), case("sphere-zones")
    wall, _, lamp = plain.scene.surfaces
    rows = Image(((wall.material.albedo,),) * 5)
    textured = msgspec.structs.replace(wall, material=Lambertian(ImageTexture(rows, "nearest")))
    expected = plain.answer.truth(Scene((wall, lamp), plain.scene.sensor).resized(6, 6), 5)
    same = found.answer.truth(Scene((textured, lamp), plain.scene.sensor).resized(6, 6), 5)
    assert expected is not None
    assert same is not None
    np.testing.assert_allclose(same.mean, expected.mean, rtol=1e-12)


def test_a_lamp_across_an_edge_of_zones_is_refused() -> None:
    found = case("sphere-zones")
    wall, lamp = found.scene.surfaces
    rows = Image((((0.1, 0.1, 0.1),), ((0.2, 0.2, 0.2),)))
    halves = msgspec.structs.replace(wall, material=Lambertian(ImageTexture(rows, "nearest")))
    with pytest.raises(ValueError, match="in one of the zones"):
        found.answer.truth(Scene((halves, lamp), found.scene.sensor), 1)


# ---- half a sphere on a mirror


def by_mirror(x: np.ndarray, n: np.ndarray, y: np.ndarray, m: np.ndarray, areas: np.ndarray) -> float:
    """As ``factor``, by way of the mirror y = 0: the way is bent where both angles to its normal are the same."""
    share = x[1] / (x[1] + y[:, 1])
    bend = x + share[:, None] * (y - x)
    bend[:, 1] = 0
    assert (np.linalg.norm(bend, axis=1) < 1).all()  # on the disk
    there, on = bend - x, y - bend
    length = np.linalg.norm(there, axis=1) + np.linalg.norm(on, axis=1)
    cosines = (
        (there @ n) / np.linalg.norm(there, axis=1),
        -(on * m).sum(axis=1) / np.linalg.norm(on, axis=1),
    )
    return float((cosines[0] * cosines[1] / (np.pi * length**2) * areas).sum())


def test_a_dome_on_a_mirror() -> None:
    """The cap directly and by way of the mirror; the dome directly; the mirror as a disk that shows the dome."""
    scene = case("dome-on-mirror").scene
    dome, mirror = scene.surfaces
    np.testing.assert_allclose(mirror.shape.normal, [0, 1, 0], atol=1e-15)
    cap, m = dome.emission.polar_range, np.array(mirror.material.reflectance)
    y, n, areas = zone(np.array(cap.axis), 0, math.radians(cap.high))
    half, half_normals, half_areas = zone(np.array([0.0, 1.0, 0.0]), 0, np.pi / 2)
    direct, bent, to_dome, to_mirror = np.array(
        [
            [
                factor(x, -x, y, -n, areas).sum(),
                by_mirror(x, -x, y, -n, areas),
                factor(x, -x, half, -half_normals, half_areas).sum(),
                factor(x, -x, *plate(mirror.shape)).sum(),
            ]
            for x in wall_points(scene, away=0.35)
        ]
    ).T
    for found in (direct, bent, to_dome, to_mirror):
        np.testing.assert_allclose(found, found[0], rtol=1e-8)

    e, rho = radiance(dome), albedo(dome)
    u = [np.zeros(3), rho * direct[0] * e]
    u.append(rho * (to_dome[0] * u[1] + bent[0] * m * e))
    while len(u) <= BOUNCES:
        u.append(rho * (to_dome[0] * u[-1] + to_mirror[0] * m * u[-2]))

    def seen_radiance(index: np.ndarray, places: np.ndarray) -> np.ndarray:
        d = places - scene.sensor.origin
        d = d * [1, -1, 1] / np.linalg.norm(d, axis=1)[:, None]  # mirrored, from the place on the mirror
        b = (places * d).sum(axis=1)
        there = places + (-b + np.sqrt(np.maximum(b**2 - (places**2).sum(axis=1) + 1, 0)))[:, None] * d
        images = np.zeros((BOUNCES + 1, len(index), 3))
        on_mirror = index == 1
        for k in range(BOUNCES + 1):
            images[k][~on_mirror] = u[k]
            images[k][on_mirror] = m * u[k - 1] if k else 0
        limit = math.cos(math.radians(cap.high))
        images[0][~on_mirror & (places @ cap.axis > limit)] = e
        images[1][on_mirror & (there @ cap.axis > limit)] += m * e
        return images

    check_images("dome-on-mirror", seen_radiance, rel=1e-8)
