"""All emitters of a scene together: what is dark, and the choice among them. Each kind has tests of its own."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from reference_tracer.emission import Emitters, bounding_radius
from reference_tracer.propagation import NOWHERE, Points, RayCaster
from scenes import (
    AreaLight,
    ConstantEnvironment,
    DirectionalLight,
    Disk,
    Ellipsoid,
    EnvironmentMap,
    Image,
    Lambertian,
    Light,
    Mesh,
    Pinhole,
    PointLight,
    PolarRange,
    Quad,
    Scene,
    Shape,
    Sphere,
    SpotLight,
    Surface,
)

CAMERA = Pinhole((0.0, 0.0, 9.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0, 4, 4)
AXIS = (0.6, 0.0, -0.8)
QUAD = Quad((-1.0, -0.5, 2.0), (0.0, 1.2, 0.3), (1.5, 0.2, 0.0))  # its front looks down
BALL = Sphere((3.0, 0.0, 1.0), 0.5)
COUNT = 60_000


def scene_of(
    *pairs: tuple[Shape, AreaLight | None], lights: tuple[Light, ...] = (), channels: int = 2
) -> Scene:
    grey = Lambertian((0.5,) * channels)
    surfaces = tuple(Surface(str(i), shape, grey, light) for i, (shape, light) in enumerate(pairs))
    return Scene(surfaces, CAMERA, lights)


def lamp(e: float, zone: PolarRange | None = None) -> AreaLight:
    return AreaLight((e, 2 * e), zone)


def at(x: np.ndarray, n: np.ndarray, surface: int = 0) -> Points:
    which = np.full(x.shape[1], surface)
    return Points(x, n, surface=which, primitive=which.copy())


def here(count: int, x: tuple = (0.3, 0.2, 0.0)) -> Points:
    return Points.nowhere(np.tile(np.array(x)[:, None], count))


def numbers(emitters: Emitters, count: int, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).random((emitters.dimensions, count))


# ---- Le


def test_a_quad_emits_from_its_front_into_every_direction_alike() -> None:
    emitters = Emitters(scene_of((QUAD, lamp(3.0)), (Sphere((0, 0, 0), 1), None)))
    d = np.array([[0.0, 0.6, 0.8, 0.0], [0.0, 0.0, 0.6, 1.0], [-1.0, -0.8, 1e-9, 1.0]])
    points = at(np.zeros((3, 4)), np.tile(QUAD.normal[:, None], 4))
    front = QUAD.normal @ d > 0
    np.testing.assert_array_equal(emitters.Le(points, d), np.where(front, [[3.0], [6.0]], 0))
    assert front.any()
    assert not front.all()


def test_no_density_on_a_back() -> None:
    """A ray that meets the back finds nothing, and next event would have chosen nothing there."""
    emitters = Emitters(scene_of((QUAD, lamp(3.0))))
    above = np.array([[0.0], [0.0], [5.0]])
    hit = at(np.array([[0.0], [0.0], [2.2]]), QUAD.normal[:, None])
    assert not emitters.pdf(Points.nowhere(above), hit, np.array([[0.0], [0.0], [-1.0]])).any()
    assert emitters.pdf(Points.nowhere(-above), hit, np.array([[0.0], [0.0], [1.0]])).all()


def test_what_does_not_emit_is_dark() -> None:
    emitters = Emitters(scene_of((QUAD, lamp(3.0)), (Sphere((0, 0, 0), 1), None), (BALL, lamp(0.0))))
    up = np.array([[0.0], [0.0], [1.0]])
    for surface in (1, 2, NOWHERE):
        assert not emitters.Le(at(up, up, surface), up).any()
        assert not emitters.pdf(here(1), at(up, -up, surface), up).any()


@pytest.mark.parametrize("inward", [False, True])
@pytest.mark.parametrize(("low", "high"), [(0, 45), (30, 100), (135, 180), (0, 180)])
def test_a_zone_is_measured_from_its_axis_seen_from_the_centre(inward: bool, low: float, high: float) -> None:
    shape = Sphere((1.0, 2.0, 3.0), 0.5, inward)
    emitters = Emitters(scene_of((shape, lamp(1.0, PolarRange(low, high, AXIS)))))
    degrees = np.array([low - 1, low + 1, (low + high) / 2, high - 1, high + 1])
    degrees = degrees[(degrees >= 0) & (degrees <= 180)]
    across = np.array([0.8, 0.0, 0.6])
    outward = np.outer(AXIS, np.cos(np.radians(degrees))) + np.outer(across, np.sin(np.radians(degrees)))
    x = np.array(shape.center)[:, None] + shape.radius * outward
    points = at(x, -outward if inward else outward)
    inside = (degrees > low) & (degrees < high)
    np.testing.assert_array_equal(emitters.Le(points, points.n)[0], inside)
    assert not emitters.Le(points, -points.n).any()
    # the density of next event is zero where nothing is emitted
    reference = Points.nowhere(x + 0.1 * points.n)
    np.testing.assert_array_equal(emitters.pdf(reference, points, -points.n) > 0, inside)


def test_a_side_is_what_the_normal_of_the_points_says() -> None:
    """A two-sided surface comes with the normal of the side that was met."""
    two = Scene((Surface("0", QUAD, Lambertian((0.5, 0.5)), lamp(3.0), two_sided=True),), CAMERA)
    n = QUAD.normal[:, None]
    emitters = Emitters(two)
    for side in (n, -n):
        np.testing.assert_array_equal(emitters.Le(at(np.zeros((3, 1)), side), side), [[3.0], [6.0]])


# ---- the choice

CAP, TRIANGLE = PolarRange(0, 60), Mesh(((0.0, 0.0, 4.0), (0.0, 1.0, 4.0), (1.0, 0.0, 4.0)), ((0, 1, 2),))
LIGHTS = (
    PointLight((0.0, 3.0, 1.0), (0.2, 0.4)),
    PointLight((0.0, 3.0, 1.0), (0.0, 0.0)),
    SpotLight((0.0, -3.0, 1.0), (0.0, 1.0, -1.0), (0.5, 1.0), 60.0, 20.0),
    DirectionalLight((0.0, 0.0, -1.0), (0.01, 0.02)),
    ConstantEnvironment((0.005, 0.01)),
)


def several() -> tuple[Scene, dict[str, float]]:
    """Emitters of different power between dark ones, and the powers, mean of the channels: here 1.5 × the first."""
    surfaces = [
        (Quad((-9.0, -9.0, -9.0), (18.0, 0.0, 0.0), (0.0, 18.0, 0.0)), None),
        (QUAD, lamp(2.0)),
        (BALL, lamp(0.4)),
        (Sphere((-4, 0, 0), 0.5, True), lamp(5.0, CAP)),
        (Quad((5.0, 5.0, 5.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), lamp(0.0)),
        (TRIANGLE, lamp(3.0)),
    ]
    scene = scene_of(*surfaces, lights=LIGHTS)
    R, c, b = bounding_radius(scene), np.radians(60), np.radians(20)
    areas = {1: QUAD.area, 2: np.pi, 3: np.pi / 4, 5: 0.5}  # the cap: (1 − cos 60°) / 2 of 4π/4
    powers = {str(i): surfaces[i][1].radiance[0] * np.pi * area for i, area in areas.items()}
    powers["point"] = 0.2 * 4 * np.pi
    powers["spot"] = 0.5 * 2 * np.pi * (1 - (np.sin(c) - np.sin(b)) / (c - b))
    powers["directional"] = 0.01 * np.pi * R**2
    powers["environment"] = 0.005 * 4 * np.pi * np.pi * R**2
    return scene, powers


def chosen(scene: Scene, sample: object) -> np.ndarray:
    """Which of the emitters of ``several`` a sample belongs to, from what is said of it."""
    delta, far = np.broadcast_to(sample.delta, sample.pdf.shape), np.isinf(sample.distance)
    names = sample.primitive.astype(str).astype(object)
    names[delta & far], names[~delta & far] = "directional", "environment"
    near = delta & ~far
    names[near] = np.where(sample.wi[1][near] > 0, "point", "spot")
    return names


def test_emitters_are_chosen_by_power(follows: Callable) -> None:
    scene, powers = several()
    emitters = Emitters(scene)
    assert emitters.dimensions == 3
    sample = emitters.sample(here(COUNT), numbers(emitters, COUNT))
    names = chosen(scene, sample)
    assert set(names) == set(powers)
    counts = np.array([(names == name).sum() for name in powers])
    share = np.array(list(powers.values())) / sum(powers.values())
    assert follows(counts, share)
    wrong = share * np.where(np.arange(len(share)) % 2, 1.1, 0.9)
    assert not follows(counts, wrong / wrong.sum())
    # for what is a delta, the pdf is the choice alone
    for name in ("point", "spot", "directional"):
        np.testing.assert_allclose(sample.pdf[names == name], powers[name] / sum(powers.values()), rtol=1e-12)


def test_two_sides_have_twice_the_power() -> None:
    grey = Lambertian((0.5, 0.5))
    other = Quad((-1.0, -0.5, 9.0), (0.0, 1.2, 0.3), (1.5, 0.2, 0.0))
    one = Surface("one", QUAD, grey, lamp(1.0))
    both = Surface("both", other, grey, lamp(1.0), two_sided=True)
    emitters = Emitters(Scene((one, both), CAMERA))
    sample = emitters.sample(here(3000), np.stack([*numbers(emitters, 3000)[:2], np.arange(3000) / 3000]))
    assert (sample.primitive == 0).sum() == pytest.approx(1000, abs=1)


def test_a_light_is_sampled_as_if_it_were_alone() -> None:
    """Directions, radiance and distance do not depend on the others; the density has the choice as a factor."""
    scene, powers = several()
    emitters = Emitters(scene)
    u = numbers(emitters, 2000)
    sample = emitters.sample(here(2000), u)
    names = chosen(scene, sample)
    for i in (1, 2, 3, 5):
        lanes = names == str(i)
        alone = scene_of(*((s.shape, s.emission if j == i else None) for j, s in enumerate(scene.surfaces)))
        one = Emitters(alone).sample(here(int(lanes.sum())), u[:2, lanes])
        for field in ("wi", "distance", "Li", "primitive"):
            found, expected = getattr(sample, field)[..., lanes], getattr(one, field)
            np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-15)
        share = powers[str(i)] / sum(powers.values())
        np.testing.assert_allclose(sample.pdf[lanes], share * one.pdf, rtol=1e-12)


def test_the_density_of_what_a_ray_meets() -> None:
    """The same as that of the sample wherever it sees what it has chosen; the environment where it meets nothing."""
    pairs = ((QUAD, lamp(2.0)), (BALL, lamp(0.4)), (Sphere((-4, 0, 0), 0.5), lamp(5.0, CAP)))
    image = Image(np.random.default_rng(1).random((6, 8, 2)))
    scene = scene_of(*pairs, lights=(*LIGHTS[:4], EnvironmentMap(image)))
    emitters, reference = Emitters(scene), here(20_000)
    sample = emitters.sample(reference, numbers(emitters, 20_000))
    hit = RayCaster(scene)(reference, sample.wi)
    seen = (hit.surface == sample.primitive) & ~sample.delta & (sample.Li[0] > 0)
    assert set(hit.surface[seen]) == {0, 1, 2, NOWHERE}
    pdf = emitters.pdf(reference, hit, sample.wi)
    np.testing.assert_allclose(pdf[seen], sample.pdf[seen], rtol=1e-8)  # of grazing hits the place is rounded
    np.testing.assert_array_equal(emitters.Le(hit, -sample.wi)[:, seen], sample.Li[:, seen])


def test_delta_only() -> None:
    scene, powers = several()
    emitters = Emitters(scene, delta_only=True)
    assert emitters.dimensions == 3
    sample = emitters.sample(here(2000), numbers(emitters, 2000))
    assert np.all(sample.delta)
    assert set(chosen(scene, sample)) == {"point", "spot", "directional"}
    total = powers["point"] + powers["spot"] + powers["directional"]
    assert set(np.round(sample.pdf * total, 9)) == {
        round(powers[name], 9) for name in ("point", "spot", "directional")
    }
    hit = RayCaster(scene_of((QUAD, lamp(1.0))))(here(2000), sample.wi)
    assert not emitters.pdf(here(2000), hit, sample.wi).any()
    assert emitters.Le(Points.nowhere(np.zeros((3, 1))), np.array([[0.0], [0.0], [1.0]])).any()


def test_the_primitive_that_a_sample_lies_on() -> None:
    """Counted over all surfaces, a mesh with one for each triangle."""
    pair = Mesh(((0.0, 0.0, 5.0), (0.0, 1.0, 5.0), (1.0, 0.0, 5.0), (1.0, 1.0, 4.9)), ((0, 1, 2), (1, 3, 2)))
    lights = (
        (BALL, None),
        (pair, lamp(1.0)),
        (QUAD, None),
        (TRIANGLE, None),
        (Sphere((6, 0, 3), 0.3), lamp(1.0)),
    )
    scene = scene_of(*lights)
    emitters = Emitters(scene)
    between = here(500, (0.3, 0.2, 4.5))
    sample = emitters.sample(between, numbers(emitters, 500))
    assert set(sample.primitive) == {1, 2, 5}
    np.testing.assert_array_equal(RayCaster(scene)(between, sample.wi).primitive, sample.primitive)


def test_how_many_numbers_a_sample_takes() -> None:
    """None, two, or three if there is a choice; what has no power is none."""
    dark = (LIGHTS[1], ConstantEnvironment((0.0, 0.0)))
    one = scene_of((QUAD, lamp(1.0)), (BALL, lamp(0.0)), lights=dark)
    assert Emitters(one).dimensions == 2
    nothing = Emitters(one, delta_only=True)
    assert nothing.dimensions == 0
    with pytest.raises(ValueError, match="no emitter to choose from"):
        nothing.sample(here(1), np.empty((0, 1)))
    assert Emitters(scene_of((QUAD, lamp(1.0)), (BALL, lamp(1.0)))).dimensions == 3


@pytest.mark.parametrize("channels", [1, 3, 5])
def test_any_number_of_channels(channels: int) -> None:
    L = tuple(1.0 + k for k in range(channels))
    scene = scene_of((QUAD, AreaLight(L)), (BALL, None), channels=channels, lights=(ConstantEnvironment(L),))
    emitters = Emitters(scene)
    sample = emitters.sample(here(500), numbers(emitters, 500))
    assert sample.Li.shape == (channels, 500)
    np.testing.assert_array_equal(sample.Li, np.outer(L, sample.Li[0]))
    hit = RayCaster(scene)(here(500), sample.wi)
    np.testing.assert_array_equal(emitters.Le(hit, -sample.wi)[-1] > 0, hit.surface != 1)


# ---- the sphere around the scene


@pytest.mark.parametrize(
    ("shape", "radius"),
    [
        (Quad((1.0, 2.0, 3.0), (2.0, 0.0, 0.0), (0.0, 0.0, 4.0)), np.sqrt(5)),
        (Sphere((5.0, 5.0, 5.0), 2.0), 2 * np.sqrt(3)),
        (Disk((1.0, 0.0, 0.0), (0.0, 3.0, 0.0), (4.0, 0.0, 0.0)), 5.0),
        (Ellipsoid((1.0, 0.0, 0.0), (0.6, 0.8, 0.0), (-0.8, 0.6, 0.0), (0.0, 0.0, 1.0)), np.sqrt(3)),
        (TRIANGLE, np.sqrt(0.5)),
    ],
    ids=lambda value: type(value).__name__,
)
def test_the_bounding_sphere(shape: Shape, radius: float) -> None:
    assert bounding_radius(scene_of((shape, lamp(1.0)))) == pytest.approx(radius)


def test_the_bounding_sphere_of_nothing_and_of_several() -> None:
    assert bounding_radius(Scene((), CAMERA, LIGHTS[:1])) == 1
    apart = (Sphere((-3.0, 0.0, 0.0), 1.0), lamp(1.0)), (Sphere((3.0, 0.0, 0.0), 1.0), None)
    assert bounding_radius(scene_of(*apart)) == pytest.approx(np.sqrt(18))
