"""Form factors against closed forms and against brute force."""

from __future__ import annotations

from math import atan, log, pi, sqrt

import numpy as np
import pytest

from reference_tracer.elements.bases import Patches, graded, uniform
from reference_tracer.elements.form_factors import (
    AdaptiveQuadrature,
    FarBlock,
    far_orders,
    kernel,
    of_patches,
    point_to_polygon,
    separation,
)
from reference_tracer.elements.separable_kernel import Aligned, PerpendicularBlock, Transforms, exponents
from reference_tracer.propagation import RayCaster
from scenes import AreaLight, Lambertian, Pinhole, Quad, Scene, Surface

# unit squares (Howell, A catalog of radiation heat transfer configuration factors, C-11 and C-14)
PARALLEL = 2 / pi * (log(2 / sqrt(3)) + 2 * sqrt(2) * atan(1 / sqrt(2)) - 2 * atan(1))
PERPENDICULAR = (2 * atan(1) - sqrt(2) * atan(1 / sqrt(2)) + log(3 / 4) / 4) / pi
FLOOR = Quad((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
WALL = Quad((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
CEILING = Quad((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
TILTED = Quad((1.2, 0.1, 0.4), (-0.1, 0.2, 0.8), (0.1, 0.9, 0.2))


def patches(quad: Quad, order: int = 5, levels: int = 4) -> Patches:
    mesh = graded(order, levels, True, True)
    return Patches.of(quad, (mesh, mesh))


def plain(quad: Quad, order: int, cells: int) -> Patches:
    return Patches.of(quad, (uniform(order, cells), uniform(order, cells)))


def by_brute_force(x: np.ndarray, n: np.ndarray, source: Patches, f: np.ndarray | float = 1.0) -> np.ndarray:
    values = kernel(x[:, :, None], n[:, None, None], source.nodes[:, None, :], source.normal[:, None, None])
    return values @ (source.weights * f)


def test_closed_forms_of_unit_squares() -> None:
    assert pytest.approx(0.199825, abs=1e-6) == PARALLEL
    assert pytest.approx(0.200044, abs=1e-6) == PERPENDICULAR
    floor, wall, ceiling = patches(FLOOR), patches(WALL), patches(CEILING)
    ones = np.ones((1, len(floor)))
    orders = far_orders(floor, ceiling, 1e-12)
    assert orders is not None
    far = FarBlock(floor, ceiling, orders)(ones)[0]
    assert far @ floor.weights == pytest.approx(PARALLEL, abs=1e-10)
    a, b = (Aligned.of(p, np.eye(3), 1.0) for p in (floor, wall))
    assert a is not None
    assert b is not None
    near = PerpendicularBlock(a, b, Transforms(exponents(1e-5, 2.0)))(ones)[0]
    assert near @ floor.weights == pytest.approx(PERPENDICULAR, abs=1e-9)
    n = np.tile(floor.normal[:, None], len(floor))
    assert point_to_polygon(floor.nodes, n, wall.corners) @ floor.weights == pytest.approx(
        PERPENDICULAR, abs=1e-9
    )


def test_lamberts_formula_against_brute_force() -> None:
    source = plain(TILTED, 12, 8)
    x = np.array([[0.1, 0.5, 0.9, 0.2], [0.2, 0.6, 0.1, 0.9], [0.0, 0.0, 0.0, 0.0]])
    n = np.array([0.0, 0.0, 1.0])
    found = point_to_polygon(x, np.tile(n[:, None], 4), source.corners)
    np.testing.assert_allclose(found, by_brute_force(x, n, source), rtol=1e-9)
    # a point right below the middle of a large square sees almost all of the sky: 1 − O(1/size²)
    size = 1e3
    sky = Quad((-size, -size, 1.0), (0.0, 2 * size, 0.0), (2 * size, 0.0, 0.0))
    all_of_it = point_to_polygon(np.zeros((3, 1)), n[:, None], plain(sky, 1, 1).corners)
    assert all_of_it[0] == pytest.approx(1, abs=2 / size**2)
    # the two halves of a quad add up to the quad, also as triangles
    c = source.corners
    halves = sum(point_to_polygon(x, np.tile(n[:, None], 4), c[:, k]) for k in ([0, 1, 2], [0, 2, 3]))
    np.testing.assert_allclose(halves, found, rtol=1e-12)


def test_patches_of_one_value_add_up() -> None:
    floor, source = plain(FLOOR, 3, 2), plain(TILTED, 1, 4)
    whole = point_to_polygon(floor.nodes, np.tile(floor.normal[:, None], len(floor)), source.corners)
    matrix = of_patches(floor, source)
    np.testing.assert_allclose(matrix.sum(axis=1), whole, rtol=1e-12)
    k = 6  # a single one, by brute force
    s, t = source.coordinates(source.nodes[:, k : k + 1])
    part = Quad(
        tuple(source.points(s - 1 / 8, t - 1 / 8)[:, 0]),
        tuple(np.array(TILTED.edge_u) / 4),
        tuple(np.array(TILTED.edge_v) / 4),
    )
    np.testing.assert_allclose(
        matrix[:, k], by_brute_force(floor.nodes, floor.normal, plain(part, 10, 4)), rtol=1e-8
    )


def test_adaptive_quadrature_of_a_tilted_quad() -> None:
    """Constants against Lambert, products of s and t against brute force."""
    floor, source = plain(FLOOR, 3, 2), plain(TILTED, 4, 2)
    matrix = AdaptiveQuadrature(floor, source).matrix
    whole = point_to_polygon(floor.nodes, np.tile(floor.normal[:, None], len(floor)), source.corners)
    np.testing.assert_allclose(matrix.sum(axis=1), whole, atol=2e-6)
    s, t = source.coordinates(source.nodes)
    fine = plain(TILTED, 12, 8)
    u, v = fine.coordinates(fine.nodes)
    expected = by_brute_force(floor.nodes, floor.normal, fine, u**3 * v + 1)
    np.testing.assert_allclose(matrix @ (s**3 * t + 1), expected, atol=2e-6)


def test_adaptive_quadrature_at_a_shared_edge() -> None:
    """Nodes 0.002 from the edge still find the half of their sky that the wall is."""
    floor, wall = patches(FLOOR, 3, 2), patches(WALL, 3, 2)
    matrix = AdaptiveQuadrature(floor, wall).matrix
    whole = point_to_polygon(floor.nodes, np.tile(floor.normal[:, None], len(floor)), wall.corners)
    assert whole.max() > 0.49
    np.testing.assert_allclose(matrix.sum(axis=1), whole, atol=1e-4)


def test_far_block_against_brute_force() -> None:
    away = Quad((3.0, -0.5, 0.2), (0.0, 1.0, 0.3), (-0.4, 0.1, 1.0))
    floor, source = patches(FLOOR, 4, 1), patches(away, 4, 1)
    orders = far_orders(floor, source, 1e-9)
    assert orders is not None
    s, t = source.coordinates(source.nodes)
    found = FarBlock(floor, source, orders)((s**3 - t)[None])[0]
    fine = plain(away, 12, 4)
    u, v = fine.coordinates(fine.nodes)
    np.testing.assert_allclose(found, by_brute_force(floor.nodes, floor.normal, fine, u**3 - v), atol=1e-10)


def test_what_is_near_is_not_taken_for_far() -> None:
    floor, wall, ceiling = plain(FLOOR, 2, 1), plain(WALL, 2, 1), plain(CEILING, 2, 1)
    assert far_orders(floor, wall, 1e-9) is None
    assert separation(floor, wall) == 0
    assert separation(floor, ceiling) == 1
    assert far_orders(floor, ceiling, 1e-9) is not None


@pytest.mark.parametrize(("slope", "off"), [(0.0, 1e-6), (0.3, 1e-6), (-0.4, 2e-5)])
def test_half_of_a_source_is_hidden(slope: float, off: float) -> None:
    """A blocker close above the floor: what each node sees of the source is a quad, known by similarity."""
    white = Lambertian((0.5,))
    floor = Quad((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.1, 0.0))
    lamp = Quad((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    start = 0.3 - min(slope, 0.0) / 2  # its edge: x = start + slope · y
    blocker = Quad((-1.0 - slope, -1.0, 0.5), (1.0 + start, 0.0, 0.0), (3.0 * slope, 3.0, 0.0))
    surfaces = (
        Surface("floor", floor, white),
        Surface("lamp", lamp, white, AreaLight((1.0,))),
        Surface("blocker", blocker, white),
    )
    scene = Scene(surfaces, Pinhole((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 30.0, 4, 4))
    receiver, source = plain(floor, 2, 1), plain(lamp, 3, 2)
    found = AdaptiveQuadrature(receiver, source, (RayCaster(scene), 0, 1)).matrix.sum(axis=1)
    for node, value in zip(receiver.nodes.T, found, strict=True):
        # half way up, the ray from the node to (x, y) is at ((x + node_x) / 2, (y + node_y) / 2)
        first, last = (2 * start - node[0] + slope * (y + node[1]) for y in (0.0, 1.0))
        assert 0 < first < 1
        assert 0 < last < 1
        seen = np.array([[first, last, 1.0, 1.0], [0.0, 1.0, 1.0, 0.0], [1.0, 1.0, 1.0, 1.0]])
        expected = point_to_polygon(node[:, None], np.array([[0.0], [0.0], [1.0]]), seen)[0]
        assert value == pytest.approx(expected, abs=off)
        assert value != pytest.approx(
            point_to_polygon(node[:, None], receiver.normal[:, None], source.corners)[0], abs=0.05
        )
