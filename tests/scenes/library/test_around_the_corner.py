"""The room by quadrature written out here: visibility is that of the floor plan, since all walls are upright."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from scenes import Quad, Scene
from scenes.library import case

BLOCK = np.array([[1.0, 1.0], [1.6, 2.7]])
"""The rectangle of the floor plan between the two arms of the room: low and high corner."""


@pytest.fixture(scope="module")
def scene() -> Scene:
    return case("around-the-corner").scene


def sees(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Whether the segments miss the block, ``(…, 3)`` both: slabs, in the floor plan."""
    d = y[..., :2] - x[..., :2]
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (BLOCK[0] - x[..., :2]) / d, (BLOCK[1] - x[..., :2]) / d
    enter, leave = np.fmin(a, b).max(axis=-1), np.fmax(a, b).min(axis=-1)
    return ~(np.maximum(enter, 0) + 1e-9 < np.minimum(leave, 1))


def nodes_of(quad: Quad, n: int, bottom: float = 0.0, top: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Gauss nodes of the part bottom < t < top of a quad, and the areas they stand for."""
    u, w = np.polynomial.legendre.leggauss(n)
    u, w = (u + 1) / 2, w / 2
    s, t = (a.ravel() for a in np.meshgrid(u, bottom + (top - bottom) * u))
    edges = np.array(quad.edge_u), np.array(quad.edge_v)
    points = np.array(quad.corner) + s[:, None] * edges[0] + t[:, None] * edges[1]
    return points, np.outer(w, w).ravel() * np.linalg.norm(np.cross(*edges)) * (top - bottom)


def exchange(x: np.ndarray, nx: np.ndarray, y: np.ndarray, ny: np.ndarray) -> np.ndarray:
    """cos θ cos θ′ / π|x − y|², ``(len(x), len(y))``, with normals per point ``(n, 3)``."""
    d = y[None] - x[:, None]
    cosines = np.maximum(np.einsum("ni,nmi->nm", nx, d), 0) * np.maximum(-np.einsum("mi,nmi->nm", ny, d), 0)
    return cosines / (np.pi * (d**2).sum(axis=-1) ** 2)


def form_factor(x: np.ndarray, n: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Lambert's formula for a polygon, counterclockwise, in front of points x ``(…, 3)`` with normals n."""
    r = corners - x[..., None, :]
    after = np.roll(r, -1, axis=-2)
    cross = np.cross(r, after)
    sine = np.linalg.norm(cross, axis=-1)
    angle = np.arctan2(sine, (r * after).sum(axis=-1))
    return -(angle * (cross @ n[..., None])[..., 0] / sine).sum(axis=-1) / (2 * np.pi)


def intervals(bounds: list[np.ndarray], count: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss nodes and weights between ascending bounds, one array each per bound: ``(…, intervals · count)``."""
    u, w = np.polynomial.legendre.leggauss(count)
    low, length = np.stack(bounds[:-1], axis=-1), np.diff(np.stack(bounds, axis=-1), axis=-1)
    nodes, weights = low[..., None] + length[..., None] * (u + 1) / 2, length[..., None] * w / 2
    return nodes.reshape(*low.shape[:-1], -1), weights.reshape(*low.shape[:-1], -1)


def second(scene: Scene, y: np.ndarray, n: np.ndarray, count: int = 8) -> np.ndarray:
    """T²E / ρ at points left of the lamp's part: over the directions in which that is seen, ``(points, 3)``.

    In the floor plan they lie between those of (1.6, 0) and of the edge that hides the rest; on each of them floor,
    wall and ceiling follow one another. TE there is Lambert's formula.
    """
    named = {s.name: s for s in scene.surfaces}
    edge = np.where(y[:, 1:2] > 1, [[1.0, 1.0]], [[1.6, 1.0]])
    low, high = (
        np.arctan2(p[:, 1] - y[:, 1], p[:, 0] - y[:, 0]) for p in (np.tile([[1.6, 0.0]], (len(y), 1)), edge)
    )
    high = np.maximum(low, high)
    corners = [np.arctan2(c - y[:, 1], 2.6 - y[:, 0]) for c in (0.0, 2.0)]
    phi, d_phi = intervals([low, *(np.clip(c, low, high) for c in corners), high], count)
    cos, sin, z = np.cos(phi), np.sin(phi), y[:, 2:3]
    with np.errstate(divide="ignore", invalid="ignore"):
        to_side = np.where(sin < 0, -y[:, 1:2] / sin, np.where(sin > 0, (2 - y[:, 1:2]) / sin, np.inf))
    wall, entry = np.minimum((2.6 - y[:, 0:1]) / cos, to_side), (1.6 - y[:, 0:1]) / cos
    bounds = [np.arctan2(h, d) for h, d in ((-z, entry), (-z, wall), (1 - z, wall), (1 - z, entry))]
    psi, d_psi = intervals(bounds, count)  # (points, directions, elevations)
    direction = np.stack(
        np.broadcast_arrays(cos[..., None] * np.cos(psi), sin[..., None] * np.cos(psi), np.sin(psi)), -1
    )
    weight = (
        d_phi[..., None]
        * d_psi
        * np.cos(psi)
        * np.maximum((direction * n[:, None, None]).sum(axis=-1), 0)
        / np.pi
    )

    third = np.repeat(np.arange(3), count)  # floor, wall, ceiling
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = np.where(
            third == 1,
            wall[..., None] / np.cos(psi),
            np.where(third == 0, -z[..., None], 1 - z[..., None]) / np.sin(psi),
        )
    reach = np.where(weight > 0, reach, 1.0)
    x = y[:, None, None] + reach[..., None] * direction
    side = np.where(to_side > (2.6 - y[:, 0:1]) / cos, 0, np.where(sin < 0, 1, 2))[..., None]
    names = ("end", "front", "niche", "floor-end", "ceiling-end")
    which = np.where(third == 0, 3, np.where(third == 2, 4, side))
    normals = np.array([named[name].shape.normal for name in names])
    albedos = np.array([named[name].material.albedo for name in names])
    lamp = named["lamp"]
    u, v = np.array(lamp.shape.edge_u), np.array(lamp.shape.edge_v)
    polygon = np.array(lamp.shape.corner) + np.array([0 * u, u, u + v, v])
    lit = weight * np.where(weight > 0, form_factor(x, normals[which], polygon), 0.0)
    return np.einsum("ped,pedc->pc", lit, albedos[which]) * lamp.emission.radiance


def gathered(scene: Scene, parts: list[tuple[str, float, float]], n: int) -> tuple[np.ndarray, ...]:
    """Nodes, normals, areas and albedos of parts of surfaces: name, bottom, top."""
    named = {s.name: s for s in scene.surfaces}
    points, normals, areas, albedos = [], [], [], []
    for name, bottom, top in parts:
        x, a = nodes_of(named[name].shape, n, bottom, top)
        points.append(x)
        areas.append(a)
        normals.append(np.tile(named[name].shape.normal, (len(x), 1)))
        albedos.append(np.tile(named[name].material.albedo, (len(x), 1)))
    return tuple(np.concatenate(parts) for parts in (points, normals, areas, albedos))


def test_what_is_seen_sees_nothing_that_the_lamp_lights(scene: Scene) -> None:
    """Camera rays by hand: the points they meet, against points all over the part with x > 1.6."""
    camera, rng = scene.sensor, np.random.default_rng(0)
    x, y = rng.random((2, 3000)) * camera.width
    o, d = np.array(camera.origin)[:, None], camera.pixel_to_direction @ np.stack([x, y, np.ones_like(x)])
    with np.errstate(divide="ignore"):
        t = np.minimum.reduce(
            [
                np.where(d[a] > 0, (high - o[a]) / d[a], (low - o[a]) / d[a])
                for a, low, high in ((0, 0.0, 1.0), (1, -np.inf, 2.7), (2, 0.0, 1.0))
            ]
        )
    seen = (o + t * d).T
    assert (seen[:, 1] > 1.65).all()
    lit = rng.random((3000, 3)) * [1.0, 2.0, 1.0] + [1.6, 0.0, 0.0]
    assert not sees(seen[:, None, :], lit[None]).any()
    assert sees(np.array([0.1, 1.1, 0.5]), np.array([2.0, 0.1, 0.5]))


def first_light(scene: Scene, rows: np.ndarray, columns: np.ndarray, n: int, count: int) -> np.ndarray:
    """T³E where the middles of pixels see the inner wall, ``(pixels, 3)``; n Gauss nodes per axis and panel."""
    breaks = [0.0, *(1 - y / 2.7 for y in (8 / 3, 2.1, 1.625, 1.0, 0.5)), 1.0]  # where shadows end
    between = [("outer", *ends) for ends in pairwise(breaks)] + [("front", 0.0, 1 / 2.6)]
    sides = [f"{side}-{part}" for side in ("floor", "ceiling") for part in ("corner", "leg")]
    between += [(side, a / 4, (a + 1) / 4) for side in sides for a in range(4)]
    y, normals, areas, albedos = gathered(scene, between, n)
    TTE = albedos * second(scene, y, normals, count)
    camera, inner = scene.sensor, next(s for s in scene.surfaces if s.name == "inner")
    d = camera.pixel_to_direction @ np.stack([columns + 0.5, rows + 0.5, np.ones(len(rows))])
    o = np.array(camera.origin)
    x = o + ((1 - o[0]) / d[0])[:, None] * d.T
    assert ((x[:, 1] > 1.8) & (x[:, 1] < 2.7) & (x[:, 2] > 0) & (x[:, 2] < 1)).all()
    K = exchange(x, np.tile(inner.shape.normal, (len(x), 1)), y, normals)
    assert sees(x[:, None], y[None])[K > 0].all()
    return np.array(inner.material.albedo) * ((K * areas) @ TTE)


def test_the_first_light_by_quadrature(scene: Scene) -> None:
    """T³E of four pixels of the inner wall: lamp → its part of the room → whatever sees both → wall."""
    found = case("around-the-corner")
    truth = found.answer.truth(found.scene, 3)
    assert truth is not None
    rows, columns = np.array([25, 30, 36, 40]), np.array([50, 46, 54, 58])
    expected = first_light(scene, rows, columns, 12, 8)
    np.testing.assert_allclose(truth.mean[3, rows, columns], expected, rtol=1e-4)


def test_nothing_arrives_before_bounce_3() -> None:
    found = case("around-the-corner")
    truth = found.answer.truth(found.scene, 6)
    assert truth is not None
    assert not truth.mean[:3].any()
    assert (truth.mean[3:] > 0).all()
