"""How a scene of quads is cut into patches, and which of them can see which.

Patches are graded towards the edges at which a field that leaves the surface is not smooth: those that touch a
surface of another plane, with their whole length or with one end, unless a like surface continues beyond them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from reference_tracer.arguments import check_scene
from reference_tracer.elements.bases import Mesh, Patches, graded, uniform
from scenes import AreaLight, Lambertian, Pinhole, Quad, Scene, Surface

Array = NDArray[np.float64]

TOUCHING = 1e-9
"""A distance, in diameters of the scene, that counts as none."""

Splits = Mapping[str, tuple[Sequence[float], Sequence[float]]]
"""Surface name → further mesh lines: values of s along edge_u, and of t along edge_v, in (0, 1)."""


class UnsupportedSceneError(ValueError):
    """A scene that finite elements can't compute: says which surface, what it is, and what is expected."""


def check(scene: Scene) -> None:
    """Refuse what is not a diffuse scene of quads.

    Raises:
        TypeError: it is no scene at all.
        UnsupportedSceneError: naming the surface.
    """
    check_scene(scene)
    for surface in scene.surfaces:
        shape, material, emission = surface.shape, surface.material, surface.emission
        if not isinstance(shape, Quad):
            raise _unsupported(surface, "shape", shape, "a Quad; approximate it by quads")
        if not isinstance(material, Lambertian):
            raise _unsupported(surface, "material", material, "Lambertian")
        if not isinstance(material.albedo, tuple) or not all(isinstance(a, float) for a in material.albedo):
            raise _unsupported(surface, "material.albedo", material.albedo, "one number per channel")
        if emission is not None and not isinstance(emission, AreaLight):
            raise _unsupported(surface, "emission", emission, "an AreaLight or None")
        if emission is not None and emission.angular_profile is not None:
            raise UnsupportedSceneError(
                f"surface {surface.name!r} has an angular profile, expected the same radiance in every direction"
            )
        if surface.two_sided:
            raise UnsupportedSceneError(f"surface {surface.name!r} is two-sided, expected one side")


def pinhole(scene: Scene) -> Pinhole:
    """The sensor of a scene, whose pixels can be averaged.

    Raises:
        UnsupportedSceneError: it is another one.
    """
    if not isinstance(scene.sensor, Pinhole):
        found = type(scene.sensor).__name__
        raise UnsupportedSceneError(
            f"the sensor is a {found}, expected a Pinhole; ask for radiance at points"
        )
    return scene.sensor


def _unsupported(surface: Surface, field: str, found: object, expected: str) -> UnsupportedSceneError:
    kind = type(found).__name__
    return UnsupportedSceneError(f"surface {surface.name!r}: its {field} is a {kind}, expected {expected}")


def diameter(surfaces: Sequence[Patches]) -> float:
    """The diagonal of the box about all surfaces."""
    corners = np.concatenate([patches.corners for patches in surfaces], axis=1)
    return float(np.linalg.norm(np.ptp(corners, axis=1)))


def meshed(
    scene: Scene, order: int, levels: int, splits: Splits | None = None, *, grading: bool = True
) -> list[Patches]:
    """Every surface of a scene, cut.

    Args:
        scene: of quads.
        order: of the polynomials: nodes per patch and axis.
        levels: with grading, how often patches shrink towards an edge; without, 2^levels equal cells per axis.
        splits: further mesh lines.
        grading: which of the two.

    Raises:
        ValueError: order or levels can't be, or splits name no surface.
    """
    if order < 1 or levels < 0:
        raise ValueError(f"order = {order}, levels = {levels}: expected order ≥ 1 and levels ≥ 0")
    splits = splits or {}
    if unknown := set(splits) - {surface.name for surface in scene.surfaces}:
        raise ValueError(f"splits name {sorted(unknown)}, and no surface of the scene is called that")
    whole = [Patches.of(s.shape, (uniform(1, 1),) * 2) for s in scene.surfaces if isinstance(s.shape, Quad)]
    near = TOUCHING * diameter(whole)
    cut = []
    for i, surface in enumerate(scene.surfaces):
        lines = splits.get(surface.name, ((), ()))
        meshes: list[Mesh] = []
        for axis in (0, 1):
            if grading:
                low, high = (_is_graded(scene, whole, i, axis, end, near) for end in (0.0, 1.0))
                meshes.append(graded(order, levels, low, high, tuple(lines[axis])))
            else:
                meshes.append(uniform(order, 2**levels, tuple(lines[axis])))
        cut.append(Patches(whole[i].corner, whole[i].edges, whole[i].normal, (meshes[0], meshes[1])))
    return cut


def _is_graded(scene: Scene, quads: list[Patches], i: int, axis: int, end: float, near: float) -> bool:
    """Whether patches of quad i shrink towards its edge s = end (axis 0) or t = end (axis 1)."""
    fixed, free = np.full(9, end), np.linspace(0, 1, 9)
    edge = quads[i].points(*((fixed, free) if axis == 0 else (free, fixed)))
    outward = quads[i].edges[axis] * (1 if end else -1)
    touched, continued = np.zeros(9, dtype=bool), np.zeros(9, dtype=bool)
    mine = scene.surfaces[i]
    for j, other in enumerate(quads):
        if j == i:
            continue
        beside = _contains(other, edge, near)
        if np.linalg.norm(np.cross(other.normal, quads[i].normal)) > TOUCHING:
            touched |= beside
            continue
        beyond = outward @ (other.corners.mean(axis=1) - edge.mean(axis=1)) > 0
        theirs = scene.surfaces[j]
        alike = theirs.material == mine.material and theirs.emission == mine.emission
        if beyond and alike and other.normal @ quads[i].normal > 0:
            continued |= beside
    return bool((touched & ~continued).any())


def _contains(quad: Patches, x: Array, near: float) -> NDArray[np.bool_]:
    """Which points lie in a quad, its edges included."""
    s, t = quad.coordinates(x)
    slack_s, slack_t = near / np.linalg.norm(quad.edges, axis=1)
    in_plane = np.abs(quad.normal @ (x - quad.corner[:, None])) <= near
    inside = (np.abs(s - 0.5) <= 0.5 + slack_s) & (np.abs(t - 0.5) <= 0.5 + slack_t)
    return np.asarray(in_plane & inside)


class Sight:
    """Which quads can see each other, proved from their corners."""

    def __init__(self, surfaces: Sequence[Patches]) -> None:
        near = TOUCHING * diameter(surfaces)
        corners = np.stack([patches.corners for patches in surfaces])  # (n, 3, 4)
        normals = np.stack([patches.normal for patches in surfaces])
        levels = np.einsum("ni,ni->n", normals, np.stack([patches.corner for patches in surfaces]))
        height = np.einsum("ki,nic->knc", normals, corners) - levels[:, None, None]
        self._above, self._below = (height > near).any(axis=2), (height < -near).any(axis=2)
        edges = np.concatenate([patches.edges for patches in surfaces])
        directions = np.concatenate([normals, edges / np.linalg.norm(edges, axis=1)[:, None]])
        extents = np.einsum("di,nic->dnc", directions, corners)
        self._low, self._high = extents.min(axis=2) + near, extents.max(axis=2) - near  # (directions, n)

    def see(self, i: int, j: int) -> bool:
        """Whether some of i is in front of j and the other way round."""
        return bool(self._above[i, j] and self._above[j, i])

    def face(self, i: int, j: int) -> bool:
        """Whether each lies wholly in front of the other."""
        return self.see(i, j) and not (self._below[i, j] or self._below[j, i])

    def hidden(self, i: int, j: int) -> bool:
        """Whether some third surface may stand between them.

        It can't if it is behind one of the two, or if it lies beside both along a normal or an edge of any surface.
        """
        behind = ~self._above[i] | ~self._above[j]
        low, high = (
            f(a[:, i], a[:, j])[:, None] for f, a in ((np.minimum, self._low), (np.maximum, self._high))
        )
        beside = ((self._high <= low) | (self._low >= high)).any(axis=0)
        between = ~(behind | beside)
        between[[i, j]] = False
        return bool(between.any())
