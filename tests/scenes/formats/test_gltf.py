"""The document, read by a small reader that knows glTF's conventions and by trimesh, is the scene again.

Khronos's own validator finds nothing in any of the library's documents; it needs Node.js and is no part of the tests.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from scenes import (
    AreaLight,
    Checkerboard,
    ConstantEnvironment,
    Dielectric,
    DirectionalLight,
    Ellipsoid,
    Lambertian,
    Mesh,
    Orthographic,
    Pinhole,
    PointLight,
    Quad,
    Scene,
    Sphere,
    SpotLight,
    Surface,
    ThinLens,
    library,
)
from scenes.channels import single_channel
from scenes.formats.export import Source, UnsupportedFeatureError
from scenes.formats.gltf import gltf
from scenes.library.cornell_box import empty_box

GREY = Lambertian((0.5, 0.4, 0.3))
POINT = PointLight((0.0, -5.0, 0.0), (4.0, 2.0, 1.0))
WALL = Quad((-1.0, 0.0, -1.0), (2.0, 0.0, 0.0), (0.0, 0.0, 2.0))
PLACE: dict[str, Any] = {"origin": (0.3, -4.0, 0.6), "target": (0.1, 0.0, 0.0), "up": (0.1, 0.0, 1.0)}
CAMERA = Pinhole(**PLACE, fov=25.0, width=12, height=8)
COMPONENTS = {5126: np.dtype("<f4"), 5125: np.dtype("<u4")}
PER_ELEMENT = {"SCALAR": 1, "VEC3": 3}


def one(shape: Any = WALL, material: Any = GREY, *lights: Any, sensor: Any = CAMERA, **options: Any) -> Scene:
    return Scene((Surface("it", shape, material, **options),), sensor, lights or (POINT,))


class Reader:
    """glTF 2.0, as far as it is used: separate buffer views, 32-bit numbers, no hierarchy of nodes."""

    def __init__(self, scene: Scene) -> None:
        export = gltf(scene, "it")
        self.document = json.loads(export.content)
        assert self.document["asset"]["version"] == "2.0"
        self.buffers = [export.files[b["uri"]] for b in self.document.get("buffers", [])]
        for declared, found in zip(self.document.get("buffers", []), self.buffers, strict=True):
            assert declared["byteLength"] == len(found)
        assert set(self.document["scenes"][0]["nodes"]) == set(range(len(self.document["nodes"])))

    def accessor(self, i: int) -> Any:
        accessor = self.document["accessors"][i]
        view = self.document["bufferViews"][accessor["bufferView"]]
        kind, width = COMPONENTS[accessor["componentType"]], PER_ELEMENT[accessor["type"]]
        assert view["byteOffset"] % 4 == 0
        assert view["byteLength"] == accessor["count"] * width * kind.itemsize
        start = view["byteOffset"]
        content = self.buffers[view["buffer"]][start : start + view["byteLength"]]
        values = np.frombuffer(content, kind).reshape(accessor["count"], width)
        if "min" in accessor:
            assert values.min(axis=0).tolist() == accessor["min"]
            assert values.max(axis=0).tolist() == accessor["max"]
        return values

    def nodes(self, key: str) -> list[Any]:
        return [n for n in self.document["nodes"] if key in n or key in n.get("extensions", {})]

    def primitive(self, node: Any) -> Any:
        [primitive] = self.document["meshes"][node["mesh"]]["primitives"]
        return primitive

    def triangles(self, node: Any) -> Any:
        primitive = self.primitive(node)
        indices = self.accessor(primitive["indices"])[:, 0].reshape(-1, 3)
        return self.accessor(primitive["attributes"]["POSITION"])[indices].astype(float)

    def material(self, node: Any) -> Any:
        return self.document["materials"][self.primitive(node)["material"]]

    def lights(self) -> list[Any]:
        found: list[Any] = self.document["extensions"]["KHR_lights_punctual"]["lights"]
        return found


def matrix(node: Any) -> Any:
    return np.reshape(node["matrix"], (4, 4)).T  # column by column


@pytest.mark.parametrize(
    "scene", [library.case("furnace-box").scene, empty_box()], ids=["furnace", "cornell"]
)
def test_a_library_scene(scene: Scene) -> None:
    reader = Reader(scene)
    nodes = reader.nodes("mesh")
    assert [node["name"] for node in nodes] == [s.name for s in scene.surfaces]
    for node, surface in zip(nodes, scene.surfaces, strict=True):
        assert isinstance(surface.shape, Quad)
        assert isinstance(surface.material, Lambertian)
        a, b, c = reader.triangles(node).transpose(1, 0, 2)
        cross = np.cross(b - a, c - a)  # glTF's front: counterclockwise
        assert np.allclose(cross / np.linalg.norm(cross, axis=1)[:, None], surface.shape.normal, atol=1e-6)
        assert np.linalg.norm(cross, axis=1).sum() / 2 == pytest.approx(surface.shape.area)
        middle = np.add(surface.shape.corner, np.add(surface.shape.edge_u, surface.shape.edge_v) / 2)
        assert np.allclose((a + b + c).mean(axis=0) / 3, middle, atol=1e-6)
        material = reader.material(node)
        base = material["pbrMetallicRoughness"]
        assert base["baseColorFactor"] == [*surface.material.albedo, 1.0]
        assert base["metallicFactor"] == 0
        assert material["extensions"]["KHR_materials_specular"] == {"specularFactor": 0}
        assert not material["doubleSided"]
        if surface.emission is not None:
            strength = material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"]
            assert max(material["emissiveFactor"]) <= 1
            assert np.allclose(strength * np.array(material["emissiveFactor"]), surface.emission.radiance)
        else:
            assert "emissiveFactor" not in material
    required = ["KHR_materials_emissive_strength", "KHR_materials_specular"]
    assert reader.document["extensionsRequired"] == reader.document["extensionsUsed"] == required


def in_gltf(scene: Scene) -> bool:
    try:
        return bool(gltf(scene).content)
    except UnsupportedFeatureError:
        return False


WHOLE = [name for name in library.CASES if in_gltf(library.case(name).scene)]


def test_a_tenth_of_the_library_can_be_had_as_gltf() -> None:
    assert len(WHOLE) > len(library.CASES) / 10


@pytest.mark.parametrize("name", WHOLE)
def test_what_another_reader_makes_of_it(name: str, tmp_path: Path) -> None:
    """Triangles and their fronts, colours to the 8 bits that trimesh keeps, the camera."""
    scene, file = library.case(name).scene, tmp_path / "a name #1 to quote.gltf"
    gltf(scene, file.stem).write(file)
    found: Any = trimesh.load(file, process=False)
    assert set(found.graph.nodes_geometry) == {surface.name for surface in scene.surfaces}
    for surface in scene.surfaces:
        transform, geometry = found.graph[surface.name]
        mesh = found.geometry[geometry]
        assert np.array_equal(transform, np.eye(4))
        shape: Any = surface.shape
        if isinstance(shape, Quad):
            np.testing.assert_allclose(mesh.face_normals, [shape.normal] * 2, atol=1e-5)
            assert mesh.area == pytest.approx(shape.area, rel=1e-6)
            middle = np.add(shape.corner, np.add(shape.edge_u, shape.edge_v) / 2)
            np.testing.assert_allclose(mesh.centroid, middle, atol=1e-6 * np.abs(middle).max() + 1e-6)
        else:
            np.testing.assert_allclose(mesh.triangles, shape.corners, rtol=1e-6, atol=1e-7)
        material: Any = surface.material
        colours = mesh.visual.material.baseColorFactor / 255
        np.testing.assert_allclose(colours, [*material.albedo, 1], atol=0.5 / 255 + 1e-9)
        assert mesh.visual.material.doubleSided == surface.two_sided
    sensor: Any = scene.sensor
    if isinstance(sensor, Pinhole):  # trimesh knows no other
        right, up, forward = sensor.frame.T
        np.testing.assert_allclose(found.camera_transform[:3].T, [right, up, -forward, sensor.origin])
        width, height = found.camera.resolution  # a whole number of pixels, which trimesh makes up
        vertical = 2 * np.arctan(np.tan(np.radians(sensor.fov) / 2) * height / min(width, height))
        assert found.camera.fov[1] == pytest.approx(np.degrees(vertical), rel=1e-4)


def test_where_it_comes_from() -> None:
    scene = one()
    asset = json.loads(gltf(scene, "it", Source("case of mine", 3)).content)["asset"]
    assert asset["generator"].startswith("lightproof ")
    expected = {"source": "case of mine", "bounces": 3}
    assert asset["extras"] == {**expected, "scene_sha256": hashlib.sha256(scene.to_json()).hexdigest()}


def test_a_mesh() -> None:
    points = [(0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.0, 0.3)]
    normals = [(0.1, -1.0, 0.0), (0.0, -1.0, 0.0), (0.0, -1.0, 0.3)]
    mesh = Mesh(points, [(0, 1, 2)], normals=normals)  # type: ignore[arg-type]
    reader = Reader(one(mesh, two_sided=True))
    [node] = reader.nodes("mesh")
    assert np.allclose(reader.triangles(node), [points])
    found = reader.accessor(reader.primitive(node)["attributes"]["NORMAL"])
    assert mesh.normals is not None
    assert np.allclose(found, mesh.normals)
    assert reader.material(node)["doubleSided"]


SENSORS = {
    "wide": CAMERA,
    "tall": Pinhole(**PLACE, fov=40.0, width=6, height=9),
    "orthographic": Orthographic(**PLACE, extent=2.0, width=12, height=8),
}


@pytest.mark.parametrize("name", SENSORS)
def test_pixels_are_where_they_were(name: str) -> None:
    sensor: Any = SENSORS[name]
    reader = Reader(one(sensor=sensor))
    [node] = reader.nodes("camera")
    camera = reader.document["cameras"][node["camera"]]
    pixels = np.array([[0, 0, 1], [sensor.width, 0, 1], [2.5, 7.0, 1], [4.0, 1.5, 1]], dtype=float)
    if isinstance(sensor, Orthographic):
        points = sensor.origin + pixels @ sensor.pixel_to_offset.T + 3.0 * sensor.frame[:, 2]
    else:
        points = sensor.origin + 3.0 * pixels @ sensor.pixel_to_direction.T
    x, y, z, _ = np.linalg.inv(matrix(node)) @ np.vstack([points.T, np.ones(len(points))])
    view = camera[camera["type"]]
    if camera["type"] == "perspective":  # of the OpenGL projection, x and y in [−1, 1]
        y = y / -z / np.tan(view["yfov"] / 2)
        x = x / -z / np.tan(view["yfov"] / 2) / view["aspectRatio"]
    else:
        x, y = x / view["xmag"], y / view["ymag"]
        assert view["znear"] < (-z).max() < view["zfar"]
    assert np.allclose([(x + 1) / 2 * sensor.width, (1 - y) / 2 * sensor.height], pixels[:, :2].T)
    assert camera["extras"] == {"width": sensor.width, "height": sensor.height}


def test_lights() -> None:
    sun = DirectionalLight((0.2, 1.0, 0.3), (6.0, 3.0, 0.0))
    reader = Reader(one(WALL, GREY, POINT, sun))
    nodes, lights = reader.nodes("KHR_lights_punctual"), reader.lights()
    assert [n["extensions"]["KHR_lights_punctual"]["light"] for n in nodes] == [0, 1]
    assert lights[0] == {"type": "point", "color": [1.0, 0.5, 0.25], "intensity": 4.0}
    assert lights[1] == {"type": "directional", "color": [1.0, 0.5, 0.0], "intensity": 6.0}
    assert matrix(nodes[0])[:3, 3].tolist() == list(POINT.position)
    turned = matrix(nodes[1])[:3, :3]
    assert np.allclose(turned @ [0, 0, -1], sun.direction)
    assert np.allclose(turned @ turned.T, np.eye(3))
    assert np.linalg.det(turned) > 0


def test_one_channel_is_grey() -> None:
    reader = Reader(single_channel(one(), 1))
    [node] = reader.nodes("mesh")
    assert reader.material(node)["pbrMetallicRoughness"]["baseColorFactor"] == [0.4, 0.4, 0.4, 1.0]
    assert reader.lights()[0]["color"] == [1, 1, 1]
    assert reader.lights()[0]["intensity"] == 2


BEHIND = PointLight((0.0, 5.0, 0.0), (1.0, 1.0, 1.0))


@pytest.mark.parametrize(
    ("feature", "scene"),
    [
        ("the back of it may be seen", one(WALL, GREY, BEHIND)),
        ("it is a sphere", one(Sphere((0, 0, 0), 1))),
        ("it is an ellipsoid", one(Ellipsoid((0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 1)))),
        ("angular profile", one(WALL, emission=AreaLight((1, 1, 1), None, ((1, 1, 1), (2, 2, 2))))),
        ("dielectric material", one(WALL, Dielectric(1.5))),
        ("checkerboard texture", one(WALL, Lambertian(Checkerboard((0.5,) * 3, (0.1,) * 3)))),
        ("spot light", one(WALL, GREY, SpotLight((0, -1, 0), (0, 1, 0), (1, 1, 1), 20, 20))),
        ("constant light", one(WALL, GREY, ConstantEnvironment((1, 1, 1)))),
        (
            "thin lens",
            one(sensor=ThinLens(**PLACE, fov=9, width=4, height=4, aperture_radius=1, focus_distance=1)),
        ),
        ("2 channels", one(WALL, Lambertian((0.5, 0.5)), PointLight((0, -1, 0), (1, 1)))),
    ],
)
def test_what_gltf_lacks_or_means_differently_is_named(feature: str, scene: Scene) -> None:
    with pytest.raises(UnsupportedFeatureError, match=feature):
        gltf(scene)


def test_a_two_sided_lamp_is_lit_from_behind_too() -> None:
    reader = Reader(one(WALL, GREY, BEHIND, two_sided=True, emission=AreaLight((0.0, 0.0, 0.0))))
    [node] = reader.nodes("mesh")
    assert reader.material(node)["doubleSided"]
    assert "emissiveFactor" not in reader.material(node), (
        "a strength of nothing is what the validator warns of"
    )
