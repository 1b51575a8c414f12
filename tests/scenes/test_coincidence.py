"""Surfaces in the same place are refused, touching ones are not, whatever the plane, the scale and the order."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from itertools import permutations

import numpy as np
import pytest

from scenes import (
    Affine,
    ConstantEnvironment,
    Dielectric,
    Disk,
    Ellipsoid,
    Lambertian,
    Material,
    Mesh,
    Pinhole,
    Quad,
    Scene,
    SceneError,
    Shape,
    Sphere,
    Surface,
    box,
    sweep,
    transformed,
)
from scenes.coincidence import check_coincidence
from scenes.library import CASES, case
from scenes.overlaps import disks_overlap

GREY = Lambertian((0.5,))
X, Y, Z, ORIGIN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
PLACES = {
    "as it is": Affine(),
    "oblique and far": Affine.translation((100, -50, 7)) @ Affine.rotation((1, 2, 3), 40),
    "small": Affine.translation((3e-4, 0, 0)) @ Affine.scaling(1e-4) @ Affine.rotation((3, -1, 1), 100),
    "large and mirrored": Affine.scaling(-1e5) @ Affine.rotation((0, 1, 1), 10),
    "sheared": Affine(((1, 0.4, 0.1), (0, 2, 0.3), (0.2, 0, 1))),
}


def coincide(*shapes: Shape) -> bool:
    try:
        check_coincidence([Surface(str(i), shape, GREY) for i, shape in enumerate(shapes)])
    except SceneError:
        return True
    return False


def square(x: float = 0.0, y: float = 0.0, z: float = 0.0, size: float = 1.0) -> Quad:
    return Quad((x, y, z), (size, 0.0, 0.0), (0.0, size, 0.0))


def triangle(*corners: tuple[float, float]) -> Mesh:
    return Mesh([(x, y, 0.0) for x, y in corners], [(0, 1, 2)])


def circle(x: float = 0.0, y: float = 0.0, radius: float = 1.0, z: float = 0.0) -> Disk:
    return Disk((x, y, z), (radius, 0.0, 0.0), (0.0, radius, 0.0))


DIAGONAL = math.sqrt(0.5)
PAIRS: dict[str, tuple[Shape, Shape, bool]] = {
    "the same quad": (square(), square(), True),
    "turned over": (square(), Quad(ORIGIN, Y, X), True),
    "shifted": (square(), square(0.5, 0.5), True),
    "one inside the other": (square(), square(0.4, 0.4, size=0.1), True),
    "a thin overlap": (square(), square(1 - 1e-4), True),
    "a common edge": (square(), square(1.0), False),
    "a common edge, in part": (square(), square(1.0, 0.5), False),
    "a common corner": (square(), square(1.0, 1.0), False),
    "apart": (square(), square(1.5), False),
    "a small gap above": (square(), square(z=1e-6), False),
    "a small one, a small gap above": (square(), square(0.5, 0.5, 1e-9, size=1e-3), False),
    "nearer than rounding": (square(), square(z=1e-15), True),
    "across": (square(), Quad((0.5, 0.5, -0.5), Y, Z), False),
    "a cross whose corners all lie outside": (
        Quad((-1.0, -0.1, 0.0), (2.0, 0.0, 0.0), (0.0, 0.2, 0.0)),
        Quad((-0.1, -1.0, 0.0), (0.2, 0.0, 0.0), (0.0, 2.0, 0.0)),
        True,
    ),
    "bounding boxes overlap, the diamond does not": (
        square(),
        Quad((1.2, 0.8, 0.0), X, (1.0, 1.0, 0.0)),
        False,
    ),
    "a triangle on a quad": (square(), triangle((0.9, 0.9), (2, 0.9), (0.9, 2)), True),
    "a triangle beside the hypotenuse": (
        triangle((0, 0), (1, 0), (0, 1)),
        triangle((1, 0), (1, 1), (0, 1)),
        False,
    ),
    "triangles across": (triangle((0, 0), (1, 0), (0, 1)), triangle((1, 1), (0.4, 0), (0, 0.4)), True),
    "a needle twice": (triangle((0, 0), (1, 0), (1, 1e-7)), triangle((0, 0), (1, 0), (1, 1e-7)), True),
    "the same disk": (circle(), circle(), True),
    "turned disk": (circle(), Disk(ORIGIN, (0.6, 0.8, 0.0), (0.8, -0.6, 0.0)), True),
    "touching disks": (circle(), circle(2.0), False),
    "overlapping disks": (circle(), circle(2 - 1e-3), True),
    "disks, boxes overlapping": (circle(), circle(1.5, 1.5), False),
    "a small disk in a large one": (circle(), circle(0.5, 0.0, 0.01), True),
    "a large disk about a small one": (circle(0.5, 0.0, 0.01), circle(), True),
    "touching the ellipse from outside": (
        Disk(ORIGIN, (3.0, 0.0, 0.0), Y),
        circle(0.0, 1.5, 0.5),
        False,
    ),
    "reaching into the ellipse": (Disk(ORIGIN, (3.0, 0.0, 0.0), Y), circle(2.0, 1.0, 0.3), True),
    "beside the ellipse": (Disk(ORIGIN, (3.0, 0.0, 0.0), Y), circle(2.6, 1.0, 0.3), False),
    "a disk in a quad": (square(), circle(0.5, 0.5, 0.1), True),
    "a quad in a disk": (circle(), square(-0.1, -0.1, size=0.2), True),
    "a disk touching an edge": (square(), circle(0.5, 1.25, 0.25), False),
    "a disk over an edge": (square(), circle(0.5, 1.25, 0.26), True),
    "a disk touching a corner": (square(), circle(1 + DIAGONAL, 1 + DIAGONAL), False),
    "a disk over a corner": (square(), circle(1 + 0.999 * DIAGONAL, 1 + 0.999 * DIAGONAL), True),
    "a disk next to a triangle": (triangle((0, 0), (1, 0), (0, 1)), circle(1.0, 1.0, DIAGONAL), False),
    "a disk over a triangle": (triangle((0, 0), (1, 0), (0, 1)), circle(1.0, 1.0, DIAGONAL + 1e-3), True),
    "a disk above": (square(), circle(0.5, 0.5, 0.1, z=1e-6), False),
    "the same sphere": (Sphere(ORIGIN, 1.0), Sphere(ORIGIN, 1.0), True),
    "a sphere inside out": (Sphere(ORIGIN, 1.0), Sphere(ORIGIN, 1.0, True), True),
    "a shell": (Sphere(ORIGIN, 1.0), Sphere(ORIGIN, 1.000001), False),
    "spheres that overlap": (Sphere(ORIGIN, 1.0), Sphere(X, 1.0), False),
    "the same ellipsoid by other axes": (
        Ellipsoid(ORIGIN, (2.0, 0.0, 0.0), Y, Z),
        Ellipsoid(ORIGIN, (1.2, 0.8, 0.0), (-1.6, 0.6, 0.0), Z),
        True,
    ),
    "a turned ellipsoid": (
        Ellipsoid(ORIGIN, (2.0, 0.0, 0.0), Y, Z),
        Ellipsoid(ORIGIN, X, (0.0, 2.0, 0.0), Z),
        False,
    ),
    "an ellipsoid that is a sphere": (Sphere(ORIGIN, 1.0), Ellipsoid(ORIGIN, Y, Z, X), True),
}


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("place", PLACES)
def test_pairs(name: str, place: str) -> None:
    """Coplanarity, touching and overlapping are affine, so the answer is the same everywhere."""
    *pair, expected = PAIRS[name]
    for one, other in permutations(transformed(shape, PLACES[place]) for shape in pair):
        assert coincide(one, other) == expected
        assert coincide(square(50.0), one, square(60.0), other) == expected


def clip(polygon: list[complex], a: complex, b: complex) -> list[complex]:
    """The part of a convex polygon to the left of a line."""
    depth = [((b - a).conjugate() * (p - a)).imag for p in polygon]
    kept = []
    for i, p in enumerate(polygon):
        if depth[i - 1] * depth[i] < 0:
            kept.append(polygon[i - 1] + (p - polygon[i - 1]) * depth[i - 1] / (depth[i - 1] - depth[i]))
        if depth[i] >= 0:
            kept.append(p)
    return kept


def test_random_triangles_against_clipping() -> None:
    """Each of 400 pairs overlaps if and only if the one clipped by the edges of the other leaves an area."""
    rng, found = np.random.default_rng(1), []
    for corners in rng.random((400, 2, 3, 2)) * 1.5:
        polygons = [list(map(complex, *c.T)) for c in corners]
        for p in polygons:
            if ((p[1] - p[0]).conjugate() * (p[2] - p[0])).imag < 0:
                p.reverse()
        rest = polygons[0]
        for i in range(3):
            rest = clip(rest, polygons[1][i - 1], polygons[1][i])
        area = sum((a.conjugate() * b).imag for a, b in zip(rest, rest[1:] + rest[:1], strict=True)) / 2
        found.append(area > 0)
        assert coincide(*(triangle(*map(tuple, c)) for c in corners)) == (area > 0)
    assert 100 < sum(found) < 300


def test_random_disks_against_points() -> None:
    """400 pairs of ellipses: the boundary of one has a point inside the other, or one holds the other's centre."""
    rng, phi = np.random.default_rng(2), np.linspace(0, 2 * np.pi, 20_000)
    rim = np.stack([np.cos(phi), np.sin(phi)])
    M, c = rng.normal(size=(400, 2, 2)) * 0.6, rng.normal(size=(400, 2)) * 1.5
    frames = np.zeros((400, 3, 3))
    frames[:, :2, :2], frames[:, 2, 2] = M, 1
    unit, zero = np.broadcast_to(np.eye(3), (400, 3, 3)), np.zeros((400, 3))
    found = disks_overlap(unit, zero, frames, np.concatenate([c, zero[:, :1]], axis=1))
    nearest = np.linalg.norm(c[:, :, None] + M @ rim, axis=1).min(axis=1)
    nearest[np.linalg.norm(np.linalg.solve(M, c[..., None])[..., 0], axis=1) < 1] = 0
    np.testing.assert_array_equal(found, nearest < 1)
    assert np.abs(nearest - 1).min() > 1e-5  # none is so close that 20,000 points could not tell
    assert 100 < found.sum() < 300


@pytest.mark.parametrize("block", [50, 1 << 20])
def test_boxes_that_meet(block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The sweep finds every pair once, in one block or many."""
    monkeypatch.setattr(sweep, "_BLOCK", block)
    rng = np.random.default_rng(3)
    low = rng.random((300, 3)) * [1, 10, 3]
    high = low + 0.3 * rng.random((300, 3))
    high[:3], low[3] = 20, -20
    found = [
        tuple(sorted(pair)) for a, b in sweep.meeting_pairs(low, high) for pair in zip(a, b, strict=True)
    ]
    meet = ((low[:, None] <= high) & (low <= high[:, None])).all(axis=2)
    assert sorted(found) == [(i, j) for i, j in np.argwhere(meet) if i < j]


def test_the_message_names_both_and_what_to_do() -> None:
    rug = Surface("rug", square(0.2, 0.2, size=0.5), GREY)
    with pytest.raises(SceneError) as caught:
        check_coincidence([Surface("lid", square(z=1.0), GREY), Surface("floor", square(), GREY), rug])
    assert caught.value.path == "Scene.surfaces[2].shape"
    assert caught.value.found == rug.shape
    assert "'rug' not in the same place as surfaces[1] 'floor'" in caught.value.expected
    assert "move one by 10⁻⁶ of its size" in caught.value.expected

    mesh = Mesh([ORIGIN, X, Y, Z, (1.0, 1.0, 0.0)], [(0, 1, 3), (0, 1, 4)])
    with pytest.raises(SceneError) as caught:
        check_coincidence([Surface("floor", square(), GREY), Surface("mesh", mesh, GREY)])
    assert (caught.value.path, caught.value.found) == ("Scene.surfaces[1].shape.triangles[1]", (0, 1, 4))
    with pytest.raises(
        SceneError, match=r"'mesh' not in the same place as surfaces\[0\] 'mesh' triangles\[0\]"
    ):
        check_coincidence([Surface("mesh", Mesh([ORIGIN, X, Y], [(0, 1, 2), (1, 0, 2)]), GREY)])


def test_a_scene_is_checked() -> None:
    camera, sky = Pinhole((0, 0, 5), ORIGIN, Y, 45, 4, 4), (ConstantEnvironment((1.0,)),)
    with pytest.raises(SceneError, match=r"Scene\.surfaces\[1\]\.shape = "):
        Scene((Surface("a", square(), GREY), Surface("b", square(), GREY)), camera, sky)


def test_pieces_below_the_rounding_of_their_place() -> None:
    """Their corners fall together; that is no coincidence with anything, nor a warning."""
    tiny = Quad((1e3, 0.0, 0.0), (1e-14, 1e-170, 0.0), (0.0, 0.0, 1e-5))
    check_coincidence([Surface("tiny", tiny, GREY), Surface("square", square(), GREY)])


# ---- solids that stand on something


def cube(material: Material = GREY, z: float = 0.5) -> list[Surface]:
    axes = ((0.3, 0.1, 0.0), (-0.1, 0.3, 0.0), (0.0, 0.0, 0.5))
    return list(box("cube", (0.5, 0.5, z), axes, material))


FLOOR = Surface("floor", square(), GREY)
PYRAMID = Mesh(
    [(0.2, 0.2, 0), (0.8, 0.2, 0), (0.5, 0.8, 0), (0.5, 0.5, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
)
SPLIT = Mesh(
    [(0.2, 0.2, 0), (0.8, 0.2, 0), (0.8, 0.8, 0), (0.2, 0.8, 0), (0.5, 0.5, 1)],
    [(0, 3, 2), (0, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)],
)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(
    "solid",
    [cube(), [Surface("pyramid", PYRAMID, GREY)], [Surface("two triangles below", SPLIT, GREY)]],
    ids=["box", "mesh", "mesh with a split foot"],
)
def test_a_solid_may_stand_on_a_floor(place: str, solid: list[Surface]) -> None:
    check_coincidence([transformed(surface, PLACES[place]) for surface in (FLOOR, *solid)])
    check_coincidence([transformed(surface, PLACES[place]) for surface in (*solid, FLOOR)])


@pytest.mark.parametrize(
    "surfaces",
    [
        pytest.param([FLOOR, *cube(Dielectric())], id="glass, whose foot is seen through it"),
        pytest.param(
            [Surface("floor", square(), GREY, two_sided=True), *cube()], id="a floor with two sides"
        ),
        pytest.param(
            [Surface("floor", Quad(ORIGIN, Y, X), GREY), *cube()], id="foot and floor both look down"
        ),
        pytest.param([FLOOR, *cube()[:3], *cube()[4:]], id="a box without all its walls"),
        pytest.param([FLOOR, cube()[4]], id="a foot alone"),
        pytest.param([FLOOR, *cube(z=-0.5)], id="hung below: its roof in the floor looks the same way"),
        pytest.param([FLOOR, Surface("rug", Quad(ORIGIN, Y, X), GREY)], id="a front below and one above"),
    ],
)
def test_what_is_no_foot_of_a_solid(surfaces: list[Surface]) -> None:
    with pytest.raises(SceneError, match="not in the same place"):
        check_coincidence(surfaces)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("place", ["as it is", "oblique and far", "small", "large and mirrored"])
def test_the_library(name: str, place: str) -> None:
    transformed(case(name).scene, PLACES[place])


# ---- large meshes


def grid(n: int, height: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Mesh:
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    i = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    triangles = np.concatenate([np.stack([i, i + n + 1, i + n + 2], 1), np.stack([i, i + n + 2, i + 1], 1)])
    return Mesh(np.stack([x, y, height(x, y)], axis=2).reshape(-1, 3), triangles)


@pytest.mark.parametrize("shape", ["flat", "round"])
def test_five_thousand_triangles(shape: str) -> None:
    """Fast, and one triangle too many is found among them."""
    mesh = grid(50, lambda x, y: 0 * x if shape == "flat" else np.sqrt(4 - x**2 - y**2))
    start = time.process_time()
    check_coincidence([Surface("mesh", mesh, GREY)])
    assert time.process_time() - start < 1.0  # 0.15 s as measured; there are 12.5 million pairs
    patch = Mesh(mesh.vertices, [mesh.triangles[1234]])
    with pytest.raises(
        SceneError, match=r"'patch' not in the same place as surfaces\[0\] 'mesh' triangles\[1234\]"
    ):
        check_coincidence([Surface("mesh", mesh, GREY), Surface("patch", patch, GREY)])
