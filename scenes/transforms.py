"""Transformed scenes: the image of shapes, surfaces, lights, sensors and whole scenes under an affine map.

Fronts stay fronts, also under a map that mirrors, and textures stay attached to their points.

Radiance stays what it is along a transformed ray. A scene that is scaled by s therefore keeps the irradiance of
its directional lights, and the intensity of point and spot lights grows by s², as does the square of distances.
That holds for similarities; any other map changes solid angles and cosines, so only shapes and surfaces take it.

A mirrored camera is none: its image would have the right on the left. Its origin and target are mapped as points
and ``up`` as a vector, so the image of a mirrored scene is the original one flipped left to right, exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import singledispatch
from typing import Any, TypeVar, cast

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from scenes.affine import Affine
from scenes.images import Image
from scenes.lights import (
    ConstantEnvironment,
    DirectionalLight,
    EnvironmentMap,
    Light,
    PointLight,
    SphericalHarmonicsEnvironment,
    SpotLight,
)
from scenes.materials import Blend, Checkerboard, ImageTexture, Lambertian, Material, Texture, is_textured
from scenes.scene import Scene
from scenes.sensor import IrradianceMeter, Orthographic, Pinhole, RadianceMeter, Sensor, ThinLens
from scenes.shapes import Disk, Ellipsoid, Mesh, Quad, Shape, Sphere
from scenes.surfaces import Surface
from scenes.validation import SceneError, Vector

Part = TypeVar("Part", Scene, Surface, Shape, Light, Sensor)


def transformed(part: Part, affine: Affine) -> Part:
    """The image of a scene or of a part of one.

    Shapes: a quad stays a quad, a disk a disk, a mesh a mesh; a sphere stays one under a similarity and becomes
    an ellipsoid otherwise. Where the map mirrors, the first edge of a quad and the first axis of a disk run the
    other way, for the normal to stay in front, and so does u; of a surface the texture is flipped with it.
    A textured sphere becomes an ellipsoid, which can carry a turned texture.

    Raises:
        SceneError: a light, a sensor, a scene, or the polar zone of a sphere, under a map that is no similarity.
        TypeError: it is no part of a scene, or the map is no Affine.
    """
    if not isinstance(cast(object, affine), Affine):
        raise TypeError(f"affine is a {type(affine).__name__}, expected an Affine")
    return _image(part, affine)  # type: ignore[no-any-return]


@singledispatch
def _image(part: Any, affine: Affine) -> Any:
    raise TypeError(
        f"{type(part).__name__} has no image under an affine map: expected a scene or a part of one"
    )


_replace = msgspec.structs.replace


def _vector(values: ArrayLike) -> Vector:
    x, y, z = np.asarray(values).tolist()
    return x, y, z


# ---- shapes


@_image.register
def _quad(quad: Quad, affine: Affine) -> Quad:
    corner, u, v = np.array(quad.corner), np.array(quad.edge_u), np.array(quad.edge_v)
    if affine.mirrors:  # A u × A v points behind: begin at the other end of u
        corner, u = corner + u, -u
    return Quad(_vector(affine.points(corner)), _vector(affine.vectors(u)), _vector(affine.vectors(v)))


@_image.register
def _disk(disk: Disk, affine: Affine) -> Disk:
    u = -np.array(disk.axis_u) if affine.mirrors else np.array(disk.axis_u)
    center, v = affine.points(disk.center), affine.vectors(disk.axis_v)
    return Disk(_vector(center), _vector(affine.vectors(u)), _vector(v))


@_image.register
def _sphere(sphere: Sphere, affine: Affine) -> Sphere | Ellipsoid:
    if affine.scale is None:
        return _as_ellipsoid(sphere, affine)
    return Sphere(_vector(affine.points(sphere.center)), affine.scale * sphere.radius, sphere.inward)


def _as_ellipsoid(sphere: Sphere, affine: Affine) -> Ellipsoid:
    r = sphere.radius
    unturned = Ellipsoid(sphere.center, (r, 0.0, 0.0), (0.0, r, 0.0), (0.0, 0.0, r), sphere.inward)
    return _ellipsoid(unturned, affine)


@_image.register
def _ellipsoid(ellipsoid: Ellipsoid, affine: Affine) -> Ellipsoid:
    u, v, w = map(_vector, affine.vectors(ellipsoid.matrix).T)
    return Ellipsoid(_vector(affine.points(ellipsoid.center)), u, v, w, ellipsoid.inward)


@_image.register
def _mesh(mesh: Mesh, affine: Affine) -> Mesh:
    return _replace(
        mesh,
        vertices=affine.points(np.array(mesh.vertices).T).T,
        # the other way round, for a mirror makes clockwise of counterclockwise
        triangles=np.array(mesh.triangles)[:, [0, 2, 1] if affine.mirrors else [0, 1, 2]],
        normals=None if mesh.normals is None else affine.normals(np.array(mesh.normals).T).T,
    )


# ---- surfaces


@_image.register
def _surface(surface: Surface, affine: Affine) -> Surface:
    shape, material, emission = _image(surface.shape, affine), surface.material, surface.emission
    if is_textured(material):
        if affine.mirrors and isinstance(shape, Quad | Disk):
            material = _flipped(material)
        only_scales = np.array_equal(affine.matrix, affine.linear[0][0] * np.eye(3))
        if isinstance(surface.shape, Sphere) and (affine.mirrors or not only_scales):
            shape = _as_ellipsoid(surface.shape, affine)
    if emission is not None and emission.polar_range is not None:
        if not isinstance(shape, Sphere):
            found = affine.linear
            expected = "none but a translation and a scaling: the sphere has a texture and a polar range"
            if affine.scale is None:
                expected = "a similarity: only a sphere has polar angles"
            raise SceneError("Affine.linear", found, expected)
        axis = _vector(affine.vectors(emission.polar_range.axis))
        emission = _replace(emission, polar_range=_replace(emission.polar_range, axis=axis))
    return _replace(surface, shape=shape, material=material, emission=emission)


def _flipped(material: Material) -> Material:
    """The material whose texture at (1 − u, v) is what it was at (u, v)."""
    match material:
        case Blend():
            return _replace(material, first=_flipped(material.first), second=_flipped(material.second))
        case Lambertian() if not isinstance(material.albedo, tuple):
            return _replace(material, albedo=_flipped_texture(material.albedo))
        case _:
            return material


def _flipped_texture(texture: Texture) -> Texture:
    match texture:
        case Checkerboard():  # squares count from the other end: an even number of columns changes their turn
            even, odd = texture.even, texture.odd
            return texture if texture.columns % 2 else _replace(texture, even=odd, odd=even)
        case ImageTexture():
            return _replace(texture, image=Image(tuple(row[::-1] for row in texture.image.pixels)))


# ---- lights and sensors


def _similarity(affine: Affine, part: object) -> float:
    """The factor of a similarity.

    Raises:
        SceneError: it is none.
    """
    if affine.scale is None:
        expected = f"a similarity: any other map changes what a {type(part).__name__} stands for"
        raise SceneError("Affine.linear", affine.linear, expected)
    return affine.scale


@_image.register(PointLight)
@_image.register(SpotLight)
def _from_a_point(light: PointLight | SpotLight, affine: Affine) -> PointLight | SpotLight:
    factor = _similarity(affine, light) ** 2
    changes: dict[str, Any] = {
        "position": _vector(affine.points(light.position)),
        "intensity": tuple(factor * i for i in light.intensity),
    }
    if isinstance(light, SpotLight):
        changes["direction"] = _vector(affine.vectors(light.direction))
    return _replace(light, **changes)


@_image.register
def _directional(light: DirectionalLight, affine: Affine) -> DirectionalLight:
    _similarity(affine, light)
    return _replace(light, direction=_vector(affine.vectors(light.direction)))


@_image.register
def _constant(light: ConstantEnvironment, affine: Affine) -> ConstantEnvironment:
    _similarity(affine, light)
    return light


@_image.register(EnvironmentMap)
@_image.register(SphericalHarmonicsEnvironment)
def _environment(
    light: EnvironmentMap | SphericalHarmonicsEnvironment, affine: Affine
) -> EnvironmentMap | SphericalHarmonicsEnvironment:
    axes = affine.vectors(np.array(light.axes).T).T / _similarity(affine, light)
    return _replace(light, axes=axes)


_LENGTHS = ("extent", "aperture_radius", "focus_distance")


@_image.register(Pinhole)
@_image.register(ThinLens)
@_image.register(Orthographic)
@_image.register(RadianceMeter)
@_image.register(IrradianceMeter)
def _sensor(sensor: Sensor, affine: Affine) -> Sensor:
    scale = _similarity(affine, sensor)
    maps: dict[str, Callable[[Any], Any]] = (
        {field: lambda x: _vector(affine.points(x)) for field in ("origin", "target")}
        | {field: lambda v: _vector(affine.vectors(v)) for field in ("up", "direction", "normal")}
        | {field: lambda length: scale * length for field in _LENGTHS}
    )
    changes = {f: maps[f](getattr(sensor, f)) for f in sensor.__struct_fields__ if f in maps}
    return _replace(sensor, **changes)


@_image.register
def _scene(scene: Scene, affine: Affine) -> Scene:
    _similarity(affine, scene)
    return Scene(
        tuple(_image(surface, affine) for surface in scene.surfaces),
        _image(scene.sensor, affine),
        tuple(_image(light, affine) for light in scene.lights),
    )
