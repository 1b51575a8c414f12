"""Materials as Mitsuba understands them: the values along single rays, and what sampling makes of them."""

from __future__ import annotations

from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import numpy as np
import pytest

from comparisons.renderers.mitsuba import MitsubaRenderer
from reference_tracer.random_walk import render
from scenes import (
    Blend,
    Conductor,
    Dielectric,
    DirectionalLight,
    EnvironmentMap,
    Lambertian,
    Material,
    Mirror,
    Pinhole,
    PointLight,
    Quad,
    RadianceMeter,
    RoughConductor,
    RoughDielectric,
    Scene,
    Surface,
)

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("single_rays.py"))))
Array, BALL, CORNER, DISK = shared.Array, shared.BALL, shared.CORNER, shared.DISK
FLOOR, GREY, LAMP, MESH = shared.FLOOR, shared.GREY, shared.LAMP, shared.MESH
QUAD, SHAPES, U, V = shared.QUAD, shared.SHAPES, shared.U, shared.V
along, around, assert_same = shared.along, shared.around, shared.assert_same
image, points_on, rays_to = shared.image, shared.points_on, shared.rays_to
rotated, sphere_points = shared.rotated, shared.sphere_points


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
