"""The scenes of the gallery that are no cases: nobody knows their answer, they only show what can be said."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from scenes import (
    AreaLight,
    Checkerboard,
    Dielectric,
    Disk,
    EnvironmentMap,
    Image,
    Lambertian,
    Mesh,
    Mirror,
    Pinhole,
    Quad,
    RoughConductor,
    Scene,
    Sphere,
    Surface,
)

Array = NDArray[np.float64]

# indices of refraction at about 630, 530 and 465 nm, rounded; Johnson and Christy 1972
GOLD = RoughConductor(eta=(0.19, 0.56, 1.40), k=(3.4, 2.2, 1.92), alpha=0.25)
SILVER = RoughConductor(eta=(0.05, 0.05, 0.04), k=(4.2, 3.4, 2.7), alpha=0.1)


def still_life(width: int, height: int) -> Scene:
    """Glass, a mirror and rough gold on a round table, a mesh, a disk lamp, an evening sky."""
    table = Disk((0.1, 0.0, 0.1), (3.1, 0.0, 0.0), (0.0, 0.0, -3.1))
    chequers = Lambertian(Checkerboard((0.75, 0.72, 0.66), (0.16, 0.19, 0.24), columns=10, rows=10))
    lamp = Disk((-2.0, 3.9, 1.4), (0.6, 0.0, 0.0), (0.0, 0.0, 0.6))
    clay = Lambertian((0.72, 0.27, 0.17))
    surfaces = (
        Surface("table", table, chequers),
        Surface("glass", Sphere((-0.62, 0.72, 1.1), 0.7), Dielectric(interior_ior=1.5)),
        Surface("mirror", Sphere((-1.55, 1.02, -0.9), 1.0), Mirror((0.92, 0.92, 0.92))),
        Surface("gold", Sphere((1.75, 0.82, -0.75), 0.8), GOLD),
        Surface("icosahedron", icosahedron((0.85, 0.5, 1.2), 0.6, turn=0.35), clay),
        Surface("lamp", lamp, Lambertian((0.0, 0.0, 0.0)), AreaLight((20.0, 17.0, 13.0))),
    )
    sensor = Pinhole((0.25, 2.7, 6.6), (0.1, 0.5, 0.0), (0.0, 1.0, 0.0), 30.0, width, height)
    return Scene(surfaces, sensor, (evening_sky(),))


def icosahedron(center: tuple[float, float, float], radius: float, turn: float = 0.0) -> Mesh:
    """Twenty triangles on three golden rectangles (Pacioli 1509), turned about y, standing on one of them."""
    golden = (1 + 5**0.5) / 2
    ends = [(0.0, s, t * golden) for s in (-1, 1) for t in (-1, 1)]
    vertices = np.array([np.roll(end, shift) for shift in range(3) for end in ends])
    # an edge is as long as a short side, 2; a face is three vertices that are all so near to each other
    near = np.isclose(np.linalg.norm(vertices[:, None] - vertices[None], axis=2), 2.0)
    triangles = [t for t in combinations(range(12), 3) if near[np.ix_(t, t)].sum() == 6]
    outward = [t if np.linalg.det(vertices[list(t)]) > 0 else t[::-1] for t in triangles]
    face = vertices[list(outward[0])].sum(axis=0)
    down, front = -_unit(face), _unit(vertices[outward[0][0]] - face / 3)
    stand = np.stack([np.cross(-down, front), -down, front])  # rows: x, y, z of the one that stands on a face
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]) @ stand
    placed = np.array(center) + radius / np.hypot(1, golden) * vertices @ rotation.T
    return Mesh(_tuples(placed), tuple(outward))


def evening_sky(rows: int = 32, columns: int = 64) -> EnvironmentMap:
    """A blue that pales towards the horizon, a warm glow low on the right, and dark ground."""
    theta = np.pi * (np.arange(rows) + 0.5) / rows
    phi = 2 * np.pi * (np.arange(columns) + 0.5) / columns
    up = np.cos(theta)[:, None, None] * np.ones((1, columns, 1))
    across = np.sin(theta)[:, None] * np.cos(phi)  # towards +x of the world
    zenith, horizon = np.array([0.10, 0.20, 0.45]), np.array([0.75, 0.62, 0.55])
    ground = np.array([0.05, 0.06, 0.09])
    radiance = horizon + (np.where(up > 0, zenith, ground) - horizon) * np.abs(up) ** 0.4
    toward_glow = (across * np.cos(0.3) + up[..., 0] * np.sin(0.3))[..., None]
    radiance = radiance + np.array([3.0, 1.5, 0.6]) * np.exp(30 * (toward_glow - 1)) * (up > 0)
    return EnvironmentMap(Image(_tuples(radiance)), ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)))


def plates(width: int, height: int) -> Scene:
    """Four plates of silver, rougher from far to near, that show the camera four lamps of the same power.

    The idea is that of Veach and Guibas 1995, figure 2; the numbers are ours. Every plate is turned so that its
    centre mirrors the row of lamps into the camera.
    """
    eye, lamps = np.array([0.0, 2.6, 9.0]), np.array([0.0, 3.4, -3.6])
    surfaces = [
        Surface(
            "wall", Quad((-9.0, -3.0, -5.0), (18.0, 0.0, 0.0), (0.0, 12.0, 0.0)), Lambertian((0.15,) * 3)
        ),
        Surface(
            "floor", Quad((-9.0, -1.0, 9.0), (18.0, 0.0, 0.0), (0.0, 0.0, -14.0)), Lambertian((0.15,) * 3)
        ),
    ]
    for i, alpha in enumerate((0.004, 0.02, 0.07, 0.2)):
        center = np.array([0.0, 0.9 - 0.42 * i, -2.0 + 1.3 * i])
        normal = _unit(_unit(eye - center) + _unit(lamps - center))
        down = np.cross(np.array([1.0, 0.0, 0.0]), normal)  # within the plate, towards the camera
        v = 0.9 * -down
        corner = center - np.array([2.9, 0.0, 0.0]) - v / 2
        plate = Quad(_tuple(corner), (5.8, 0.0, 0.0), _tuple(v))
        surfaces.append(Surface(f"plate-{i}", plate, replace(SILVER, alpha=alpha)))
    tints = ((1.0, 0.55, 0.35), (1.0, 0.9, 0.45), (0.5, 1.0, 0.6), (0.5, 0.7, 1.0))
    for i, (x, radius) in enumerate(zip((-2.4, -0.8, 0.8, 2.4), (0.04, 0.13, 0.32, 0.65), strict=True)):
        light = AreaLight(_tuple(0.9 * np.array(tints[i]) / radius**2))
        sphere = Sphere((x, float(lamps[1]), float(lamps[2])), radius)
        surfaces.append(Surface(f"lamp-{i}", sphere, Lambertian((0.0,) * 3), light))
    sensor = Pinhole(_tuple(eye), (0.0, 0.95, 0.0), (0.0, 1.0, 0.0), 32.0, width, height)
    return Scene(tuple(surfaces), sensor)


def _unit(v: Array) -> Array:
    return v / np.linalg.norm(v)


def _tuple(v: Array) -> tuple[float, float, float]:
    x, y, z = v.tolist()
    return x, y, z


def _tuples(a: Array) -> tuple:  # type: ignore[type-arg]
    """Nested lists as nested tuples, as frozen data wants them."""
    return tuple(map(_tuples, a)) if a.ndim > 1 else tuple(a.tolist())
