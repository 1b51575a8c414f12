"""A renderer, as a program, that reads pbrt-v4 or glTF: the lamps of a scene of triangles, pixel by pixel.

    drawn_triangles.py SCENE OUTPUT [BOUNCES]

Bounce k is E / 2ᵏ, so that each is told from the others; up to which one, a pbrt file says itself. It shares no code
with ours, and knows nothing but the formats' own conventions.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import OpenImageIO as oiio

sys.path.insert(0, str(Path(__file__).parents[2] / "scenes" / "formats"))
import pbrt_reader


class Read(NamedTuple):
    """Rays of pixels (height, width, 3), triangles (n, 3, 3), the radiance of their fronts (n, 3)."""

    origin: np.ndarray
    rays: np.ndarray
    triangles: np.ndarray
    radiance: np.ndarray
    bounces: int | None


def rays(to_world: np.ndarray, half: float, width: int, height: int, forward: float) -> np.ndarray:
    """Through the centres of pixels; ``half`` is the tangent of half the view along the smaller axis."""
    x = (2 * np.arange(width) + 1 - width) / min(width, height) * half
    y = (height - 1 - 2 * np.arange(height)) / min(width, height) * half
    local = np.stack([*np.broadcast_arrays(x[None], y[:, None]), np.full((height, width), forward)], axis=-1)
    return local @ to_world[:3, :3].T


def pbrt(file: Path) -> Read:
    found = pbrt_reader.read(file.read_text())
    camera, film, integrator = (
        next(r for r in found if r.name == n) for n in ("Camera", "Film", "Integrator")
    )
    width, height = (int(film.parameters[f"integer {axis}resolution"][0]) for axis in "xy")
    to_world = np.linalg.inv(camera.matrix)
    half = np.tan(np.radians(camera.parameters["float fov"][0]) / 2)
    triangles, radiance = [], []
    for shape in (r for r in found if r.name == "Shape"):
        corners = np.reshape(shape.parameters["point3 P"], (-1, 3))
        index = np.reshape(shape.parameters["integer indices"], (-1, 3)).astype(int)
        lamp = shape.state.get("AreaLightSource")
        triangles += list(corners[index])
        radiance += [lamp.parameters["rgb L"] if lamp else [0.0] * 3] * len(index)
    last = int(integrator.parameters["integer maxdepth"][0])
    seen = rays(to_world, half, width, height, 1.0)
    return Read(to_world[:3, 3], seen, np.array(triangles), np.array(radiance), last)


def gltf(file: Path) -> Read:
    document = json.loads(file.read_text())
    nodes, kinds = document["nodes"], {5126: "<f4", 5125: "<u4"}

    def numbers(i: int) -> np.ndarray:
        accessor = document["accessors"][i]
        view = document["bufferViews"][accessor["bufferView"]]
        content = file.with_name(document["buffers"][view["buffer"]]["uri"]).read_bytes()
        kind = kinds[accessor["componentType"]]
        size = accessor["count"] * {"VEC3": 3, "SCALAR": 1}[accessor["type"]]
        return np.frombuffer(content, kind, size, view.get("byteOffset", 0))

    [node] = [node for node in nodes if "camera" in node]
    camera = document["cameras"][node["camera"]]
    width, height = (camera["extras"][key] for key in ("width", "height"))
    to_world = np.reshape(node["matrix"], (4, 4)).T
    half = np.tan(camera["perspective"]["yfov"] / 2) * min(width, height) / height
    triangles, radiance = [], []
    for node in (node for node in nodes if "mesh" in node):
        [primitive] = document["meshes"][node["mesh"]]["primitives"]
        corners = numbers(primitive["attributes"]["POSITION"]).reshape(-1, 3)
        index = numbers(primitive["indices"]).reshape(-1, 3)
        material = document["materials"][primitive["material"]]
        strength = (
            material["extensions"].get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
        )
        triangles += list(corners[index].astype(float))
        radiance += [strength * np.array(material.get("emissiveFactor", [0.0] * 3))] * len(index)
    seen = rays(to_world, half, width, height, -1.0)
    return Read(to_world[:3, 3], seen, np.array(triangles), np.array(radiance), None)


def emitted(scene: Read) -> np.ndarray:
    """E of what each ray meets first; black on backs and beside the triangles."""
    nearest = np.full(scene.rays.shape[:2], np.inf)
    image = np.zeros(scene.rays.shape)
    for (a, b, c), radiance in zip(scene.triangles, scene.radiance, strict=True):
        n = np.cross(b - a, c - a)
        t = (a - scene.origin) @ n / (scene.rays @ n)
        p = scene.origin + t[..., None] * scene.rays
        sides = [np.cross(v - u, p - u) @ n for u, v in ((a, b), (b, c), (c, a))]
        hit = (t > 0) & (t <= nearest) & (np.min(sides, axis=0) >= -1e-9)
        nearest[hit] = t[hit]
        image[hit] = np.where((scene.rays[hit] @ n < 0)[:, None], radiance, 0.0)
    return image


def main(file: Path, output: str, asked: str = "") -> None:
    scene = {".pbrt": pbrt, ".gltf": gltf}[file.suffix](file)
    last = int(asked) if asked else scene.bounces
    image = emitted(scene) * sum(0.5**k for k in range(last + 1))
    height, width, _ = image.shape
    spec = oiio.ImageSpec(width, height, 3, "float")
    out = oiio.ImageOutput.create(output)
    assert out.open(output, spec)
    assert out.write_image(np.ascontiguousarray(image, dtype=np.float32))
    out.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])
