"""Transformed scenes: points go to points, fronts stay fronts, textures stay attached, radiance stays."""

from __future__ import annotations

import math
from typing import Any

import msgspec
import numpy as np
import pytest

from scenes import (
    Affine,
    AreaLight,
    Blend,
    Checkerboard,
    ConstantEnvironment,
    Dielectric,
    DirectionalLight,
    Disk,
    Ellipsoid,
    EnvironmentMap,
    Image,
    ImageTexture,
    IrradianceMeter,
    Lambertian,
    Mesh,
    Orthographic,
    Pinhole,
    PointLight,
    PolarRange,
    Quad,
    RadianceMeter,
    Scene,
    SceneError,
    Shape,
    Sphere,
    SphericalHarmonicsEnvironment,
    SpotLight,
    Surface,
    ThinLens,
    transformed,
)
from scenes.library import case

X, Y, Z, ORIGIN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
TURN = Affine.rotation((1, 2, -3), 50)
SIMILARITIES = {
    "nothing": Affine(),
    "translation": Affine.translation((3, -1, 2)),
    "rotation": TURN,
    "scaling": Affine.scaling(2.5),
    "reflection": Affine.reflection((1, 2, 2)),
    "point reflection": Affine.scaling(-1),
    "all of them": Affine.translation((1, 2, 3)) @ TURN @ Affine.scaling(0.3) @ Affine.reflection((0, 1, 1)),
}
OTHERS = {
    "stretch": Affine.scaling((1, 2, 3)),
    "shear": Affine(((1, 0.4, 0.1), (0, 2, 0.3), (0.2, 0, 1)), (1, 2, 3)),
    "stretch and mirror": Affine.scaling((1, -2, 3)) @ TURN,
}
MAPS = SIMILARITIES | OTHERS
similarities = pytest.mark.parametrize("affine", SIMILARITIES.values(), ids=SIMILARITIES)
others = pytest.mark.parametrize("affine", OTHERS.values(), ids=OTHERS)
maps = pytest.mark.parametrize("affine", MAPS.values(), ids=MAPS)

SHAPES: dict[str, Shape] = {
    "quad": Quad((1.0, 0.0, 2.0), (1.0, 0.5, 0.0), (0.0, 1.0, 1.0)),
    "disk": Disk((1.0, 0.0, 2.0), (1.0, 0.5, 0.0), (0.0, 0.3, 0.6)),
    "sphere": Sphere((1.0, 0.0, 2.0), 1.5),
    "cavity": Sphere((1.0, 0.0, 2.0), 1.5, inward=True),
    "ellipsoid": Ellipsoid((1.0, 0.0, 2.0), X, (0.0, 2.0, 0.0), (0.5, 0.0, 0.5), inward=True),
    "mesh": Mesh([ORIGIN, X, Y, (1.0, 1.0, 0.5)], [(0, 1, 2), (1, 3, 2)], [(-0.1, -0.1, 1.0)] * 4),
}
shapes = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)


def local(shape: Shape) -> np.ndarray:
    """Parameters (s, t) or unit vectors of 200 points that any shape of that type has."""
    rng = np.random.default_rng(1)
    if isinstance(shape, Sphere | Ellipsoid):
        q = rng.normal(size=(3, 200))
        return q / np.linalg.norm(q, axis=0)
    if isinstance(shape, Disk):
        r, phi = np.sqrt(rng.random(200)), 2 * np.pi * rng.random(200)
        return np.stack([r * np.cos(phi), r * np.sin(phi)])
    return rng.random((2, 200))


def surface_points(shape: Shape) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points, normals of the front there, and texture coordinates, by the definitions alone."""
    q = local(shape)
    if isinstance(shape, Quad):
        x = np.array(shape.corner)[:, None] + np.outer(shape.edge_u, q[0]) + np.outer(shape.edge_v, q[1])
        return x, np.tile(shape.normal[:, None], 200), q
    if isinstance(shape, Disk):
        x = np.array(shape.center)[:, None] + np.outer(shape.axis_u, q[0]) + np.outer(shape.axis_v, q[1])
        return x, np.tile(shape.normal[:, None], 200), (1 + q) / 2
    if isinstance(shape, Sphere | Ellipsoid):
        M = shape.matrix if isinstance(shape, Ellipsoid) else shape.radius * np.eye(3)
        n = np.linalg.inv(M).T @ q * (-1 if shape.inward else 1)
        uv = np.stack([np.arctan2(q[1], q[0]) / 2 / np.pi % 1, 1 - np.arccos(q[2]) / np.pi])
        return np.array(shape.center)[:, None] + M @ q, n / np.linalg.norm(n, axis=0), uv
    a, b, c = shape.corners.transpose(1, 0, 2)
    n = np.cross(b - a, c - a)
    middles = shape.corners.mean(axis=1)
    return middles.T, (n / np.linalg.norm(n, axis=1)[:, None]).T, np.zeros((2, len(middles)))


def coordinates(shape: Shape, x: np.ndarray) -> np.ndarray:
    """What is 0 where a point lies on the shape, and its local coordinates besides, by solving the definition."""
    if isinstance(shape, Quad | Disk):
        start, u, v = (
            (shape.corner, shape.edge_u, shape.edge_v)
            if isinstance(shape, Quad)
            else (shape.center, shape.axis_u, shape.axis_v)
        )
        M = np.stack([u, v, np.cross(u, v)], axis=1)
        return np.linalg.solve(M, x - np.array(start)[:, None])
    M = shape.matrix if isinstance(shape, Ellipsoid) else shape.radius * np.eye(3)
    return np.linalg.solve(M, x - np.array(shape.center)[:, None])


# ---- shapes


@shapes
@maps
def test_points_and_fronts_go_along(shape: Shape, affine: Affine) -> None:
    image = transformed(shape, affine)
    x, n, _ = surface_points(shape)
    y, front = affine.points(x), affine.vectors(n)  # a vector that leaves the front leaves the image's front
    if isinstance(image, Mesh):
        there, normal, _ = surface_points(image)
        np.testing.assert_allclose(there, y, atol=1e-13)
    elif isinstance(image, Quad | Disk):
        s, t, off = coordinates(image, y)
        np.testing.assert_allclose(off, 0, atol=1e-13)
        inside = s**2 + t**2 <= 1 + 1e-12 if isinstance(image, Disk) else (np.abs([s, t]) <= 1 + 1e-12).all(0)
        assert inside.all()
        if isinstance(image, Quad):
            assert min(s.min(), t.min()) >= -1e-12
        normal = np.tile(image.normal[:, None], len(s))
    else:
        q = coordinates(image, y)
        np.testing.assert_allclose(np.linalg.norm(q, axis=0), 1, rtol=1e-12)
        M = image.matrix if isinstance(image, Ellipsoid) else image.radius * np.eye(3)
        normal = np.linalg.inv(M).T @ q * (-1 if image.inward else 1)
    assert ((normal * front).sum(axis=0) > 0).all()
    # the normal stays across every direction that lay in the surface
    for across in np.eye(3):
        tangent = np.cross(n.T, across).T
        length = np.linalg.norm(affine.vectors(tangent), axis=0) * np.linalg.norm(normal, axis=0)
        np.testing.assert_allclose(
            (normal * affine.vectors(tangent)).sum(axis=0), 0, atol=1e-12 * length.max()
        )


@pytest.mark.parametrize("name", ["quad", "disk", "sphere", "mesh"])
@similarities
def test_areas_scale_with_the_square(name: str, affine: Affine) -> None:
    shape: Any = SHAPES[name]
    assert transformed(shape, affine).area == pytest.approx(affine.scale**2 * shape.area)


def test_a_stretched_area_in_closed_form() -> None:
    stretch = Affine.scaling((2, 3, 1))
    assert transformed(Disk(ORIGIN, X, Y), stretch).area == pytest.approx(6 * math.pi)
    assert transformed(Quad(ORIGIN, X, Z), stretch).area == pytest.approx(2)
    assert transformed(Mesh([ORIGIN, X, Y], [(0, 1, 2)]), stretch).area == pytest.approx(3)


@maps
def test_a_sphere_stays_one_only_under_a_similarity(affine: Affine) -> None:
    assert isinstance(transformed(SHAPES["sphere"], affine), Sphere if affine.scale else Ellipsoid)


@maps
def test_shading_normals_stay_across(affine: Affine) -> None:
    mesh = SHAPES["mesh"]
    image = transformed(mesh, affine)
    assert isinstance(mesh, Mesh)
    assert isinstance(image, Mesh)
    for before, after in zip(mesh.normals, image.normals, strict=True):
        tangents = np.linalg.svd([before])[2][1:]
        np.testing.assert_allclose(affine.vectors(tangents.T).T @ after, 0, atol=1e-13)
        assert affine.vectors(before) @ after > 0


# ---- surfaces

ROWS = Image([[[0.1], [0.2], [0.3]], [[0.4], [0.5], [0.6]]])
TEXTURES = {
    "even columns": Checkerboard((0.1,), (0.9,), 4, 3),
    "odd columns": Checkerboard((0.1,), (0.9,), 3, 2),
    "image": ImageTexture(ROWS, "nearest"),
}


def albedo(material: Any, uv: np.ndarray) -> np.ndarray:
    texture = material.albedo
    if isinstance(texture, Checkerboard):
        squares = np.floor(uv[0] * texture.columns) + np.floor(uv[1] * texture.rows)
        return np.where(squares % 2 == 0, texture.even[0], texture.odd[0])
    rows, columns, _ = texture.image.array.shape
    return texture.image.array[((1 - uv[1]) * rows).astype(int), (uv[0] * columns).astype(int), 0]


@pytest.mark.parametrize("texture", TEXTURES.values(), ids=TEXTURES)
@pytest.mark.parametrize("name", ["quad", "disk", "sphere", "ellipsoid"])
@maps
def test_textures_stay_attached(name: str, texture: Any, affine: Affine) -> None:
    """Each point looks as it did: found again in the image by its place alone, and its albedo looked up there."""
    shape = SHAPES[name]
    before = Surface("s", shape, Lambertian(texture))
    after = transformed(before, affine)
    x, _, uv = surface_points(shape)
    q = coordinates(after.shape, affine.points(x))
    if isinstance(after.shape, Sphere | Ellipsoid):
        there = np.stack(
            [np.arctan2(q[1], q[0]) / 2 / np.pi % 1, 1 - np.arccos(np.clip(q[2], -1, 1)) / np.pi]
        )
    else:
        there = q[:2] if isinstance(after.shape, Quad) else (1 + q[:2]) / 2
    np.testing.assert_array_equal(albedo(after.material, there), albedo(before.material, uv))


def test_textures_in_a_blend_are_flipped_too() -> None:
    checks = Lambertian(Checkerboard((0.1,), (0.9,), 2, 2))
    surface = Surface("s", SHAPES["quad"], Blend(Dielectric(), Blend(checks, Lambertian((0.5,)), 0.3), 0.2))
    flipped = transformed(surface, Affine.scaling(-1)).material
    assert flipped == Blend(
        Dielectric(), Blend(Lambertian(Checkerboard((0.9,), (0.1,), 2, 2)), Lambertian((0.5,)), 0.3), 0.2
    )


@similarities
def test_a_zone_turns_with_its_sphere(affine: Affine) -> None:
    light = AreaLight((1.0,), PolarRange(20, 70, (1, 2, 2)))
    image = transformed(Surface("s", Sphere(X, 2.0), Lambertian((0.5,)), light), affine)
    x, _, _ = surface_points(Sphere(X, 2.0))
    axis, center = np.array(light.polar_range.axis), np.array(image.shape.center)[:, None]
    new_axis = np.array(image.emission.polar_range.axis)
    radius = image.shape.radius
    np.testing.assert_allclose(
        new_axis @ (affine.points(x) - center) / radius, axis @ (x - np.array(X)[:, None]) / 2, atol=1e-13
    )
    assert image.emission.radiance == (1.0,)


@others
def test_a_zone_needs_a_sphere(affine: Affine) -> None:
    surface = Surface("s", Sphere(X, 2.0), Lambertian((0.5,)), AreaLight((1.0,), PolarRange(20, 70)))
    with pytest.raises(SceneError, match="a similarity: only a sphere has polar angles"):
        transformed(surface, affine)


def test_a_textured_zone_can_t_be_turned() -> None:
    material = Lambertian(Checkerboard((0.1,), (0.9,)))
    surface = Surface("s", Sphere(X, 2.0), material, AreaLight((1.0,), PolarRange(20, 70)))
    moved = transformed(surface, Affine.translation(Y) @ Affine.scaling(2))
    assert isinstance(moved.shape, Sphere)
    with pytest.raises(SceneError, match="a texture and a polar range"):
        transformed(surface, TURN)


# ---- lights and sensors


@similarities
def test_irradiance_stays(affine: Affine) -> None:
    """I cos θ / r² of a point light and E cos θ of a directional one, at a patch that is transformed with them."""
    x, n = np.array([0.5, 1.0, -1.0]), np.array([0.0, 0.6, 0.8])
    y, m = affine.points(x), affine.normals(n) / np.linalg.norm(affine.normals(n))

    def irradiance(light: Any, x: np.ndarray, n: np.ndarray) -> float:
        if isinstance(light, DirectionalLight):
            return -light.irradiance[0] * float(n @ light.direction)
        d = np.array(light.position) - x
        return light.intensity[0] * float(n @ d) / float(np.linalg.norm(d)) ** 3

    spot = SpotLight((3.0, 4.0, 5.0), (-1.0, -0.5, -2.0), (7.0,), 40, 20)
    for light in (PointLight((3.0, 4.0, 5.0), (7.0,)), spot, DirectionalLight((1, -2, -3), (7.0,))):
        assert irradiance(light, x, n) > 0
        assert irradiance(transformed(light, affine), y, m) == pytest.approx(irradiance(light, x, n))
    turned, d = transformed(spot, affine), x - np.array(spot.position)
    e = y - np.array(turned.position)
    assert np.dot(turned.direction, e) / np.linalg.norm(e) == pytest.approx(
        np.dot(spot.direction, d) / np.linalg.norm(d)
    )
    assert (turned.cutoff, turned.beam) == (40, 20)


@similarities
def test_environments_turn(affine: Affine) -> None:
    """A direction has the same local coordinates after it and the environment were turned."""
    d = np.array([0.48, 0.6, 0.64])
    e = affine.vectors(d) / affine.scale
    axes = tuple(map(tuple, TURN.matrix.T.tolist()))
    for light in (EnvironmentMap(ROWS, axes), SphericalHarmonicsEnvironment([[1.0]], axes)):
        image = transformed(light, affine)
        np.testing.assert_allclose(np.array(image.axes) @ e, np.array(light.axes) @ d, atol=1e-14)
        assert msgspec.structs.replace(image, axes=axes) == light
    assert transformed(ConstantEnvironment((1.0,)), affine) == ConstantEnvironment((1.0,))


def rays(sensor: Any, x: float, y: float) -> tuple[np.ndarray, np.ndarray]:
    """Origin and direction of the ray through a pixel's place; of a thin lens the one through its centre."""
    if isinstance(sensor, Orthographic):
        return np.array(sensor.origin) + sensor.pixel_to_offset @ [x, y, 1], sensor.frame[:, 2]
    d = sensor.pixel_to_direction @ [x, y, 1]
    return np.array(sensor.origin), d / np.linalg.norm(d)


CAMERA = ((1.0, 2.0, 3.0), (-2.0, 0.5, 4.0), (0.3, 0.1, 1.0))
CAMERAS = [
    Pinhole(*CAMERA, 50.0, 8, 6),
    ThinLens(*CAMERA, 50.0, 8, 6, 0.2, 3.0),
    Orthographic(*CAMERA, 2.0, 8, 6),
]


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: type(camera).__name__)
@similarities
def test_a_camera_sees_the_same_or_its_mirror_image(camera: Any, affine: Affine) -> None:
    image = transformed(camera, affine)
    for x, y in [(0.0, 0.0), (8.0, 6.0), (1.3, 4.7)]:
        origin, d = rays(camera, x, y)
        other_origin, e = rays(image, 8 - x if affine.mirrors else x, y)
        np.testing.assert_allclose(other_origin, affine.points(origin), atol=1e-13)
        np.testing.assert_allclose(e, affine.vectors(d) / affine.scale, atol=1e-13)
    if isinstance(camera, ThinLens):
        assert image.aperture_radius == pytest.approx(0.2 * affine.scale)
        assert image.focus_distance == pytest.approx(3.0 * affine.scale)


@similarities
def test_meters_go_along(affine: Affine) -> None:
    radiance = transformed(RadianceMeter(X, (0.0, 0.6, 0.8)), affine)
    np.testing.assert_allclose(radiance.origin, affine.points(X))
    np.testing.assert_allclose(radiance.direction, affine.vectors((0.0, 0.6, 0.8)) / affine.scale, atol=1e-15)
    irradiance = transformed(IrradianceMeter(X, (0.0, 0.6, 0.8)), affine)
    np.testing.assert_allclose(irradiance.normal, radiance.direction, atol=1e-15)


PARTS = [
    PointLight(X, (1.0,)),
    SpotLight(X, Y, (1.0,), 30, 20),
    DirectionalLight(X, (1.0,)),
    ConstantEnvironment((1.0,)),
    EnvironmentMap(ROWS),
    SphericalHarmonicsEnvironment([[1.0]]),
    *CAMERAS,
    RadianceMeter(X, Y),
    IrradianceMeter(X, Y),
    case("cornell-box").scene,
]


@pytest.mark.parametrize("part", PARTS, ids=lambda part: type(part).__name__)
@others
def test_what_only_a_similarity_can_move(part: Any, affine: Affine) -> None:
    with pytest.raises(SceneError, match=f"a similarity: any other map changes what a {type(part).__name__}"):
        transformed(part, affine)


def test_what_has_no_image() -> None:
    with pytest.raises(TypeError, match="Lambertian has no image"):
        transformed(Lambertian((0.5,)), TURN)


# ---- scenes


@pytest.mark.parametrize("name", ["furnace-box", "furnace-sphere", "integrating-sphere"])
@similarities
def test_the_answer_stays(name: str, affine: Affine) -> None:
    """The closed forms, evaluated for the transformed scene: the rim of the cap is found from its new place."""
    given = case(name)
    scene = given.scene.resized(12, 8)
    before, after = (given.answer.truth(s, 3) for s in (scene, transformed(scene, affine)))
    expected = before.mean[:, :, ::-1] if affine.mirrors else before.mean
    np.testing.assert_allclose(after.mean, expected, atol=1e-9)


def test_everything_in_a_scene_goes_along() -> None:
    lights = (PointLight(X, (1.0,)), ConstantEnvironment((1.0,)))
    scene = Scene((Surface("s", Sphere(X, 1.0), Lambertian((0.5,))),), CAMERAS[0], lights)
    twice = transformed(scene, Affine.scaling(2))
    assert twice.surfaces[0].shape == Sphere((2.0, 0.0, 0.0), 2.0)
    assert twice.lights == (PointLight((2.0, 0.0, 0.0), (4.0,)), lights[1])
    assert twice.sensor.origin == (2.0, 4.0, 6.0)
    assert Scene.from_json(twice.to_json()) == twice


def test_only_an_affine_transforms() -> None:
    with pytest.raises(TypeError, match="affine is a ndarray, expected an Affine"):
        transformed(Sphere(X, 1.0), np.eye(3))  # type: ignore[arg-type]
