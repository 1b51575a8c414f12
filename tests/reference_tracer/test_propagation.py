"""r(x, l) against geometry written out for one ray and one surface at a time, and against Mitsuba."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from reference_tracer.points import NOWHERE, Points
from reference_tracer.propagation import RayCaster
from scenes import AreaLight, Lambertian, Pinhole, Quad, Scene, Sphere, Surface, box
from scenes.library import case

GREY, LIGHT = Lambertian((0.5,)), AreaLight((1.0,))
CAMERA = Pinhole((0.0, 0.0, 9.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0, 4, 4)
Shape = Quad | Sphere


def scene_of(*shapes: Shape) -> Scene:
    return Scene(tuple(Surface(str(i), s, GREY, LIGHT) for i, s in enumerate(shapes)), CAMERA)


def unit(rng: np.random.Generator, count: int) -> np.ndarray:
    d = rng.standard_normal((3, count))
    return d / np.linalg.norm(d, axis=0)


def vector(rng: np.random.Generator, size: float) -> tuple[float, float, float]:
    return tuple(rng.uniform(-size, size, 3).tolist())


def random_scene(seed: int) -> Scene:
    """Quads and spheres, inward and outward, in and through one another, within about ±3."""
    rng = np.random.default_rng(seed)
    quads = [Quad(vector(rng, 2), vector(rng, 2), vector(rng, 2)) for _ in range(6)]
    spheres = [Sphere(vector(rng, 1.5), float(rng.uniform(0.2, 1.2)), bool(i % 2)) for i in range(4)]
    shapes: list[Shape] = [*quads, *spheres]
    rng.shuffle(shapes)
    return scene_of(*shapes)


# ---- one ray, one surface


def distance(shape: Shape, x: np.ndarray, d: np.ndarray, starts_here: bool) -> float:
    """Where x + td first meets the shape, inf if nowhere."""
    if isinstance(shape, Quad):
        if starts_here:
            return np.inf
        t, a, b = np.linalg.solve(
            np.stack([d, -np.array(shape.edge_u), -np.array(shape.edge_v)], axis=1), -x + shape.corner
        )
        return t if t > 0 and 0 <= a <= 1 and 0 <= b <= 1 else np.inf
    o = x - np.array(shape.center)
    roots = np.roots([1.0, 2 * o @ d, o @ o - shape.radius**2])
    met = [t.real for t in roots if abs(t.imag) < 1e-12 and t.real > (1e-9 if starts_here else 0)]
    return min(met, default=np.inf)


def first(scene: Scene, x: np.ndarray, d: np.ndarray, start: int) -> tuple[int, float]:
    distances = [distance(s.shape, x, d, i == start) for i, s in enumerate(scene.surfaces)]
    nearest = int(np.argmin(distances))
    return (nearest, distances[nearest]) if np.isfinite(distances[nearest]) else (NOWHERE, np.inf)


def front(shape: Shape, x: np.ndarray) -> np.ndarray:
    if isinstance(shape, Quad):
        return np.cross(shape.edge_u, shape.edge_v) / np.linalg.norm(np.cross(shape.edge_u, shape.edge_v))
    return (x - shape.center) / shape.radius * (-1 if shape.inward else 1)


def check(scene: Scene, origin: Points, d: np.ndarray) -> Points:
    hit = RayCaster(scene)(origin, d)
    for i in range(len(origin)):
        surface, t = first(scene, origin.x[:, i], d[:, i], int(origin.surface[i]))
        assert hit.surface[i] == surface
        if surface != NOWHERE:
            expected = origin.x[:, i] + t * d[:, i]
            np.testing.assert_allclose(hit.x[:, i], expected, atol=1e-12)
            np.testing.assert_allclose(
                hit.n[:, i], front(scene.surfaces[surface].shape, expected), atol=1e-11
            )
    return hit


@pytest.mark.parametrize("seed", range(4))
def test_from_space_and_from_surface_to_surface(seed: int) -> None:
    scene, rng, count = random_scene(seed), np.random.default_rng(100 + seed), 200
    x, aim = rng.uniform(-3, 3, (3, count)), rng.uniform(-1.5, 1.5, (3, count))
    hit = check(scene, Points.nowhere(x), (aim - x) / np.linalg.norm(aim - x, axis=0))
    met = hit[hit.surface != NOWHERE]
    assert 60 < len(met) < count  # some rays meet something, some nothing
    again = check(scene, met, unit(rng, len(met)))  # to either side, so also through the body of a sphere
    assert np.count_nonzero(again.surface == met.surface) > 3


def test_nowhere_has_a_normal() -> None:
    away = RayCaster(random_scene(0))(Points.nowhere(np.full((3, 1), 100.0)), np.full((3, 1), 3**-0.5))
    assert away.surface.tolist() == [NOWHERE]
    np.testing.assert_array_equal(away.n[:, 0], [0, 0, 1])
    assert np.isfinite(away.x).all()


@pytest.mark.parametrize("kind", ["quads", "spheres"])
def test_a_scene_of_one_kind_of_shape(kind: str) -> None:
    shapes = [s.shape for s in random_scene(1).surfaces if isinstance(s.shape, Quad) == (kind == "quads")]
    rng = np.random.default_rng(5)
    check(scene_of(*shapes), Points.nowhere(rng.uniform(-3, 3, (3, 100))), unit(rng, 100))


def test_the_nearest_of_a_stack() -> None:
    stack = [Quad((-1.0, -1.0, z), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0)) for z in (3.0, 1.0, 2.0)]
    hit = RayCaster(scene_of(*stack))(
        Points.nowhere(np.array([[0.1, 0.1], [0.2, 0.2], [0.0, 5.0]])),
        np.array([[0.0, 0.0], [0.0, 0.0], [1.0, -1.0]]),
    )
    assert hit.surface.tolist() == [1, 0]


# ---- leaving a surface


def leaving(n: np.ndarray, rng: np.random.Generator, cosines: np.ndarray) -> np.ndarray:
    """Unit directions with given cosines to the normals."""
    across = np.cross(n.T, unit(rng, n.shape[1]).T).T
    across /= np.linalg.norm(across, axis=0)
    return cosines * n + np.sqrt(1 - cosines**2) * across


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("grazing", [1.0, 1e-3, 1e-6, 1e-9])
def test_a_ray_does_not_meet_what_it_starts_on(size: float, grazing: float) -> None:
    """On a quad, and outside a sphere, not at all; inside a sphere at the other end of the chord, −2(x − c)·l."""
    rng, count = np.random.default_rng(1), 500
    center = np.array([0.3, -2.0, 5.0]) * size
    for inward in (True, False):
        sphere = Sphere(tuple(center.tolist()), 0.7 * size, inward)
        outward = unit(rng, count)
        x, n = center[:, None] + sphere.radius * outward, -outward if inward else outward
        d = leaving(n, rng, grazing * rng.uniform(0.1, 1, count))
        hit = RayCaster(scene_of(sphere))(Points(x, n, np.zeros(count, dtype=int)), d)
        if inward:
            assert (hit.surface == 0).all()
            t = np.linalg.norm(hit.x - x, axis=0)
            chord = -2 * ((x - center[:, None]) * d).sum(axis=0)
            np.testing.assert_allclose(t, chord, atol=1e-13 * size)
        else:
            assert (hit.surface == NOWHERE).all()

    quad = Quad(vector(rng, size), vector(rng, size), vector(rng, size))
    a, b = rng.random((2, 1, count))
    x = (
        np.array(quad.corner)[:, None]
        + a * np.array(quad.edge_u)[:, None]
        + b * np.array(quad.edge_v)[:, None]
    )
    n = np.tile(quad.normal[:, None], count)
    d = leaving(n, rng, grazing * rng.uniform(0.1, 1, count))
    assert (RayCaster(scene_of(quad))(Points(x, n, np.zeros(count, dtype=int)), d).surface == NOWHERE).all()


@pytest.mark.parametrize("away", [1.0, 1e3, 1e6])
def test_a_hit_lies_on_the_sphere_however_far_the_ray_has_come(away: float) -> None:
    rng, ball = np.random.default_rng(6), Sphere((0.1, 0.2, 0.3), 0.5)
    aim = np.array(ball.center)[:, None]
    d = unit(rng, 500)
    hit = RayCaster(scene_of(ball))(Points.nowhere(aim - away * d), d)
    outward = hit.x - aim
    np.testing.assert_allclose(np.linalg.norm(outward, axis=0), 0.5, rtol=1e-15)
    np.testing.assert_allclose(outward / 0.5, hit.n, atol=1e-15)
    np.testing.assert_allclose(hit.n, -d, atol=1e-15 * away)


@pytest.mark.parametrize("name", ["furnace-box", "furnace-sphere"])
def test_no_ray_escapes_from_a_closed_scene(name: str) -> None:
    """20 legs of 2,000 walks: not one slips through an edge between two walls."""
    scene, rng = case(name).scene, np.random.default_rng(2)
    at, caster = Points.nowhere(np.zeros((3, 2000))), RayCaster(scene)
    d = unit(rng, 2000)
    for _ in range(20):
        at = caster(at, d)
        assert (at.surface != NOWHERE).all()
        assert ((at.n * d).sum(axis=0) < 0).all()
        d = leaving(at.n, rng, np.sqrt(rng.random(2000)))


# ---- scale, and rays that lie in planes


def scaled(scene: Scene, factor: float) -> Scene:
    def larger(shape: Shape) -> Shape:
        fields = ("corner", "edge_u", "edge_v") if isinstance(shape, Quad) else ("center",)
        changes = {f: tuple(factor * c for c in getattr(shape, f)) for f in fields}
        if isinstance(shape, Sphere):
            changes["radius"] = factor * shape.radius
        return msgspec.structs.replace(shape, **changes)

    return scene_of(*(larger(surface.shape) for surface in scene.surfaces))


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 1e3, 1e6])
def test_the_size_of_a_scene_changes_nothing(factor: float) -> None:
    scene, rng, count = random_scene(3), np.random.default_rng(3), 1000
    x, d, d2 = rng.uniform(-3, 3, (3, count)), unit(rng, count), unit(rng, count)
    casters = RayCaster(scene), RayCaster(scaled(scene, factor))
    hits = casters[0](Points.nowhere(x), d), casters[1](Points.nowhere(factor * x), d)
    for _ in range(2):
        np.testing.assert_array_equal(hits[0].surface, hits[1].surface)
        met = hits[0].surface != NOWHERE
        np.testing.assert_allclose(hits[0].x[:, met] * factor, hits[1].x[:, met], atol=1e-10 * factor)
        hits = casters[0](hits[0], d2), casters[1](hits[1], d2)


@pytest.mark.parametrize("height", [0.0, 0.5])
def test_a_ray_parallel_to_a_plane_does_not_meet_it(height: float) -> None:
    floor = Quad((-1.0, -1.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0))
    d = np.array([[1.0, -1.0, 0.0, 0.6], [0.0, 0.0, 1.0, 0.8], [0.0, 0.0, 0.0, 0.0]])
    for start in (0.0, -3.0):  # inside the quad's outline and outside
        origin = Points.nowhere(np.tile([[start], [0.0], [height]], 4))
        assert (RayCaster(scene_of(floor))(origin, d).surface == NOWHERE).all()


def test_parallel_rays_still_meet_what_stands_in_their_way() -> None:
    cube = scene_of(*(face.shape for face in box("b", (0, 0, 0), ((1, 0, 0), (0, 1, 0), (0, 0, 1)), GREY)))
    d = np.concatenate([np.eye(3), -np.eye(3)], axis=1)
    hit = RayCaster(cube)(Points.nowhere(-3 * d + 0.1 * (d == 0)), d)
    np.testing.assert_array_equal((hit.n * d).sum(axis=0), -1)


def test_against_mitsuba() -> None:
    """The Cornell box from its camera and from inside; Mitsuba's rays are single precision."""
    import mitsuba

    mitsuba.set_variant("scalar_rgb")
    theirs, rng, count = mitsuba.load_dict(mitsuba.cornell_box()), np.random.default_rng(4), 400
    x = np.where(np.arange(count) % 2, rng.uniform(-0.95, 0.95, (3, count)), [[0.0], [0.0], [3.9]])
    d = rng.uniform(-0.95, 0.95, (3, count)) - x
    d /= np.linalg.norm(d, axis=0)
    hit = RayCaster(case("cornell-box").scene)(Points.nowhere(x), d)
    agree = 0
    for i in range(count):
        si = theirs.ray_intersect(mitsuba.Ray3f(x[:, i].tolist(), d[:, i].tolist()))
        assert si.is_valid() == (hit.surface[i] != NOWHERE)
        if si.is_valid():
            close = np.allclose(np.array(si.p), hit.x[:, i], atol=1e-4)
            agree += close and np.allclose(np.array(si.n), hit.n[:, i], atol=1e-4)
        else:
            agree += 1
    assert agree >= count - 1  # a ray through an edge may go either way
