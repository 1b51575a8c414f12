"""Faults of G: where rays start, what they meet, and what a shadow ray takes to be in its way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.faults import rays
from comparisons.faults.fault import Fault, Plant
from comparisons.faults.planting import Replacement, in_tracer
from reference_tracer import propagation
from reference_tracer.emission import Emitters
from reference_tracer.points import NOWHERE, Points
from reference_tracer.propagation import RayCaster
from reference_tracer.shapes import parallelepipeds
from reference_tracer.shapes.coordinates import Coordinates
from reference_tracer.shapes.hierarchy import Hierarchy
from reference_tracer.shapes.intersection import Ellipsoids, keep_nearer
from reference_tracer.vectors import dot, unit
from scenes import Disk, Mesh, Quad, Sphere

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Method = Callable[..., Any]

OFFSET = 5e-4
"""Of the start of rays, in the units of the scene: what suits a room in metres."""

LEAST = 1e-3
"""Distance of hits that are believed, in the units of the scene."""

# ---- where rays start


def _lifted(origin: Points, d: Array) -> Points:
    side = np.sign(dot(origin.n, d))
    return _anywhere(origin, origin.x + OFFSET * side * (origin.surface != NOWHERE) * origin.n)


def _lifted_outwards(origin: Points, d: Array) -> Points:
    return _anywhere(origin, origin.x + OFFSET * (origin.surface != NOWHERE) * origin.n)


def _anywhere(origin: Points, x: Array) -> Points:
    """Points that do not know any more which surface they are on."""
    return replace(origin, x=x, primitive=np.full(len(origin), NOWHERE))


def _start(change: Callable[[Points, Array], Points], *, shadows_alone: bool = False) -> Plant:
    """Rays start elsewhere."""
    shadow = Replacement(
        RayCaster,
        "visible",
        lambda visible: lambda self, origin, d, *rest: visible(self, change(origin, d), d, *rest),
    )
    if shadows_alone:
        return in_tracer(shadow, Replacement(propagation, "_occluders", lambda occluders: _everything))
    ray = Replacement(
        RayCaster, "__call__", lambda cast: lambda self, origin, d: cast(self, change(origin, d), d)
    )
    return in_tracer(ray, shadow)


def _everything(primitives: Any, scene: Any) -> NDArray[np.intp]:
    return np.arange(len(primitives))


# ---- which hit counts


def _not_too_near(nearest: Method) -> Method:
    def beyond(shapes: Any, origin: Points, d: Array) -> tuple[Array, NDArray[np.intp]]:
        t, primitive = nearest(shapes, _anywhere(origin, origin.x + LEAST * d), d)
        return t + LEAST, primitive

    return beyond


def _one_in_200_lost(cast: Method) -> Method:
    """As a traversal loses rays whose stack is full: the direction says which, so that no number is drawn."""

    def losing(self: RayCaster, origin: Points, d: Array) -> Points:
        points: Points = cast(self, origin, d)
        lost = (origin.surface != NOWHERE) & (np.modf(np.abs(d[0]) * 1e6)[0] < 1 / 200)
        for field, value in (("surface", NOWHERE), ("primitive", NOWHERE)):
            getattr(points, field)[lost] = value
        return points

    return losing


# ---- shapes


def _far_root(meet: Method) -> Method:
    """A ray that enters an ellipsoid goes on to where it leaves."""

    def met(self: Ellipsoids, x: Array, d: Array, start: Any, t: Array, primitive: Any) -> None:
        near, which = np.full(len(t), np.inf), np.full(len(t), NOWHERE)
        meet(self, x, d, start, near, which)
        lanes = np.flatnonzero(which != NOWHERE)
        rest, then = np.full(len(lanes), np.inf), np.full(len(lanes), NOWHERE)
        meet(self, x[:, lanes] + near[lanes] * d[:, lanes], d[:, lanes], which[lanes], rest, then)
        near[lanes] += np.where(then == which[lanes], rest, 0)
        keep_nearer(t, primitive, near, which)

    return met


def _object_space_distance(meet: Method) -> Method:
    """The direction is made a unit vector in the frame of the unit sphere, where t then counts."""

    def met(self: Ellipsoids, x: Array, d: Array, start: Any, t: Array, primitive: Any) -> None:
        near, which = np.full(len(t), np.inf), np.full(len(t), NOWHERE)
        meet(self, x, d, start, near, which)
        for i, index in enumerate(self._primitives):
            here = which == index
            near[here] *= np.linalg.norm(self._rows[:, i] @ d[:, here], axis=0)
        keep_nearer(t, primitive, near, which)

    return met


def _normal_as_a_direction(on_ellipsoid: Method) -> Method:
    """Normals are mapped as directions are, by M instead of M⁻ᵀ."""

    def mapped(self: Coordinates, i: int, x: Array) -> tuple[Array, Array]:
        x, n = on_ellipsoid(self, i, x)
        outward = unit(self._p.axes[i].T @ (self._inverse[i].T @ (x - self._p.center[i, :, None])))
        return x, outward * np.sign(dot(outward, n))

    return mapped


def _last_child_lost(init: Method) -> Method:
    def made(self: Hierarchy, *of: Any) -> None:
        init(self, *of)
        if len(self._children) > 1:
            self._children.pop()
            self._low, self._high = self._low[:, :-1], self._high[:, :-1]

    return made


def _in_the_bounding_disk(a: Array, b: Array) -> Array:
    excess: Array = a * a + b * b - 2
    return excess


def _in_the_first_triangle(a: Array, b: Array) -> Array:
    excess: Array = np.maximum(np.maximum(np.abs(a), np.abs(b)) - 1, a + b)
    return excess


def _quads(excess: Callable[[Array, Array], Array]) -> Plant:
    """Quads are another shape; none is met as a face of a box."""
    return in_tracer(
        Replacement(propagation, "quad_excess", lambda right: excess),
        Replacement(parallelepipeds, "find", lambda find: lambda centers, axes: []),
    )


def _interpolated(points: Method) -> Method:
    def met(self: Coordinates, x: Array, d: Array, primitive: Any) -> Points:
        found: Points = points(self, x, d, primitive)
        return replace(found, n=found.ns)

    return met


# ---- shadow rays


def _occluding(keep: Callable[[Any, NDArray[np.intp]], Any]) -> Plant:
    """Not all that is in the way of a shadow ray is looked at: ``keep(primitives, indices)`` chooses."""

    def changed(occluders: Method) -> Method:
        def chosen(primitives: Any, scene: Any) -> NDArray[np.intp]:
            indices = occluders(primitives, scene)
            kept: NDArray[np.intp] = indices[keep(primitives, indices)]
            return kept

        return chosen

    return in_tracer(Replacement(propagation, "_occluders", changed))


def _but(kind: type) -> Callable[[Any, NDArray[np.intp]], Any]:
    return lambda primitives, indices: primitives.kind[indices] != kind


def _shadow_length(change: Callable[[RayCaster, Array], Array]) -> Plant:
    """Shadow rays end at another distance; they look at everything, as walls may now be in the way of some."""

    def changed(visible: Method) -> Method:
        return lambda self, origin, d, distance, target: visible(
            self, origin, d, change(self, distance), target
        )

    return in_tracer(
        Replacement(RayCaster, "visible", changed),
        Replacement(propagation, "_occluders", lambda occluders: _everything),
    )


def _until_the_radius(caster: RayCaster, distance: Array) -> Array:
    corners = caster._primitives.corners().reshape(-1, 3)
    radius = np.linalg.norm(np.ptp(corners, axis=0)) / 2
    return np.minimum(distance, np.where(np.isinf(distance), radius, np.inf))


# ---- rays that leave


def _nothing_outside(Le: Method) -> Method:
    return lambda self, points, wo: Le(self, points, wo) * (points.surface != NOWHERE)


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="ray-offset-large",
        operator="G",
        what="rays start 0.0005 above the surface, however small the scene is",
        plant=_start(_lifted),
        happened=("https://github.com/mitsuba-renderer/mitsuba3/pull/1962",),
    ),
    Fault(
        name="ray-offset-outward",
        operator="G",
        what="rays start 0.0005 above the front of the surface, those too that are refracted to behind it",
        plant=_start(_lifted_outwards),
    ),
    Fault(
        name="ray-offset-missing",
        operator="G",
        what="rays start on the surface, and rounding decides whether they meet it again",
        plant=_start(lambda origin, d: _anywhere(origin, origin.x)),
        happened=("https://github.com/athas/raytracers/issues/34",),
    ),
    Fault(
        name="shadow-offset-missing",
        operator="G",
        what="shadow rays start on the surface, and rounding decides whether it shadows itself",
        plant=_start(lambda origin, d: _anywhere(origin, origin.x), shadows_alone=True),
    ),
    Fault(
        name="near-hits-skipped",
        operator="G",
        what="hits nearer than 0.001 do not count, however small the scene is",
        plant=in_tracer(Replacement(propagation, "_nearest", _not_too_near)),
    ),
    Fault(
        name="farthest-hit",
        operator="G",
        what="of all that a ray meets, the farthest counts",
        plant=in_tracer(Replacement(propagation, "_nearest", rays.farthest)),
    ),
    Fault(
        name="backs-culled",
        operator="G",
        what="rays pass through surfaces that they meet from behind",
        plant=in_tracer(
            Replacement(RayCaster, "__call__", rays.through_backs),
            Replacement(RayCaster, "visible", rays.visible_through_backs),
        ),
        happened=("https://github.com/w23/xash3d-fwgs/pull/508",),
    ),
    Fault(
        name="one-ray-in-200-lost",
        operator="G",
        what="of rays that start on a surface, 0.5 % meet nothing",
        plant=in_tracer(Replacement(RayCaster, "__call__", _one_in_200_lost)),
    ),
    Fault(
        name="sphere-far-root",
        operator="G",
        what="spheres are met where the ray leaves them",
        plant=in_tracer(Replacement(Ellipsoids, "meet", _far_root)),
    ),
    Fault(
        name="sphere-distance-before-scaling",
        operator="G",
        what="distances to spheres are those in the frame in which they have the radius 1",
        plant=in_tracer(Replacement(Ellipsoids, "meet", _object_space_distance)),
        happened=("https://github.com/BabylonJS/Babylon.js/pull/1783",),
    ),
    Fault(
        name="normals-scaled-as-directions",
        operator="G",
        what="normals of stretched spheres are stretched with them",
        plant=in_tracer(Replacement(Coordinates, "_on_ellipsoid", _normal_as_a_direction)),
        happened=("https://github.com/KhronosGroup/ANARI-SDK/pull/8",),
    ),
    Fault(
        name="shading-normal-for-geometric",
        operator="G",
        what="the interpolated normal of a mesh says which side a direction is on",
        plant=in_tracer(Replacement(Coordinates, "points", _interpolated)),
        happened=("https://github.com/Unity-Technologies/Graphics/pull/2692",),
    ),
    Fault(
        name="quads-met-in-their-bounding-disk",
        operator="G",
        what="rays meet a quad anywhere in the ellipse around it",
        plant=_quads(_in_the_bounding_disk),
    ),
    Fault(
        name="second-triangle-lost",
        operator="G",
        what="of the two triangles that a quad is cut into, one is not met",
        plant=_quads(_in_the_first_triangle),
    ),
    Fault(
        name="gaps-between-triangles",
        operator="G",
        what="triangles end 0.1 % of their height before their edges, and rays pass in between",
        plant=in_tracer(
            Replacement(propagation, "triangle_excess", lambda excess: lambda a, b: excess(a, b) + 1e-3)
        ),
        happened=("https://github.com/godotengine/godot/pull/53844",),
    ),
    Fault(
        name="hierarchy-loses-a-child",
        operator="G",
        what="rays do not look into the last child of a node of the hierarchy",
        plant=in_tracer(Replacement(Hierarchy, "__init__", _last_child_lost)),
        happened=("https://github.com/Walther/clovers/issues/105",),
    ),
    Fault(
        name="shadows-of-half-the-scene",
        operator="G",
        what="shadow rays look at every other shape only",
        plant=_occluding(lambda primitives, indices: indices % 2 == 0),
    ),
    Fault(
        name="meshes-cast-no-shadow",
        operator="G",
        what="shadow rays pass through meshes",
        plant=_occluding(_but(Mesh)),
    ),
    Fault(
        name="spheres-cast-no-shadow",
        operator="G",
        what="shadow rays pass through spheres",
        plant=_occluding(_but(Sphere)),
    ),
    Fault(
        name="disks-cast-no-shadow",
        operator="G",
        what="shadow rays pass through disks",
        plant=_occluding(_but(Disk)),
    ),
    Fault(
        name="quads-cast-no-shadow",
        operator="G",
        what="shadow rays pass through quads",
        plant=_occluding(_but(Quad)),
    ),
    Fault(
        name="shadow-rays-short",
        operator="G",
        what="shadow rays end half-way to the light",
        plant=_shadow_length(lambda caster, distance: distance / 2),
    ),
    Fault(
        name="shadow-rays-of-length-1",
        operator="G",
        what="shadow rays end at a distance of 1, as if their direction reached to the light",
        plant=_shadow_length(lambda caster, distance: np.minimum(distance, 1)),
        happened=("https://github.com/szellmann/visionaray/issues/29",),
    ),
    Fault(
        name="shadow-rays-beyond-the-light",
        operator="G",
        what="what lies behind a light shadows it",
        plant=_shadow_length(lambda caster, distance: np.full_like(distance, np.inf)),
        happened=("https://github.com/nvpro-samples/vk_raytrace/issues/13",),
    ),
    Fault(
        name="sun-shadows-end",
        operator="G",
        what="shadow rays to what is infinitely far end at the radius of the scene, not at its diameter",
        plant=_shadow_length(_until_the_radius),
        happened=("https://github.com/matiaszanolli/ByroRedux/issues/102",),
    ),
    Fault(
        name="environment-unseen",
        operator="G",
        what="rays that leave the scene find nothing, though next event takes them to find the environment",
        plant=in_tracer(Replacement(Emitters, "Le", _nothing_outside)),
    ),
)
