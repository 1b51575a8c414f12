"""A scene as glTF 2.0, with KHR_lights_punctual, KHR_materials_emissive_strength and KHR_materials_specular.

Conventions that are translated here:

- A quad is two triangles; coordinates are 32-bit floats, all that glTF has.
- glTF's core material is a diffuse base under a coat that reflects 4 % and more; ``specularFactor = 0`` takes the
  coat away, and what is left is Lambertian. A reader without that extension has to refuse the file: it is listed
  as required.
- Emission is a factor in [0, 1] times a strength: radiance.
- A camera and a light look along their −z. The field of view is the vertical one; glTF has no resolution, which is
  in the camera's ``extras``.
- A single-sided surface is culled from behind: not there, where ours is black. It is written only where neither the
  sensor nor a light meets its back (``scenes.backs``).

Triangles, Lambertian materials without texture, area, point and directional lights, pinhole and orthographic
cameras: that is all that both sides have.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes.backs import visible_backs
from scenes.bounds import farthest
from scenes.formats import export
from scenes.formats.export import Export, Source, UnsupportedFeatureError, kind
from scenes.lights import AreaLight, DirectionalLight, Light, PointLight, SpotLight
from scenes.materials import Lambertian
from scenes.scene import Scene
from scenes.sensor import Orthographic, Pinhole
from scenes.shapes import Ellipsoid, Mesh, Quad
from scenes.surfaces import Surface

Array = NDArray[np.float64]
Json = dict[str, Any]

FORMAT = "gltf"
_FLOAT, _UNSIGNED_INT = 5126, 5125
_VERTICES, _INDICES = 34962, 34963
_LIGHTS, _STRENGTH, _SPECULAR = (
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_specular",
)


def gltf(scene: Scene, name: str = "scene", source: Source = export.UNKNOWN) -> Export:
    """The scene as JSON, with its triangles in a binary file.

    Args:
        scene: with one channel or three.
        name: of the binary file.
        source: for the description of the asset.

    Raises:
        UnsupportedFeatureError: naming what glTF does not have, or means differently.
    """
    export.refuse_spectra(FORMAT, scene)
    for surface in visible_backs(scene, to_lights=True):
        raise _unsupported(
            f"the back of {surface} may be seen: here it is black, in glTF it is not there; close the body, or make "
            "the surface two-sided"
        )
    return _Writer(export.portable(name)).write(scene, source)


def _unsupported(feature: str) -> UnsupportedFeatureError:
    return UnsupportedFeatureError(FORMAT, feature)


class _Writer:
    """Collects the lists of the document and the bytes of the binary file."""

    def __init__(self, name: str) -> None:
        self._file, self._bytes = f"{name}.bin", bytearray()
        lists = ("nodes", "meshes", "materials", "accessors", "bufferViews", "cameras")
        self._lists: dict[str, list[Json]] = {key: [] for key in lists}
        self._lights: list[Json] = []

    def write(self, scene: Scene, source: Source) -> Export:
        for surface in scene.surfaces:
            self._surface(surface)
        for light in scene.lights:
            self._light(light)
        self._camera(scene)
        used = self._extensions()
        document: Json = {
            "asset": {
                "version": "2.0",
                "generator": export.generator(),
                "extras": {"source": source.text, "scene_sha256": scene.sha256, "bounces": source.bounces},
            },
            "scene": 0,
            "scenes": [{"nodes": list(range(len(self._lists["nodes"])))}],
        }
        document |= {key: items for key, items in self._lists.items() if items}
        if self._bytes:
            document["buffers"] = [{"uri": self._file, "byteLength": len(self._bytes)}]
        if self._lights:
            document["extensions"] = {_LIGHTS: {"lights": self._lights}}
        if used:  # without any of them the scene would be another one
            document |= {"extensionsUsed": used, "extensionsRequired": used}
        content = json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False).encode() + b"\n"
        return Export(content, {self._file: bytes(self._bytes)} if self._bytes else {})

    def _extensions(self) -> list[str]:
        in_materials = {e for material in self._lists["materials"] for e in material["extensions"]}
        return sorted(in_materials | ({_LIGHTS} if self._lights else set()))

    def _add(self, key: str, item: Json) -> int:
        self._lists[key].append(item)
        return len(self._lists[key]) - 1

    def _surface(self, surface: Surface) -> None:
        vertices, triangles, normals = _triangles(surface)
        positions = {"min": vertices.min(axis=0).tolist(), "max": vertices.max(axis=0).tolist()}
        attributes = {"POSITION": self._accessor(vertices, "VEC3", _FLOAT, _VERTICES, positions)}
        if normals is not None:
            attributes["NORMAL"] = self._accessor(normals, "VEC3", _FLOAT, _VERTICES)
        primitive = {
            "attributes": attributes,
            "indices": self._accessor(triangles, "SCALAR", _UNSIGNED_INT, _INDICES),
            "material": self._add("materials", _material(surface)),
        }
        mesh = self._add("meshes", {"name": surface.name, "primitives": [primitive]})
        self._add("nodes", {"name": surface.name, "mesh": mesh})

    def _accessor(
        self, values: NDArray[Any], type: str, component: int, target: int, limits: Json | None = None
    ) -> int:
        # all components have four bytes, so that everything is aligned
        content = values.tobytes()
        view = {"buffer": 0, "byteOffset": len(self._bytes), "byteLength": len(content), "target": target}
        self._bytes += content
        accessor = {"bufferView": self._add("bufferViews", view), "componentType": component}
        return self._add("accessors", accessor | {"count": len(values), "type": type} | (limits or {}))

    def _light(self, light: Light) -> None:
        match light:
            case PointLight():
                colour, matrix = light.intensity, _matrix(np.eye(3), light.position)
            case DirectionalLight():
                colour, matrix = light.irradiance, _matrix(_looking(light.direction), (0, 0, 0))
            case SpotLight():
                raise _unsupported(
                    "spot light: glTF leaves its falloff to the renderer, and allows no hard edge"
                )
            case _:
                raise _unsupported(f"{kind(light)} light: glTF has no environment")
        factor, strength = _split(export.rgb(colour))
        self._lights.append({"type": kind(light), "color": factor, "intensity": strength})
        reference = {_LIGHTS: {"light": len(self._lights) - 1}}
        self._add("nodes", {"matrix": matrix, "extensions": reference})

    def _camera(self, scene: Scene) -> None:
        sensor = scene.sensor
        if not isinstance(sensor, Pinhole | Orthographic):
            raise _unsupported(f"{kind(sensor)}: glTF's cameras are pinhole and orthographic")
        camera = self._add("cameras", _projection(sensor, 1.0 + 2 * farthest(scene)))
        right, up, forward = sensor.frame.T
        matrix = _matrix(np.stack([right, up, -forward]), sensor.origin)
        self._add("nodes", {"name": "sensor", "camera": camera, "matrix": matrix})


def _matrix(axes: ArrayLike, center: ArrayLike) -> list[float]:
    """Where the local x, y and z axis and the local origin go, column by column."""
    columns = np.eye(4)
    columns[:3, :3], columns[3, :3] = axes, center
    found: list[float] = columns.ravel().tolist()
    return found


def _looking(direction: ArrayLike) -> Array:
    """Axes of which −z is the direction, ``(3, 3)``."""
    z = -np.asarray(direction)
    x = np.cross(np.eye(3)[np.abs(z).argmin()], z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z])


def _split(values: tuple[float, ...]) -> tuple[list[float], float]:
    """A colour in [0, 1] and a strength, whose product the values are."""
    strength = max(values)
    return ([value / strength for value in values], strength) if strength else ([0.0, 0.0, 0.0], 0.0)


def _triangles(
    surface: Surface,
) -> tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.float32] | None]:
    """Vertices ``(n, 3)``, indices ``(3 m,)``, and normals ``(n, 3)`` or None."""
    shape, normals = surface.shape, None
    if not isinstance(shape, Quad | Mesh):
        article = "an" if isinstance(shape, Ellipsoid) else "a"
        raise _unsupported(f"{surface.name} is {article} {kind(shape)}: glTF has triangles only")
    indices = np.array([0, 1, 2, 0, 2, 3])
    if isinstance(shape, Mesh):
        indices = np.ravel(shape.triangles)
        normals = None if shape.normals is None else np.array(shape.normals).astype("<f4")
    vertices = _corners(shape)
    return vertices.astype("<f4"), indices.astype("<u4"), normals


def _material(surface: Surface) -> Json:
    material = surface.material
    if not isinstance(material, Lambertian):
        raise _unsupported(
            f"{kind(material)} material: glTF's metals and glass follow Schlick's approximation"
        )
    if not isinstance(material.albedo, tuple):
        raise _unsupported(f"{kind(material.albedo)} texture: glTF's have 8 bits, encoded as sRGB")
    albedo = export.rgb(material.albedo)
    base = {"baseColorFactor": [*albedo, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0}
    extensions: Json = {_SPECULAR: {"specularFactor": 0.0}}
    emissive: Json = {}
    if surface.emission is not None and surface.emits:
        emissive = _emissive(surface, surface.emission, extensions)
    return {
        "name": surface.name,
        "pbrMetallicRoughness": base,
        "doubleSided": surface.two_sided,
        "extensions": extensions,
    } | emissive


def _emissive(surface: Surface, light: AreaLight, extensions: Json) -> Json:
    if light.polar_range is not None:
        raise _unsupported(f"{surface.name} emits from a zone: glTF has triangles only")
    if light.angular_profile is not None:
        raise _unsupported(f"{surface.name} has an angular profile: what glTF's materials emit is diffuse")
    factor, strength = _split(export.rgb(light.radiance))
    extensions[_STRENGTH] = {"emissiveStrength": strength}
    return {"emissiveFactor": factor}


def _corners(shape: Quad | Mesh) -> Array:
    """All corners, ``(n, 3)``."""
    if isinstance(shape, Mesh):
        return np.array(shape.vertices)
    c, u, v = map(np.asarray, (shape.corner, shape.edge_u, shape.edge_v))
    return np.stack([c, c + u, c + u + v, c + v])


def _projection(sensor: Pinhole | Orthographic, far: float) -> Json:
    width, height = sensor.width, sensor.height
    smaller, extras = min(width, height), {"width": width, "height": height}
    if isinstance(sensor, Orthographic):
        half = sensor.extent / 2 / smaller
        limits = {"xmag": half * width, "ymag": half * height, "znear": 0.0, "zfar": far}
        return {"type": "orthographic", "orthographic": limits, "extras": extras}
    near = 1e-6 * math.dist(sensor.origin, sensor.target)
    yfov = 2 * math.atan(math.tan(math.radians(sensor.fov) / 2) * height / smaller)
    view = {"aspectRatio": width / height, "yfov": yfov, "znear": near}
    return {"type": "perspective", "perspective": view, "extras": extras}
