"""Emission: where it is zero, how points of emitters are chosen, and the density of that choice."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from reference_tracer.emission import Emitters
from reference_tracer.points import Points
from scenes import AreaLight, Lambertian, Pinhole, PolarRange, Quad, Scene, Sphere, Surface
from scenes.library import case

GREY = Lambertian((0.5, 0.5))
CAMERA = Pinhole((0.0, 0.0, 9.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0, 4, 4)
AXIS = (0.6, 0.0, -0.8)
QUAD = Quad((-1.0, -0.5, 2.0), (0.0, 1.2, 0.3), (1.5, 0.2, 0.0))  # its front looks down
COUNT = 60_000


def scene_of(*pairs: tuple[Quad | Sphere, AreaLight | None]) -> Scene:
    return Scene(tuple(Surface(str(i), shape, GREY, light) for i, (shape, light) in enumerate(pairs)), CAMERA)


def lamp(e: float, zone: PolarRange | None = None) -> AreaLight:
    return AreaLight((e, 2 * e), zone)


def at(x: np.ndarray, n: np.ndarray, surface: int = 0) -> Points:
    return Points(x, n, np.full(x.shape[1], surface))


def sphere_points(shape: Sphere, outward: np.ndarray) -> Points:
    x = np.array(shape.center)[:, None] + shape.radius * outward
    return at(x, -outward if shape.inward else outward)


def zone_histogram(outward: np.ndarray, axis: tuple, cos_low: float, cos_high: float) -> np.ndarray:
    """Counts over 10 × 12 cells of equal area of the zone."""
    across = np.cross(axis, [0.0, 1.0, 0.0])
    across /= np.linalg.norm(across)
    azimuth = np.arctan2(np.cross(axis, across) @ outward, across @ outward)
    counts = np.histogram2d(
        np.array(axis) @ outward, azimuth, (10, 12), [(cos_low, cos_high), (-np.pi, np.pi)]
    )[0]
    assert counts.sum() == outward.shape[1], "a point lies outside the zone"
    return counts


# ---- Le


def test_a_quad_emits_from_its_front_into_every_direction_alike() -> None:
    emitters = Emitters(scene_of((QUAD, lamp(3.0)), (Sphere((0, 0, 0), 1), None)))
    d = np.array([[0.0, 0.6, 0.8, 0.0], [0.0, 0.0, 0.6, 1.0], [-1.0, -0.8, 1e-9, 1.0]])
    points = at(np.zeros((3, 4)), np.tile(QUAD.normal[:, None], 4))
    front = QUAD.normal @ d > 0
    np.testing.assert_array_equal(emitters.Le(points, d), np.where(front, [[3.0], [6.0]], 0))
    assert front.any()
    assert not front.all()


def test_what_does_not_emit_is_dark() -> None:
    emitters = Emitters(scene_of((QUAD, lamp(3.0)), (Sphere((0, 0, 0), 1), None)))
    up = np.array([[0.0], [0.0], [1.0]])
    assert not emitters.Le(at(up, up, surface=1), up).any()
    assert not emitters.Le(Points.nowhere(up), up).any()


@pytest.mark.parametrize("inward", [False, True])
@pytest.mark.parametrize(("low", "high"), [(0, 45), (30, 100), (135, 180), (0, 180)])
def test_a_zone_is_measured_from_its_axis_seen_from_the_centre(inward: bool, low: float, high: float) -> None:
    shape = Sphere((1.0, 2.0, 3.0), 0.5, inward)
    emitters = Emitters(scene_of((shape, lamp(1.0, PolarRange(low, high, AXIS)))))
    degrees = np.array([low - 1, low + 1, (low + high) / 2, high - 1, high + 1])
    degrees = degrees[(degrees >= 0) & (degrees <= 180)]
    across = np.array([0.8, 0.0, 0.6])
    outward = np.outer(AXIS, np.cos(np.radians(degrees))) + np.outer(across, np.sin(np.radians(degrees)))
    points = sphere_points(shape, outward)
    inside = (degrees > low) & (degrees < high)
    np.testing.assert_array_equal(emitters.Le(points, points.n)[0], inside)
    assert not emitters.Le(points, -points.n).any()
    # the density of next-event sampling is that of the choice: zero where no point is chosen
    np.testing.assert_array_equal(emitters.pdf(points, points.n, np.ones(len(points))) > 0, inside)


# ---- the choice


@pytest.mark.parametrize("quad", [QUAD, Quad((0.0, 0.0, 5.0), (1e-3, 0.0, 0.0), (0.0, 0.0, 2e3))])
def test_points_of_a_quad_are_uniform(quad: Quad, follows: Callable) -> None:
    points = Emitters(scene_of((quad, lamp(1.0)))).sample(np.random.default_rng(1), COUNT)
    corner, u, v = (np.array(e) for e in (quad.corner, quad.edge_u, quad.edge_v))
    (s, t, height), *_ = np.linalg.lstsq(
        np.stack([u, v, quad.normal], axis=1), points.x - corner[:, None], rcond=None
    )
    np.testing.assert_allclose(height, 0, atol=1e-12)
    np.testing.assert_array_equal(points.n, np.tile(quad.normal[:, None], COUNT))
    counts = np.histogram2d(s, t, (12, 12), [(0, 1), (0, 1)])[0]
    assert counts.sum() == COUNT
    assert follows(counts, np.full(144, 1 / 144))
    # a density that grows by a fifth across the quad is found out
    assert not follows(counts, np.repeat(np.linspace(0.9, 1.1, 12), 12) / 144)


@pytest.mark.parametrize("inward", [False, True])
@pytest.mark.parametrize(("low", "high"), [(0, 180), (0, 45), (60, 120)])
def test_points_of_a_zone_are_uniform(inward: bool, low: float, high: float, follows: Callable) -> None:
    shape, zone = Sphere((1.0, 2.0, 3.0), 0.5, inward), PolarRange(low, high, AXIS)
    points = Emitters(scene_of((shape, lamp(1.0, zone)))).sample(np.random.default_rng(2), COUNT)
    outward = (points.x - np.array(shape.center)[:, None]) / shape.radius
    np.testing.assert_allclose(np.linalg.norm(outward, axis=0), 1, atol=1e-14)
    np.testing.assert_allclose(points.n, -outward if inward else outward, atol=1e-14)
    counts = zone_histogram(outward, AXIS, *zone.cosines)
    assert follows(counts, np.full(120, 1 / 120))


def several() -> tuple[Scene, np.ndarray]:
    """Emitters of different power between dark surfaces, and their powers: mean radiance × area."""
    cap = PolarRange(0, 60)
    lights = [
        (QUAD, None),
        (QUAD, lamp(2.0)),
        (Sphere((0, 0, 0), 0.5), lamp(0.4)),
        (Sphere((3, 0, 0), 0.5, True), lamp(5.0, cap)),
        (QUAD, lamp(0.0)),
        (Quad((0, 0, 0), (0.1, 0, 0), (0, 0.2, 0)), lamp(50.0)),
        (QUAD, None),
    ]
    areas = np.array([shape.area for shape, _ in lights])
    areas[3] *= 0.25  # (1 − cos 60°) / 2
    return scene_of(*lights), areas * [light.radiance[0] * 1.5 if light else 0 for _, light in lights]


def test_emitters_are_chosen_by_power(follows: Callable) -> None:
    scene, power = several()
    points = Emitters(scene).sample(np.random.default_rng(3), COUNT)
    counts = np.bincount(points.surface, minlength=len(power))
    assert not counts[power == 0].any()
    chosen = power > 0
    assert follows(counts[chosen], power[chosen] / power.sum())
    assert not follows(counts[chosen], np.full(chosen.sum(), 1 / chosen.sum()))


# ---- the density as a solid angle: the mean of 1/pdf over the choice is the solid angle of all emitters


def triangle(x: np.ndarray, *corners: np.ndarray) -> float:
    """Solid angle of a triangle (van Oosterom and Strackee 1983), without sign."""
    a, b, c = (corner - x for corner in corners)
    la, lb, lc = (np.linalg.norm(e) for e in (a, b, c))
    below = la * lb * lc + a @ b * lc + a @ c * lb + b @ c * la
    return 2 * math.atan2(abs(a @ np.cross(b, c)), below)


def quad_angle(quad: Quad, x: np.ndarray) -> float:
    corner, u, v = (np.array(e) for e in (quad.corner, quad.edge_u, quad.edge_v))
    if (x - corner) @ quad.normal <= 0:
        return 0.0
    return triangle(x, corner, corner + u, corner + u + v) + triangle(x, corner, corner + u + v, corner + v)


def sphere_angle(sphere: Sphere, x: np.ndarray) -> float:
    """Of the front; the inside of a sphere, seen from within, is all around."""
    ratio = sphere.radius / np.linalg.norm(x - sphere.center)
    if sphere.inward:
        return 4 * np.pi if ratio > 1 else 2 * np.pi * (1 - math.sqrt(1 - ratio**2))
    return 2 * np.pi * (1 - math.sqrt(1 - ratio**2)) if ratio < 1 else 0.0


BALL, CAVITY = Sphere((0.5, 0.2, -1.0), 0.4), Sphere((0.0, 0.0, 0.5), 3.0, inward=True)
SMALL = Quad((2.0, -1.0, 0.5), (0.0, 0.8, 0.1), (-0.2, 0.0, 0.9))


@pytest.mark.parametrize(
    "shapes",
    [(QUAD,), (BALL,), (CAVITY,), (QUAD, BALL, SMALL)],
    ids=lambda s: f"{len(s)} of {type(s[0]).__name__}",
)
@pytest.mark.parametrize("x", [(0.1, 0.2, 0.3), (-0.7, 0.1, -0.6), (0.0, 0.0, 30.0)])
def test_the_mean_of_one_over_pdf_is_the_solid_angle(
    shapes: tuple, x: tuple, expect_means: Callable[..., None], off: type[Exception]
) -> None:
    here, batches = np.array(x), 64
    emitters = Emitters(scene_of(*((shape, lamp(1.0 + i)) for i, shape in enumerate(shapes))))
    points = emitters.sample(np.random.default_rng(4), COUNT // batches * batches)
    segment = here[:, None] - points.x
    squared = (segment**2).sum(axis=0)
    pdf = emitters.pdf(points, segment / np.sqrt(squared), squared)
    inverse = np.divide(1, pdf, out=np.zeros_like(pdf), where=pdf > 0).reshape(batches, -1).mean(axis=1)
    angle = sum((quad_angle if isinstance(s, Quad) else sphere_angle)(s, here) for s in shapes)
    if angle == 0:
        assert not inverse.any()
        return
    expect_means(inverse, angle, resolution=0.07)
    with pytest.raises(off):
        expect_means(1.15 * inverse, angle, resolution=0.1)


def test_no_density_from_behind_and_nowhere() -> None:
    emitters, up = Emitters(case("cornell-box").scene), np.array([[0.0], [0.0], [1.0]])
    assert not emitters.pdf(Points.nowhere(up), up, np.ones(1)).any()
    lamp_points = emitters.sample(np.random.default_rng(5), 100)
    assert not emitters.pdf(lamp_points, -lamp_points.n, np.ones(100)).any()
    sideways = np.tile([[1.0], [0.0], [0.0]], 100)
    assert not emitters.pdf(lamp_points, sideways, np.ones(100)).any()
    area = 0.46 * 0.38
    np.testing.assert_allclose(emitters.pdf(lamp_points, lamp_points.n, np.full(100, 4.0)), 4 / area)
