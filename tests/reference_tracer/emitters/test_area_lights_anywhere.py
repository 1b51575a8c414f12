"""Area lights from both sides, in scenes of any size, and in places where nothing can be seen."""

from __future__ import annotations

import numpy as np
import pytest

from reference_tracer.emission import Emitters
from reference_tracer.points import NOWHERE, Points
from scenes import AreaLight, Disk, Ellipsoid, Lambertian, Mesh, Pinhole, Quad, Scene, Shape, Sphere, Surface

CAMERA = Pinhole((0.0, 0.0, 9.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0, 4, 4)
TILTED = (0.36, -0.48, 0.8)

SHAPES: dict[str, Shape] = {
    "rectangle": Quad((-0.6, -0.5, 2.0), (0.0, 1.2, 0.0), (1.5, 0.0, 0.0)),  # its front looks down
    "parallelogram": Quad((-1.0, -0.5, 2.0), (0.0, 1.2, 0.3), (1.5, 0.2, 0.0)),
    "disk": Disk((0.3, 0.1, 2.0), (0.1, 0.8, 0.0), (1.1, 0.2, 0.1)),
    "ball": Sphere((0.3, 0.2, 2.0), 0.9),
    "egg": Ellipsoid((0.3, 0.2, 2.0), (0.7, 0.0, 0.2), (0.1, 0.4, 0.0), (0.0, 0.3, 0.5)),
    "mesh": Mesh(((-1.0, -0.5, 2.0), (-1.0, 0.7, 2.3), (0.5, 0.9, 2.3)), ((0, 1, 2),)),
}


def lamp(shape: Shape, radiance: tuple = (1.0,), two_sided: bool = False) -> Scene:
    grey = Lambertian((0.5,) * len(radiance))
    return Scene((Surface("lamp", shape, grey, AreaLight(radiance), two_sided),), CAMERA)


def at(x: tuple, n: tuple, count: int, primitive: int = NOWHERE) -> Points:
    columns = (np.tile(np.array(v, dtype=float)[:, None], count) for v in (x, n))
    surface = np.full(count, 0 if primitive >= 0 else NOWHERE)
    return Points(*columns, surface=surface, primitive=np.full(count, primitive))


def contributions(scene: Scene, reference: Points, u: np.ndarray) -> np.ndarray:
    sample = Emitters(scene).sample(reference, u)
    np.testing.assert_allclose((sample.wi**2).sum(axis=0), 1, rtol=1e-12)
    return sample.Li * np.maximum((sample.wi * reference.n).sum(axis=0), 0) / sample.pdf


def irradiance(scene: Scene, x: tuple, n: tuple) -> np.ndarray:
    """Per channel, by Gauss's rule over the unit square of random numbers."""
    nodes, weights = np.polynomial.legendre.leggauss(32)
    u, share = (
        np.stack(np.meshgrid(nodes, nodes)).reshape(2, -1) / 2 + 0.5,
        np.outer(weights, weights).ravel() / 4,
    )
    return contributions(scene, at(x, n, len(share)), u) @ share


def scaled(shape: Shape, s: float) -> Shape:
    fields = {}
    for field in shape.__struct_fields__:
        value = getattr(shape, field)
        if field == "vertices":
            fields[field] = tuple(tuple(s * c for c in vertex) for vertex in value)
        elif isinstance(value, tuple) and field != "triangles":
            fields[field] = tuple(s * c for c in value)
        else:
            fields[field] = s * value if field == "radius" else value
    return type(shape)(**fields)


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3, 1e6])
@pytest.mark.parametrize("name", SHAPES)
def test_the_same_in_a_scene_of_another_size(name: str, scale: float) -> None:
    shape, u = SHAPES[name], np.random.default_rng(3).random((2, 1000))
    for x in ((0.4, -0.3, -1.0), (0.1, 0.1, 1.05)):
        samples = []
        for s in (1.0, scale):
            reference = at(tuple(s * c for c in x), (0, 0, 1), 1000)
            samples.append(Emitters(lamp(scaled(shape, s))).sample(reference, u))
        one, other = samples
        np.testing.assert_allclose(other.wi, one.wi, atol=1e-11)
        np.testing.assert_allclose(other.pdf, one.pdf, rtol=1e-10)
        np.testing.assert_allclose(other.distance, scale * one.distance, rtol=1e-10)
        np.testing.assert_array_equal(other.Li, one.Li)


@pytest.mark.parametrize("name", ["rectangle", "parallelogram", "disk", "mesh"])
def test_backs_are_dark_unless_two_sided(name: str) -> None:
    """From behind, a two-sided one is what its front is from the mirrored place."""
    shape, u = SHAPES[name], np.random.default_rng(3).random((2, 1000))
    x, behind, up = (0.4, -0.3, 0.5), (0.4, -0.3, 3.5), (0.0, 0.0, 1.0)
    assert contributions(lamp(shape), at(x, up, 1000), u).min() > 0
    assert not contributions(lamp(shape), at(behind, (0, 0, -1), 1000), u).any()
    found = contributions(lamp(shape, two_sided=True), at(behind, (0, 0, -1), 1000), u)
    assert found.min() > 0
    if name == "rectangle":  # which lies in the plane z = 2, the mirror
        np.testing.assert_allclose(found, contributions(lamp(shape), at(x, up, 1000), u), rtol=1e-12)


def degenerate(shape: Shape) -> list[tuple[tuple, int]]:
    """Places on the shape or in its plane, with the primitive that they are on, or none."""
    if isinstance(shape, Quad):
        c, u, v = (np.array(e) for e in (shape.corner, shape.edge_u, shape.edge_v))
        multiples = [(0, 0), (1, 1), (0.5, 0), (0.5, 0.5), (2, 0.5), (1, 1.5), (-1e9, 3.0)]
        places = [c + s * u + t * v for s, t in multiples]
    elif isinstance(shape, Disk):
        c, u, v = (np.array(e) for e in (shape.center, shape.axis_u, shape.axis_v))
        places = [c, c + u, c + 0.5 * u - 0.5 * v, c + 3 * v]
    elif isinstance(shape, Mesh):
        places = [*np.array(shape.vertices), np.mean(shape.vertices, axis=0)]
    else:
        matrix = shape.matrix if isinstance(shape, Ellipsoid) else shape.radius * np.eye(3)
        c = np.array(shape.center)
        places = [c + matrix @ (s * np.array(TILTED)) for s in (0, 1e-300, 1 - 1e-15, 1, 1 + 1e-15, 1e12)]
    return [(tuple(p), primitive) for p in places for primitive in (NOWHERE, 0)]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("two_sided", [False, True])
@pytest.mark.parametrize("name", SHAPES)
def test_nothing_is_undefined_anywhere(name: str, two_sided: bool) -> None:
    """The corners of the unit square of random numbers among others."""
    shape, last = SHAPES[name], np.nextafter(1, 0)
    corners = np.array([[0, 0, last, last, 0.5, 0.5], [0, last, 0, last, 0.5, 0.0]])
    u = np.concatenate([corners, np.random.default_rng(3).random((2, 100))], axis=1)
    emitters = Emitters(lamp(shape, two_sided=two_sided))
    for x, primitive in degenerate(shape):
        reference = at(x, (0, 0, 1), u.shape[1], primitive)
        sample = emitters.sample(reference, u)
        hit = at((0.3, 0.1, 2.0), (0, 0, -1), u.shape[1], 0)
        for values in (
            sample.wi,
            sample.distance,
            sample.Li,
            sample.pdf,
            emitters.pdf(reference, hit, sample.wi),
        ):
            assert np.isfinite(values).all(), (x, primitive)
        assert (sample.pdf >= 0).all()
        assert (sample.pdf[sample.Li[0] > 0] > 0).all()
        flat = isinstance(shape, Quad | Disk | Mesh)
        if flat and primitive == 0:
            assert not sample.Li.any()


@pytest.mark.parametrize("name", ["rectangle", "ball", "egg", "disk"])
def test_a_solid_angle_of_1e_12(name: str) -> None:
    """Irradiance A cos cos / d² far away, or π (r / d)²: by the polygon's formula it would have no digits."""
    shape, x, n = SHAPES[name], np.array([3e5, -2e5, -1e6]), (0.0, 0.0, 1.0)
    away = np.array([0.3, 0.1, 2.0]) - x
    d = np.linalg.norm(away)
    wi = away / d
    if isinstance(shape, Sphere):
        projected = np.pi * shape.radius**2
    elif isinstance(shape, Ellipsoid):  # area of the shadow: π |det M| |M⁻¹ w|
        projected = (
            np.pi * abs(np.linalg.det(shape.matrix)) * np.linalg.norm(np.linalg.solve(shape.matrix, wi))
        )
    else:
        projected = shape.area * abs(shape.normal @ wi)
    found = irradiance(lamp(shape), tuple(x), n)
    np.testing.assert_allclose(found, projected * wi[2] / d**2, rtol=1e-5)


@pytest.mark.parametrize("channels", [1, 3, 5])
def test_any_number_of_channels(channels: int) -> None:
    radiance = tuple(float(1 + k) for k in range(channels))
    found = irradiance(lamp(SHAPES["rectangle"], radiance), (0.4, -0.3, 0.5), (0, 0, 1))
    assert found.shape == (channels,)
    np.testing.assert_allclose(found, np.array(radiance) * found[0], rtol=1e-14)
