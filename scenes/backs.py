"""Whose back can be seen: for formats in which a back is something else than black.

A surface of ours is black from behind. Elsewhere a back reflects, or is not there at all. That makes no difference
where no path that starts at the sensor ever meets a back, and two arguments prove it:

- *half space*: nothing, sensor and all surfaces, lies behind the plane of the face, so no path comes from there;
- *closed*: a sphere, an ellipsoid, or faces that share every edge with exactly one other face, in the opposite
  direction: no path gets through, so it is enough that the sensor is on the front side, outside or (fronts
  inward) inside. A polyhedron is taken to be one that does not cut itself.

What neither of them proves may be seen.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from scenes.bounds import extent, least
from scenes.lights import DirectionalLight, PointLight, SpotLight
from scenes.materials import Blend, Material, has_dielectric
from scenes.scene import Scene
from scenes.sensor import Orthographic, Sensor, ThinLens
from scenes.shapes import Disk, Ellipsoid, Mesh, Quad, Shape, Sphere
from scenes.surfaces import Surface

Array = NDArray[np.float64]

_ROUNDING = 1e-9  # of the extent of the scene
_INFINITY = 1e4  # how far away a directional light is put, in extents of the scene


def visible_backs(scene: Scene, *, to_lights: bool = False) -> list[str]:
    """Names of the one-sided surfaces whose back may be met.

    Args:
        scene: the scene.
        to_lights: by point, spot and directional lights as well: for formats in which a back casts no shadow.
    """
    reach = extent(scene)
    viewers = [_sensor(scene.sensor)]
    if to_lights:
        viewers += _lights(scene, reach)
    proofs = _Proofs(scene, viewers, _ROUNDING * reach)
    return [s.name for s in scene.surfaces if _one_sided(s) and not proofs.unseen(s)]


def _one_sided(surface: Surface) -> bool:
    return not surface.two_sided and not _is_dielectric(surface.material)


def _is_dielectric(material: Material) -> bool:
    """Whether all of it is a boundary between two media, which has two sides of its own."""
    if isinstance(material, Blend):
        return _is_dielectric(material.first) and _is_dielectric(material.second)
    return has_dielectric(material)


@dataclass(frozen=True)
class _Ball:
    """Where paths start: within a radius of a point."""

    center: Array
    radius: float = 0.0


def _sensor(sensor: Sensor) -> _Ball:
    radius = 0.0
    if isinstance(sensor, ThinLens):
        radius = sensor.aperture_radius
    elif isinstance(sensor, Orthographic):
        width, height = sensor.width, sensor.height
        radius = sensor.extent / 2 * float(np.hypot(width, height)) / min(width, height)
    return _Ball(np.asarray(sensor.origin), radius)


def _lights(scene: Scene, reach: float) -> list[_Ball]:
    found = []
    for light in scene.lights:
        if isinstance(light, PointLight | SpotLight):
            found.append(_Ball(np.asarray(light.position)))
        elif isinstance(light, DirectionalLight):
            found.append(_Ball(-_INFINITY * reach * np.asarray(light.direction)))
    return found


class _Proofs:
    """The two arguments, for one scene."""

    def __init__(self, scene: Scene, viewers: list[_Ball], rounding: float) -> None:
        self._scene, self._viewers, self._rounding = scene, viewers, rounding
        self._closed = set(self._closed_polyhedra())

    def unseen(self, surface: Surface) -> bool:
        """Whether one of them holds for the surface."""
        if has_dielectric(surface.material):
            return False  # a part of it lets paths through to its back
        if isinstance(surface.shape, Sphere | Ellipsoid):
            return all(_in_front(surface.shape, viewer) for viewer in self._viewers)
        return surface.name in self._closed or all(self._half_space(x, n) for x, n in _planes(surface.shape))

    def _half_space(self, x: Array, n: Array) -> bool:
        limit = n @ x - self._rounding
        return all(n @ viewer.center - viewer.radius >= limit for viewer in self._viewers) and all(
            least(surface.shape, n) >= limit for surface in self._scene.surfaces
        )

    def _closed_polyhedra(self) -> Iterator[str]:
        """Surfaces all of whose faces belong to closed polyhedra that every viewer sees from the front."""
        faces, owners = [], []
        for surface in self._scene.surfaces:
            if isinstance(surface.shape, Quad | Mesh) and not has_dielectric(surface.material):
                found = _polygons(surface.shape)
                faces += found
                owners += [surface.name] * len(found)
        unproved = set[str]()
        for component in _components(faces, self._rounding):
            polyhedron = [faces[i] for i in component]
            if not _is_closed(polyhedron, self._rounding) or not all(
                _outside_or_inside(polyhedron, viewer) for viewer in self._viewers
            ):
                unproved |= {owners[i] for i in component}
        yield from set(owners) - unproved


def _in_front(shape: Sphere | Ellipsoid, viewer: _Ball) -> bool:
    matrix = shape.matrix if isinstance(shape, Ellipsoid) else shape.radius * np.eye(3)
    inverse = np.linalg.inv(matrix)
    distance = np.linalg.norm(inverse @ (viewer.center - shape.center))
    margin = viewer.radius * np.linalg.norm(inverse, 2)
    return bool(distance + margin <= 1 if shape.inward else distance - margin >= 1)


def _planes(shape: Shape) -> Iterator[tuple[Array, Array]]:
    """A point of each flat face and its unit normal."""
    if isinstance(shape, Quad):
        yield np.asarray(shape.corner), shape.normal
    elif isinstance(shape, Disk):
        yield np.asarray(shape.center), shape.normal
    elif isinstance(shape, Mesh):
        for a, b, c in shape.corners:
            n = np.cross(b - a, c - a)
            yield a, n / np.linalg.norm(n)


# ---- polyhedra


def _polygons(shape: Quad | Mesh) -> list[Array]:
    """Corners of each face, counterclockwise seen from its front, ``(corners, 3)``."""
    if isinstance(shape, Mesh):
        return list(shape.corners)
    c, u, v = map(np.asarray, (shape.corner, shape.edge_u, shape.edge_v))
    return [np.stack([c, c + u, c + u + v, c + v])]


Edge = tuple[tuple[int, ...], tuple[int, ...]]


def _edges(polygon: Array, rounding: float) -> list[Edge]:
    # a third of a step, so that round numbers do not lie where rounding changes
    keys = [tuple(key) for key in np.round(polygon / rounding / 4 + 1 / 3).astype(np.int64).tolist()]
    return list(zip(keys, keys[1:] + keys[:1], strict=True))


def _components(polygons: list[Array], rounding: float) -> list[list[int]]:
    """Which of them hang together by edges."""
    users: dict[frozenset[tuple[int, ...]], list[int]] = {}
    edges = [[frozenset(edge) for edge in _edges(polygon, rounding)] for polygon in polygons]
    for i, own in enumerate(edges):
        for edge in own:
            users.setdefault(edge, []).append(i)
    seen, found = set[int](), []
    for start in range(len(polygons)):
        if start in seen:
            continue
        component, front = [], [start]
        seen.add(start)
        while front:
            i = front.pop()
            component.append(i)
            new = {j for edge in edges[i] for j in users[edge]} - seen
            seen |= new
            front += new
        found.append(component)
    return found


def _is_closed(polygons: list[Array], rounding: float) -> bool:
    """Whether every edge is that of two faces, once in each direction."""
    count = Counter(edge for polygon in polygons for edge in _edges(polygon, rounding))
    return all(n == 1 and count[edge[::-1]] == 1 for edge, n in list(count.items()))


def _outside_or_inside(polygons: list[Array], viewer: _Ball) -> bool:
    """Whether the viewer is on the front side of a closed polyhedron: outside, or inside if fronts are inward."""
    triangles = np.concatenate([_fan(polygon) for polygon in polygons]) - viewer.center
    if viewer.radius and _clearance(triangles) < viewer.radius:
        return False
    a, b, c = triangles.transpose(1, 0, 2)
    triple = np.einsum("ti,ti->t", a, np.cross(b, c))
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    ab, bc, ca = (np.einsum("ti,ti->t", x, y) for x, y in ((a, b), (b, c), (c, a)))
    # the solid angle of a triangle, signed (Van Oosterom and Strackee 1983, eq. 8)
    angle = 2 * np.arctan2(triple, la * lb * lc + ab * lc + bc * la + ca * lb)
    winding = round(float(angle.sum()) / (4 * np.pi))
    outward = triple.sum() > 0
    return winding == (0 if outward else -1)


def _fan(polygon: Array) -> Array:
    """The polygon, which is convex, as triangles, ``(corners − 2, 3, 3)``."""
    return np.stack([np.stack([polygon[0], b, c]) for b, c in pairwise(polygon[1:])])


def _clearance(triangles: Array) -> float:
    """The distance of the origin from the triangles, at least."""
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    plane = np.abs(np.einsum("ti,ti->t", normal, triangles[:, 0]))
    middle = triangles.mean(axis=1)
    around = np.linalg.norm(middle, axis=1) - np.linalg.norm(triangles - middle[:, None], axis=2).max(axis=1)
    return float(np.maximum(plane, around).min())
