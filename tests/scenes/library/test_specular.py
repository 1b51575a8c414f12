"""Smooth surfaces by following every branch of every ray through the scene, written out here for quads and spheres.

Fresnel's shares come from matching the fields at the boundary, the factor η² from the solid angles themselves.
"""

from __future__ import annotations

import math
from functools import cache

import msgspec
import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.interpolate import RegularGridInterpolator

from scenes import (
    Conductor,
    ConstantEnvironment,
    Dielectric,
    EnvironmentMap,
    Lambertian,
    Mirror,
    Pinhole,
    Quad,
    Scene,
    Sphere,
)
from scenes.library import case

SMOOTH = ("metal-angles", "glass-slab", "glass-ball", "inside-glass", "lamp-under-water", "cie-171-glass")
EDGES = ("mirror-lamps", "two-mirrors", "snells-window")


def boundary(cos_theta: np.ndarray, index: complex | np.ndarray) -> np.ndarray:
    """R by matching tangential fields: incident 1, reflected r, transmitted t, for both polarisations."""
    c1 = cos_theta.astype(complex)
    c2 = np.sqrt(1 - (1 - c1**2) / index**2)
    R = []
    for ratio in (index * c2 / c1, c2 / (index * c1)):  # of the other field's tangential parts, s and p
        one = np.ones_like(ratio)
        A = np.stack([np.stack([-one, one], -1), np.stack([one, ratio], -1)], -2)
        r, _ = np.linalg.solve(A, np.stack([one, one], -1)[..., None])[..., 0].T
        R.append(np.abs(r.T) ** 2)
    return np.where(np.abs(R[0] - 1) < 1e-14, 1.0, (R[0] + R[1]) / 2)


@cache
def normal_of(quad: Quad) -> np.ndarray:
    across = np.cross(quad.edge_u, quad.edge_v)
    return across / np.linalg.norm(across)


def meet(scene: Scene, o: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nearest surface (−1 for none), distance and outward normal of rays ``(n, 3)``."""
    best, which, normal = np.full(len(o), np.inf), np.full(len(o), -1), np.zeros_like(o)
    for i, surface in enumerate(scene.surfaces):
        shape = surface.shape
        with np.errstate(divide="ignore", invalid="ignore"):
            if isinstance(shape, Quad):
                u, v = np.array(shape.edge_u), np.array(shape.edge_v)
                n = np.broadcast_to(normal_of(shape), o.shape)
                t = (np.array(shape.corner) - o) @ n[0] / (d @ n[0])
                p = o + t[:, None] * d - shape.corner
                inside = (p @ u > 0) & (p @ u < u @ u) & (p @ v > 0) & (p @ v < v @ v)
                t = np.where(inside & (t > 1e-9), t, np.inf)
            else:
                assert isinstance(shape, Sphere)
                c = o - shape.center
                b = (c * d).sum(1)
                root = np.sqrt(b**2 - (c * c).sum(1) + shape.radius**2)
                t = np.where(-b - root > 1e-9, -b - root, np.where(-b + root > 1e-9, -b + root, np.inf))
                t = np.where(np.isfinite(root), t, np.inf)
                n = np.where(np.isfinite(t)[:, None], c + np.where(np.isfinite(t), t, 0)[:, None] * d, 1.0)
                n = n / np.linalg.norm(n, axis=1, keepdims=True)
        nearer = t < best
        best, which = np.where(nearer, t, best), np.where(nearer, i, which)
        normal = np.where(nearer[:, None], n, normal)
    return which, best, normal


def sky(environment: ConstantEnvironment | EnvironmentMap, d: np.ndarray) -> np.ndarray:
    """Radiance from directions ``(n, 3)``; of a map, by SciPy's interpolation between the centres of its pixels."""
    if isinstance(environment, ConstantEnvironment):
        return np.broadcast_to(environment.radiance, d.shape)
    pixels = np.array(environment.image.pixels)
    rows, columns, _ = pixels.shape
    x, y, z = (d @ axis for axis in np.array(environment.axes))
    theta = (np.arange(-1, rows + 1) + 0.5) * np.pi / rows
    phi = (np.arange(-1, columns + 1) + 0.5) * 2 * np.pi / columns
    padded = np.pad(
        np.pad(pixels, ((1, 1), (0, 0), (0, 0)), mode="edge"), ((0, 0), (1, 1), (0, 0)), mode="wrap"
    )
    longitude = np.mod(np.arctan2(y, x), 2 * np.pi)
    at = np.stack([np.arccos(np.clip(z, -1, 1)), longitude], axis=1)
    return RegularGridInterpolator((theta, phi), padded)(at)


def follow(scene: Scene, k: int, o: np.ndarray, d: np.ndarray) -> np.ndarray:
    """TᵏE along rays ``(n, 3)``, ``(n, channels)``."""
    found = np.zeros((len(o), scene.channels))
    if not len(o):
        return found
    which, t, n = meet(scene, o, d)
    if k == 0 and scene.environment is not None:
        found[which < 0] = sky(scene.environment, d[which < 0])
    for i, surface in enumerate(scene.surfaces):
        at = np.flatnonzero(which == i)
        x, di, ni = o[at] + t[at, None] * d[at], d[at], n[at]
        cos = -(di * ni).sum(1)
        if k == 0:
            if surface.emission is not None:
                found[at] = (cos > 0)[:, None] * surface.emission.radiance
            continue
        inside = cos < 0
        c, ns = np.abs(cos), np.where(inside[:, None], -ni, ni)
        mirrored = (x, di + 2 * c[:, None] * ns)
        match surface.material:
            case Lambertian(albedo):
                assert max(albedo) == 0
            case Mirror(reflectance):
                found[at] = follow(scene, k - 1, *mirrored) * reflectance * ~inside[:, None]
            case Conductor(eta, kappa):
                F = boundary(c[:, None], np.array(eta) + 1j * np.array(kappa))
                found[at] = follow(scene, k - 1, *mirrored) * F * ~inside[:, None]
            case Dielectric():
                m = surface.material.interior_ior / surface.material.exterior_ior
                index = np.where(inside, 1 / m, m)
                R = boundary(c, index)[:, None]
                tangent = (di + c[:, None] * ns) / index[:, None]
                through = 1 - (tangent**2).sum(1)
                bent = tangent - np.sqrt(np.maximum(through, 0))[:, None] * ns
                found[at] = R * follow(scene, k - 1, *mirrored)
                on = np.flatnonzero(through > 0)
                found[at[on]] += ((1 - R) / index[:, None] ** 2)[on] * follow(scene, k - 1, x[on], bent[on])
    return found


@cache
def frame(sensor: Pinhole) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    forward = np.subtract(sensor.target, sensor.origin)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, sensor.up)
    right /= np.linalg.norm(right)
    return right, np.cross(right, forward), forward


def through(scene: Scene, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rays through points of the image, in pixels from its top left corner, ``(n, 3)``."""
    sensor = scene.sensor
    right, up, forward = frame(sensor)
    extent = math.tan(math.radians(sensor.fov / 2)) / min(sensor.width, sensor.height)
    x, y = extent * (2 * x - sensor.width), extent * (sensor.height - 2 * y)
    d = forward + x[:, None] * right + y[:, None] * up
    return np.broadcast_to(np.array(sensor.origin), d.shape), d / np.linalg.norm(d, axis=-1, keepdims=True)


def camera(scene: Scene, fine: int) -> tuple[np.ndarray, np.ndarray]:
    """Rays through the centres of fine × fine squares of every pixel, row by row, ``(n, 3)``."""
    width, height = scene.sensor.width * fine, scene.sensor.height * fine
    x, y = np.meshgrid((np.arange(width) + 0.5) / fine, (np.arange(height) + 0.5) / fine)
    return through(scene, x.ravel(), y.ravel())


def averages(scene: Scene, k: int, fine: int) -> np.ndarray:
    image = follow(scene, k, *camera(scene, fine))
    sensor = scene.sensor
    return image.reshape(sensor.height, fine, sensor.width, fine, -1).mean(axis=(1, 3))


def averages_of_steps(scene: Scene, k: int, lines: int, columns: int) -> np.ndarray:
    """Averages of what is constant between edges: on each of the lines of a pixel edges are found by bisection."""
    image = np.zeros(scene.shape)
    some = np.pad(averages(scene, k, 12).any(axis=2), 1)
    near = np.lib.stride_tricks.sliding_window_view(some, (3, 3)).any(axis=(2, 3))
    x, y = np.arange(columns + 1) / columns, (np.arange(lines) + 0.5) / lines
    for row, column in np.argwhere(near):  # something is in the pixel or beside it; all others are black

        def at(x: np.ndarray, y: np.ndarray, row: int = row, column: int = column) -> np.ndarray:
            return follow(scene, k, *through(scene, column + x, row + y))

        values = at(np.tile(x, lines), np.repeat(y, columns + 1)).reshape(lines, columns + 1, -1)
        left, right = values[:, :-1], values[:, 1:]
        line, step = np.nonzero((left != right).any(axis=2))
        low, high = x[step], x[step + 1]
        for _ in range(25):
            middle = (low + high) / 2
            still = (at(middle, y[line]) == left[line, step]).all(axis=1)
            low, high = np.where(still, middle, low), np.where(still, high, middle)
        share = np.ones(left.shape[:2])  # of the step that has the value of its left end
        share[line, step] = (low - x[step]) * columns
        image[row, column] = (share[..., None] * left + (1 - share)[..., None] * right).mean(axis=(0, 1))
    return image


@pytest.mark.parametrize("name", SMOOTH)
def test_every_bounce_where_the_view_is_smooth(name: str) -> None:
    """Midpoint rules of 12² and 24² rays per pixel, extrapolated."""
    found = case(name)
    scene = found.scene.resized(7, 5)
    truth = found.answer.truth(scene, max(found.bounces, 4 if name == "cie-171-glass" else 0))
    assert truth is not None
    for k, image in enumerate(truth.mean):
        expected = (4 * averages(scene, k, 24) - averages(scene, k, 12)) / 3
        np.testing.assert_allclose(image, expected, rtol=1e-6, atol=1e-12)
    lit = truth.mean[truth.mean.any(axis=(1, 2, 3))]
    assert (lit.std(axis=(1, 2)) / lit.mean(axis=(1, 2))).max() > 0.03  # not all the same


def mean_of_steps(scene: Scene, k: int) -> np.ndarray:
    """Mean of an image of convex spots on black: ∫ r² dφ / 2 around each, its edge found by bisection."""
    width, height, fine = scene.sensor.width, scene.sensor.height, 40
    x, y = np.meshgrid((np.arange(width * fine) + 0.5) / fine, (np.arange(height * fine) + 0.5) / fine)
    coarse = follow(scene, k, *through(scene, x.ravel(), y.ravel()))
    total, phi = np.zeros(scene.channels), 2 * np.pi * np.arange(512) / 512
    for value in np.unique(coarse, axis=0):
        if not value.any():
            continue
        spot = (coarse == value).all(axis=1)
        middle = np.array([x.ravel()[spot].mean(), y.ravel()[spot].mean()])
        low, high = (
            np.zeros_like(phi),
            np.full_like(phi, 2.0 * np.sqrt(spot.sum() / np.pi) / fine),
        )  # beyond the edge
        for _ in range(50):
            r = (low + high) / 2
            at = middle[0] + r * np.cos(phi), middle[1] + r * np.sin(phi)
            still = (follow(scene, k, *through(scene, *at)) == value).all(axis=1)
            low, high = np.where(still, r, low), np.where(still, high, r)
        assert at[0].min() > 0 < at[1].min()
        assert (width - at[0]).min() > 0 < (height - at[1]).min()
        total += value * (low**2).mean() * np.pi
    return total / (width * height)


def test_images_of_spheres() -> None:
    """The mean of each image, and each pixel by a midpoint rule; the top of a spot leaves about N^(−3/2) there."""
    found = case("mirror-lamps")
    scene = found.scene.resized(12, 10)
    truth = found.answer.truth(scene, 2)
    assert truth is not None
    assert truth.mean.any(axis=(1, 2, 3)).tolist() == [True, True, False]
    for k, image in enumerate(truth.mean):
        np.testing.assert_allclose(image.mean(axis=(0, 1)), mean_of_steps(scene, k), rtol=1e-7)
        expected = averages_of_steps(scene, k, lines=300, columns=16)
        np.testing.assert_allclose(image, expected, rtol=0, atol=3e-4 * image.max())


def test_images_of_a_wall() -> None:
    """Each pixel by a midpoint rule, which is exact but where an edge meets a side of the pixel."""
    found = case("two-mirrors")
    scene = found.scene.resized(9, 8)
    truth = found.answer.truth(scene, 7)
    assert truth is not None
    for k, image in enumerate(truth.mean):
        assert image.any()
        expected = averages_of_steps(scene, k, lines=60, columns=10)
        np.testing.assert_allclose(image, expected, rtol=0, atol=3e-5 * image.max())


def over_pixel(scene: Scene, row: int, column: int) -> np.ndarray:
    """∫∫ TE over a pixel: lines by tanh-sinh rules, cut by bisection where refraction begins, then adaptively."""
    t = np.linspace(-3.2, 3.2, 49)
    u, du = np.tanh(np.pi / 2 * np.sinh(t)), np.pi / 2 * np.cosh(t) / np.cosh(np.pi / 2 * np.sinh(t)) ** 2
    eta = scene.surfaces[0].material.interior_ior

    def refracted(x: np.ndarray, y: float) -> np.ndarray:
        d = through(scene, x, np.full_like(x, y))[1]
        return eta * np.hypot(d[:, 0], d[:, 2]) < 1  # Snell's law

    def along(y: float) -> np.ndarray:
        ends = column + np.arange(9) / 8
        state = refracted(ends, y)
        crossed = np.flatnonzero(state[:-1] != state[1:])
        low, high = ends[crossed], ends[crossed + 1]
        for _ in range(50):
            middle = (low + high) / 2
            still = refracted(middle, y) == state[crossed]
            low, high = np.where(still, middle, low), np.where(still, high, middle)
        breaks = np.array([column, *low, column + 1.0])
        middle, half = (breaks[:-1] + breaks[1:]) / 2, np.diff(breaks) / 2
        x, dx = (middle[:, None] + half[:, None] * u).ravel(), np.outer(half, du * (t[1] - t[0])).ravel()
        return dx @ follow(scene, 1, *through(scene, x, np.full_like(x, y)))

    return quad_vec(along, row, row + 1, epsabs=1e-6)[0]


def test_the_window_of_snell() -> None:
    """Pixels that see the critical circle, one within it and one beyond; E and T²E are black."""
    found = case("snells-window")
    scene = found.scene.resized(9, 9)
    truth = found.answer.truth(scene, 2)
    assert truth is not None
    assert not truth.mean[[0, 2]].any()
    x, y = np.meshgrid(np.arange(10.0), np.arange(10.0))
    d = through(scene, x.ravel(), y.ravel())[1]
    inside = (1.33 * np.hypot(d[:, 0], d[:, 2]) < 1).reshape(10, 10)
    count = sum(inside[i : i + 9, j : j + 9].astype(int) for i in (0, 1) for j in (0, 1))
    crossed = np.argwhere((count > 0) & (count < 4))
    assert len(crossed) > 8
    for row, column in [*crossed[[0, -1]], np.argwhere(count == 4)[7], np.argwhere(count == 0)[5]]:
        expected = over_pixel(scene, int(row), int(column))
        np.testing.assert_allclose(truth.mean[1, row, column], expected, rtol=1e-6)


def test_the_window_shows_where_refraction_leads() -> None:
    """The sky in the direction of the ray itself, as if there were no bend, would be another image."""
    scene = case("snells-window").scene.resized(16, 16)
    o, d = camera(scene, 1)
    R = boundary(d[:, 1], np.full(len(d), 1 / 1.33))[:, None]
    mirrored = sky(scene.environment, d * [1, -1, 1])
    straight = 1.33**2 * (1 - R) * sky(scene.environment, d) + R * mirrored
    bent = follow(scene, 1, o, d)
    assert np.abs(straight - bent).mean() > 0.05 * bent.mean()
    np.testing.assert_allclose(bent[R[:, 0] == 1], mirrored[R[:, 0] == 1])


def test_a_view_beyond_the_cell_of_the_map_is_refused() -> None:
    found = case("snells-window")
    behind = msgspec.structs.replace(found.scene.sensor, target=(0.03, 0.3, 0.62))
    with pytest.raises(ValueError, match="bilinear cell"):
        found.answer.truth(msgspec.structs.replace(found.scene, sensor=behind), 1)


def test_hidden_lamps_are_refused() -> None:
    found = case("mirror-lamps")
    mirror, first, _ = found.scene.surfaces
    behind = msgspec.structs.replace(first, name="behind", shape=Sphere((-0.6, 0.9, -0.2), 0.3))
    with pytest.raises(ValueError, match="hides"):
        found.answer.truth(msgspec.structs.replace(found.scene, surfaces=(mirror, first, behind)), 1)


def test_the_slab_is_wide_enough() -> None:
    """At the last bounce that the answer holds for, along the rays in the corners of the image."""
    found = case("glass-slab")
    assert found.max_bounces is not None
    scene = found.scene.resized(2, 2)
    o, d = camera(
        msgspec.structs.replace(scene, sensor=msgspec.structs.replace(scene.sensor, width=9, height=9)), 1
    )
    R = boundary(-d[:, 1], np.full(len(d), 2.4))[:, None]
    for k in (found.max_bounces - 1, found.max_bounces):
        e = np.array(found.scene.environment.radiance if k % 2 else scene.surfaces[-1].emission.radiance)
        np.testing.assert_allclose(follow(scene, k, o, d), (1 - R) ** 2 * R ** (k - 2) * e, rtol=1e-9)


@pytest.mark.parametrize(("name", "factor"), [("glass-ball", 1.0), ("inside-glass", 1.5**2)])
def test_clear_glass_keeps_everything(name: str, factor: float) -> None:
    """All bounces together: the ball can't be seen, and inside it radiance is η² times that outside."""
    found = case(name)
    truth = found.answer.truth(found.scene.resized(6, 6), 40)
    assert truth is not None
    expected = factor * np.array(found.scene.environment.radiance)
    np.testing.assert_allclose(truth.mean.sum(axis=0), np.broadcast_to(expected, (6, 6, 3)), rtol=1e-9)


@pytest.mark.parametrize("degrees", [5.0, 40.0, 80.0])
def test_refraction_scales_radiance_by_the_squared_index(degrees: float) -> None:
    """Flux L cos θ dω is kept; dω = sin θ dθ dφ, dθ′/dθ by differences of Snell's law."""
    eta, h = 1.33, 1e-5
    theta = math.radians(degrees)
    bent = [math.asin(math.sin(t) / eta) for t in (theta - h, theta, theta + h)]
    spread = (bent[2] - bent[0]) / (2 * h)
    outside, inside = math.sin(theta) * math.cos(theta), math.sin(bent[1]) * math.cos(bent[1]) * spread
    assert outside / inside == pytest.approx(eta**2, rel=1e-7)


def test_metal_seen_from_straight_above() -> None:
    """((η − 1)² + k²) / ((η + 1)² + k²), Born and Wolf, §14.2."""
    found = case("metal-angles")
    above = msgspec.structs.replace(
        found.scene.sensor, target=(0.3, 0.0, 0.4), up=(0.0, 0.0, -1.0), fov=1e-3, width=1, height=1
    )
    scene = msgspec.structs.replace(found.scene, sensor=above)
    eta, k = np.array(scene.surfaces[0].material.eta), np.array(scene.surfaces[0].material.k)
    expected = ((eta - 1) ** 2 + k**2) / ((eta + 1) ** 2 + k**2) * scene.environment.radiance
    truth = found.answer.truth(scene, 1)
    assert truth is not None
    np.testing.assert_allclose(truth.mean[1, 0, 0], expected, rtol=1e-9)


@pytest.mark.parametrize("name", SMOOTH + EDGES)
def test_a_coarse_image_is_the_mean_of_a_fine_one(name: str) -> None:
    found = case(name)
    fine, coarse = (found.answer.truth(found.scene.resized(n, n), found.bounces) for n in (24, 6))
    assert fine is not None
    assert coarse is not None
    blocks = fine.mean.reshape(found.bounces + 1, 6, 4, 6, 4, 3).mean(axis=(2, 4))
    np.testing.assert_allclose(coarse.mean, blocks, rtol=1e-6, atol=1e-9)
