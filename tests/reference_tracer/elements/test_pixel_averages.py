"""Pixel averages against areas and integrals that are known, with other surfaces in front, and in a real scene."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reference_tracer.elements.bases import Patches, graded, uniform
from reference_tracer.elements.pixel_averages import Polygons, View, image, pixels, visible_parts, weights
from scenes import Pinhole, Quad
from scenes.library import case
from scenes.library.cornell_box import empty_box

# one unit of the plane z = 0 is one pixel; the middle of the image is the origin, up is +y
FACING = Pinhole((0.0, 0.0, 4.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 90.0, 8, 8)


def facing(low: tuple[float, float], high: tuple[float, float], z: float = 0.0, order: int = 3) -> Patches:
    quad = Quad((low[0], low[1], z), (high[0] - low[0], 0.0, 0.0), (0.0, high[1] - low[1], 0.0))
    return Patches.of(quad, (graded(order, 2, True, False), uniform(order, 2)))


def overlap(low: float, high: float) -> np.ndarray:
    """Lengths of [low, high] in the eight unit intervals from −4."""
    ends = np.clip([low, high], np.arange(-4, 4)[:, None], np.arange(-3, 5)[:, None])
    return np.diff(ends, axis=1)[:, 0]


def area(low: tuple[float, float], high: tuple[float, float]) -> np.ndarray:
    """Of a rectangle in each pixel; row 0 at the top."""
    return np.outer(overlap(low[1], high[1])[::-1], overlap(low[0], high[0]))


def test_the_area_of_a_rectangle() -> None:
    low, high = (-1.3, -2.25), (2.6, 0.4)
    seen = facing(low, high)
    found = weights(FACING, [seen]) @ np.ones(len(seen))
    np.testing.assert_allclose(found.reshape(8, 8), area(low, high), atol=1e-12)


def test_the_average_of_a_polynomial() -> None:
    low, high = (-3.7, -1.2), (1.9, 3.1)
    seen = facing(low, high)
    x, y, _ = seen.nodes
    found = image(weights(FACING, [seen]), (x**2 * y)[None], FACING)[..., 0]
    corners_x, corners_y = (np.clip(np.arange(-4, 5), low[i], high[i]) for i in (0, 1))
    expected = np.outer((np.diff(corners_y**2) / 2)[::-1], np.diff(corners_x**3) / 3)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_what_is_in_front_hides_and_the_back_is_black() -> None:
    low, high = (-3.3, -3.1), (3.2, 2.9)
    behind = facing(low, high)
    blocker = facing((-0.4, -0.6), (0.7, 0.55), z=2.0)  # appears twice as large
    back = Patches(blocker.corner, blocker.edges[::-1], -blocker.normal, blocker.meshes[::-1])
    for front in (blocker, back):
        W = weights(FACING, [behind, front]).toarray()
        hidden = area((-0.8, -1.2), (1.4, 1.1))
        far, near = W[:, : len(behind)].sum(axis=1), W[:, len(behind) :].sum(axis=1)
        np.testing.assert_allclose(far.reshape(8, 8), area(low, high) - hidden, atol=1e-12)
        np.testing.assert_allclose(near.reshape(8, 8), hidden if front is blocker else 0 * hidden, atol=1e-12)


def test_two_blockers_that_overlap_in_the_image() -> None:
    behind = facing((-4.0, -4.0), (4.0, 4.0))
    one, two = facing((-1.0, -1.0), (0.5, 0.5), z=2.0), facing((0.0, 0.0), (1.5, 2.5), z=1.0)
    found = weights(FACING, [behind, one, two])[:, : len(behind)] @ np.ones(len(behind))
    both = area((-2.0, -2.0), (1.0, 1.0)) + area((0.0, 0.0), (2.0, 10 / 3)) - area((0.0, 0.0), (1.0, 1.0))
    np.testing.assert_allclose(found.reshape(8, 8), 1 - both, atol=1e-12)


def test_surfaces_behind_the_pinhole_are_not_seen() -> None:
    behind = Patches.of(Quad((-9.0, -9.0, 5.0), (18.0, 0.0, 0.0), (0.0, 18.0, 0.0)), (uniform(1, 1),) * 2)
    turned = Patches(behind.corner, behind.edges[::-1], -behind.normal, behind.meshes)
    assert weights(FACING, [behind, turned]).nnz == 0
    # a floor that runs from behind the pinhole to the horizon fills the lower half of the image
    floor = Quad((-1e4, -1.0, 1e4), (2e4, 0.0, 0.0), (0.0, 0.0, -2e4))
    level = Patches.of(floor, (uniform(1, 1),) * 2)
    seen = (weights(FACING, [level]) @ np.ones(1)).reshape(8, 8)
    np.testing.assert_allclose(seen[4:], np.repeat([[1 - 4e-4], [1], [1], [1]], 8, axis=1), atol=1e-6)
    assert not seen[:4].any()


def test_a_closed_room_fills_every_pixel() -> None:
    scene = case("furnace-box").scene
    surfaces = [Patches.of(s.shape, (graded(3, 2, True, True),) * 2) for s in scene.surfaces]
    total = weights(scene.sensor, surfaces).sum(axis=1)
    np.testing.assert_allclose(total, 1, atol=1e-11)


def test_a_smooth_function_of_the_position_in_perspective() -> None:
    """A wall seen at a grazing angle, by 100² rays per pixel."""
    scene = empty_box().resized(16, 16)
    i = [s.name for s in scene.surfaces].index("red-wall")
    surfaces = [Patches.of(s.shape, (graded(8, 2, True, True),) * 2) for s in scene.surfaces]
    x, y, z = surfaces[i].nodes
    W = weights(scene.sensor, surfaces)
    start = sum(len(p) for p in surfaces[:i])
    nodal = np.zeros(W.shape[1])
    nodal[start : start + len(x)] = np.exp(y) * np.cos(2 * z)
    found = (W @ nodal).reshape(16, 16)
    coarse, fine = (by_rays(scene.sensor, n) for n in (50, 100))
    # the rays' own error at the wall's edges: one row of 100 at most
    np.testing.assert_allclose(found, fine[0], atol=2 / 100)
    inner = fine[1]
    assert inner.any()
    richardson = (4 * fine[0] - coarse[0]) / 3  # the midpoint rule's error falls like 1/n²
    np.testing.assert_allclose(found[inner], richardson[inner], atol=1e-6)


def by_rays(sensor: Pinhole, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Averages over n² rays per pixel of e^y cos 2z on the wall x = −1, and which pixels see nothing else."""
    u = (np.arange(16 * n) + 0.5) / n
    pixel = np.stack([*np.meshgrid(u, u), np.ones((16 * n, 16 * n))])
    d = np.einsum("ij,jyx->iyx", sensor.pixel_to_direction, pixel)
    t = -1 / d[0]
    y, z = t * d[1], 3.9 + t * d[2]
    met = (t > 0) & (np.abs(y) <= 1) & (np.abs(z) <= 1)
    value = np.zeros(t.shape)
    value[met] = np.exp(y[met]) * np.cos(2 * z[met])
    shape = (16, n, 16, n)
    return value.reshape(shape).mean(axis=(1, 3)), met.reshape(shape).all(axis=(1, 3))


def test_the_emission_of_the_cornell_box_is_within_the_error_of_its_estimate() -> None:
    """18 quads, hidden by one another; the committed truth was made by ray casting."""
    found = case("cornell-box")
    truth = found.answer.truth(found.scene, 0)
    assert truth is not None
    assert truth.stderr is not None
    surfaces = [Patches.of(s.shape, (uniform(1, 1),) * 2) for s in found.scene.surfaces]
    emitted = [s.emission.radiance if s.emission else (0.0,) * 3 for s in found.scene.surfaces]
    mean = image(weights(found.scene.sensor, surfaces), np.array(emitted).T, found.scene.sensor)
    off, error = mean - truth.mean[0], truth.stderr[0]
    assert np.abs(off[error == 0]).max() < 0.02  # no ray met the lamp, or none missed it
    assert (np.abs(off[error > 0]) <= 5.5 * error[error > 0]).all()
    assert (error > 0).sum() > 60


@given(st.lists(st.tuples(st.floats(-4, 4), st.floats(-4, 4)), min_size=2, max_size=7))
def test_cutting_keeps_the_area(through: list[tuple[float, float]]) -> None:
    """Lines through pairs of points; a polygon cut by any of them keeps its area, on its own side."""
    whole = Polygons(pixels(FACING).vertices[[9]] - 2.5, np.array([9]))
    parts = whole
    for a, b in pairwise(np.array(through)):
        normal = np.array([a[1] - b[1], b[0] - a[0]])
        if (size := np.linalg.norm(normal)) < 1e-3:
            continue
        parts = parts.split(np.append(normal, -normal @ a) / size)
    assert (parts.pixel == 9).all()
    areas = parts.quadrilaterals().rule(1)[1].sum()
    assert areas == pytest.approx(1, abs=1e-10)


def test_visible_parts_of_one_surface_do_not_overlap() -> None:
    """Their areas in a pixel sum to no more than it, with a blocker that cuts them to pieces."""
    behind, front = facing((-4.0, -4.0), (4.0, 4.0)), facing((-0.3, -0.2), (0.4, 0.9), z=2.5)
    parts = visible_parts([View(FACING, p) for p in (behind, front)], 0, pixels(FACING)).quadrilaterals()
    per_pixel = np.bincount(parts.pixel, parts.rule(2)[1].sum(axis=1), minlength=64)
    assert per_pixel.max() <= 1 + 1e-12
    assert per_pixel.sum() == pytest.approx(64 - (4 / 1.5) ** 2 * 0.7 * 1.1)
