"""Coincident surfaces: two in the same place would leave it to rounding which of them a ray meets.

Flat shapes coincide where they share an area of the same plane, whichever way they face; touching edges are no
area. Spheres and ellipsoids coincide if they are the same. "The same" is a distance of 10⁻⁹ of the smaller
piece's size: a gap of 10⁻⁶ is a gap.

One coincidence is left: the foot of a solid that stands on something, since nobody sees either side of it. A
piece is such a foot where every edge of it is shared by a neighbour that rises on its back, and both surfaces
face opposite ways and are one-sided and opaque.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from scenes.materials import has_dielectric
from scenes.overlaps import disk_overlaps_polygon, disks_overlap, polygons_overlap
from scenes.shapes import Disk, Ellipsoid, Mesh, Quad, Sphere
from scenes.surfaces import Surface
from scenes.sweep import meeting_pairs
from scenes.validation import SceneError

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_GAP = 1e-9  # of the smaller piece's size: what is nearer is in the same plane
_ROUNDING = 1e-13  # of the coordinates: what transforming a piece may have moved it by
_TILT = 1e-6  # of the components of normals, only to sort out candidates
_SHARED = 1e-6  # of an edge: two whose ends are nearer are the same edge


def check_coincidence(surfaces: Sequence[Surface]) -> None:
    """Refuse surfaces that overlap in the same plane or on the same sphere.

    Raises:
        SceneError: naming both.
    """
    with np.errstate(all="ignore"):  # of coordinates beyond 1e150, or pieces below rounding, nothing is said
        _check_round(surfaces)
        _check_flat(surfaces)


@dataclass(frozen=True)
class _Pieces:
    """Flat pieces of surfaces.

    Attributes:
        surface: which one each is of, ``(n,)``.
        part: which triangle of its mesh, 0 otherwise, ``(n,)``.
        is_disk: ``(n,)``.
        corners: in order, ``(n, 4, 3)``; a triangle has its last one twice; a disk has those of the
            parallelogram around it.
    """

    surface: Indices
    part: Indices
    is_disk: NDArray[np.bool_]
    corners: Array

    @property
    def normals(self) -> Array:
        """Of the fronts, ``(n, 3)``."""
        a, b, c, _ = self.corners.transpose(1, 0, 2)
        return _unit(np.cross(b - a, c - a))

    def frames(self, pieces: Indices) -> tuple[Array, Array]:
        """Of disks: axis_u, axis_v, normal as columns ``(n, 3, 3)``; centres ``(n, 3)``."""
        a, b, _, d = self.corners[pieces].transpose(1, 0, 2)
        u, v = (b - a) / 2, (d - a) / 2
        return np.stack([u, v, _unit(np.cross(u, v))], axis=2), a + u + v


def _unit(vectors: Array) -> Array:
    unit: Array = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    return unit


def _flat_pieces(surfaces: Sequence[Surface]) -> _Pieces:
    corners, counts, disks = [], [], []
    for surface in surfaces:
        match surface.shape:
            case Quad() as quad:
                c, u, v = np.array([quad.corner, quad.edge_u, quad.edge_v])
                corners.append(np.array([[c, c + u, c + u + v, c + v]]))
            case Disk() as disk:
                c, u, v = np.array([disk.center, disk.axis_u, disk.axis_v])
                corners.append(np.array([[c - u - v, c + u - v, c + u + v, c - u + v]]))
            case Mesh():
                corners.append(surface.shape.corners[:, [0, 1, 2, 2]])
            case _:
                corners.append(np.zeros((0, 4, 3)))
        counts.append(len(corners[-1]))
        disks.append(isinstance(surface.shape, Disk))
    return _Pieces(
        surface=np.repeat(np.arange(len(surfaces)), counts),
        part=np.concatenate([np.arange(0), *map(np.arange, counts)]),
        is_disk=np.repeat(np.array(disks, dtype=bool), counts),
        corners=np.concatenate([np.zeros((0, 4, 3)), *corners]),
    )


def _check_flat(surfaces: Sequence[Surface]) -> None:
    pieces = _flat_pieces(surfaces)
    corners, normals = pieces.corners, pieces.normals
    size = np.ptp(corners, axis=1).max(axis=1, initial=0)
    rounding = _ROUNDING * np.abs(corners).max(axis=(1, 2), initial=0)
    # n nᵀ is the same for both sides of a plane
    tensor = np.einsum("ni,nj->nij", normals, normals)[:, *np.triu_indices(3)]
    # widened by the gap, and narrowed by less than the width of an overlap, or all that touch would be candidates
    pad = (_GAP * size + rounding)[:, None] - 1e-7 * np.ptp(corners, axis=1)
    low = np.concatenate([corners.min(axis=1, initial=np.inf) - pad, tensor - _TILT], axis=1)
    high = np.concatenate([corners.max(axis=1, initial=-np.inf) + pad, tensor + _TILT], axis=1)
    for a, b in meeting_pairs(low, high):
        larger, smaller = np.where(size[a] > size[b], [a, b], [b, a])
        offsets = corners[smaller] - corners[larger, :1]
        distance = np.abs(np.einsum("nci,ni->nc", offsets, normals[larger])).max(axis=1)
        same = distance <= _GAP * size[smaller] + np.maximum(rounding[a], rounding[b])
        a, b = np.minimum(a, b)[same], np.maximum(a, b)[same]
        found = _share_area(pieces, normals, a, b)
        found[found] = ~_stand(surfaces, pieces, normals, a[found], b[found])
        if found.any():
            first = np.lexsort((a[found], b[found]))[0]
            pair = a[found][first], b[found][first]
            _refuse(surfaces, *((int(pieces.surface[p]), int(pieces.part[p])) for p in pair))


def _share_area(pieces: _Pieces, normals: Array, a: Indices, b: Indices) -> NDArray[np.bool_]:
    """Whether two pieces of the same plane overlap, by what they are."""
    overlap = np.zeros(len(a), dtype=bool)
    on_a, on_b = pieces.is_disk[a], pieces.is_disk[b]
    flat, round_ = ~on_a & ~on_b, on_a & on_b
    overlap[flat] = polygons_overlap(pieces.corners[a[flat]], pieces.corners[b[flat]], normals[a[flat]])
    overlap[round_] = disks_overlap(*pieces.frames(a[round_]), *pieces.frames(b[round_]))
    for mixed, disk, polygon in ((on_a & ~on_b, a, b), (on_b & ~on_a, b, a)):
        overlap[mixed] = disk_overlaps_polygon(*pieces.frames(disk[mixed]), pieces.corners[polygon[mixed]])
    return overlap


def _stand(
    surfaces: Sequence[Surface], pieces: _Pieces, normals: Array, a: Indices, b: Indices
) -> NDArray[np.bool_]:
    """Whether one of two coincident pieces is the foot of a solid that stands on the other."""
    closed = np.array([not (s.two_sided or has_dielectric(s.material)) for s in surfaces], dtype=bool)
    possible = (normals[a] * normals[b]).sum(axis=1) < 0
    possible &= closed[pieces.surface[a]] & closed[pieces.surface[b]]
    feet = _feet(pieces, normals, np.union1d(a[possible], b[possible]))
    stand: NDArray[np.bool_] = possible & (np.isin(a, feet) | np.isin(b, feet))
    return stand


def _feet(pieces: _Pieces, normals: Array, chosen: Indices) -> Indices:
    """Those of the chosen pieces of which every edge is shared by a neighbour that rises on their back."""
    if not chosen.size:
        return chosen
    start, end = pieces.corners, np.roll(pieces.corners, -1, axis=1)
    owner, edge = np.nonzero((start != end).any(axis=2) & ~pieces.is_disk[:, None])
    ends = np.concatenate([start[owner, edge], end[owner, edge]], axis=1)
    length = np.linalg.norm(ends[:, 3:] - ends[:, :3], axis=1)
    both = np.concatenate([ends, np.roll(ends, 3, axis=1)])  # neighbours run along it in either direction
    pad = _SHARED / 2 * np.tile(length, 2)[:, None]
    closed = np.zeros(len(owner), dtype=bool)
    for e, f in meeting_pairs(both - pad, both + pad):
        for own, other in ((e % len(owner), f % len(owner)), (f % len(owner), e % len(owner))):
            piece, neighbour = owner[own], owner[other]
            offsets = pieces.corners[neighbour] - pieces.corners[piece, :1]
            height = np.einsum("nci,ni->nc", offsets, normals[piece]) / length[own, None]
            rises = (height < -_SHARED).any(axis=1) | ((normals[piece] * normals[neighbour]).sum(axis=1) > 0)
            closed[own[(height < _SHARED).all(axis=1) & rises & (piece != neighbour)]] = True
    open_ = np.zeros(len(pieces.corners), dtype=bool)
    open_[owner[~closed]] = True
    return chosen[~open_[chosen] & ~pieces.is_disk[chosen]]


def _check_round(surfaces: Sequence[Surface]) -> None:
    """Two ellipsoids c + Mq are the same if their centres and M Mᵀ are."""
    round_ = [
        (i, s.shape.center, s.shape.radius * np.eye(3) if isinstance(s.shape, Sphere) else s.shape.matrix)
        for i, s in enumerate(surfaces)
        if isinstance(s.shape, Sphere | Ellipsoid)
    ]
    if not round_:
        return
    index, center, matrix = (np.array(column) for column in zip(*round_, strict=True))
    tensor = matrix @ matrix.transpose(0, 2, 1)
    size = np.sqrt(np.trace(tensor, axis1=1, axis2=2))
    pad = (_GAP * size + _ROUNDING * np.abs(center).max(axis=1, initial=0))[:, None]
    keys = np.concatenate([center, size[:, None]], axis=1)
    for a, b in meeting_pairs(keys - pad, keys + pad):
        difference = np.abs(tensor[a] - tensor[b]).max(axis=(1, 2))
        same = np.flatnonzero(difference <= 2 * _GAP * size[a] ** 2)
        if len(same):
            pair = a[same[0]], b[same[0]]
            _refuse(surfaces, (int(index[min(pair)]), 0), (int(index[max(pair)]), 0))


def _refuse(surfaces: Sequence[Surface], first: tuple[int, int], second: tuple[int, int]) -> NoReturn:
    """Raise the error that names both, each as surface and part."""
    (i, part), (j, other) = first, second
    shape, place = surfaces[j].shape, f"Scene.surfaces[{j}].shape"
    found: object = shape
    if isinstance(shape, Mesh):
        place, found = f"{place}.triangles[{other}]", shape.triangles[other]
    where = f" triangles[{part}]" if isinstance(surfaces[i].shape, Mesh) else ""
    raise SceneError(
        place,
        found,
        f"{surfaces[j].name!r} not in the same place as surfaces[{i}] {surfaces[i].name!r}{where}: which of the "
        "two a ray meets would be left to rounding; move one by 10⁻⁶ of its size, or cut it so that they only "
        "touch",
    )
