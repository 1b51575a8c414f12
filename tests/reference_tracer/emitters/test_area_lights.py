"""Directions towards area lights: chosen with the density that is stated, and the right irradiance from it.

The rays of these tests are cast here, shape by shape, by code that shares nothing with the tracer.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from reference_tracer.emitters.area_lights import AreaEmitter, EllipsoidEmitter, FlatEmitter
from reference_tracer.emission import Emitters
from reference_tracer.points import NOWHERE, Points
from scenes import (
    AreaLight,
    Disk,
    Ellipsoid,
    Lambertian,
    Mesh,
    Pinhole,
    PolarRange,
    Quad,
    Scene,
    Shape,
    Sphere,
    Surface,
)

GREY = Lambertian((0.5, 0.5))
CAMERA = Pinhole((0.0, 0.0, 9.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0, 4, 4)
L = np.array([3.0, 5.0])
COUNT = 40_000
AXIS = (0.6, 0.0, -0.8)

RECTANGLE = Quad((-0.6, -0.5, 2.0), (0.0, 1.2, 0.0), (1.5, 0.0, 0.0))  # its front looks down
SLANTED = Quad((-1.0, -0.5, 2.0), (0.0, 1.2, 0.3), (1.5, 0.2, 0.0))  # no rectangle
DISK = Disk((0.3, 0.1, 2.0), (0.1, 0.8, 0.0), (1.1, 0.2, 0.1))
BALL, CAVITY = Sphere((0.3, 0.2, 2.0), 0.9), Sphere((0.3, 0.2, 0.5), 1.7, inward=True)
EGG = Ellipsoid((0.3, 0.2, 2.0), (1.1, 0.0, 0.2), (0.1, 0.6, 0.0), (0.0, 0.3, 0.8))
HOLLOW = Ellipsoid((0.1, 0.0, 0.3), (2.0, 0.0, 0.2), (0.1, 1.6, 0.0), (0.0, 0.3, 1.2), inward=True)
OCTAHEDRON = Mesh(
    ((1.0, 0.0, 2.0), (-0.8, 0.0, 2.0), (0.0, 0.7, 2.0), (0.0, -0.9, 2.0), (0.1, 0.0, 3.0), (0.0, 0.2, 1.2)),
    ((0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)),
)
PATCHES = Mesh(  # flat, and none of its four triangles as large as another
    ((-0.6, -0.5, 2.0), (-0.6, 0.7, 2.0), (0.9, 0.7, 2.0), (0.9, -0.5, 2.0), (0.0, 0.0, 2.0)),
    ((0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
)


def scene_of(shape: Shape, zone: PolarRange | None = None, two_sided: bool = False) -> Scene:
    return Scene((Surface("lamp", shape, GREY, AreaLight(tuple(L), zone), two_sided),), CAMERA)


def at(x: tuple, count: int, primitive: int = NOWHERE, n: tuple = (0.0, 0.0, 1.0)) -> Points:
    surface = np.full(count, 0 if primitive >= 0 else NOWHERE)
    columns = (np.tile(np.array(v, dtype=float)[:, None], count) for v in (x, n))
    return Points(*columns, surface=surface, primitive=np.full(count, primitive))


# ---- rays, cast here


def cast(scene: Scene, reference: Points, d: np.ndarray) -> Points:
    """What rays to the one surface of the scene meet; normals as the tracer has them."""
    surface, x = scene.surfaces[0], reference.x
    shape, nearest = surface.shape, np.full(d.shape[1], np.inf)
    n, primitive = np.tile([[0.0], [0.0], [1.0]], d.shape[1]), np.full(d.shape[1], NOWHERE)
    if isinstance(shape, Sphere | Ellipsoid):
        matrix = shape.matrix if isinstance(shape, Ellipsoid) else shape.radius * np.eye(3)
        o = np.linalg.solve(matrix, x - np.array(shape.center)[:, None])
        v = np.linalg.solve(matrix, d)
        a, b, c = (v * v).sum(0), (o * v).sum(0), (o * o).sum(0) - 1
        root = np.sqrt(np.maximum(b * b - a * c, 0))
        real, on = b * b - a * c > 0, reference.primitive >= 0
        near, far = (-b - root) / a, (-b + root) / a
        t = np.where(on, np.maximum(-2 * b / a, 0), np.where(near > 0, near, far))
        met = real & (t > 0)
        nearest, primitive = np.where(met, t, np.inf), np.where(met, 0, NOWHERE)
        outward = np.linalg.solve(matrix.T, o + t * v)
        outward /= np.linalg.norm(outward, axis=0)
        n = np.where(met, -outward if shape.inward else outward, n)
    else:
        for k, (corner, u, v, inside) in enumerate(parts(shape)):
            s, t_, t = np.linalg.solve(
                np.broadcast_to(np.stack([u, v, np.zeros(3)], axis=1), (d.shape[1], 3, 3))
                - d.T[:, :, None] * np.array([0.0, 0.0, 1.0]),
                (x.T - corner)[:, :, None],
            )[..., 0].T
            met = inside(s, t_) & (t > 0) & (t < nearest) & (reference.primitive != k)
            normal = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
            nearest, primitive = np.where(met, t, nearest), np.where(met, k, primitive)
            n = np.where(met, normal[:, None], n)
    if surface.two_sided:
        n = n * -np.sign((n * d).sum(0))
    met = primitive >= 0
    return Points(x + np.where(met, nearest, 0) * d, n, np.where(met, 0, NOWHERE), primitive=primitive)


def parts(shape: Shape) -> list[tuple]:
    """The planar pieces of a shape: a corner, two edges, and which of their multiples belong to it."""
    if isinstance(shape, Quad):
        edges = (np.array(e) for e in (shape.corner, shape.edge_u, shape.edge_v))
        return [(*edges, lambda s, t: (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1))]
    if isinstance(shape, Disk):
        edges = (np.array(e) for e in (shape.center, shape.axis_u, shape.axis_v))
        return [(*edges, lambda s, t: s * s + t * t <= 1)]
    return [(a, b - a, c - a, lambda s, t: (s >= 0) & (t >= 0) & (s + t <= 1)) for a, b, c in shape.corners]


# ---- sample follows pdf


class Bins:
    """Cells of equal solid angle in a cone about the direction to the emitter, or all around."""

    rows, columns, fine = 10, 12, 40

    def __init__(self, axis: np.ndarray, versine: float) -> None:
        across = np.cross(axis, [0.6, -0.64, 0.48])
        across /= np.linalg.norm(across)
        self.frame, self.versine = np.stack([across, np.cross(axis, across), axis], axis=1), versine

    def count(self, wi: np.ndarray) -> np.ndarray:
        x, y, _ = self.frame.T @ wi
        # 1 − cos without cancellation: half the square of the chord
        versine = ((wi - self.frame[:, 2:]) ** 2).sum(0) / 2
        limits = [(0, self.versine), (-np.pi, np.pi)]
        counts = np.histogram2d(versine, np.arctan2(y, x), (self.rows, self.columns), limits)[0]
        assert counts.sum() == wi.shape[1], "a direction lies outside the cone"
        return counts

    def integrate(self, density: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """By the midpoint rule on fine × fine points of each cell."""
        rows, columns = self.rows * self.fine, self.columns * self.fine
        versine = self.versine * (np.arange(rows) + 0.5) / rows
        phi = -np.pi + 2 * np.pi * (np.arange(columns) + 0.5) / columns
        versine, phi = (grid.ravel() for grid in np.meshgrid(versine, phi, indexing="ij"))
        r = np.sqrt(versine * (2 - versine))
        d = self.frame @ np.stack([r * np.cos(phi), r * np.sin(phi), 1 - versine])
        values = density(d).reshape(self.rows, self.fine, self.columns, self.fine)
        return values.mean(axis=(1, 3)) * 2 * np.pi * self.versine / (self.rows * self.columns)


def agreed(emitters: Emitters, scene: Scene, reference: Points, bins: Bins, follows: Callable) -> bool:
    """Whether directions follow the density, whose integral is 1."""
    u = np.random.default_rng(7).random((emitters.dimensions, len(reference)))
    counts = bins.count(emitters.sample(reference, u).wi)

    def density(d: np.ndarray) -> np.ndarray:
        here = at(tuple(reference.x[:, 0]), d.shape[1], int(reference.primitive[0]))
        return emitters.pdf(here, cast(scene, here, d), d)

    expected = bins.integrate(density)
    assert counts[expected == 0].sum() < 1e-3 * COUNT, "chosen where the density is zero"
    if abs(expected.sum() - 1) > 4e-3:
        return False
    full = expected * COUNT > 30  # the others make one cell
    grouped = [np.append(values[full], values[~full].sum()) for values in (counts, expected)]
    if grouped[1][-1] * COUNT < 30:
        grouped = [values[:-1] for values in grouped]
    return follows(grouped[0], grouped[1] / grouped[1].sum())


def cone_to(shape: Shape, x: tuple) -> Bins:
    """A cone that holds the shape as seen from x; all directions where it is all around."""
    here = np.array(x)
    if isinstance(shape, Sphere | Ellipsoid):
        reach = shape.radius if isinstance(shape, Sphere) else np.linalg.norm(shape.matrix, 2)
        away = np.array(shape.center) - here
        distance = np.linalg.norm(away)
        if distance <= reach:
            return Bins(np.array([0.0, 0.0, 1.0]), 2.0)
        sine_squared = (1.0001 * reach / distance) ** 2
        return Bins(away / distance, sine_squared / (1 + np.sqrt(max(1 - sine_squared, 0))))
    low = -1 if isinstance(shape, Disk) else 0
    corners = [c + s * u + t * v - here for c, u, v, _ in parts(shape) for s in (low, 1) for t in (low, 1)]
    towards = np.array([corner / np.linalg.norm(corner) for corner in corners])
    axis = towards.sum(axis=0) / np.linalg.norm(towards.sum(axis=0))
    versine = 1 - (towards @ axis).min()
    return Bins(axis, 1.01 * versine if versine < 0.9 else 2.0)


PLACES = {
    "rectangle, far": (RECTANGLE, (0.4, -0.3, -1.0), None),
    "rectangle, near": (RECTANGLE, (0.4, 0.3, 1.2), None),
    "rectangle, nearly in its plane": (RECTANGLE, (1.4, 0.3, 1.9), None),
    "rectangle, close under it": (RECTANGLE, (0.5, 0.4, 1.95), None),
    "parallelogram, far": (SLANTED, (0.4, -0.3, -0.5), None),
    "parallelogram, near": (SLANTED, (0.4, 0.3, 1.3), None),
    "parallelogram, close under it": (SLANTED, (-0.1, 0.2, 2.1), None),
    "disk": (DISK, (0.4, -0.3, 0.5), None),
    "ball": (BALL, (0.4, -0.3, 0.1), None),
    "ball, far": (BALL, (4e5, -3e5, 1e6), None),
    "ball, close": (BALL, (0.3, 0.2, 1.0999), None),
    "cavity": (CAVITY, (0.9, -0.3, 0.4), None),
    "cavity, its centre": (CAVITY, CAVITY.center, None),
    "zone": (BALL, (0.4, -0.3, 0.1), PolarRange(50, 120, AXIS)),
    "zone of a cavity": (CAVITY, (0.9, -0.3, 0.4), PolarRange(20, 150, AXIS)),
    "egg": (EGG, (0.4, -0.3, 0.1), None),
    "hollow egg": (HOLLOW, (0.9, -0.3, 0.1), None),
    "flat mesh": (PATCHES, (0.4, -0.3, 0.5), None),
    "mesh": (OCTAHEDRON, (0.4, -0.3, 0.1), None),
}


def choosable(shape: Shape, zone: PolarRange | None) -> bool:
    """Whether every point that is chosen is seen, so that the density of what is seen integrates to 1."""
    return shape is not OCTAHEDRON and (zone is None or shape.inward)


@pytest.mark.parametrize("place", PLACES)
def test_directions_follow_the_density(place: str, follows: Callable) -> None:
    shape, x, zone = PLACES[place]
    scene, reference = scene_of(shape, zone), at(x, COUNT)
    emitters = Emitters(scene)
    if choosable(shape, zone):
        assert agreed(emitters, scene, reference, cone_to(shape, x), follows)
    # a direction that was chosen has the density that it was chosen with
    sample = emitters.sample(reference, np.random.default_rng(1).random((2, COUNT)))
    hit = cast(scene, reference, sample.wi)
    seen = sample.Li[0] > 0
    if isinstance(shape, Mesh):  # its other triangles hide some
        seen &= hit.primitive == sample.primitive
    inner = seen & (hit.primitive == sample.primitive)
    assert inner.sum() > 0.999 * seen.sum() > 0.1 * COUNT  # rounding at edges, and no more
    pdf = emitters.pdf(reference, hit, sample.wi)[inner]
    np.testing.assert_allclose(pdf, sample.pdf[inner], rtol=2e-5 if "far" in place else 1e-6)
    distance = np.linalg.norm(hit.x - reference.x, axis=0)[inner]
    np.testing.assert_allclose(distance, sample.distance[inner], rtol=1e-6)


@pytest.mark.parametrize("inward", [True, False])
def test_directions_from_the_surface_of_a_sphere_itself(inward: bool, follows: Callable) -> None:
    outward = np.array([0.48, 0.6, 0.64])
    for shape in (Sphere((0.3, 0.2, 2.0), 0.9, inward), Ellipsoid(*HOLLOW_AXES, inward)):
        matrix = shape.matrix if isinstance(shape, Ellipsoid) else shape.radius * np.eye(3)
        x = tuple(np.array(shape.center) + matrix @ outward)
        scene, reference = scene_of(shape), at(x, COUNT, primitive=0)
        emitters = Emitters(scene)
        if inward:
            assert agreed(emitters, scene, reference, Bins(-outward, 2.0), follows)
        else:
            sample = emitters.sample(reference, np.random.default_rng(1).random((2, COUNT)))
            assert not sample.Li.any()


HOLLOW_AXES = (HOLLOW.center, HOLLOW.axis_u, HOLLOW.axis_v, HOLLOW.axis_w)


def faulty_cone(self: EllipsoidEmitter, squared: np.ndarray, *_: np.ndarray) -> np.ndarray:
    return np.full(len(squared), 1 / (2 * np.pi))


def faulty_area(self: AreaEmitter, reference: Points, points: Points, wi: np.ndarray) -> np.ndarray:
    return np.full(len(points), 1 / self.area)


def faulty_jacobian(self: EllipsoidEmitter, reference: Points, points: Points, wi: np.ndarray) -> np.ndarray:
    return np.full(len(points), 1 / (4 * np.pi))


def faulty_branch(self: FlatEmitter, offset: np.ndarray, lit: np.ndarray) -> tuple:
    return np.empty(0, dtype=int), offset[:, :0], np.empty(0)


@pytest.mark.parametrize(
    ("place", "owner", "method", "fault"),
    [
        ("cavity", EllipsoidEmitter, "_local_pdf", faulty_cone),
        ("rectangle, far", FlatEmitter, "pdf", faulty_area),
        ("hollow egg", EllipsoidEmitter, "pdf", faulty_jacobian),
        ("rectangle, near", FlatEmitter, "_by_solid_angle", faulty_branch),
    ],
)
def test_planted_faults_are_found(
    place: str, owner: type, method: str, fault: Callable, follows: Callable, monkeypatch: pytest.MonkeyPatch
) -> None:
    shape, x, zone = PLACES[place]
    scene = scene_of(shape, zone)
    emitters = Emitters(scene)
    wi = emitters.sample(at(x, COUNT), np.random.default_rng(7).random((2, COUNT))).wi
    monkeypatch.setattr(owner, method, fault)
    counts = cone_to(shape, x).count(wi)
    expected = cone_to(shape, x).integrate(
        lambda d: emitters.pdf(at(x, d.shape[1]), cast(scene, at(x, d.shape[1]), d), d)
    )
    full = expected * COUNT > 30
    share = expected[full] / expected[full].sum()
    assert abs(expected.sum() - 1) > 0.02 or not follows(counts[full], share)
