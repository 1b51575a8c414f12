"""Every part of a scene as Mitsuba understands it, held against the reference tracer.

Where nothing is random, single rays are: an emitter, a lit surface, a mirror. Their values agree to the single
precision that Mitsuba computes in, at dozens of random places, so a convention that differs anywhere shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from comparisons.renderers.mitsuba import MitsubaRenderer
from reference_tracer.random_walk import render
from scenes import (
    AreaLight,
    Blend,
    Checkerboard,
    Conductor,
    ConstantEnvironment,
    Dielectric,
    DirectionalLight,
    Disk,
    EnvironmentMap,
    Image,
    ImageTexture,
    Lambertian,
    Light,
    Material,
    Mesh,
    Mirror,
    Pinhole,
    PointLight,
    PolarRange,
    Quad,
    RadianceMeter,
    RoughConductor,
    RoughDielectric,
    Scene,
    Shape,
    Sphere,
    SpotLight,
    Surface,
)

Array = NDArray[np.float64]
GREY = Lambertian((0.5, 0.25, 0.75))
LAMP = AreaLight((1.0, 2.0, 4.0))


@pytest.fixture(scope="module")
def mitsuba() -> MitsubaRenderer:
    return MitsubaRenderer("scalar_rgb")


def image(rows: int, columns: int, high: float = 1.0) -> Image:
    pixels = np.random.default_rng(rows * columns).uniform(0.1, high, (rows, columns, 3))
    return Image(tuple(tuple(tuple(pixel) for pixel in row) for row in pixels.tolist()))


def rotated(mirrored: bool = False) -> Any:
    """Three orthonormal axes, none of them along the world's."""
    axes = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    axes[0] *= np.linalg.det(axes) * (-1 if mirrored else 1)
    return tuple(map(tuple, axes.tolist()))


def sphere_points(count: int, seed: int = 0) -> Array:
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1)[:, None]


def around(shape: Shape, count: int) -> Array:
    """Directions from a shape to viewers: all of them.

    With shading normals only those well away from the horizon, on either side. Where the two normals disagree about
    the side Mitsuba differs: docs/findings/mitsuba-shading-normals.md.
    """
    d = sphere_points(count)
    if not (isinstance(shape, Mesh) and shape.normals):
        return d
    d = np.array([0.0, 0.0, 1.0]) + 0.35 * d
    return d * np.where(np.arange(count) % 2, 1.0, -1.0)[:, None]


Rays = Sequence[tuple[Array, Array]]


def rays_to(targets: Array, origins: Array) -> Rays:
    return [(o, t - o) for o, t in zip(origins, targets, strict=True)]


def along(
    mitsuba: MitsubaRenderer, surfaces: Sequence[Surface], lights: Sequence[Light], rays: Rays, bounces: int
) -> tuple[Array, Array]:
    """Ours and theirs along rays, ``(rays, bounces + 1, 3)``: one path each."""
    ours, theirs = [], []
    for origin, direction in rays:
        view = Scene(tuple(surfaces), RadianceMeter(tuple(origin), tuple(direction)), tuple(lights))
        ours.append(render(view, bounces, 1, 0)[:, 0, 0])
        theirs.append(mitsuba.render(view, range(bounces + 1), 1, 0)[:, 0, 0])
    return np.array(ours), np.array(theirs)


def assert_same(
    mitsuba: MitsubaRenderer,
    surfaces: Sequence[Surface],
    lights: Sequence[Light],
    rays: Rays,
    bounces: int = 1,
    rtol: float = 2e-5,
) -> Array:
    """No random number matters along these rays, and the values are the same. Returns them."""
    ours, theirs = along(mitsuba, surfaces, lights, rays, bounces)
    assert len(np.unique(ours.round(6), axis=0)) > 1, "the same everywhere: nothing is tried"
    np.testing.assert_allclose(theirs, ours, rtol=rtol, atol=1e-6 * ours.max())
    return ours


# ---- shapes: where they are, which side is the front, texture coordinates

U, V, CORNER = np.array([0.9, 0.1, 0.2]), np.array([-0.22, 1.1, 0.44]), np.array([-0.4, -0.5, 0.1])
RADIUS = np.linalg.norm(U) / np.linalg.norm(V)
QUAD = Quad(tuple(CORNER), tuple(U), tuple(V))
DISK = Disk((0.1, 0.2, 0.3), tuple(U), tuple(RADIUS * V))
BALL = Sphere((0.1, -0.2, 0.3), 0.8)
# two triangles that share an edge, bent along it; texture coordinates beyond [0, 1] on every side
MESH = Mesh(
    ((-0.5, -0.6, 0.0), (0.6, -0.5, 0.1), (0.5, 0.6, 0.0), (-0.6, 0.5, 0.4)),
    ((0, 1, 2), (0, 2, 3)),
    uv=((-0.3, -0.2), (1.2, 0.1), (1.3, 1.4), (0.1, 1.2)),
)
SMOOTH = Mesh(
    MESH.vertices, MESH.triangles, normals=((-0.2, -0.1, 1.0), (0.2, -0.1, 1), (0.2, 0.3, 1), (0, 0.1, 1))
)


def points_on(shape: Shape, count: int, seed: int = 1) -> Array:
    s, t = np.random.default_rng(seed).random((2, count, 1))
    match shape:
        case Quad():
            return CORNER + s * U + t * V
        case Disk():
            r, phi = np.sqrt(s), 2 * np.pi * t
            return np.array(shape.center) + r * np.cos(phi) * U + r * np.sin(phi) * RADIUS * V
        case Sphere():
            return np.array(shape.center) + shape.radius * sphere_points(count, seed)
        case Mesh():
            a, b, c = shape.corners[np.arange(count) % len(shape.triangles)].transpose(1, 0, 2)
            s, t = np.where(s + t > 1, 1 - s, s), np.where(s + t > 1, 1 - t, t)
            return a + s * (b - a) + t * (c - a)
    raise AssertionError(shape)


SHAPES: dict[str, Shape] = {"quad": QUAD, "disk": DISK, "sphere": BALL, "mesh": MESH, "smooth mesh": SMOOTH}


@pytest.mark.parametrize("name", SHAPES)
def test_both_sides_of_a_shape(mitsuba: MitsubaRenderer, name: str) -> None:
    """E and TE: emission on the front, reflection about the (shading) normal; black behind."""
    shape = SHAPES[name]
    targets = points_on(shape, 40)
    rays = rays_to(targets, targets + 2 * around(shape, 40))
    lamp = PointLight((0.7, 0.4, 3.0), (3.0, 5.0, 7.0))
    if name != "sphere":  # no ray meets the back of a sphere from outside
        emitted = assert_same(mitsuba, [Surface("shape", shape, GREY, LAMP)], [], rays, 0)
        assert 5 < (emitted[:, 0, 0] > 0).sum() < 35
    reflected = assert_same(mitsuba, [Surface("shape", shape, GREY)], [lamp], rays)
    assert (reflected[:, 1, 0] > 0).sum() > 5


def test_inside_of_a_sphere(mitsuba: MitsubaRenderer) -> None:
    cavity = Sphere(BALL.center, BALL.radius, inward=True)
    rays = rays_to(points_on(cavity, 30), np.array(BALL.center) + 0.3 * sphere_points(30, 3))
    lamp = PointLight((0.2, -0.3, 0.5), (3.0, 5.0, 7.0))
    ours = assert_same(mitsuba, [Surface("shape", cavity, GREY)], [lamp], rays)
    assert (ours[:, 1] > 0).all()
    emitting = [Surface("shape", cavity, GREY, LAMP)]
    np.testing.assert_allclose(
        along(mitsuba, emitting, [], rays, 0)[1][:, 0], np.tile(LAMP.radiance, (30, 1))
    )
    outside = rays_to(points_on(BALL, 3), np.array(BALL.center) + 2 * sphere_points(3, 4))
    black = along(mitsuba, [Surface("shape", cavity, GREY, LAMP)], [lamp], outside, 1)
    assert not np.any(black)


@pytest.mark.parametrize("name", SHAPES)
def test_a_two_sided_shape(mitsuba: MitsubaRenderer, name: str) -> None:
    shape = SHAPES[name]
    targets = points_on(shape, 30)
    rays = rays_to(targets, targets + (0.1 if name == "sphere" else 2) * around(shape, 30))
    lamp = PointLight((0.3, -0.1, -1.7) if name != "sphere" else BALL.center, (3.0, 5.0, 7.0))
    ours = assert_same(mitsuba, [Surface("shape", shape, GREY, two_sided=True)], [lamp], rays)
    assert (ours[:, 1] > 0).any()


TEXTURES = {
    "checkerboard, odd": Checkerboard((0.1, 0.2, 0.3), (0.9, 0.8, 0.7), 3, 5),
    "checkerboard, even": Checkerboard((0.1, 0.2, 0.3), (0.9, 0.8, 0.7), 4, 2),
    "checkerboard, one row": Checkerboard((0.1, 0.2, 0.3), (0.9, 0.8, 0.7), 3, 1),
    "nearest": ImageTexture(image(5, 7), "nearest"),
    "bilinear": ImageTexture(image(4, 3)),
    "bilinear, one pixel high": ImageTexture(image(1, 4)),
    "nearest, one pixel wide": ImageTexture(image(4, 1), "nearest"),
}


@pytest.mark.parametrize("texture", TEXTURES)
@pytest.mark.parametrize(
    "shape", [QUAD, BALL, Sphere(BALL.center, BALL.radius, True), MESH], ids=lambda part: type(part).__name__
)
def test_textures_lie_where_ours_do(mitsuba: MitsubaRenderer, shape: Shape, texture: str) -> None:
    targets = points_on(shape, 40)
    front = np.array([0.2, 0.1, 2.5]) if not isinstance(shape, Sphere) else np.array(shape.center)
    if isinstance(shape, Sphere) and not shape.inward:
        front = front + 3 * (targets - front)  # from straight above each point
    origins = np.broadcast_to(front, targets.shape)
    lamp = DirectionalLight((0.1, 0.2, -1.0), (1.0, 2.0, 3.0))
    lights: list[Light] = [lamp]
    if isinstance(shape, Sphere):
        lights = [PointLight(shape.center, (1.0, 2.0, 3.0))] if shape.inward else [lamp]
    surface = Surface("shape", shape, Lambertian(TEXTURES[texture]))
    ours = assert_same(mitsuba, [surface], lights, rays_to(targets, origins))
    assert (ours[:, 1].min(axis=1) > 0).sum() > 15


def test_a_texture_on_a_sphere_that_emits_from_a_zone(mitsuba: MitsubaRenderer) -> None:
    light = AreaLight(LAMP.radiance, PolarRange(30, 90))
    surface = Surface("shape", BALL, Lambertian(TEXTURES["nearest"]), light)
    targets = points_on(BALL, 40)
    rays = rays_to(targets, np.array(BALL.center) + 3 * (targets - np.array(BALL.center)))
    assert_same(mitsuba, [surface], [DirectionalLight((0.1, 0.2, -1.0), (1.0, 2.0, 3.0))], rays)


# ---- lights

FLOOR = Surface("floor", Quad((-3.0, -3.0, 0.0), (6.0, 0.0, 0.0), (0.0, 6.0, 0.0)), GREY)
LIGHTS: dict[str, Light] = {
    "point": PointLight((0.3, 0.4, 2.0), (1.0, 20.0, 300.0)),
    "spot": SpotLight((0.3, 0.4, 2.0), (0.1, 0.2, -1.0), (1.0, 2.0, 30.0), 50.0, 20.0),
    "spot without falloff": SpotLight((0.3, 0.4, 2.0), (0.1, 0.2, -1.0), (1.0, 2.0, 3.0), 30.0, 30.0),
    "spot, falling from the axis on": SpotLight(
        (0.3, 0.4, 2.0), (0.0, 0.0, -1.0), (1.0, 2.0, 3.0), 45.0, 0.0
    ),
    "spot wider than a half space": SpotLight((0.3, 0.4, 2.0), (0.0, 1.0, 0.3), (1.0, 2.0, 3.0), 150.0, 30.0),
    "spot of all directions": SpotLight((0.3, 0.4, 2.0), (0.0, 1.0, 0.0), (1.0, 2.0, 3.0), 180.0, 0.0),
    "directional": DirectionalLight((0.3, -0.5, -0.8), (1.0, 20.0, 300.0)),
}


@pytest.mark.parametrize("name", LIGHTS)
def test_a_light_on_a_floor(mitsuba: MitsubaRenderer, name: str) -> None:
    """A ball casts a shadow, so that the light is seen to come from where it should."""
    xy = np.random.default_rng(2).uniform(-2.9, 2.9, (60, 2))
    targets = np.column_stack([xy, np.zeros(60)])
    ball = Surface("ball", Sphere((0.2, -0.5, 0.6), 0.5), GREY)
    ours = assert_same(
        mitsuba,
        [FLOOR, ball],
        [LIGHTS[name]],
        rays_to(targets, targets + np.array([0.1, 0.2, 3.0])),
        rtol=5e-5,
    )
    assert 0 < (ours[:, 1, 0] > 0).mean() < 1


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("size", [(4, 7), (1, 5), (5, 1), (1, 1), (8, 16)])
def test_an_environment_map(mitsuba: MitsubaRenderer, size: tuple[int, int], mirrored: bool) -> None:
    """Random directions, and those where conventions would part: poles and the seam."""
    axes = rotated(mirrored)
    light = EnvironmentMap(image(*size, high=20.0), axes)
    seam = np.array([[1.0, s, z] for s in (-1e-3, 1e-3) for z in (-0.5, 0.8)])
    poles = np.array([[1e-3, 2e-3, s] for s in (-1.0, 1.0)])
    d = np.concatenate([sphere_points(40), seam @ axes, poles @ axes])
    rays = [(np.zeros(3), direction) for direction in d]
    if size == (1, 1):
        ours, theirs = along(mitsuba, [], [light], rays, 0)
        np.testing.assert_allclose(theirs, ours, rtol=1e-6)
    else:
        assert_same(mitsuba, [], [light], rays, 0, rtol=2e-4)


def test_a_constant_environment(mitsuba: MitsubaRenderer) -> None:
    rays = [(np.zeros(3), d) for d in sphere_points(10)]
    half = Surface(
        "half", Disk((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), Mirror((0.5, 0.25, 0.125))
    )
    assert_same(mitsuba, [half], [ConstantEnvironment((1.0, 20.0, 300.0))], rays)


# ---- materials that reflect into one direction, under an environment that tells directions apart

SKY = EnvironmentMap(image(6, 9, high=20.0), rotated())
METAL = {"eta": (0.2, 1.1, 2.9), "k": (3.9, 6.8, 0.0)}


@pytest.mark.parametrize("two_sided", [False, True])
@pytest.mark.parametrize(
    "material", [Mirror((0.9, 0.5, 0.1)), Conductor(**METAL)], ids=lambda part: type(part).__name__
)
@pytest.mark.parametrize("name", SHAPES)
def test_reflection_of_the_sky(
    mitsuba: MitsubaRenderer, name: str, material: Material, two_sided: bool
) -> None:
    shape = SHAPES[name]
    targets = points_on(shape, 20)
    rays = rays_to(targets, targets + 2 * around(shape, 20))
    surface = Surface("shape", shape, material, two_sided=two_sided)
    assert_same(mitsuba, [surface], [SKY], rays, bounces=2, rtol=5e-4)


GLASS = {
    "glass": Dielectric(1.5, 1.0),
    "a bubble in water": Dielectric(1.0, 1.33),
    "half mirror": Blend(Mirror((0.2, 0.4, 0.6)), Conductor(**METAL), 0.3),
    "glass and mirror": Blend(Dielectric(1.5, 1.0), Mirror((0.2, 0.4, 0.6)), 0.3),
}


@pytest.mark.parametrize("material", GLASS)
@pytest.mark.parametrize("inside", [False, True])
def test_each_way_through_glass(mitsuba: MitsubaRenderer, material: str, inside: bool) -> None:
    """At a pane a path has few ways to go on. Each has the same value here and there, and the same share."""
    pane = Surface("pane", Quad((-50.0, -50.0, 0.0), (100.0, 0.0, 0.0), (0.0, 100.0, 0.0)), GLASS[material])
    behind = inside and "mirror" not in material
    origin = np.array([0.3, 0.1, -1.0 if behind else 1.0])
    for tilt in (0.2, 0.7) if behind else (0.2, 2.0):  # inside, 0.7 is close to total reflection
        direction = np.array([tilt, 0.3 * tilt, 1.0 if behind else -1.0])
        view = Scene((pane,), RadianceMeter(tuple(origin), tuple(direction)), (SKY,))
        ours = np.array([render(view, 1, 1, seed)[1, 0, 0] for seed in range(200)])
        theirs = np.array([mitsuba.render(view, [1], 1, seed)[0, 0, 0] for seed in range(200)])
        ways = np.unique(ours.round(3), axis=0)
        for way in ways:
            shares = [(np.abs(sides - way).max(axis=1) < 1e-2).mean() for sides in (ours, theirs)]
            # a binomial share of 200: its standard error is at most 0.05 for the difference of two
            assert abs(shares[0] - shares[1]) < 0.2
        exact = ours[:, None] - theirs[None]
        np.testing.assert_allclose(np.abs(exact).max(axis=2).min(axis=0), 0, atol=1e-3)
        assert len(ways) >= 1


# ---- rough materials: f at many pairs of directions, and what sampling makes of it

ROUGH: dict[str, Material] = {
    "metal": RoughConductor(**METAL, alpha=0.3, shadowing="separable"),
    "polished metal": RoughConductor(**METAL, alpha=0.05, shadowing="separable"),
    "glass": RoughDielectric(0.4, 1.5, 1.0, "separable"),
    "a bubble in water": RoughDielectric(0.2, 1.0, 1.33, "separable"),
    "paint over metal": Blend(GREY, RoughConductor(**METAL, alpha=0.3, shadowing="separable"), 0.3),
    "three of them": Blend(
        Blend(GREY, RoughDielectric(0.4, 1.5, 1.0, "separable"), 0.8), Lambertian((0.9, 0.1, 0.4)), 0.3
    ),
}


@pytest.mark.parametrize("material", ROUGH)
def test_f_of_rough_materials(mitsuba: MitsubaRenderer, material: str) -> None:
    """Reflection and, where there is any, refraction, from both sides."""
    pane = Surface("pane", Quad((-1.0, -1.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0)), ROUGH[material])
    to_viewer, to_light = sphere_points(60, 6), sphere_points(60, 7)
    lit = 0
    for wo, wi in zip(to_viewer, to_light, strict=True):
        lamp = DirectionalLight(tuple(-wi), (1.0, 2.0, 3.0))
        ours, theirs = along(mitsuba, [pane], [lamp], [(0.5 * wo, -wo)], 1)
        np.testing.assert_allclose(theirs, ours, rtol=1e-4, atol=1e-7)
        lit += ours.any()
    assert lit > 8


def test_two_sided_metal_and_paint(mitsuba: MitsubaRenderer) -> None:
    pane = Surface("pane", QUAD, ROUGH["paint over metal"], two_sided=True)
    targets = points_on(QUAD, 40)
    rays = rays_to(targets, targets + 2 * sphere_points(40))
    assert_same(mitsuba, [pane], [PointLight((0.3, -0.1, -1.7), (3.0, 5.0, 7.0))], rays, rtol=1e-4)


def image_means(mitsuba: MitsubaRenderer, view: Scene, bounces: int, spp: int) -> tuple[Array, Array, Array]:
    """Means of both images, ``(bounces + 1, 3)``, and the standard error of their difference, from the pixels.

    The field of view is tiny: pixels are replicates.
    """
    ours, theirs = render(view, bounces, spp, 1), mitsuba.render(view, range(bounces + 1), spp, 1)
    count = ours.shape[1] * ours.shape[2]
    error = np.sqrt((ours.var(axis=(1, 2)) + theirs.var(axis=(1, 2))) / count)
    return ours.mean(axis=(1, 2)), theirs.mean(axis=(1, 2)), error


LIT: dict[str, tuple[Surface, ...]] = {
    **{name: (Surface("pane", QUAD, material),) for name, material in ROUGH.items()},
    "paper": (Surface("pane", QUAD, GREY),),
    "glass ball": (Surface("ball", BALL, GLASS["glass"]), Surface("pane", QUAD, GREY)),
    "emitting mesh": (FLOOR, Surface("mesh", MESH, GREY, LAMP)),
    "emitting disk": (FLOOR, Surface("disk", DISK, GREY, LAMP)),
}


@pytest.mark.parametrize("name", LIT)
def test_sampling_under_an_uneven_sky(mitsuba: MitsubaRenderer, name: str) -> None:
    """Weights and densities: no value along a single path can be told from another's, but the means can."""
    target = np.array([1.2, 0.9, 0.0]) if FLOOR in LIT[name] else CORNER + 0.5 * U + 0.6 * V
    origin = target + np.array([0.5, 0.2, 2.0])
    sensor = Pinhole(tuple(origin), tuple(target), (0.0, 1.0, 0.0), 1e-2, 24, 24)
    ours, theirs, error = image_means(mitsuba, Scene(LIT[name], sensor, (SKY,)), 2, 64)
    assert (ours[1] > 0).all()
    assert (error[1] < 0.05 * ours[1]).all()
    # 9 comparisons: 4.5 standard errors are exceeded once in 16,000
    np.testing.assert_array_less(np.abs(theirs - ours), 4.5 * error + 1e-5 * ours.max())


@pytest.mark.parametrize(("a", "b"), [("paper", "paint over metal"), ("paint over metal", "metal")])
def test_sampling_tells_materials_apart(mitsuba: MitsubaRenderer, a: str, b: str) -> None:
    """The power of the test above: two materials differ by more than it allows."""
    sensor = Pinhole((0.5, 0.4, 2.4), tuple(CORNER + 0.5 * U + 0.6 * V), (0.0, 1.0, 0.0), 1e-2, 24, 24)
    ours, _, error = image_means(mitsuba, Scene(LIT[a], sensor, (SKY,)), 1, 64)
    other, *_ = image_means(mitsuba, Scene(LIT[b], sensor, (SKY,)), 1, 64)
    assert (np.abs(other[1] - ours[1]) > 9 * error[1]).any()
