"""The room of ``cie_171``: 4 m × 4 m, 3 m high, and a camera that sees the whole of its floor and of one wall.

The camera is orthographic and looks slantwise down at the floor, x along the image, and at the wall z = 0: a pixel is
a rectangle on the floor, on the wall, or one on each. Its rays start inside the room, in the plane that joins the far
edge of the floor to the top of the wall. The image is 5 m high, 4 m · 0.8 of floor and 3 m · 0.6 of wall.
"""

from __future__ import annotations

import numpy as np

from scenes.materials import Lambertian
from scenes.sensor import Orthographic
from scenes.shapes import Quad
from scenes.surfaces import Surface, box

SIDE, HEIGHT = 4.0, 3.0

FLOOR_COSINE, WALL_COSINE = 0.8, 0.6
"""Of the angles between the camera's rays and the normals of the two."""

_BLACK = Lambertian((0.0, 0.0, 0.0))
_FACTORS = np.array([1.0, 0.5, 0.25])
"""Of the albedos of red, green and blue, so that channels are not all the same."""


def view(x: float, above: float, across: float, width: int, height: int) -> Orthographic:
    """The camera, or a part of its image.

    Args:
        x, above: the middle of the image: along x, and above the edge in which floor and wall meet, both as they
            appear in the image, m. The floor ends at −3.2, the wall at 1.8.
        across: what the image shows along x, m; its height follows.
        width, height: pixels, width ≤ height.
    """
    back = np.array([0.0, FLOOR_COSINE, WALL_COSINE])  # to the camera
    target = np.array([x, WALL_COSINE * above, -FLOOR_COSINE * above])
    origin = target + SIDE * WALL_COSINE * back
    return Orthographic(
        tuple(origin.tolist()), tuple(target.tolist()), (0.0, 1.0, 0.0), across, width, height
    )


def whole_view() -> Orthographic:
    """Every point of the floor and of the wall, and nothing else: 4 m × 5 m."""
    return view(SIDE / 2, -0.7, SIDE, 64, 80)


def room(floor: float, wall: float, hole: Quad | None = None) -> tuple[Surface, ...]:
    """``floor`` and ``wall``, and the rest in black: three walls and the ceiling, with or without a hole.

    Args:
        floor, wall: albedos of the red channel; green has half of them, blue a quarter.
        hole: in the ceiling, edges along x and z.
    """
    half = ((SIDE / 2, 0.0, 0.0), (0.0, HEIGHT / 2, 0.0), (0.0, 0.0, SIDE / 2))
    middle = (SIDE / 2, HEIGHT / 2, SIDE / 2)
    left, right, bottom, top, back, front = box("room", middle, half, _BLACK, inward=True)
    lit = (Surface("floor", bottom.shape, _grey(floor)), Surface("wall", back.shape, _grey(wall)))
    return *lit, left, right, front, *((top,) if hole is None else _around(hole))


def square_of_ceiling(side: float) -> Quad:
    """In its middle, facing down."""
    low = (SIDE - side) / 2
    return Quad((low, HEIGHT, low), (side, 0.0, 0.0), (0.0, 0.0, side))


def hole_of(surfaces: tuple[Surface, ...]) -> Quad:
    """The hole in the ceiling of a room, facing down."""
    shapes = {surface.name: surface.shape for surface in surfaces}
    back, front = shapes["ceiling.back"], shapes["ceiling.front"]
    assert isinstance(back, Quad)
    assert isinstance(front, Quad)
    corner = np.add(back.corner, back.edge_v)
    return Quad(tuple(corner.tolist()), back.edge_u, tuple((np.array(front.corner) - corner).tolist()))


def _grey(albedo: float) -> Lambertian:
    return Lambertian(tuple((albedo * _FACTORS).tolist()))


def _around(hole: Quad) -> tuple[Surface, ...]:
    """The ceiling in four strips that face down."""
    (x0, _, z0), (x1, _, z1) = hole.corner, np.add(np.add(hole.corner, hole.edge_u), hole.edge_v).tolist()

    def strip(name: str, x: tuple[float, float], z: tuple[float, float]) -> Surface:
        edges = (x[1] - x[0], 0.0, 0.0), (0.0, 0.0, z[1] - z[0])
        return Surface(f"ceiling.{name}", Quad((x[0], HEIGHT, z[0]), *edges), _BLACK)

    return (
        strip("left", (0.0, x0), (0.0, SIDE)),
        strip("right", (x1, SIDE), (0.0, SIDE)),
        strip("back", (x0, x1), (0.0, z0)),
        strip("front", (x0, x1), (z1, SIDE)),
    )
