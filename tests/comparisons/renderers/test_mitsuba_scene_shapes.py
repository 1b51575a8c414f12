"""Shapes as Mitsuba understands them: where they are, which side is the front, texture coordinates."""

from __future__ import annotations

from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from comparisons.renderers.mitsuba import MitsubaRenderer
from scenes import (
    AreaLight,
    Checkerboard,
    DirectionalLight,
    Disk,
    ImageTexture,
    Lambertian,
    Light,
    PointLight,
    PolarRange,
    Quad,
    Shape,
    Sphere,
    Surface,
    library,
)

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("single_rays.py"))))
BALL, GREY, LAMP = shared.BALL, shared.GREY, shared.LAMP
MESH, QUAD, SHAPES = shared.MESH, shared.QUAD, shared.SHAPES
along, around, assert_same, image = shared.along, shared.around, shared.assert_same, shared.image
points_on, rays_to, sphere_points = shared.points_on, shared.rays_to, shared.sphere_points


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
    "shape",
    [QUAD, SHAPES["parallelogram"], BALL, Sphere(BALL.center, BALL.radius, True), MESH],
    ids=lambda part: type(part).__name__,
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


LAMPS = {
    "parallelogram": Quad((-1.4, 1.2, 0.3), (0.9, 0.1, -1.0), (0.8, 0.4, -0.1)),
    "ellipse": Disk((-0.7, 1.4, -0.4), (0.9, 0.1, -0.2), (0.3, -0.15, 0.4)),
}


@pytest.mark.parametrize("name", LAMPS)
def test_a_skew_lamp_is_as_bright_as_its_formula(mitsuba: MitsubaRenderer, name: str) -> None:
    """Emitter samples have the density of its own area; a rectangle of these edges has 42 % more, a circle 7 %."""
    case = library.case("quad-over-plane")
    floor, lamp = case.scene.surfaces
    view = msgspec.structs.replace(
        case.scene.resized(8, 8), surfaces=(floor, msgspec.structs.replace(lamp, shape=LAMPS[name]))
    )
    answer = case.answer.truth(view, 1)
    assert answer is not None
    exact = answer.mean[1].mean()
    means = [mitsuba.render(view, [1], 64, seed).mean() for seed in range(32)]
    error = np.std(means, ddof=1) / np.sqrt(len(means))
    assert error < 0.004 * exact
    assert abs(np.mean(means) - exact) < 4.5 * error
