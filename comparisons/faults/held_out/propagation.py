"""Faults of G, held out: surfaces that some rays pass, shapes that are met as others, and normals."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Fault
from comparisons.faults.planting import Replacement, in_tracer
from comparisons.faults.rays import LAYERS
from comparisons.faults.scene_changes import of_surfaces, replace
from reference_tracer import propagation
from reference_tracer.points import NOWHERE, Points
from reference_tracer.propagation import RayCaster
from reference_tracer.shapes.coordinates import Coordinates
from reference_tracer.shapes.hierarchy import Hierarchy
from reference_tracer.shapes.intersection import Ellipsoids, keep_nearer
from reference_tracer.vectors import dot, norm
from scenes import Disk, Mesh, Scene, Surface
from scenes.materials import is_textured

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]
Method = Callable[..., Any]

FACETS = 24
"""Of the polygon that stands for a disk."""

STEPS = 16
"""Of the grid over a node of the hierarchy, to which the boxes of its children are rounded."""

FARTHEST = 1000.0
"""Distance of hits that are looked for, in the units of the scene."""

# ---- rays that pass what should stop them


def _visible_past(passes: Callable[[Points, Points, Array], Mask]) -> Replacement:
    """Shadow rays pass some hits: a function of the points they start from, of the hits, and of the directions."""

    def made_of(visible: Method) -> Method:
        def passing(self: RayCaster, origin: Points, d: Array, distance: Array, target: Indices) -> Mask:
            seen: Mask = visible(self, origin, d, distance, target)
            lanes, passed = np.flatnonzero(~seen), np.zeros(len(origin))
            start = origin[lanes]
            for _ in range(LAYERS):
                if not len(lanes):
                    break
                t, primitive = propagation._nearest(self._occluders, start, d[:, lanes])
                hits = self._coordinates.points(start.x + t * d[:, lanes], d[:, lanes], primitive)
                through = np.flatnonzero(passes(origin[lanes], hits, d[:, lanes]))
                lanes, start = lanes[through], hits[through]
                passed[lanes] += t[through]
                now = visible(self, start, d[:, lanes], distance[lanes] - passed[lanes], target[lanes])
                seen[lanes] = now
                hidden = np.flatnonzero(~now)
                lanes, start = lanes[hidden], start[hidden]
            return seen

        return passing

    return Replacement(RayCaster, "visible", made_of)


def _from_the_front(origin: Points, hits: Points, d: Array) -> Mask:
    front: Mask = dot(hits.n, d) < 0
    return front


def _on_its_own_surface(origin: Points, hits: Points, d: Array) -> Mask:
    own: Mask = (hits.surface == origin.surface) & (origin.surface != NOWHERE)
    return own


def _past_its_own_surface(cast: Method) -> Method:
    def passing(self: RayCaster, origin: Points, d: Array) -> Points:
        points: Points = cast(self, origin, d)
        for _ in range(LAYERS):
            lanes = np.flatnonzero(_on_its_own_surface(origin, points, d))
            if not len(lanes):
                break
            beyond = cast(self, points[lanes], d[:, lanes])
            for field, values in vars(beyond).items():
                if values is not None:
                    getattr(points, field)[..., lanes] = values
        return points

    return passing


def _without_lamps(occluders: Method) -> Method:
    def chosen(primitives: Any, scene: Scene) -> Indices:
        indices: Indices = occluders(primitives, scene)
        emits = np.array([surface.emits for surface in scene.surfaces], dtype=bool)
        dark: Indices = indices[~emits[primitives.surface[indices]]]
        return dark

    return chosen


def _not_too_far(nearest: Method) -> Method:
    def within(shapes: Any, origin: Points, d: Array) -> tuple[Array, Indices]:
        t, primitive = nearest(shapes, origin, d)
        beyond = t > FARTHEST
        t[beyond], primitive[beyond] = np.inf, NOWHERE
        return t, primitive

    return within


# ---- shapes


def _first_root_alone(meet: Method) -> Method:
    """A ray that starts inside of a sphere, or on it, has its nearer root behind it, and the other is forgotten."""

    def met(self: Ellipsoids, x: Array, d: Array, start: Indices, t: Array, primitive: Indices) -> None:
        near, which = np.full(len(t), np.inf), np.full(len(t), NOWHERE)
        meet(self, x, d, start, near, which)
        for i, index in enumerate(self._primitives):
            o = self._rows[:, i] @ x + self._offsets[:, i]
            near[(which == index) & ((dot(o, o) < 1) | (start == index))] = np.inf
        keep_nearer(t, primitive, near, which)

    return met


def _polygon(surface: Surface) -> Surface:
    disk = surface.shape
    if not isinstance(disk, Disk) or is_textured(surface.material):
        return surface
    angles = 2 * np.pi * np.arange(FACETS) / FACETS
    rim = np.outer(np.cos(angles), disk.axis_u) + np.outer(np.sin(angles), disk.axis_v) + disk.center
    triangles = tuple((0, 1 + i, 1 + (i + 1) % FACETS) for i in range(FACETS))
    vertices = (disk.center, *((float(x), float(y), float(z)) for x, y, z in rim))
    return replace(surface, shape=Mesh(vertices=vertices, triangles=triangles))


def _rounded_boxes(init: Method) -> Method:
    """Boxes of children take few bits, and are rounded to the nearest of them instead of outwards."""

    def made(self: Hierarchy, *of: Any) -> None:
        init(self, *of)
        low, high = self._low.min(axis=1, keepdims=True), self._high.max(axis=1, keepdims=True)
        step = np.maximum(high - low, 1e-300) / STEPS
        self._low, self._high = (
            low + np.round((side - low) / step) * step for side in (self._low, self._high)
        )

    return made


# ---- normals


def _not_normalised(shading_normals: Method) -> Method:
    """The sum of a triangle's three normals is used as it is."""

    def shorter(self: Coordinates, points: Points) -> Array:
        ns: Array = shading_normals(self, points)
        for i in self._smooth:
            lanes = np.flatnonzero(points.surface == i)
            if len(lanes):
                mesh: Any = self._surfaces[i].shape
                ns[:, lanes] *= norm(self._interpolate(np.array(mesh.normals), mesh, int(i), points[lanes]))
        return ns

    return shorter


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="spheres-open-from-inside",
        operator="G",
        what="rays that start inside of a sphere do not meet it: of the two roots only the nearer is looked at",
        plant=in_tracer(Replacement(Ellipsoids, "meet", _first_root_alone)),
        happened=("https://github.com/turanszkij/WickedEngine/issues/1695",),
    ),
    Fault(
        name="disks-of-24-facets",
        operator="G",
        what="disks are polygons of 24 sides whose corners lie on the rim",
        plant=of_surfaces(_polygon),
    ),
    Fault(
        name="hierarchy-boxes-rounded",
        operator="G",
        what="the boxes of the hierarchy are rounded to nearest, not outwards: some end within their shapes",
        plant=in_tracer(Replacement(Hierarchy, "__init__", _rounded_boxes)),
    ),
    Fault(
        name="lamps-cast-no-shadow",
        operator="G",
        what="shadow rays pass through all that emits",
        plant=in_tracer(Replacement(propagation, "_occluders", _without_lamps)),
    ),
    Fault(
        name="shadow-rays-pass-fronts",
        operator="G",
        what="shadow rays are stopped by backs alone, as if fronts were culled against shadow acne",
        plant=in_tracer(_visible_past(_from_the_front)),
    ),
    Fault(
        name="own-surface-skipped",
        operator="G",
        what="no ray meets the surface that it starts on, not even elsewhere on it",
        plant=in_tracer(
            Replacement(RayCaster, "__call__", _past_its_own_surface), _visible_past(_on_its_own_surface)
        ),
    ),
    Fault(
        name="rays-end-at-1000",
        operator="G",
        what="what is farther away than 1000 is not met, however large the scene is",
        plant=in_tracer(Replacement(propagation, "_nearest", _not_too_far)),
    ),
    Fault(
        name="shading-normals-not-normalised",
        operator="G",
        what="interpolated normals are not made unit vectors again",
        plant=in_tracer(Replacement(Coordinates, "_shading_normals", _not_normalised)),
        happened=("https://github.com/KhronosGroup/glTF-Sample-Viewer/pull/69",),
    ),
)
