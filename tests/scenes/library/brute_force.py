"""Direct light by brute force: every lamp is integrated point by point, with rays of the tests' own.

Nothing of the formulas is used, nor the library's camera: pixels are points on a plane before the eye, visibility is
a ray met with every surface by hand, and where it changes along a line over the lamp is found by bisection.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.special import lpmv

from scenes import (
    Case,
    Disk,
    Ellipsoid,
    EnvironmentMap,
    Lambertian,
    Mesh,
    Orthographic,
    PointLight,
    Quad,
    Scene,
    Shape,
    Sphere,
    SphericalHarmonicsEnvironment,
    SpotLight,
)

Point = np.ndarray
BY_REFLECTION = ("wall-by-reflection", "wall-behind-a-shelf")
EPSILON = 1e-9


def gauss(count: int, low: float = 0.0, high: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return low + (high - low) * (nodes + 1) / 2, weights * (high - low) / 2


# ---- rays


def camera_rays(sensor: Any, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Origins and unit directions ``(n, 3)`` for image coordinates in pixels from the top left."""
    forward = np.subtract(sensor.target, sensor.origin)
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, sensor.up)
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    flat = isinstance(sensor, Orthographic)
    half = sensor.extent / 2 if flat else math.tan(math.radians(sensor.fov / 2))
    scale = 2 * half / min(sensor.width, sensor.height)
    aside = np.outer(scale * (x - sensor.width / 2), right) + np.outer(scale * (sensor.height / 2 - y), up)
    if flat:
        return sensor.origin + aside, np.tile(forward, (len(x), 1))
    d = forward + aside
    return np.tile(sensor.origin, (len(x), 1)), d / np.linalg.norm(d, axis=1, keepdims=True)


def distances(shape: Shape, o: np.ndarray, d: np.ndarray) -> np.ndarray:
    """To the first hit of each ray ``(n, 3)``; infinite for none."""
    if isinstance(shape, Mesh):
        a, b, c = np.array(shape.vertices)[np.array(shape.triangles)].transpose(1, 0, 2)
        return np.min([flat(a[i], b[i] - a[i], c[i] - a[i], o, d, "triangle") for i in range(len(a))], axis=0)
    if isinstance(shape, Quad):
        return flat(*map(np.array, (shape.corner, shape.edge_u, shape.edge_v)), o, d, "quad")
    if isinstance(shape, Disk):
        return flat(*map(np.array, (shape.center, shape.axis_u, shape.axis_v)), o, d, "disk")
    M = shape.radius * np.eye(3) if isinstance(shape, Sphere) else shape.matrix
    o, d = np.linalg.solve(M, (o - shape.center).T).T, np.linalg.solve(M, d.T).T
    a, b, c = (d * d).sum(axis=1), (o * d).sum(axis=1), (o * o).sum(axis=1) - 1
    root = np.sqrt(np.maximum(b**2 - a * c, 0))
    t = (-b - root) / a
    return np.where((b**2 > a * c) & (t > EPSILON), t, np.inf)


def flat(p: Point, u: Point, v: Point, o: np.ndarray, d: np.ndarray, kind: str) -> np.ndarray:
    n = np.cross(u, v)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (p - o) @ n / (d @ n)
        w = o + t[:, None] * d - p
        r, s = np.cross(w, v) @ n / (n @ n), np.cross(u, w) @ n / (n @ n)
        inside = {
            "quad": (r >= 0) & (r <= 1) & (s >= 0) & (s <= 1),
            "triangle": (r >= 0) & (s >= 0) & (r + s <= 1),
            "disk": r**2 + s**2 <= 1,
        }[kind]
    return np.where(inside & (t > EPSILON), t, np.inf)


def seen(scene: Scene, x: Point, y: np.ndarray, lamp: Shape) -> np.ndarray:
    """Whether nothing but the lamp itself is between x and each point y ``(n, 3)`` of it."""
    free = np.ones(len(y), dtype=bool)
    for surface in scene.surfaces[1:]:
        if surface.shape is not lamp:
            free &= distances(surface.shape, np.tile(x, (len(y), 1)), y - x) > 1 - EPSILON
    return free


# ---- irradiance per radiance, by quadrature


def by_flat_lamp(
    scene: Scene, x: Point, n: Point, lamp: Shape, frame: tuple[Point, Point, Point], panels: int
) -> float:
    """Over p + s·u + t·v(s): lines of constant s, cut where visibility or the horizon changes along them.

    A triangle is a quad whose lines grow from nothing: ``lamp`` says which of both it is.
    """
    p, u, v = frame
    triangle = isinstance(lamp, Mesh)
    m = np.cross(u, v)  # as long as the quad is large
    total = 0.0
    nodes, weights = gauss(6)
    corners = shadows_of_corners(scene, x, lamp, frame)
    ends = np.unique(np.concatenate([np.linspace(0, 1, panels + 1), corners[0]]))
    s = (ends[:-1, None] + np.diff(ends)[:, None] * nodes).ravel()
    ds = (np.diff(ends)[:, None] * weights).ravel()
    length = s if triangle else np.ones_like(s)

    def place(t: np.ndarray) -> np.ndarray:
        if triangle:  # p + s (u + t (v − u))
            return p + s[:, None] * (u + t[:, None] * (v - u))
        return p + s[:, None] * u + t[:, None] * v

    def lights(t: np.ndarray) -> np.ndarray:
        y = place(t)
        return seen(scene, x, y, lamp) & ((y - x) @ n > 0)

    # beside the corners of a shadow it may be as narrow as it likes
    grid = np.concatenate([np.linspace(0, 1, 6), corners[1] - 1e-6, corners[1] + 1e-6])
    grid = np.unique(np.clip(grid, 1e-7, 1 - 1e-7))
    states = np.array([lights(np.full_like(s, t)) for t in grid])
    edges = [np.zeros_like(s)]
    for i in range(len(grid) - 1):  # at most one change per interval
        low, high = np.full_like(s, grid[i]), np.full_like(s, grid[i + 1])
        changes = states[i] != states[i + 1]
        if changes.any():
            for _ in range(45):
                middle = (low + high) / 2
                same = lights(middle) == states[i]
                low, high = np.where(same, middle, low), np.where(same, high, middle)
            edges.append(np.where(changes, low, grid[i + 1]))
    edges.append(np.ones_like(s))
    for low, high in pairwise(edges):
        lit = lights((low + high) / 2)
        for node, weight in zip(*gauss(16), strict=True):
            d = place(low + (high - low) * node) - x
            kernel = np.maximum(d @ n, 0) * np.maximum(-d @ m, 0) / (d * d).sum(axis=1) ** 2
            total += float((lit * kernel * length * ds * (high - low) * weight).sum())
    return total


def shadows_of_corners(scene: Scene, x: Point, lamp: Shape, frame: tuple[Point, Point, Point]) -> np.ndarray:
    """The s and the t ``(2, n)`` at which corners of other quads are seen before the lamp: kinks and jumps."""
    p, u, v = frame
    m, found = np.cross(u, v), []
    for surface in scene.surfaces[1:]:
        if surface.shape is lamp or surface.emission is not None or not isinstance(surface.shape, Quad):
            continue
        for i, j in np.ndindex(2, 2):
            d = (
                surface.shape.corner
                + i * np.array(surface.shape.edge_u)
                + j * np.array(surface.shape.edge_v)
                - x
            )
            y = x + d * ((p - x) @ m) / (d @ m)
            found.append([np.cross(y - p, v) @ m / (m @ m), np.cross(u, y - p) @ m / (m @ m)])
    return np.clip(np.reshape(found, (-1, 2)).T, 0, 1)


def by_round_lamp(x: Point, n: Point, lamp: Sphere | Disk | Ellipsoid) -> float:
    """Over the disk in polar coordinates; over the part of the unit sphere's image that faces x."""
    c, phi = np.array(lamp.center), 2 * np.pi * (np.arange(96) + 0.3) / 96
    if isinstance(lamp, Disk):
        r, weights = (g.repeat(96) for g in gauss(40))
        u, v, phi = np.array(lamp.axis_u), np.array(lamp.axis_v), np.tile(phi, 40)
        y = c + np.outer(r * np.cos(phi), u) + np.outer(r * np.sin(phi), v)
        dA = np.cross(u, v) * (r * weights * 2 * np.pi / 96)[:, None]
    else:
        M = lamp.radius * np.eye(3) if isinstance(lamp, Sphere) else lamp.matrix
        o = np.linalg.solve(M, x - c)
        away = np.linalg.norm(o)
        z, weights = (g.repeat(96) for g in gauss(40, 1 / away, 1.0))
        a = o / away
        b = np.cross(a, [0.6, 0.0, 0.8] if abs(a[1]) > 0.5 else [0.0, 1.0, 0.0])
        b /= np.linalg.norm(b)
        phi, rho = np.tile(phi, 40), np.sqrt(1 - z**2)
        p = np.outer(z, a) + np.outer(rho * np.cos(phi), b) + np.outer(rho * np.sin(phi), np.cross(a, b))
        y = c + p @ M.T
        dA = abs(np.linalg.det(M)) * p @ np.linalg.inv(M) * (weights * 2 * np.pi / 96)[:, None]
    d = y - x
    squared = (d * d).sum(axis=1)
    return float((np.maximum(d @ n, 0) * np.maximum(-(d * dA).sum(axis=1), 0) / squared**2).sum())


def by_lamp(scene: Scene, x: Point, n: Point, lamp: Shape, panels: int) -> float:
    if isinstance(lamp, Quad):
        frame = np.array(lamp.corner), np.array(lamp.edge_u), np.array(lamp.edge_v)
        return by_flat_lamp(scene, x, n, lamp, frame, panels)
    if isinstance(lamp, Mesh):
        [[a, b, c]] = np.array(lamp.vertices)[np.array(lamp.triangles)]
        return by_flat_lamp(scene, x, n, lamp, (a, b - a, c - a), panels)
    return by_round_lamp(x, n, lamp)


# ---- lights


def by_light(light: Any, x: Point, n: Point) -> np.ndarray:
    """Irradiance per channel."""
    if isinstance(light, PointLight | SpotLight):
        d = np.array(light.position) - x
        E = np.array(light.intensity) * max(d @ n, 0) / np.linalg.norm(d) ** 3
        if isinstance(light, SpotLight):
            angle = math.degrees(math.acos(-d @ light.direction / np.linalg.norm(d)))
            E *= np.interp(angle, [light.beam, light.cutoff], [1, 0])
        return E
    if isinstance(light, EnvironmentMap):
        return over_the_map(light, n)
    if isinstance(light, SphericalHarmonicsEnvironment):
        z, weights = (g.repeat(32) for g in gauss(16))
        phi = np.tile(2 * np.pi * np.arange(32) / 32, 16)
        b = np.cross(n, [0.0, 1.0, 0.0] if abs(n[1]) < 0.8 else [1.0, 0.0, 0.0])
        b /= np.linalg.norm(b)
        across = np.outer(np.cos(phi), b) + np.outer(np.sin(phi), np.cross(n, b))
        d = np.outer(z, n) + np.sqrt(1 - z**2)[:, None] * across
        return harmonic_radiance(light, d).T @ (z * weights * 2 * np.pi / 32)
    return np.array(light.irradiance) * max(-(n @ light.direction), 0)


def over_the_map(light: EnvironmentMap, n: Point) -> np.ndarray:
    """Cell by cell between the centres of texels, where the map is bilinear."""
    L = light.image.array
    rows, columns, _ = L.shape
    E, (f, w) = np.zeros(3), gauss(8)
    for i, j in np.ndindex(rows - 1, columns):
        corners = L[i, j], L[i, (j + 1) % columns], L[i + 1, j], L[i + 1, (j + 1) % columns]
        if not np.any(corners):
            continue
        v, h = (g.ravel() for g in np.meshgrid(f, f, indexing="ij"))
        theta, phi = (i + 0.5 + v) * np.pi / rows, (j + 0.5 + h) * 2 * np.pi / columns
        local = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
        weights = [(1 - v) * (1 - h), (1 - v) * h, v * (1 - h), v * h]
        radiance = sum(np.outer(a, b) for a, b in zip(weights, corners, strict=True))
        cosine = np.maximum(n @ (np.array(light.axes).T @ local), 0)
        E += radiance.T @ (cosine * np.sin(theta) * np.outer(w, w).ravel() * 2 * np.pi**2 / rows / columns)
    return E


def harmonic_radiance(light: SphericalHarmonicsEnvironment, d: np.ndarray) -> np.ndarray:
    """By associated Legendre functions, ``(n, 3)``."""
    x, y, z = np.array(light.axes) @ d.T
    phi, total, c = np.arctan2(y, x), np.zeros((len(d), 3)), np.array(light.coefficients)
    for k in range(len(c)):
        degree = math.isqrt(k)
        m = k - degree * (degree + 1)
        norm = math.factorial(degree - abs(m)) / math.factorial(degree + abs(m))
        P = (-1) ** m * lpmv(abs(m), degree, z)  # takes the Condon–Shortley phase away
        azimuth = 1.0 if m == 0 else math.sqrt(2) * (np.cos(m * phi) if m > 0 else np.sin(-m * phi))
        total += np.outer(math.sqrt((2 * degree + 1) / (4 * math.pi) * norm) * P * azimuth, c[k])
    return total


# ---- a pixel


def pixel_by_brute_force(found: Case, scene: Scene, pixel: tuple[int, int], count: int) -> np.ndarray:
    """The mean over the pixel of (ρ/π) × irradiance, count² points."""
    receiver = scene.surfaces[0]
    assert isinstance(receiver.material, Lambertian)
    nodes, weights = gauss(count)
    dy, dx = (g.ravel() for g in np.meshgrid(nodes, nodes, indexing="ij"))
    o, d = camera_rays(scene.sensor, pixel[1] + dx, pixel[0] + dy)
    points = o + distances(receiver.shape, o, d)[:, None] * d
    total = np.zeros(3)
    for x, weight in zip(points, np.outer(weights, weights).ravel(), strict=True):
        round_one = isinstance(receiver.shape, Sphere)
        n = (x - receiver.shape.center) / receiver.shape.radius if round_one else receiver.shape.normal
        total += weight * irradiance(found, scene, x, n)
    return np.array(receiver.material.albedo) / np.pi * total


def irradiance(found: Case, scene: Scene, x: Point, n: Point) -> np.ndarray:
    panels = 6
    if found.name in BY_REFLECTION:
        floor, [sun] = scene.surfaces[1], scene.lights
        b = np.array(floor.material.albedo) / np.pi * sun.irradiance * -(floor.shape.normal @ sun.direction)
        return b * by_lamp(scene, x, n, floor.shape, panels)
    E = np.zeros(3)
    for surface in scene.surfaces[1:]:
        if surface.emission is not None:
            E += np.array(surface.emission.radiance) * by_lamp(scene, x, n, surface.shape, panels)
    for light in scene.lights:
        E += by_light(light, x, n)
    return E
