"""G, propagation: the ray-cast function r(x, l), where the ray from x along l first meets a surface.

There is no ray offset. A ray that starts on a surface knows which: a plane is not met again, and a sphere only
at the other root of its quadratic. Scenes of any size give the same radiance.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from reference_tracer.points import NOWHERE, Points
from reference_tracer.shapes import parallelepipeds
from reference_tracer.shapes.coordinates import Coordinates
from reference_tracer.shapes.hierarchy import LEAF, Hierarchy
from reference_tracer.shapes.intersection import (
    Boxes,
    Ellipsoids,
    Flats,
    Shapes,
    disk_excess,
    quad_excess,
    triangle_excess,
)
from reference_tracer.shapes.primitives import Primitives
from scenes import Disk, Mesh, PointLight, Quad, Scene, SpotLight

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


TOUCHES = 1e-9
"""Of the distance to a light: what is nearer to it than that is what it lies on, and does not hide it. A lamp in
the plane of a ceiling would be left to rounding; to validation, too, a gap of 10⁻⁹ is none."""


LARGE_MESH = 64
"""Triangles beyond which a mesh is taken to occlude as a whole."""


class RayCaster:
    """The ray-cast function of a scene."""

    def __init__(self, scene: Scene) -> None:
        self._primitives = Primitives(scene.surfaces)
        self._coordinates = Coordinates(scene, self._primitives)
        self._all = _shapes(self._primitives, np.arange(len(self._primitives)))
        self._occluders = _shapes(self._primitives, _occluders(self._primitives, scene))

    def __call__(self, origin: Points, d: Array) -> Points:
        """r(x, d): the first points that rays meet.

        Args:
            origin: where they start, n points.
            d: unit directions, ``(3, n)``.

        Returns:
            n points, NOWHERE for rays that leave the scene.
        """
        t, primitive = _nearest(self._all, origin, d)
        away = np.flatnonzero(primitive == NOWHERE)
        t[away] = 0
        return self._coordinates.points(origin.x + t * d, d, primitive)

    def distance(self, origin: Points, d: Array) -> Array:
        """How far the rays come, ``(n,)``; inf where they leave the scene."""
        return _nearest(self._all, origin, d)[0]

    def visible(self, origin: Points, d: Array, distance: Array, target: Indices) -> NDArray[np.bool_]:
        """Whether nothing lies on segments between two points of the scene.

        Args:
            origin: where they start, n points.
            d: unit directions, ``(3, n)``.
            distance: where they end, ``(n,)``; inf for what is infinitely far.
            target: the primitives they end on, NOWHERE for none, ``(n,)``.
        """
        if not self._occluders:
            return np.ones(len(origin), dtype=bool)
        t, primitive = _nearest(self._occluders, origin, d)
        visible: NDArray[np.bool_] = (t >= distance * (1 - TOUCHES)) | (
            (primitive == target) & (target != NOWHERE)
        )
        return visible


def _nearest(shapes: list[Shapes], origin: Points, d: Array) -> tuple[Array, Indices]:
    """Distance to the nearest primitive of all, and which it is; inf and NOWHERE for none."""
    t, primitive = np.full(len(origin), np.inf), np.full(len(origin), NOWHERE)
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        for some in shapes:
            some.meet(origin.x, d, origin.primitive, t, primitive)
    return t, primitive


def _shapes(primitives: Primitives, indices: Indices) -> list[Shapes]:
    """These primitives, grouped by how they are met."""
    p, shapes = primitives, list[Shapes]()
    round_ones = indices[p.round[indices]]
    if len(round_ones):
        shapes.append(_grouped(p, round_ones, lambda i: Ellipsoids(p.center[i], p.axes[i], i.tolist())))
    quads = indices[p.kind[indices] == Quad]
    boxes = parallelepipeds.find(p.center[quads], p.axes[quads])
    if boxes:
        centers, axes, faces = (np.array(field) for field in zip(*boxes, strict=True))
        shapes.append(Boxes(centers, axes, np.where(faces >= 0, quads[faces], NOWHERE)))
        quads = np.delete(quads, faces[faces >= 0])
    kinds = ((Quad, quads, quad_excess), (Disk, indices[p.kind[indices] == Disk], disk_excess),
             (Mesh, indices[p.kind[indices] == Mesh], triangle_excess))  # fmt: skip
    for _, some, excess in kinds:
        if len(some):
            flats = partial(_flats, p, excess)
            shapes.append(_grouped(p, some, flats))
    return shapes


def _flats(p: Primitives, excess: Callable[[Array, Array], Array], indices: Indices) -> Shapes:
    return Flats(p.center[indices], p.axes[indices], excess, indices)


def _grouped(p: Primitives, indices: Indices, leaf: Callable[[Indices], Shapes]) -> Shapes:
    """Primitives of one kind: tested one by one, or where there are many, in a hierarchy."""
    if len(indices) <= LEAF:
        return leaf(indices)
    corners = p.corners()[indices]
    return Hierarchy(corners.min(axis=1), corners.max(axis=1), lambda some: leaf(indices[some]))


def _occluders(primitives: Primitives, scene: Scene) -> Indices:
    """Primitives that may stand between a point of the scene and one of an emitter.

    In the Cornell box these are the blocks, and the floor, which one of them pierces.

    Not a wall that all else is on one side of: a segment between points on one side of a plane doesn't cross it,
    nor one between points inside an ellipsoid its surface. Not the only emitter: it doesn't hide itself. It is not
    asked of the triangles of a large mesh: it takes each of them all points of the scene, and few would go.
    """
    everything = np.arange(len(primitives))
    emitting = np.flatnonzero([scene.surfaces[i].emits for i in primitives.surface])
    if len(emitting) == 1 and not scene.lights:
        everything = np.delete(everything, emitting)
    if any(not isinstance(light, PointLight | SpotLight) for light in scene.lights):
        return everything  # some segments end infinitely far
    lights = [light.position for light in scene.lights if isinstance(light, PointLight | SpotLight)]
    corners = primitives.corners()
    points = np.unique(np.concatenate([*corners, np.array(lights).reshape(-1, 3)]), axis=0)
    tolerance = 1e-12 * np.abs(points).max(initial=0)

    large = np.bincount(primitives.surface)[primitives.surface] > LARGE_MESH

    def occludes(i: int) -> bool:
        if large[i]:
            return True
        if primitives.round[i]:
            others = np.concatenate([*np.delete(corners, i, axis=0), np.array(lights).reshape(-1, 3)])
            local = (others - primitives.center[i]) @ np.linalg.inv(primitives.axes[i])
            return bool(((local**2).sum(axis=1) > 1 + 1e-12).any())
        side = (points - primitives.center[i]) @ primitives.normal[i]
        return bool(side.min() < -tolerance and side.max() > tolerance)

    return np.array([i for i in everything.tolist() if occludes(i)], dtype=np.intp)
