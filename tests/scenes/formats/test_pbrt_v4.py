"""The text, read by a small parser that knows pbrt's grammar and its conventions, is the scene again."""

from __future__ import annotations

import hashlib
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenes import (
    Affine,
    AreaLight,
    Blend,
    Checkerboard,
    Conductor,
    ConstantEnvironment,
    Dielectric,
    DirectionalLight,
    Disk,
    Ellipsoid,
    EnvironmentMap,
    Image,
    Lambertian,
    Mesh,
    Mirror,
    Orthographic,
    Pinhole,
    PointLight,
    PolarRange,
    Quad,
    RadianceMeter,
    RoughConductor,
    RoughDielectric,
    Scene,
    Sphere,
    SpotLight,
    Surface,
    ThinLens,
    library,
    transformed,
)
from scenes.channels import single_channel
from scenes.formats.export import Source, UnsupportedFeatureError
from scenes.formats.pbrt_v4 import pbrt_v4

GREY, BLACK = Lambertian((0.5, 0.5, 0.5)), Lambertian((0.0, 0.0, 0.0))
LIGHT = PointLight((0.0, 5.0, 0.0), (1.0, 2.0, 3.0))
WALL = Quad((-1.0, 0.0, -1.0), (2.0, 0.0, 0.0), (0.0, 0.0, 2.0))
PLACE: dict[str, Any] = {"origin": (0.3, -4.0, 0.6), "target": (0.1, 0.0, 0.0), "up": (0.1, 0.0, 1.0)}
CAMERA = Pinhole(**PLACE, fov=25.0, width=12, height=8)
METAL = {"eta": (0.2,) * 3, "k": (3.9,) * 3}


def one(shape: Any = WALL, material: Any = GREY, *lights: Any, sensor: Any = CAMERA, **options: Any) -> Scene:
    return Scene((Surface("it", shape, material, **options),), sensor, lights or (LIGHT,))


# ---- the reader

reader = runpy.run_path(str(Path(__file__).with_name("pbrt_reader.py")))
Read, read = reader["Read"], reader["read"]


def only(text: str, name: str) -> Any:
    [found] = [r for r in read(text) if r.name == name]
    return found


def written(scene: Scene) -> str:
    return pbrt_v4(scene, "it").content.decode()


# ---- shapes


def corners(shape: Read) -> Any:
    """Of the triangles, ``(n, 3, 3)``."""
    points = np.reshape(shape.parameters["point3 P"], (-1, 3))
    assert np.array_equal(shape.matrix, np.eye(4))
    assert not shape.state.get("reversed")
    return points[np.reshape(shape.parameters["integer indices"], (-1, 3)).astype(int)]


def test_every_case_is_read_or_refused() -> None:
    """As it is and channel by channel; what is read has all surfaces and lights."""
    written_of = dict.fromkeys(library.CASES, 0)
    for name in library.CASES:
        scene = library.case(name).scene
        for part in (scene, *(single_channel(scene, channel) for channel in range(min(scene.channels, 3)))):
            try:
                text = pbrt_v4(part, name).content.decode()
            except UnsupportedFeatureError:
                continue
            found = [r.name for r in read(text)]
            assert found.count("Shape") == len(scene.surfaces)
            assert found.count("LightSource") == len(scene.lights)
            assert found.count("AreaLightSource") == sum(s.emits for s in part.surfaces)
            written_of[name] += 1
    assert sum(count > 0 for count in written_of.values()) >= 30


@pytest.mark.parametrize("name", ["furnace-box"])
def test_triangles_of_a_library_scene(name: str) -> None:
    scene = library.case(name).scene
    shapes = [r for r in read(written(scene)) if r.name == "Shape"]
    assert len(shapes) == len(scene.surfaces)
    for shape, surface in zip(shapes, scene.surfaces, strict=True):
        assert isinstance(surface.shape, Quad)
        a, b, c = corners(shape).transpose(1, 0, 2)
        cross = np.cross(b - a, c - a)  # pbrt's front: counterclockwise
        assert np.allclose(cross / np.linalg.norm(cross, axis=1)[:, None], surface.shape.normal)
        assert np.linalg.norm(cross, axis=1).sum() / 2 == pytest.approx(surface.shape.area)
        middle = np.add(surface.shape.corner, np.add(surface.shape.edge_u, surface.shape.edge_v) / 2)
        assert np.allclose((a + b + c).mean(axis=0) / 3, middle)
        assert shape.state["AreaLightSource"].parameters == {"rgb L": [1, 1, 1], "bool twosided": [False]}
        assert shape.state["Material"].parameters == {"rgb reflectance": [0.5, 0.5, 0.5]}


TURN = Affine.rotation((1, 2, 3), 40)
EGG = Ellipsoid((0.1, 0.2, 0.3), (2, 0, 0), (0, 1, 0.3), (0, 0, 0.5))


@pytest.mark.parametrize(
    "shape",
    [
        Sphere((1, 2, 3), 0.5),
        EGG,
        transformed(EGG, TURN),
        transformed(EGG, Affine.reflection((1, 0, 0))),
        Sphere((0, 0, 0), 9.0, inward=True),
    ],
)
def test_round_shapes(shape: Any) -> None:
    """The unit sphere through pbrt's matrix and radius satisfies our equation, and the right side is in front."""
    made = only(written(one(shape)), "Shape")
    [radius] = made.parameters["float radius"]
    points = np.random.default_rng(1).normal(size=(50, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    world = radius * points @ made.matrix[:3, :3].T + made.matrix[:3, 3]
    matrix = shape.matrix if isinstance(shape, Ellipsoid) else shape.radius * np.eye(3)
    assert np.allclose(np.linalg.norm(np.linalg.solve(matrix, (world - shape.center).T), axis=0), 1)
    assert np.linalg.det(made.matrix[:3, :3]) > 0, "a matrix that mirrors turns pbrt's normals over"
    assert made.state.get("reversed", False) == shape.inward


@pytest.mark.parametrize("axes", [((0.7, 0, 0), (0, 0, 0.7)), ((0.7, 0, 0), (0.2, 0, 0.4))])
def test_disks(axes: Any) -> None:
    disk = Disk((0.1, 0.2, 0.3), *axes)
    made = only(written(one(disk)), "Shape")
    assert made.types == ["disk"]
    [radius] = made.parameters["float radius"]
    matrix = made.matrix[:3, :3]
    assert np.allclose(radius * matrix[:, 0], disk.axis_u)
    assert np.allclose(radius * matrix[:, 1], disk.axis_v)
    assert np.linalg.inv(matrix).T[:, 2] @ disk.normal > 0
    assert np.allclose(made.matrix[:3, 3], disk.center)


def test_a_mesh_is_a_file() -> None:
    points = [(0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.0, 0.3)]
    mesh = Mesh(points, [(0, 1, 2)], uv=[(0.1, 0.2)] * 3)  # type: ignore[arg-type]
    export = pbrt_v4(one(mesh), "it")
    made = only(export.content.decode(), "Shape")
    assert made.types == ["plymesh"]
    [file] = made.parameters["string filename"]
    header, _, body = export.files[file].partition(b"end_header\n")
    assert b"element vertex 3\n" in header
    assert np.array_equal(np.frombuffer(body[:120], "<f8").reshape(3, 5)[:, :3], points)
    assert np.frombuffer(body[121:], "<i4").tolist() == [0, 1, 2]


# ---- cameras


def project(camera: Read, film: Read, points: Any) -> Any:
    """Pixels as pbrt computes them: the smaller axis of the screen is [−1, 1], its y points up."""
    x, y, z, _ = camera.matrix @ np.vstack([points.T, np.ones(len(points))])
    width, height = film.parameters["integer xresolution"][0], film.parameters["integer yresolution"][0]
    window = np.array([width, width, height, height]) / min(width, height) * [-1, 1, -1, 1]
    if camera.types == ["perspective"]:
        scale = np.tan(np.radians(camera.parameters["float fov"][0]) / 2)
        x, y = x / z / scale, y / z / scale
    else:
        window = np.array(camera.parameters["float screenwindow"])
    return np.stack(
        [
            (x - window[0]) / (window[1] - window[0]) * width,
            (window[3] - y) / (window[3] - window[2]) * height,
        ]
    )


SENSORS = {
    "wide": CAMERA,
    "tall": Pinhole(**PLACE, fov=40.0, width=6, height=9),
    "lens": ThinLens(**PLACE, fov=25.0, width=12, height=8, aperture_radius=0.1, focus_distance=3.0),
    "orthographic": Orthographic(**PLACE, extent=2.0, width=12, height=8),
}


@pytest.mark.parametrize("name", SENSORS)
def test_pixels_are_where_they_were(name: str) -> None:
    sensor: Any = SENSORS[name]
    text = written(one(sensor=sensor))
    camera, film = only(text, "Camera"), only(text, "Film")
    pixels = np.array([[0, 0, 1], [sensor.width, 0, 1], [2.5, 7.0, 1], [4.0, 1.5, 1]], dtype=float)
    if isinstance(sensor, Orthographic):
        points = sensor.origin + pixels @ sensor.pixel_to_offset.T + 3.0 * sensor.frame[:, 2]
    else:
        points = sensor.origin + 3.0 * pixels @ sensor.pixel_to_direction.T
    assert np.allclose(project(camera, film, points), pixels[:, :2].T)
    if isinstance(sensor, ThinLens):
        assert camera.parameters["float lensradius"] == [0.1]
        assert camera.parameters["float focaldistance"] == [3.0]
    assert only(text, "PixelFilter").types == ["box"]


# ---- materials and lights


@pytest.mark.parametrize(
    ("material", "type", "parameters"),
    [
        (Dielectric(1.5, 1.2), "dielectric", {"float eta": [1.5 / 1.2], "float roughness": [0]}),
        (
            RoughDielectric(0.3, 1.5),
            "dielectric",
            {"float eta": [1.5], "float roughness": [0.3], "bool remaproughness": [False]},
        ),
        (
            Conductor(**METAL),
            "conductor",
            {
                "spectrum eta": [200, 0.2, 1000, 0.2],
                "spectrum k": [200, 3.9, 1000, 3.9],
                "float roughness": [0],
            },
        ),
    ],
)
def test_materials(material: Any, type: str, parameters: Any) -> None:
    made = only(written(one(Sphere((0, 0, 0), 1), material)), "Material")
    assert (made.types, made.parameters) == ([type], parameters)


def test_a_blend_of_blends() -> None:
    inner = Blend(GREY, RoughConductor(**METAL, alpha=0.2), 0.25)
    text = written(one(Sphere((0, 0, 0), 1), Blend(BLACK, inner, 0.75)))
    made = only(text, "Shape").state
    outer = made["Material"]
    assert outer.types == ["mix"]
    assert outer.parameters["float amount"] == [0.75]
    first, second = (made[name] for name in outer.parameters["string materials"])
    assert first.parameters["rgb reflectance"] == [0, 0, 0]
    assert second.parameters["string type"] == ["mix"]
    assert second.parameters["float amount"] == [0.25]
    third, fourth = (made[name] for name in second.parameters["string materials"])
    assert third.parameters["string type"] == ["diffuse"]
    assert fourth.parameters["float roughness"] == [0.2]


def test_names_of_materials_are_used_once() -> None:
    """They are global in pbrt: a second surface with a blend must not take those of the first."""
    blend = Blend(BLACK, Blend(GREY, RoughConductor(**METAL, alpha=0.2), 0.25), 0.75)
    other = Surface("other", Sphere((5, 0, 0), 1), Blend(GREY, BLACK, 0.5))
    scene = Scene((Surface("it", Sphere((0, 0, 0), 1), blend), other), CAMERA, (LIGHT,))
    found = read(written(scene))
    assert len([r for r in found if r.name == "MakeNamedMaterial"]) == 6
    last = [r for r in found if r.name == "Shape"][-1].state
    first, second = (last[name] for name in last["Material"].parameters["string materials"])
    assert first.parameters["rgb reflectance"] == [0.5] * 3
    assert second.parameters["rgb reflectance"] == [0] * 3


def test_the_film_keeps_all_digits() -> None:
    film = only(written(one()), "Film")
    assert film.parameters["bool savefp16"] == [False]
    assert film.parameters["string filename"] == ["it.exr"]


def test_the_header() -> None:
    scene = one()
    text = pbrt_v4(scene, 'my "own"', Source("case of mine,\nchannel 1", 3)).content.decode()
    assert only(text, "Integrator").parameters["integer maxdepth"] == [3]
    assert only(text, "Film").parameters["string filename"] == ["my__own_.exr"]
    header = [line for line in text.splitlines() if line.startswith("# ")]
    assert any(line.endswith("case of mine, channel 1") for line in header)
    assert any(line.endswith(hashlib.sha256(scene.to_json()).hexdigest()) for line in header)
    assert any("Bounces 0 to 3: pbrt --spp" in line for line in header)


@pytest.mark.parametrize("colour", [(1, 1, 1), (1, 2, 3)])
def test_a_coloured_light_is_told(colour: tuple[float, ...]) -> None:
    scene = Scene((Surface("it", WALL, GREY),), CAMERA, (PointLight((0, -2, 0), colour),))
    assert ("Coloured lights" in written(scene)) == (colour != (1, 1, 1))
    assert "Coloured lights" not in written(single_channel(scene, 1))


def test_lights() -> None:
    lights = (
        PointLight((0, 1, 2), (1, 2, 3)),
        SpotLight((0, 1, 2), (0, 0, -1), (1, 2, 3), 30, 30),
        DirectionalLight((0, 0, -1), (1, 2, 3)),
        ConstantEnvironment((1, 2, 3)),
    )
    point, spot, sun, sky = (r for r in read(written(one(WALL, GREY, *lights))) if r.name == "LightSource")
    assert (point.types, point.parameters) == (["point"], {"point3 from": [0, 1, 2], "rgb I": [1, 2, 3]})
    assert spot.parameters == {
        "point3 from": [0, 1, 2],
        "point3 to": [0, 1, 1],
        "float coneangle": [30],
        "float conedeltaangle": [0],
        "rgb I": [1, 2, 3],
    }
    assert sun.types == ["distant"]
    assert np.subtract(sun.parameters["point3 to"], sun.parameters["point3 from"]).tolist() == [0, 0, -1]
    assert sun.parameters["rgb L"] == sky.parameters["rgb L"] == [1, 2, 3]
    assert sky.types == ["infinite"]


# ---- what is refused

CORNERS = [(0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.0, 0.3)]

BEHIND = Surface("behind", Quad((-1, 1, -1), (2, 0, 0), (0, 0, 2)), GREY)


def both(material: Any, **options: Any) -> Scene:
    """A wall whose back another one can see."""
    return Scene((Surface("wall", WALL, material, **options), BEHIND), CAMERA, (LIGHT,))


def test_backs() -> None:
    with pytest.raises(UnsupportedFeatureError, match="the back of wall may be seen"):
        pbrt_v4(both(GREY))
    assert only(written(one()), "Shape"), "nothing is behind"
    for harmless in (both(BLACK), both(GREY, two_sided=True)):
        assert pbrt_v4(harmless).content
    lamp = one(WALL, GREY, emission=AreaLight((1, 1, 1)), two_sided=True)
    assert only(written(lamp), "AreaLightSource").parameters["bool twosided"] == [True]
    dark = one(WALL, GREY, emission=AreaLight((0, 0, 0)))
    assert not [r for r in read(written(dark)) if r.name == "AreaLightSource"]


@pytest.mark.parametrize(
    ("feature", "scene"),
    [
        ("coloured albedo", one(WALL, Lambertian((0.5, 0.4, 0.3)))),
        ("coloured eta", one(WALL, Conductor((0.2, 0.3, 0.4), (1, 1, 1)))),
        ("mirror", one(WALL, Mirror((0.5, 0.5, 0.5)))),
        ("separable shadowing", one(WALL, RoughConductor(**METAL, alpha=0.3, shadowing="separable"))),
        ("checkerboard texture", one(WALL, Lambertian(Checkerboard((0.5,) * 3, (0.1,) * 3)))),
        ("emits from a zone", one(Sphere((0, 0, 0), 1), emission=AreaLight((1, 1, 1), PolarRange(0, 90)))),
        ("angular profile", one(WALL, emission=AreaLight((1, 1, 1), None, ((1, 1, 1), (2, 2, 2))))),
        ("ellipsoid that emits", one(EGG, emission=AreaLight((1, 1, 1)))),
        ("ellipse that emits", one(Disk((0, 0, 0), (1, 0, 0), (0, 0, 2)), emission=AreaLight((1, 1, 1)))),
        (
            "falls off between 10° and 20°",
            one(WALL, GREY, SpotLight((0, -1, 0), (0, 1, 0), (1, 1, 1), 20, 10)),
        ),
        ("environment map", one(WALL, GREY, EnvironmentMap(Image(np.ones((2, 4, 3)))))),  # type: ignore[arg-type]
        ("radiance meter", one(sensor=RadianceMeter((0, -1, 0), (0, 1, 0)))),
        ("shading normals of it", one(Mesh(CORNERS, [(0, 1, 2)], normals=[(0.1, -1.0, 0.0)] * 3))),  # type: ignore[arg-type]
        ("2 channels", one(WALL, Lambertian((0.0, 0.0)), PointLight((0, -1, 0), (1, 1)))),
    ],
)
def test_what_pbrt_lacks_or_means_differently_is_named(feature: str, scene: Scene) -> None:
    with pytest.raises(UnsupportedFeatureError, match=feature):
        pbrt_v4(scene)
