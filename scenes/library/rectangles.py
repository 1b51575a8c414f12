"""Light exchanged between rectangles: form factors, pixel by pixel.

The camera is orthographic and looks straight at the receiver, so that a pixel is a rectangle on it and its average
irradiance a form factor of two rectangles: exact, up to the edge in which receiver and lamp meet.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from scenes.case import Case, Formula, Images
from scenes.form_factors import parallel_exchange, perpendicular_exchange
from scenes.irradiance_of_lamps import clipped, polygon_irradiance, polygons
from scenes.library.direct_light import BLACK, DIRECT, TOLERANCE, hit
from scenes.lights import AreaLight, DirectionalLight
from scenes.materials import Lambertian
from scenes.pixel_average import pixel_average
from scenes.pixels_on_rectangle import pixels_on
from scenes.scene import Scene
from scenes.sensor import Orthographic
from scenes.shapes import Quad
from scenes.surfaces import Surface

Array = NDArray[np.float64]

_SOURCE = "Ehlert and Smith 1993, View factors for perpendicular and parallel rectangular plates"

_AFTER_CIE = "recomputed in the manner of CIE 171:2006, {}, with dimensions of its own"

_REFLECTED = """\
The light comes from behind the wall, so that its first bounce is on the floor alone, which then has the uniform
radiance b = (ρ/π) E cos θ. The wall hides nothing of that light from the floor, and the camera sees only the
wall: E = 0 and TE = 0 in every pixel. T²E is the light of the floor on the wall, {}. The floor gets nothing back
before its third bounce, so T³E = 0; from T⁴E on there is no closed form."""


# ---- the answers


def _albedo(surface: Surface) -> Array:
    assert isinstance(surface.material, Lambertian)
    return np.asarray(surface.material.albedo)


def exchange_per_pixel(sensor: Orthographic, receiver: Quad, lamp: Quad) -> Array:
    """The form factor F from each pixel on the receiver to the lamp, ``(height, width)``.

    A pixel that reaches beyond the receiver sees black there.
    """
    pixels = pixels_on(receiver, sensor)
    corners, facing = pixels.local(polygons(lamp)[0]), pixels.frame @ lamp.normal
    factor: Array = np.abs(_exchange(pixels.columns, pixels.rows, corners, facing)) / pixels.area
    return factor


def _exchange(columns: Array, rows: Array, corners: Array, facing: Array) -> Array:
    """Between the cells of a grid in the plane z = 0 and a rectangle with corners ``(3, 4)`` and normal ``(3,)``."""
    (x, y, z), (X, Y, Z) = corners.min(axis=1), corners.max(axis=1)
    height = max(z, 0.0), Z
    if np.isclose(facing[2], -1):
        return parallel_exchange(columns, rows, (x, X), (y, Y), z)
    if np.isclose(abs(facing[0]), 1):
        return perpendicular_exchange((columns - x) * facing[0], rows, height, (y, Y))
    if np.isclose(abs(facing[1]), 1):
        return perpendicular_exchange((rows - y) * facing[1], columns, height, (x, X)).T
    raise ValueError("expected a lamp parallel or perpendicular to the receiver, edges along its edges")


def _facing_lamp(scene: Scene, bounces: int) -> Images:
    """TE = ρ L times the form factor."""
    receiver, lamp = scene.surfaces
    assert isinstance(receiver.shape, Quad)
    assert isinstance(lamp.shape, Quad)
    assert lamp.emission is not None
    assert isinstance(scene.sensor, Orthographic)
    images = np.zeros((bounces + 1, *scene.shape))
    if bounces:
        factor = exchange_per_pixel(scene.sensor, receiver.shape, lamp.shape)
        images[1] = factor[..., None] * _albedo(receiver) * lamp.emission.diffuse_radiance
    return images


def _floor_radiance(scene: Scene) -> Array:
    """b = (ρ/π) E cos θ, of the floor after one bounce, ``(channels,)``."""
    floor, [light] = scene.surfaces[1], scene.lights
    assert isinstance(floor.shape, Quad)
    assert isinstance(light, DirectionalLight)
    cosine = -floor.shape.normal @ np.array(light.direction)
    b: Array = _albedo(floor) / np.pi * light.irradiance * cosine
    return b


def _by_reflection(scene: Scene, bounces: int) -> Images:
    """T²E = ρ b times the form factor."""
    _up_to_three(bounces)
    wall, floor, *_ = scene.surfaces
    assert isinstance(wall.shape, Quad)
    assert isinstance(floor.shape, Quad)
    assert isinstance(scene.sensor, Orthographic)
    images = np.zeros((bounces + 1, *scene.shape))
    if bounces >= 2:
        factor = exchange_per_pixel(scene.sensor, wall.shape, floor.shape)
        images[2] = factor[..., None] * _albedo(wall) * _floor_radiance(scene)
    return images


def _by_reflection_obstructed(scene: Scene, bounces: int) -> Images:
    """T²E = (ρ/π) × irradiance by what of the floor is seen over the far edge of the shelf."""
    _up_to_three(bounces)
    wall, floor, shelf = scene.surfaces
    assert isinstance(floor.shape, Quad)
    assert isinstance(shelf.shape, Quad)
    assert isinstance(scene.sensor, Orthographic)
    [corners], [edges] = polygons(floor.shape), polygons(shelf.shape)
    near, far = edges[:2], edges[2:]
    outward, b = np.array(shelf.shape.edge_v)[:, None], _floor_radiance(scene)

    def radiance(o: Array, d: Array) -> Array:
        x, n = hit(wall.shape, o, d)

        def beyond(edge: Array) -> Array:
            """The normal of the plane through the point and an edge of the shelf, pointing away from the wall."""
            across = np.cross((edge[1] - edge[0])[:, None], x - edge[0][:, None], axis=0)
            away: Array = across * np.sign((outward * across).sum(axis=0))
            return away

        if not (np.einsum("kin,in->kn", corners[..., None] - x, beyond(near)) > 0).all():
            raise ValueError("expected a shelf whose near edge lies before the whole floor")
        seen = clipped(np.broadcast_to(corners[..., None], (4, *x.shape)), x, beyond(far))
        return np.outer(_albedo(wall) / np.pi * b, polygon_irradiance(seen, x, n[:, 0]))

    images = np.zeros((bounces + 1, *scene.shape))
    if bounces >= 2:
        images[2] = pixel_average(scene.sensor, radiance)
    return images


def _up_to_three(bounces: int) -> None:
    if bounces > 3:
        raise ValueError(f"bounces = {bounces}: expected at most 3, there is no closed form beyond")


# ---- scenes


def _rectangles(
    name: str,
    title: str,
    surfaces: tuple[Surface, ...],
    sensor: Orthographic,
    derivation: str,
    *,
    lights: tuple[DirectionalLight, ...] = (),
    evaluate: Callable[[Scene, int], Images] = _facing_lamp,
    source: str = _SOURCE,
) -> Case:
    return Case(
        name=name,
        family="rectangles",
        title=title,
        scene=Scene(surfaces, sensor, lights),
        answer=Formula(evaluate, source),
        bounces=3 if lights else 2,
        tolerance=TOLERANCE,
        derivation=derivation,
        blind_to="directions of reflection other than the camera's: every surface is Lambertian",
        max_bounces=3 if lights else None,
    )


_FACTOR = """\
Camera rays meet the receiver at right angles, so a pixel is a rectangle on it. Its mean irradiance by a lamp of
radiance L is πL F, with the form factor F = (1/A) ∫∫ cos θ cos θ′ / πd² dA dA′ between {} rectangles, a
fourfold alternating sum of an elementary function of their corners; TE = ρ L F."""


def parallel_rectangles() -> Case:
    """A receiver under a smaller lamp; the camera is between the two."""
    receiver = Quad((-1.0, 0.0, 1.0), (2.0, 0.0, 0.0), (0.0, 0.0, -2.0))
    lamp = Quad((-0.9, 1.1, -0.3), (1.3, 0.0, 0.0), (0.0, 0.0, 0.8))
    return _rectangles(
        "parallel-rectangles",
        "A rectangle under a parallel one: form factors per pixel",
        (
            Surface("floor", receiver, Lambertian((0.7, 0.5, 0.9))),
            Surface("lamp", lamp, BLACK, AreaLight((3.0, 5.0, 2.0))),
        ),
        Orthographic((0.0, 0.9, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), 2.0, 64, 64),
        f"{_FACTOR.format('parallel')}\n\n{DIRECT}",
    )


def perpendicular_rectangles() -> Case:
    """A receiver that meets the lamp in an edge."""
    receiver = Quad((0.0, 0.0, 1.0), (1.5, 0.0, 0.0), (0.0, 0.0, -1.5))
    lamp = Quad((0.0, 0.0, 1.0), (0.0, 0.0, -1.1), (0.0, 0.8, 0.0))
    return _rectangles(
        "perpendicular-rectangles",
        "A rectangle that meets a perpendicular one in an edge: form factors per pixel",
        (
            Surface("floor", receiver, Lambertian((0.7, 0.5, 0.9))),
            Surface("lamp", lamp, BLACK, AreaLight((3.0, 5.0, 2.0))),
        ),
        Orthographic((0.75, 2.0, 0.25), (0.75, 0.0, 0.25), (0.0, 0.0, -1.0), 1.5, 64, 64),
        f"{_FACTOR.format('perpendicular')}\n\n{DIRECT}",
    )


_LIT = (
    Surface("wall", Quad((0.0, 0.0, 0.4), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0)), Lambertian((0.6, 0.9, 0.75))),
    Surface("floor", Quad((0.5, 0.0, 1.0), (1.5, 0.0, 0.0), (0.0, 0.0, -1.8)), Lambertian((0.9, 0.5, 0.7))),
)
_SUN = DirectionalLight((0.35, -1.0, 0.1), (20.0, 30.0, 25.0))


def wall_by_reflection() -> Case:
    """A floor in parallel light lights a wall that the light itself does not reach."""
    return _rectangles(
        "wall-by-reflection",
        "A wall that is lit by a sunlit floor alone: the second bounce",
        _LIT,
        Orthographic((3.0, 0.5, -0.1), (0.0, 0.5, -0.1), (0.0, 1.0, 0.0), 1.0, 64, 64),
        _REFLECTED.format("ρ b F with the form factor F between a pixel on the wall and the floor"),
        lights=(_SUN,),
        evaluate=_by_reflection,
        source=f"{_AFTER_CIE.format('5.6')}; {_SOURCE}",
    )


def wall_behind_a_shelf() -> Case:
    """The same with a shelf that hides a part of the floor from every point in view."""
    shelf = Quad((0.02, 0.4, 4.0), (0.0, 0.0, -8.0), (0.28, 0.0, 0.0))
    return _rectangles(
        "wall-behind-a-shelf",
        "The second bounce on a wall, half hidden by a shelf",
        (*_LIT, Surface("shelf", shelf, BLACK)),
        Orthographic((3.0, 0.7, -0.05), (0.0, 0.7, -0.05), (0.0, 1.0, 0.0), 0.3, 64, 64),
        _REFLECTED.format(
            "(ρ/π) × irradiance by the part of the floor beyond the plane through the point and the far edge of the "
            "shelf (Lambert's formula)"
        )
        + " The shelf is black, and its shadow falls before the floor.",
        lights=(_SUN,),
        evaluate=_by_reflection_obstructed,
        source=f"{_AFTER_CIE.format('5.7')}; Lambert 1760, Photometria",
    )


CASES: Mapping[str, Callable[[], Case]] = {
    "parallel-rectangles": parallel_rectangles,
    "perpendicular-rectangles": perpendicular_rectangles,
    "wall-by-reflection": wall_by_reflection,
    "wall-behind-a-shelf": wall_behind_a_shelf,
}
