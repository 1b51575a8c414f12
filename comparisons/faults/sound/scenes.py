"""Sound variants that render another scene of the same image.

What rays meet first is still told of the scene that was asked for: surfaces have other numbers in these.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from functools import lru_cache

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from comparisons.faults.fault import Plant, Sound
from comparisons.faults.planting import of_request
from comparisons.renderers import Images, Renderer
from reference_tracer.emission import bounding_radius
from scenes import (
    Affine,
    Disk,
    Ellipsoid,
    Mesh,
    Orthographic,
    Pinhole,
    Quad,
    Scene,
    SceneError,
    Sphere,
    Surface,
    ThinLens,
    transformed,
)
from scenes.lights import DeltaLight, Light
from scenes.materials import is_textured

_replace = msgspec.structs.replace


def _same_image(
    change: Callable[[Scene], Scene], view: Callable[[Images], Images] = lambda images: images
) -> Plant:
    """Another scene; what the view makes of its image is that of the one asked for."""

    def render(inner: Renderer, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        try:
            other = change(scene)
        except SceneError:  # a turned sphere can't have both a texture and a polar range
            return inner.render(scene, bounces, spp, seed)
        return view(inner.render(other, bounces, spp, seed))

    return of_request(render)


# ---- similarities


def _moved(affine: Affine) -> Callable[[Scene], Scene]:
    return lambda scene: transformed(scene, affine)


def _far_away(scene: Scene) -> Scene:
    offset = 10 * bounding_radius(scene) * np.array([1, -2, 3])
    return transformed(scene, Affine.translation(offset.tolist()))


def _mirrored_or_plain(inner: Renderer, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    try:
        other = transformed(scene, Affine.reflection((1, 2, 0.5)))
    except SceneError:
        return inner.render(scene, bounces, spp, seed)
    return inner.render(other, bounces, spp, seed)[:, :, ::-1]


def _rolled(inner: Renderer, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    sensor = scene.sensor
    if not isinstance(sensor, Pinhole | ThinLens | Orthographic):
        return inner.render(scene, bounces, spp, seed)
    x, y, z = sensor.up
    over = _replace(scene, sensor=_replace(sensor, up=(-x, -y, -z)))
    return inner.render(over, bounces, spp, seed)[:, ::-1, ::-1]


# ---- the same surfaces, said otherwise


def _in_reverse(scene: Scene) -> Scene:
    return _replace(scene, surfaces=scene.surfaces[::-1], lights=scene.lights[::-1])


def _of_surfaces(change: Callable[[Surface], Iterable[Surface]]) -> Callable[[Scene], Scene]:
    """Every surface becomes others. Textured ones stay: their coordinates would change."""

    def changed(scene: Scene) -> Scene:
        surfaces: list[Surface] = []
        for surface in scene.surfaces:
            surfaces += [surface] if is_textured(surface.material) else change(surface)
        return _replace(scene, surfaces=tuple(surfaces))

    return changed


@lru_cache(maxsize=4)
def _all_cut_that_can_be(scene: Scene) -> Scene:
    """One quad after the other is cut. The foot of a block can't be, since it lies in its floor."""
    for surface in scene.surfaces:

        def halves(other: Surface, chosen: str = surface.name) -> Iterable[Surface]:
            return _halves(other) if other.name == chosen else [other]

        with suppress(SceneError):
            scene = _of_surfaces(halves)(scene)
    return scene


def _vector(values: ArrayLike) -> tuple[float, float, float]:
    x, y, z = np.asarray(values, dtype=float).tolist()
    return x, y, z


def _halves(surface: Surface) -> Iterable[Surface]:
    """A quad, cut across its first edge, near its end: no cut of a wall runs through what stands against it."""
    if not isinstance(quad := surface.shape, Quad):
        return [surface]
    corner, u, v = (np.array(e) for e in (quad.corner, quad.edge_u, quad.edge_v))
    cut = 0.0625
    return [
        _replace(surface, name=f"{surface.name} a", shape=Quad(quad.corner, _vector(cut * u), _vector(v))),
        _replace(
            surface,
            name=f"{surface.name} b",
            shape=Quad(_vector(corner + cut * u), _vector((1 - cut) * u), _vector(v)),
        ),
    ]


def _triangles(surface: Surface) -> Iterable[Surface]:
    if not isinstance(quad := surface.shape, Quad):
        return [surface]
    corner, u, v = (np.array(e) for e in (quad.corner, quad.edge_u, quad.edge_v))
    corners = tuple(_vector(p) for p in (corner, corner + u, corner + u + v, corner + v))
    return [_replace(surface, shape=Mesh(corners, ((0, 1, 2), (0, 2, 3))))]


def _from_another_corner(surface: Surface) -> Iterable[Surface]:
    if not isinstance(quad := surface.shape, Quad):
        return [surface]
    corner, u, v = (np.array(e) for e in (quad.corner, quad.edge_u, quad.edge_v))
    return [_replace(surface, shape=Quad(_vector(corner + u), _vector(v), _vector(-u)))]


def _turned_disks(surface: Surface) -> Iterable[Surface]:
    if not isinstance(disk := surface.shape, Disk):
        return [surface]
    u, v, c, s = np.array(disk.axis_u), np.array(disk.axis_v), np.cos(0.7), np.sin(0.7)
    return [_replace(surface, shape=Disk(disk.center, _vector(c * u + s * v), _vector(c * v - s * u)))]


def _ellipsoids(surface: Surface) -> Iterable[Surface]:
    sphere, emission = surface.shape, surface.emission
    if not isinstance(sphere, Sphere) or (emission is not None and emission.polar_range is not None):
        return [surface]
    turned = sphere.radius * Affine.rotation((1, 2, 3), 40).matrix
    u, v, w = map(_vector, turned.T)
    return [_replace(surface, shape=Ellipsoid(sphere.center, u, v, w, sphere.inward))]


def _lights_in_halves(scene: Scene) -> Scene:
    """Every point, spot and directional light is two, of one and of three quarters."""
    lights: list[Light] = []
    for share in (0.25, 0.75):
        for light in scene.lights:
            if isinstance(light, DeltaLight):
                field = "intensity" if hasattr(light, "intensity") else "irradiance"
                part = tuple(share * i for i in getattr(light, field))
                lights.append(_replace(light, **{field: part}))
    lights += [light for light in scene.lights if not isinstance(light, DeltaLight)]
    return _replace(scene, lights=tuple(lights))


VARIANTS: tuple[Sound, ...] = (
    Sound(
        name="turned",
        what="the scene and its sensor turned and moved",
        plant=_same_image(_moved(Affine.translation((0.3, -0.2, 0.5)) @ Affine.rotation((1, 2, -3), 50))),
    ),
    Sound(
        name="mirrored",
        what="the scene and its sensor mirrored, and the image flipped back",
        plant=of_request(_mirrored_or_plain),
    ),
    Sound(
        name="a-thousand-times-as-large",
        what="the scene and its sensor a thousand times as large, point and spot intensities a million times",
        plant=_same_image(_moved(Affine.scaling(1000.0))),
    ),
    Sound(
        name="a-hundred-times-smaller",
        what="the scene and its sensor a hundred times smaller, point and spot intensities 10⁻⁴ of what they were",
        plant=_same_image(_moved(Affine.scaling(0.01))),
    ),
    Sound(
        name="far-from-the-origin",
        what="the scene and its sensor moved by many times its size",
        plant=_same_image(_far_away),
    ),
    Sound(
        name="camera-rolled",
        what="the camera upside down, and the image turned back",
        plant=of_request(_rolled),
    ),
    Sound(
        name="parts-in-reverse-order",
        what="surfaces and lights in reverse order",
        plant=_same_image(_in_reverse),
    ),
    Sound(
        name="quads-in-two",
        what="every quad cut into two, but for feet of blocks",
        plant=_same_image(_all_cut_that_can_be),
    ),
    Sound(
        name="quads-as-triangles",
        what="every quad a mesh of two triangles",
        plant=_same_image(_of_surfaces(_triangles)),
    ),
    Sound(
        name="quads-from-another-corner",
        what="every quad told from the next corner",
        plant=_same_image(_of_surfaces(_from_another_corner)),
    ),
    Sound(
        name="disks-turned",
        what="every disk with other conjugate radii of the same ellipse",
        plant=_same_image(_of_surfaces(_turned_disks)),
    ),
    Sound(
        name="spheres-as-ellipsoids",
        what="every sphere an ellipsoid with three equal axes, unless it emits from a zone",
        plant=_same_image(_of_surfaces(_ellipsoids)),
    ),
    Sound(
        name="point-lights-in-two",
        what="every point, spot and directional light two in one place, that share its intensity",
        plant=_same_image(_lights_in_halves),
    ),
)
