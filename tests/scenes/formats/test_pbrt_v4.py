"""The text, read by a small parser that knows pbrt's grammar and its conventions, is the scene again."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
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
from scenes.formats.export import UnsupportedFeatureError
from scenes.formats.pbrt_v4 import pbrt_v4

GREY, BLACK = Lambertian((0.5, 0.5, 0.5)), Lambertian((0.0, 0.0, 0.0))
LIGHT = PointLight((0.0, 5.0, 0.0), (1.0, 2.0, 3.0))
WALL = Quad((-1.0, 0.0, -1.0), (2.0, 0.0, 0.0), (0.0, 0.0, 2.0))
PLACE: dict[str, Any] = {"origin": (0.3, -4.0, 0.6), "target": (0.1, 0.0, 0.0), "up": (0.1, 0.0, 1.0)}
CAMERA = Pinhole(**PLACE, fov=25.0, width=12, height=8)
METAL = {"eta": (0.2,) * 3, "k": (3.9,) * 3}


def one(shape: Any = WALL, material: Any = GREY, *lights: Any, sensor: Any = CAMERA, **options: Any) -> Scene:
    return Scene((Surface("it", shape, material, **options),), sensor, lights or (LIGHT,))


# ---- a reader

TOKEN = re.compile(r'#[^\n]*|"[^"]*"|\[|\]|[^\s\[\]"]+')


@dataclass
class Read:
    """A directive with what held where it stood."""

    name: str
    types: list[str]
    parameters: dict[str, Any]
    matrix: Any
    state: dict[str, Any] = field(default_factory=dict)


@dataclass
class Directive:
    """A name and all that follows it."""

    name: str
    numbers: list[float] = field(default_factory=list)
    types: list[str] = field(default_factory=list)
    parameters: dict[str, Any] = field(default_factory=dict)


def parse(text: str) -> list[Directive]:
    tokens = iter([t for t in TOKEN.findall(text) if not t.startswith("#")])
    found: list[Directive] = []
    for token in tokens:
        if re.fullmatch(r"[A-Z][A-Za-z]+", token):
            found.append(Directive(token))
        elif token.startswith('"') and " " in token:
            assert next(tokens) == "["
            found[-1].parameters[token.strip('"')] = [value(t) for t in iter(lambda: next(tokens), "]")]
        elif token.startswith('"'):
            found[-1].types.append(token.strip('"'))
        elif token not in "[]":
            found[-1].numbers.append(float(token))
    return found


def read(text: str) -> list[Read]:
    """Directives that make something, with the transformation and the state that held there."""
    found: list[Read] = []
    matrix, state, stack = np.eye(4), dict[str, Any](), list[Any]()
    for d in parse(text):
        match d.name:
            case "Transform":
                matrix = np.reshape(d.numbers, (4, 4)).T
            case "Scale":
                matrix = matrix @ np.diag([*d.numbers, 1])
            case "LookAt":
                matrix = matrix @ look_at(*np.reshape(d.numbers, (3, 3)))
            case "WorldBegin":
                matrix, state = np.eye(4), {}
            case "AttributeBegin":
                stack.append((matrix, state))
            case "AttributeEnd":
                matrix, state = stack.pop()
            case "ReverseOrientation":
                state = state | {"reversed": not state.get("reversed", False)}
            case _:
                made = Read(d.name, d.types, d.parameters, matrix, state)
                found.append(made)
                # a named material under its name, the others under that of their directive
                state = state | {d.types[0] if d.name == "MakeNamedMaterial" else d.name: made}
    assert not stack
    return found


def value(token: str) -> Any:
    if token in ("true", "false"):
        return token == "true"
    return token.strip('"') if token.startswith('"') else float(token)


def look_at(eye: Any, target: Any, up: Any) -> Any:
    """World to camera; pbrt's camera has x = up × view, left-handed."""
    view = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(up / np.linalg.norm(up), view)
    right /= np.linalg.norm(right)
    camera = np.eye(4)
    camera[:3] = np.stack([right, np.cross(view, right), view, eye], axis=1)
    return np.linalg.inv(camera)


def only(text: str, name: str) -> Read:
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
    mesh = Mesh(points, [(0, 1, 2)], normals=[(0.1, -1.0, 0.0)] * 3)  # type: ignore[arg-type]
    export = pbrt_v4(one(mesh), "it")
    made = only(export.content.decode(), "Shape")
    assert made.types == ["plymesh"]
    [file] = made.parameters["string filename"]
    header, _, body = export.files[file].partition(b"end_header\n")
    assert b"element vertex 3\n" in header
    assert np.array_equal(np.frombuffer(body[:144], "<f8").reshape(3, 6)[:, :3], points)
    assert np.frombuffer(body[145:], "<i4").tolist() == [0, 1, 2]


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
        ("2 channels", one(WALL, Lambertian((0.0, 0.0)), PointLight((0, -1, 0), (1, 1)))),
    ],
)
def test_what_pbrt_lacks_or_means_differently_is_named(feature: str, scene: Scene) -> None:
    with pytest.raises(UnsupportedFeatureError, match=feature):
        pbrt_v4(scene)
