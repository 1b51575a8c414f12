"""A room lit only around the corner: nothing arrives in view before bounce 3."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise

from scenes.case import Case, Computed, Tolerance
from scenes.lights import AreaLight
from scenes.materials import Lambertian
from scenes.scene import Scene
from scenes.sensor import Pinhole
from scenes.shapes import Quad
from scenes.surfaces import Surface

# the floor plan, counterclockwise: the walls and where each begins
#
#   (0, 2.7) far (1, 2.7)
#     |            |            (1.6, 2) niche (2.6, 2)
#   outer        inner              |lamp>       |
#     |            |                |            |
#     |          (1, 1) corridor (1.6, 1)       end
#     |                                          |
#   (0, 0) ---------------- front ---------- (2.6, 0)
_PLAN = {
    "front": (0.0, 0.0),
    "end": (2.6, 0.0),
    "niche": (2.6, 2.0),
    "lamp": (1.6, 2.0),
    "corridor": (1.6, 1.0),
    "inner": (1.0, 1.0),
    "far": (1.0, 2.7),
    "outer": (0.0, 2.7),
}
_ALBEDO = {
    "front": (0.7, 0.8, 0.6),
    "end": (0.8, 0.7, 0.75),
    "niche": (0.7, 0.7, 0.7),
    "lamp": (0.5, 0.5, 0.5),
    "corridor": (0.7, 0.8, 0.5),
    "inner": (0.7, 0.5, 0.4),
    "far": (0.4, 0.6, 0.8),
    "outer": (0.8, 0.8, 0.7),
    "floor": (0.7, 0.7, 0.7),
    "ceiling": (0.8, 0.8, 0.8),
}
_PARTS = {
    "corner": ((0.0, 0.0), (1.0, 1.0)),
    "corridor": ((1.0, 0.0), (0.6, 1.0)),
    "end": ((1.6, 0.0), (1.0, 2.0)),
    "leg": ((0.0, 1.0), (1.0, 1.7)),
}
"""Of floor and ceiling: corner, extent."""

# mesh lines: where surfaces meet other ones along their edges, where the light of the lamp's part of the room ends,
# and about what the camera sees, so that no polynomial there has a share in light elsewhere
_LEG = ((0.3, 0.65), (0.35, 1.2 / 1.7))
_SPLITS = {
    "front": ((), (1 / 2.6, 1.6 / 2.6)),
    "end": ((), (0.5,)),
    "inner": ((), (0.35, 1.2 / 1.7)),
    "outer": ((), tuple(1 - y / 2.7 for y in (8 / 3, 2.1, 1.625, 1.0))),
    "floor-leg": _LEG,
    "ceiling-leg": _LEG[::-1],
    "floor-corner": ((0.5,), (0.5,)),
    "ceiling-corner": ((0.5,), (0.5,)),
    "floor-end": ((0.5,), (0.25, 0.5)),
    "ceiling-end": ((0.25, 0.5), (0.5,)),
}

_DERIVATION = """\
The lamp faces the end of the room and lights that part alone: x > 1.6, which is convex. What is seen, the inner and
the far wall and the ends of floor and ceiling between them, has no line of sight to that part: such a line would
have to pass the edge at (1, 1) and the plane x = 1.6 below y = 1, and ends at most at (1.6, 0). So E, TE and T²E
are 0 in every pixel, and T³E is the first light. No closed form is known; every TᵏE was computed by finite elements
(reference_tracer/finite_elements.py), its mesh cut where shadows end. The error is what a solution of lower order on
a coarser mesh is off by: the root mean square of its pixels, relative to the mean of the image.
The reference tracer can't be held to ±0.2 % here: few paths from what is seen find the lamp behind two corners. Some
1.6 million of them resolve 10 % of T³E, so that ±0.2 % would take four thousand million. Hence the wide tolerance."""


def around_the_corner() -> Case:
    """An L-shaped room of height 1 with a niche, in which a lamp faces away from what is seen."""
    return Case(
        name="around-the-corner",
        family="around_the_corner",
        title="An L-shaped room lit around its corner: nothing arrives in view before bounce 3",
        scene=_scene(),
        answer=Computed("around-the-corner.exr", order=4, levels=0, splits=_SPLITS),
        bounces=5,
        tolerance=Tolerance(image=(0.03,), tile=(0.15,)),
        derivation=_DERIVATION,
        blind_to="bounces 1 and 2 other than that nothing arrives; specular reflection; emitters that are no area",
    )


def _scene() -> Scene:
    lamp = AreaLight((100.0, 80.0, 60.0))
    surfaces = []
    corners = [*_PLAN.values(), (0.0, 0.0)]
    for name, (p, q) in zip(_PLAN, pairwise(corners), strict=True):
        wall = Quad((*p, 0.0), (0.0, 0.0, 1.0), (q[0] - p[0], q[1] - p[1], 0.0))
        surfaces.append(Surface(name, wall, _lambertian(name), lamp if name == "lamp" else None))
    for name, ((x, y), (w, h)) in _PARTS.items():
        floor = Quad((x, y, 0.0), (w, 0.0, 0.0), (0.0, h, 0.0))
        ceiling = Quad((x, y, 1.0), (0.0, h, 0.0), (w, 0.0, 0.0))
        surfaces.append(Surface(f"floor-{name}", floor, _lambertian("floor")))
        surfaces.append(Surface(f"ceiling-{name}", ceiling, _lambertian("ceiling")))
    camera = Pinhole((0.3, 1.65, 0.45), (0.738, 2.549, 0.47), (0.0, 0.0, 1.0), 50.0, 64, 64)
    return Scene(tuple(surfaces), camera)


def _lambertian(name: str) -> Lambertian:
    return Lambertian(_ALBEDO[name])


CASES: Mapping[str, Callable[[], Case]] = {"around-the-corner": around_the_corner}
