"""A scene as Mitsuba 3's dictionary: every translation of conventions that the scene itself needs.

- Mitsuba's shapes face the same way as ours; a sphere whose front is its inside has ``flip_normals``. A two-sided
  surface is Mitsuba's ``twosided`` BSDF.
- Its rectangle is [−1, 1]², its disk the unit disk, both with normal +z. They take axes that are not
  orthogonal, too: a parallelogram, an ellipse. Mitsuba's manual forbids an ellipse; it was measured to be right as
  long as its area, a difference of squares in single precision, is not lost.
- Meshes go through a PLY file, since emitters can't be attached to a mesh in memory.
- Texture coordinates are the same on rectangles and meshes; on a sphere Mitsuba's v runs down from the pole. The
  first row of a bitmap is at v = 0. A disk has polar ones.
- A zone of emission is a texture of one column, see ``zone_rows``.
- Rough materials: GGX, visible normals, and the separable shadowing, which is the only one that Mitsuba has.
- The first row of Mitsuba's environment map is the pole +y, the last one −y, see ``environment_rows``; longitude
  runs from −z to +x.
- Its cameras look along +z with x to the left.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from comparisons.renderers.mitsuba_colours import Colours
from comparisons.renderers.protocol import Unsupported
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
    Lambertian,
    Light,
    Material,
    Mesh,
    Mirror,
    Orthographic,
    Pinhole,
    PointLight,
    Quad,
    RadianceMeter,
    RoughConductor,
    RoughDielectric,
    Scene,
    Sensor,
    Sphere,
    SpotLight,
    Surface,
    Texture,
    ThinLens,
)
from scenes.formats.mitsuba_pictures import environment_rows, zone_rows
from scenes.formats.mitsuba_xml import loses_its_area
from scenes.materials import is_textured
from scenes.validation import Vector

Array = NDArray[np.float64]
Dict = dict[str, Any]

_Z: Vector = (0.0, 0.0, 1.0)


def scene_dict(colours: Colours, scene: Scene, folder: Path, sampler: Dict | None = None) -> Dict:
    """The scene as Mitsuba's dictionary.

    Args:
        colours: how its channels are put to the variant that is set.
        scene: the scene.
        folder: where files of meshes are written; they are read when the dictionary is loaded.
        sampler: left out: ``independent``.

    Raises:
        Unsupported: naming the feature that Mitsuba, in this variant, does not have.
    """
    return {
        "type": "scene",
        "sensor": sensor_dict(colours, scene.sensor, sampler),
        # numbered, since Mitsuba does not take every name
        **{
            f"surface{i}": _surface(colours, surface, folder / f"{i}.ply")
            for i, surface in enumerate(scene.surfaces)
        },
        **{f"light{i}": _light(colours, light) for i, light in enumerate(scene.lights)},
    }


def _type(part: msgspec.Struct) -> str:
    """What a part of a scene is called in JSON."""
    return str(part.__struct_config__.tag)


# ---- sensors


def sensor_dict(colours: Colours, sensor: Sensor, sampler: Dict | None = None) -> Dict:
    """The sensor as Mitsuba's dictionary; see ``scene_dict``.

    Raises:
        Unsupported: Mitsuba has none of the kind.
    """
    mi = colours.mi
    size: Dict = {"width": sensor.width, "height": sensor.height}
    film = colours.film() | size | {"rfilter": {"type": "box"}}
    common: Dict = {"film": film, "sampler": sampler or {"type": "independent"}}
    if isinstance(sensor, RadianceMeter):
        return {
            "type": "radiancemeter",
            "origin": list(sensor.origin),
            "direction": list(sensor.direction),
        } | common
    if not isinstance(sensor, Pinhole | ThinLens | Orthographic):
        raise Unsupported(f"{_type(sensor)} sensor: Mitsuba's measures on a shape, not at a point")
    right, up, forward = sensor.frame.T
    distance = math.dist(sensor.origin, sensor.target)
    common |= {"near_clip": 1e-6 * distance, "far_clip": 1e6 * distance}
    if isinstance(sensor, Orthographic):
        # Mitsuba's image is [−1, 1] across the width, whatever its height
        half = sensor.extent / 2 * sensor.width / min(sensor.width, sensor.height)
        view = _placed(mi, [-half * right, half * up, forward], sensor.origin)
        return {"type": "orthographic", "to_world": view} | common
    view = _placed(mi, [-right, up, forward], sensor.origin)
    camera = {"fov_axis": "smaller", "fov": sensor.fov, "to_world": view} | common
    if isinstance(sensor, ThinLens):
        lens = {"aperture_radius": sensor.aperture_radius, "focus_distance": sensor.focus_distance}
        return {"type": "thinlens"} | lens | camera
    return {"type": "perspective"} | camera


# ---- surfaces


def _surface(colours: Colours, surface: Surface, file: Path) -> Dict:
    mi = colours.mi
    match surface.shape:
        case Quad():
            shape = _quad(mi, surface.shape)
        case Disk():
            shape = _disk(mi, surface.shape)
        case Sphere():
            shape = _sphere(mi, surface)
        case Mesh():
            shape = _mesh(mi, surface.shape, file)
        case _:
            raise Unsupported(f"{_type(surface.shape)} shape: Mitsuba's sphere warns and stays round")
    if surface.two_sided and surface.emits:
        raise Unsupported("emission from both sides: Mitsuba's area light has one")
    bsdf = _bsdf(colours, surface.material, _texture_coordinates(mi, surface))
    shape["bsdf"] = {"type": "twosided", "bsdf": bsdf} if surface.two_sided else bsdf
    if surface.emission is not None:
        shape["emitter"] = {"type": "area", "radiance": _radiance(colours, surface.emission)}
    return shape


def _placed(mi: Any, axes: Sequence[Array] | Array, center: Sequence[float] | Array) -> Any:
    """The map that takes the unit vectors to these axes, and 0 to the centre."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = np.array(axes).T, center
    return mi.ScalarTransform4f(matrix)


def _frame(z: Vector) -> Array:
    """Three right-handed unit vectors, the last of them this one, ``(3, 3)``."""
    x = np.cross(np.eye(3)[np.abs(z).argmin()], z)
    x = x / np.linalg.norm(x)
    return np.array([x, np.cross(z, x), z])


def _texture_coordinates(mi: Any, surface: Surface) -> Any:
    """The map from Mitsuba's texture coordinates to ours.

    Raises:
        Unsupported: the material has a texture, and there is no such map.
    """
    if not is_textured(surface.material):
        return mi.ScalarTransform4f()
    if isinstance(surface.shape, Disk):
        raise Unsupported("a texture on a disk: Mitsuba's coordinates are polar there")
    if isinstance(surface.shape, Sphere):
        if _zone_axis(surface) != _Z:
            raise Unsupported(
                "a texture on a sphere with a zone about an axis other than z: both turn together"
            )
        return mi.ScalarTransform4f().translate([0.0, 1.0, 0.0]).scale([1.0, -1.0, 1.0])
    return mi.ScalarTransform4f()


def _quad(mi: Any, quad: Quad) -> Dict:
    u, v = np.asarray(quad.edge_u) / 2, np.asarray(quad.edge_v) / 2
    to_world = _placed(mi, [u, v, quad.normal], np.asarray(quad.corner) + u + v)
    return {"type": "rectangle", "to_world": to_world}


def _disk(mi: Any, disk: Disk) -> Dict:
    if loses_its_area(disk):
        raise Unsupported("an ellipse by radii that are nearly parallel: Mitsuba loses its area to rounding")
    axes = [np.asarray(disk.axis_u), np.asarray(disk.axis_v), disk.normal]
    return {"type": "disk", "to_world": _placed(mi, axes, disk.center)}


def _zone_axis(surface: Surface) -> Vector:
    """The polar axis of the zone that emits; +z where there is none."""
    zone = surface.emission.polar_range if surface.emission else None
    return zone.axis if zone else _Z


def _sphere(mi: Any, surface: Surface) -> Dict:
    """A sphere, its polar axis turned to that of the zone that emits."""
    assert isinstance(surface.shape, Sphere)
    axis = _zone_axis(surface)
    axes = np.eye(3) if axis == _Z else _frame(axis)
    to_world = _placed(mi, surface.shape.radius * axes, surface.shape.center)
    inside = {"flip_normals": True} if surface.shape.inward else {}
    return {"type": "sphere", "to_world": to_world} | inside


def _mesh(mi: Any, mesh: Mesh, file: Path) -> Dict:
    smooth, textured = mesh.normals is not None, mesh.uv is not None
    counts = {"vertex_count": len(mesh.vertices), "face_count": len(mesh.triangles)}
    made = mi.Mesh("mesh", **counts, has_vertex_normals=smooth, has_vertex_texcoords=textured)
    parameters = mi.traverse(made)
    parameters["vertex_positions"] = np.ravel(mesh.vertices).astype(np.float32)
    parameters["faces"] = np.ravel(mesh.triangles).astype(np.uint32)
    if mesh.normals is not None:
        parameters["vertex_normals"] = np.ravel(mesh.normals).astype(np.float32)
    if mesh.uv is not None:
        parameters["vertex_texcoords"] = np.ravel(mesh.uv).astype(np.float32)
    parameters.update()
    made.write_ply(str(file))
    return {"type": "ply", "filename": str(file), "face_normals": not smooth}


# ---- materials


def _bsdf(colours: Colours, material: Material, to_uv: Any) -> Dict:
    match material:
        case Lambertian():
            return {"type": "diffuse", "reflectance": _albedo(colours, material.albedo, to_uv)}
        case Mirror():
            return {
                "type": "conductor",
                "material": "none",
                "specular_reflectance": colours.spectrum(material.reflectance),
            }
        case Dielectric():
            return {"type": "dielectric"} | _media(material)
        case Conductor():
            return {
                "type": "conductor",
                "eta": colours.spectrum(material.eta),
                "k": colours.spectrum(material.k),
            }
        case RoughConductor():
            return {
                "type": "roughconductor",
                "eta": colours.spectrum(material.eta),
                "k": colours.spectrum(material.k),
            } | _ggx(material)
        case RoughDielectric():
            return {"type": "roughdielectric"} | _media(material) | _ggx(material)
        case Blend():
            first, second = (_bsdf(colours, part, to_uv) for part in (material.first, material.second))
            return {"type": "blendbsdf", "weight": material.weight, "first": first, "second": second}


def _media(material: Dielectric | RoughDielectric) -> Dict:
    return {"int_ior": material.interior_ior, "ext_ior": material.exterior_ior}


def _ggx(material: RoughConductor | RoughDielectric) -> Dict:
    if material.shadowing != "separable":
        raise Unsupported(f"{material.shadowing} shadowing: Mitsuba's is the separable one")
    return {"distribution": "ggx", "alpha": material.alpha, "sample_visible": True}


def _albedo(colours: Colours, albedo: tuple[float, ...] | Texture, to_uv: Any) -> Dict:
    if isinstance(albedo, tuple):
        return colours.spectrum(albedo)
    if isinstance(albedo, Checkerboard):
        # one period of Mitsuba's is two squares
        to_uv = colours.mi.ScalarTransform4f().scale([albedo.columns / 2, albedo.rows / 2, 1.0]) @ to_uv
        return {
            "type": "checkerboard",
            "color0": colours.spectrum(albedo.even),
            "color1": colours.spectrum(albedo.odd),
            "to_uv": to_uv,
        }
    # Mitsuba's first row is at v = 0
    return _bitmap(colours, albedo.image.array[::-1], albedo.interpolation) | {"to_uv": to_uv}


def _bitmap(colours: Colours, pixels: Array, interpolation: str) -> Dict:
    return {
        "type": "bitmap",
        "bitmap": colours.mi.Bitmap(np.ascontiguousarray(colours.picture(pixels), dtype=np.float32)),
        "raw": True,
        "filter_type": interpolation,
        "wrap_mode": "clamp",
    }


# ---- lights


def _radiance(colours: Colours, light: AreaLight) -> Dict:
    if light.angular_profile is not None:
        raise Unsupported("an angular profile of emission: Mitsuba's area light is diffuse")
    if light.polar_range is None:
        return colours.spectrum(light.radiance)
    zone = light.polar_range
    rows = zone_rows(zone, light.radiance)
    if rows is None:
        raise Unsupported(f"emission between {zone.low}° and {zone.high}°: no texture has borders there")
    return _bitmap(colours, rows, "nearest")


def _light(colours: Colours, light: Light) -> Dict:
    match light:
        case PointLight():
            return {
                "type": "point",
                "position": list(light.position),
                "intensity": colours.spectrum(light.intensity),
            }
        case SpotLight():
            return _spot(colours, light)
        case DirectionalLight():
            return {
                "type": "directional",
                "direction": list(light.direction),
                "irradiance": colours.spectrum(light.irradiance),
            }
        case ConstantEnvironment():
            return {"type": "constant", "radiance": colours.spectrum(light.radiance)}
        case EnvironmentMap():
            return _environment_map(colours, light)
        case _:
            raise Unsupported(f"{_type(light)} light: Mitsuba has none")


def _spot(colours: Colours, light: SpotLight) -> Dict:
    to_world = _placed(colours.mi, _frame(light.direction), light.position)
    angles = {"cutoff_angle": light.cutoff, "beam_width": light.beam}
    return {"type": "spot", "to_world": to_world, "intensity": colours.spectrum(light.intensity)} | angles


def _environment_map(colours: Colours, light: EnvironmentMap) -> Dict:
    x, y, z = np.asarray(light.axes)
    return {
        "type": "envmap",
        "bitmap": colours.mi.Bitmap(colours.sky(environment_rows(light.image.array)).astype(np.float32)),
        "to_world": _placed(colours.mi, [y, z, -x], (0.0, 0.0, 0.0)),
    }
