"""A scene as Mitsuba 3's XML, for the variants ``*_rgb``.

Conventions that are translated here:

- Mitsuba's rectangle is [−1, 1]² and its disk the unit disk, both with normal +z; ``flip_normals`` turns a sphere
  inside out; a two-sided surface is the BSDF ``twosided``.
- Mitsuba's images have their first row at v = 0, the bottom of ours. On a sphere its v is θ / π, where ours is
  1 − θ / π: there, images need no turning, but the squares of a checkerboard count from the other pole.
- A zone of emission is a texture of one column, an environment map a picture whose rows begin and end at the poles:
  ``mitsuba_pictures.py``. The poles of Mitsuba's map are ±y, its longitude runs from −z to +x.
- ``lookat`` makes a camera that looks along +z with x to the left.
- Mitsuba's ``max_depth = d`` holds bounces 0 … d − 1; the file takes it as a parameter,
  ``mitsuba -m scalar_rgb scene.xml -D max_depth=3 -D spp=256``. Russian roulette is off, so it should not be −1,
  without end: in a closed room no path ends by itself.

Meshes and images are files beside the XML.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes.bounds import farthest
from scenes.formats import export
from scenes.formats.export import Export, Source, UnsupportedFeatureError, kind
from scenes.formats.mitsuba_pictures import environment_rows, zone_rows
from scenes.formats.pfm import pfm
from scenes.formats.ply import ply
from scenes.lights import (
    AreaLight,
    ConstantEnvironment,
    DirectionalLight,
    EnvironmentMap,
    Light,
    PointLight,
    SpotLight,
)
from scenes.materials import (
    Blend,
    Checkerboard,
    Conductor,
    Dielectric,
    Lambertian,
    Material,
    Mirror,
    RoughConductor,
    RoughDielectric,
    Texture,
    is_textured,
)
from scenes.scene import Scene
from scenes.sensor import Camera, IrradianceMeter, Orthographic, RadianceMeter, Sensor, ThinLens
from scenes.shapes import Disk, Ellipsoid, Mesh, Quad, Shape, Sphere
from scenes.surfaces import Surface

Array = NDArray[np.float64]

FORMAT = "mitsuba-xml"
_NO_ROULETTE = 1 << 30
_FAR = 1e4  # where Mitsuba's cameras cease to see unless told otherwise
_VERSION = "3.0.0"


def mitsuba_xml(scene: Scene, name: str = "scene", source: Source = export.UNKNOWN) -> Export:
    """The scene as XML, with its meshes (PLY) and images (PFM).

    Args:
        scene: with one channel or three.
        name: what the names of the other files begin with.
        source: for the header.

    Raises:
        UnsupportedFeatureError: naming what Mitsuba does not have.
    """
    export.refuse_spectra(FORMAT, scene)
    root, files = _Writer(export.portable(name)).write(scene)
    root.insert(0, _header(scene, source, name))
    root.insert(1, Element("default", name="max_depth", value=str(source.bounces + 1)))
    ElementTree.indent(root)
    return Export(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n", files)


def _unsupported(feature: str) -> UnsupportedFeatureError:
    return UnsupportedFeatureError(FORMAT, feature)


# ---- elements


def _numbers(values: ArrayLike) -> str:
    """All digits: reading them gives the same numbers."""
    return ", ".join(repr(float(value)) for value in np.ravel(values))


def _plugin(parent: Element, tag: str, type: str, name: str | None = None) -> Element:
    return SubElement(parent, tag, {"type": type} | ({"name": name} if name else {}))


def _float(parent: Element, **values: float) -> None:
    for name, value in values.items():
        SubElement(parent, "float", name=name, value=repr(float(value)))


def _text(parent: Element, tag: str, **values: object) -> None:
    for name, value in values.items():
        text = str(value).lower() if isinstance(value, bool) else str(value)
        SubElement(parent, tag, name=name, value=text)


def _rgb(parent: Element, name: str, values: tuple[float, ...]) -> None:
    SubElement(parent, "rgb", name=name, value=_numbers(export.rgb(values)))


def _vector(parent: Element, tag: str, name: str, values: Iterable[float]) -> None:
    x, y, z = (repr(float(value)) for value in values)
    SubElement(parent, tag, name=name, x=x, y=y, z=z)


def _transform(parent: Element, name: str = "to_world") -> Element:
    return SubElement(parent, "transform", name=name)


def _matrix(parent: Element, axes: ArrayLike, center: ArrayLike) -> None:
    """Where the local x, y and z axis and the local origin go."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = np.transpose(axes), center
    SubElement(_transform(parent), "matrix", value=_numbers(matrix).replace(",", ""))


def _look_at(transform: Element, origin: ArrayLike, target: ArrayLike, up: ArrayLike) -> None:
    SubElement(transform, "lookat", origin=_numbers(origin), target=_numbers(target), up=_numbers(up))


# ---- the scene


def _header(scene: Scene, source: Source, name: str) -> Element[Any]:
    n = source.bounces
    lines = export.header(
        scene,
        source,
        f"Bounces 0 to {n}: mitsuba -m scalar_rgb {name}.xml -D max_depth={n + 1} -D spp=256",
        "Bounce k alone: the image of max_depth = k + 1 less that of max_depth = k",
    )
    # no two hyphens in a row: they would end the comment
    text = re.sub("-(?=-)", "- ", "\n    ".join(["", *lines]))
    return ElementTree.Comment(f"{text}\n  ")


class _Writer:
    """Collects the files that the XML refers to."""

    def __init__(self, name: str) -> None:
        self._name, self._files = name, dict[str, bytes]()

    def write(self, scene: Scene) -> tuple[Element, dict[str, bytes]]:
        root = Element("scene", version=_VERSION)
        SubElement(root, "default", name="spp", value="64")
        integrator = _plugin(root, "integrator", "path")
        _text(integrator, "integer", max_depth="$max_depth", rr_depth=_NO_ROULETTE)
        _sensor(root, scene.sensor, farthest(scene))
        for i, surface in enumerate(scene.surfaces):
            self._surface(root, surface, i)
        for light in scene.lights:
            if isinstance(light, EnvironmentMap):
                self._environment_map(_plugin(root, "emitter", "envmap"), light)
            else:
                _light(root, light)
        return root, self._files

    def _file(self, suffix: str, content: bytes) -> str:
        name = f"{self._name}-{len(self._files)}.{suffix}"
        self._files[name] = content
        return name

    def _surface(self, root: Element, surface: Surface, number: int) -> None:
        # numbered, since Mitsuba does not take every name
        shape = self._shape(root, surface)
        shape.set("id", f"surface{number}")
        parent = _plugin(shape, "bsdf", "twosided") if surface.two_sided else shape
        self._bsdf(parent, surface.material, surface.shape)
        if surface.emission is not None:
            if surface.emission.angular_profile is not None:
                raise _unsupported(f"{surface.name} has an angular profile: Mitsuba's area light is diffuse")
            if surface.two_sided and surface.emits:
                raise _unsupported(f"{surface.name} emits from both sides: Mitsuba's area light has one")
            self._emission(_plugin(shape, "emitter", "area"), surface.emission)

    def _shape(self, root: Element, surface: Surface) -> Element:
        match surface.shape:
            case Quad():
                return _quad(root, surface.shape)
            case Disk():
                return _disk(root, surface.shape, surface)
            case Sphere():
                return _sphere(root, surface.shape, surface)
            case Ellipsoid():
                raise _unsupported(f"{surface.name} is an ellipsoid: Mitsuba's sphere warns and stays round")
            case Mesh():
                shape = _plugin(root, "shape", "ply")
                _text(shape, "string", filename=self._file("ply", ply(surface.shape)))
                _text(shape, "boolean", face_normals=surface.shape.normals is None)
                return shape

    def _bsdf(self, parent: Element, material: Material, shape: Shape) -> None:
        match material:
            case Lambertian():
                self._albedo(_plugin(parent, "bsdf", "diffuse"), material.albedo, shape)
            case Mirror():
                bsdf = _plugin(parent, "bsdf", "conductor")
                _text(bsdf, "string", material="none")
                _rgb(bsdf, "specular_reflectance", material.reflectance)
            case Dielectric() | RoughDielectric():
                bsdf = _plugin(parent, "bsdf", kind(material).replace(" ", ""))
                _float(bsdf, int_ior=material.interior_ior, ext_ior=material.exterior_ior)
                _ggx(bsdf, material)
            case Conductor() | RoughConductor():
                bsdf = _plugin(parent, "bsdf", kind(material).replace(" ", ""))
                _rgb(bsdf, "eta", material.eta)
                _rgb(bsdf, "k", material.k)
                _ggx(bsdf, material)
            case Blend():
                bsdf = _plugin(parent, "bsdf", "blendbsdf")
                _float(bsdf, weight=material.weight)
                self._bsdf(bsdf, material.first, shape)
                self._bsdf(bsdf, material.second, shape)

    def _albedo(self, bsdf: Element, albedo: tuple[float, ...] | Texture, shape: Shape) -> None:
        from_top = isinstance(shape, Sphere)  # v begins at the top, see above
        if isinstance(albedo, tuple):
            _rgb(bsdf, "reflectance", albedo)
        elif isinstance(albedo, Checkerboard):
            texture = _plugin(bsdf, "texture", "checkerboard", "reflectance")
            exchanged = from_top and albedo.rows % 2 == 0
            _rgb(texture, "color1" if exchanged else "color0", albedo.even)
            _rgb(texture, "color0" if exchanged else "color1", albedo.odd)
            # one period of Mitsuba's is two squares
            x, y = repr(albedo.columns / 2), repr(albedo.rows / 2)
            SubElement(_transform(texture, "to_uv"), "scale", x=x, y=y, z="1")
        else:
            pixels = albedo.image.array
            self._bitmap(bsdf, "reflectance", pixels if from_top else pixels[::-1], albedo.interpolation)

    def _picture(self, parent: Element, pixels: Array) -> None:
        """A file of its own, grey where there is one channel."""
        content = pfm(np.broadcast_to(pixels, (*pixels.shape[:2], 3)))
        _text(parent, "string", filename=self._file("pfm", content))

    def _bitmap(self, parent: Element, name: str, pixels: Array, interpolation: str) -> None:
        texture = _plugin(parent, "texture", "bitmap", name)
        self._picture(texture, pixels)
        _text(texture, "string", filter_type=interpolation, wrap_mode="clamp")
        _text(texture, "boolean", raw=True)

    def _emission(self, emitter: Element, light: AreaLight) -> None:
        zone = light.polar_range
        if zone is None:
            _rgb(emitter, "radiance", light.radiance)
            return
        rows = zone_rows(zone, light.radiance)
        if rows is None:
            raise _unsupported(f"emission between {zone.low}° and {zone.high}°: no texture has borders there")
        self._bitmap(emitter, "radiance", rows, "nearest")

    def _environment_map(self, emitter: Element, light: EnvironmentMap) -> None:
        self._picture(emitter, environment_rows(light.image.array))
        x, y, z = np.asarray(light.axes)
        _matrix(emitter, [y, z, -x], (0.0, 0.0, 0.0))


# ---- shapes


def _quad(root: Element, quad: Quad) -> Element:
    shape = _plugin(root, "shape", "rectangle")
    u, v = np.asarray(quad.edge_u) / 2, np.asarray(quad.edge_v) / 2
    _matrix(shape, [u, v, quad.normal], np.asarray(quad.corner) + u + v)
    return shape


def loses_its_area(disk: Disk) -> bool:
    """Whether its radii are so nearly parallel that Mitsuba's area is off by more than 0.2 %.

    Measured: docs/findings/mitsuba-skew-disk.md.
    """
    u, v = np.asarray(disk.axis_u), np.asarray(disk.axis_v)
    return bool(np.linalg.norm(np.cross(u, v)) < 0.01 * np.linalg.norm(u) * np.linalg.norm(v))


def _disk(root: Element, disk: Disk, surface: Surface) -> Element:
    if is_textured(surface.material):
        raise _unsupported(f"{surface.name} is a disk with a texture: Mitsuba's coordinates are polar there")
    if loses_its_area(disk):
        raise _unsupported(f"{surface.name} has radii that are nearly parallel: Mitsuba loses its area")
    shape = _plugin(root, "shape", "disk")
    _matrix(shape, [np.asarray(disk.axis_u), np.asarray(disk.axis_v), disk.normal], disk.center)
    return shape


def _sphere(root: Element, sphere: Sphere, surface: Surface) -> Element:
    """A sphere, its polar axis turned to that of the zone that emits."""
    zone = surface.emission.polar_range if surface.emission else None
    axes = np.eye(3)
    if zone is not None and zone.axis != (0.0, 0.0, 1.0):
        if is_textured(surface.material):
            raise _unsupported(
                f"{surface.name} has a texture, and a zone about an axis other than z: both turn together"
            )
        z = np.asarray(zone.axis)
        x = np.cross(np.eye(3)[np.abs(z).argmin()], z)
        x /= np.linalg.norm(x)
        axes = np.stack([x, np.cross(z, x), z])
    shape = _plugin(root, "shape", "sphere")
    _matrix(shape, sphere.radius * axes, sphere.center)
    _text(shape, "boolean", flip_normals=sphere.inward)
    return shape


# ---- materials and lights


def _ggx(bsdf: Element, material: Material) -> None:
    if not isinstance(material, RoughConductor | RoughDielectric):
        return
    if material.shadowing != "separable":
        raise _unsupported(f"{material.shadowing} shadowing: Mitsuba's is the separable one")
    _text(bsdf, "string", distribution="ggx")
    _float(bsdf, alpha=material.alpha)


def _light(root: Element, light: Light) -> None:
    match light:
        case PointLight():
            emitter = _plugin(root, "emitter", "point")
            _vector(emitter, "point", "position", light.position)
            _rgb(emitter, "intensity", light.intensity)
        case SpotLight():
            emitter = _plugin(root, "emitter", "spot")
            up = np.eye(3)[np.abs(light.direction).argmin()]
            _look_at(_transform(emitter), light.position, np.add(light.position, light.direction), up)
            _rgb(emitter, "intensity", light.intensity)
            _float(emitter, cutoff_angle=light.cutoff, beam_width=light.beam)
        case DirectionalLight():
            emitter = _plugin(root, "emitter", "directional")
            _vector(emitter, "vector", "direction", light.direction)
            _rgb(emitter, "irradiance", light.irradiance)
        case ConstantEnvironment():
            _rgb(_plugin(root, "emitter", "constant"), "radiance", light.radiance)
        case _:
            raise _unsupported(f"{kind(light)} light: Mitsuba has none, and a picture would be another one")


# ---- sensors


def _sensor(root: Element, sensor: Sensor, far: float) -> None:
    if isinstance(sensor, IrradianceMeter):
        raise _unsupported("irradiance meter: Mitsuba's measures on a shape, not at a point")
    if isinstance(sensor, RadianceMeter):
        element = _plugin(root, "sensor", "radiancemeter")
        _vector(element, "point", "origin", sensor.origin)
        _vector(element, "vector", "direction", sensor.direction)
    elif isinstance(sensor, Orthographic):
        element = _plugin(root, "sensor", "orthographic")
        transform = _transform(element)
        # Mitsuba's image is [−1, 1] across the width, whatever its height
        half = repr(sensor.extent / 2 * sensor.width / min(sensor.width, sensor.height))
        SubElement(transform, "scale", x=half, y=half, z="1")
        _look_at(transform, sensor.origin, sensor.target, sensor.up)
        _clip(element, sensor, far)
    else:
        element = _plugin(root, "sensor", "thinlens" if isinstance(sensor, ThinLens) else "perspective")
        _look_at(_transform(element), sensor.origin, sensor.target, sensor.up)
        _text(element, "string", fov_axis="smaller")
        _float(element, fov=sensor.fov)
        _clip(element, sensor, far)
        if isinstance(sensor, ThinLens):
            _float(element, aperture_radius=sensor.aperture_radius, focus_distance=sensor.focus_distance)
    film = _plugin(element, "film", "hdrfilm")
    _text(film, "integer", width=sensor.width, height=sensor.height)
    _text(film, "string", pixel_format="rgb", component_format="float32")
    _plugin(film, "rfilter", "box")
    _text(_plugin(element, "sampler", "independent"), "integer", sample_count="$spp")


def _clip(element: Element, sensor: Camera, far: float) -> None:
    """Mitsuba's camera sees nothing beyond a distance, and nothing closer than another one, which can't be 0."""
    _float(element, near_clip=1e-6 * math.dist(sensor.origin, sensor.target))
    if far > _FAR / 2:
        _float(element, far_clip=2 * far)
