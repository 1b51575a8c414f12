"""The Cornell box with its two blocks, in the geometry, colours and camera of Mitsuba 3's ``mi.cornell_box()``."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from scenes.case import Case, Estimate, Tolerance
from scenes.lights import AreaLight
from scenes.materials import Lambertian
from scenes.scene import Scene
from scenes.sensor import Pinhole
from scenes.shapes import Quad
from scenes.surfaces import Surface, box
from scenes.validation import Vector

# measured data: Cornell University Program of Computer Graphics, as converted to RGB in Mitsuba 3
_WHITE = Lambertian((0.885809, 0.698859, 0.666422))
_GREEN = Lambertian((0.105421, 0.37798, 0.076425))
_RED = Lambertian((0.570068, 0.0430135, 0.0443706))
_LAMP = AreaLight((18.387, 13.9873, 6.75357))

_SENSOR = Pinhole((0.0, 0.0, 3.9), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 39.3077, 64, 64)

_DERIVATION = """\
No closed form is known. The truth was estimated by the reference tracer with multiple importance sampling and
is committed with its standard error, which every verdict counts. An estimate can't judge the estimator that
made it: the reference tracer is held against it with another strategy, next-event estimation alone, which
tests one strategy against the other and nothing else.

The reference tracer is not held to ±0.2 % at every bounce, since few paths carry the later ones: 860 samples per
pixel resolve 1.1, 0.14, 0.6, 1.1, 0.9 and 1.5 % of E to T⁵E, so that ±0.2 % would take fifty thousand."""


def _wall(name: str, corner: Vector, edge_u: Vector, edge_v: Vector, material: Lambertian) -> Surface:
    return Surface(name, Quad(corner, edge_u, edge_v), material)


def _walls() -> tuple[Surface, ...]:
    """Floor, ceiling, back, and the coloured sides; the front is open."""
    return (
        _wall("floor", (-1.0, -1.0, 1.0), (2.0, 0.0, 0.0), (0.0, 0.0, -2.0), _WHITE),
        _wall("ceiling", (-1.0, 1.0, -1.0), (2.0, 0.0, 0.0), (0.0, 0.0, 2.0), _WHITE),
        _wall("back", (-1.0, -1.0, -1.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0), _WHITE),
        _wall("green-wall", (1.0, -1.0, -1.0), (0.0, 0.0, 2.0), (0.0, 2.0, 0.0), _GREEN),
        _wall("red-wall", (-1.0, -1.0, 1.0), (0.0, 0.0, -2.0), (0.0, 2.0, 0.0), _RED),
    )


def _block(name: str, center: Vector, half: Vector, degrees: float) -> tuple[Surface, ...]:
    """A box turned about the y axis by ``degrees``, counterclockwise seen from above."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    x, y, z = half
    axes = ((x * c, 0.0, -x * s), (0.0, y, 0.0), (z * s, 0.0, z * c))
    return box(name, center, axes, _WHITE)


def _lying(name: str, x: tuple[float, float], z: tuple[float, float], **light: AreaLight) -> Surface:
    """A part of the ceiling, facing down: the rectangle x[0] ≤ x ≤ x[1], z[0] ≤ z ≤ z[1] at y = 1."""
    shape = Quad((x[0], 1.0, z[0]), (x[1] - x[0], 0.0, 0.0), (0.0, 0.0, z[1] - z[0]))
    return Surface(name, shape, _WHITE, light.get("emission"))


def empty_box() -> Scene:
    """The same walls without the blocks, the lamp flush in a hole of the ceiling: a convex scene.

    No surface hides another and none overlaps, so that its light can be computed without visibility.
    """
    surfaces = (
        _lying("lamp", (-0.23, 0.23), (-0.18, 0.2), emission=_LAMP),
        _lying("ceiling-left", (-1.0, -0.23), (-1.0, 1.0)),
        _lying("ceiling-right", (0.23, 1.0), (-1.0, 1.0)),
        _lying("ceiling-back", (-0.23, 0.23), (-1.0, -0.18)),
        _lying("ceiling-front", (-0.23, 0.23), (0.2, 1.0)),
        *(wall for wall in _walls() if wall.name != "ceiling"),
    )
    return Scene(surfaces, _SENSOR)


def cornell_box() -> Case:
    """Five walls, open to the front, a lamp 0.01 below the ceiling, two blocks."""
    surfaces = (
        Surface("lamp", Quad((-0.23, 0.99, -0.18), (0.46, 0.0, 0.0), (0.0, 0.0, 0.38)), _WHITE, _LAMP),
        *_walls(),
        *_block("small-block", (0.335, -0.7, 0.38), (0.3, 0.3, 0.3), -17.0),
        *_block("large-block", (-0.33, -0.4, -0.28), (0.3, 0.61, 0.3), 18.25),
    )
    image = (0.005, 0.005, 0.01, 0.02)
    return Case(
        name="cornell-box",
        family="cornell_box",
        title="The Cornell box of Mitsuba 3, all diffuse",
        scene=Scene(surfaces, _SENSOR),
        answer=Estimate(file="cornell-box.exr"),
        bounces=5,
        tolerance=Tolerance(image=image, tile=tuple(5 * t for t in image)),
        derivation=_DERIVATION,
        blind_to="an error that the reference tracer shares",
    )


CASES: Mapping[str, Callable[[], Case]] = {"cornell-box": cornell_box}
