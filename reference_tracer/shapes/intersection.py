"""Where rays meet shapes: boxes, flat shapes and ellipsoids, each many at once against a block of rays.

Every shape is an affine image of a simple one, so that a matrix takes all rays into the frames of all shapes:
there a box is |x|, |y|, |z| ≤ 1, a flat shape lies in z = 0, an ellipsoid is the unit sphere. The parameter t
along a ray is the same in every frame.

``meet`` has the same form everywhere:

    Args:
        x, d: origins and unit directions, ``(3, n)``.
        start: the primitive that each ray starts on, NOWHERE = −1 for none. There is no ray offset: a plane is
            not met again by a ray that starts on it, an ellipsoid only at the other root.
        t: distance to the nearest primitive so far, inf for none, ``(n,)``; updated in place.
        primitive: which one that is, ``(n,)``; updated in place.

Three things in here are for speed. Arrays lie by component, and nothing is chosen by ``where`` with a scalar,
nor by ``argmin``: t / valid, with valid 0 or 1, is inf where it should be, and bytes pick the index (both
several times faster in NumPy). A direction that is exactly parallel to a plane gets TINY added, so that no 0/0
has to be looked after.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

TINY = 1e-300


class Shapes(Protocol):
    """Some primitives, met together."""

    def meet(self, x: Array, d: Array, start: Indices, t: Array, primitive: Indices) -> None:
        """See the module."""


def frames(centers: Array, axes: Array) -> tuple[Array, Array]:
    """The maps from the world into frames: ``rows @ x + offsets``.

    Args:
        centers: ``(shapes, 3)``.
        axes: the three axes of each frame as rows, ``(shapes, 3, 3)``.

    Returns:
        ``(3, shapes, 3)`` and ``(3, shapes, 1)``: the same local axis of all shapes lies together.
    """
    rows = np.linalg.inv(axes.transpose(0, 2, 1)).astype(np.float64, copy=False)
    offsets = -np.einsum("sij,sj->si", rows, centers)
    return rows.transpose(1, 0, 2).copy(), offsets.T[:, :, None].copy()


class Boxes:
    """Parallelepipeds, some of whose faces may be missing, met as slabs (Kay and Kajiya 1986, sect. 3)."""

    def __init__(self, centers: Array, axes: Array, faces: Indices) -> None:
        """``faces[box, 2·axis + side]`` is the primitive on the side −1 (0) or +1 (1) of a local axis, or −1."""
        self._rows, self._offsets = frames(centers, axes)
        self._stacked = self._rows.transpose(1, 0, 2).reshape(-1, 3).copy()
        # code 0: no face. Face f has the code f + 1
        self._faces = np.concatenate([np.full((len(faces), 1), -1), faces], axis=1)
        self._codes = np.array([1, 3, 5], dtype=np.uint8)[:, None]
        self._box_of = np.full(faces.max() + 2, -1)  # the last one is that of NOWHERE
        for box, primitives in enumerate(faces):
            self._box_of[primitives[primitives >= 0]] = box

    def meet(self, x: Array, d: Array, start: Indices, t: Array, primitive: Indices) -> None:
        """See the module."""
        home = self._box_of.take(np.minimum(start, len(self._box_of) - 1))
        local_x, local_d = (self._stacked @ w for w in (x, d))
        for b in range(len(self._faces)):
            # |x| ≤ 1 along each axis: the ray is within the slab from −x / d − 1 / |d| to −x / d + 1 / |d|
            inverse = local_d[3 * b : 3 * b + 3]
            inverse += TINY
            np.divide(1, inverse, out=inverse)
            middle = local_x[3 * b : 3 * b + 3]
            middle += self._offsets[:, b]
            middle *= inverse
            half = np.abs(inverse)
            near, far = -(middle + half), half - middle
            enter, leave = near.max(axis=0), far.min(axis=0)
            lanes = np.flatnonzero((enter < leave) & (leave > 0) & (enter < t))
            if len(lanes) < len(start):  # most rays miss most boxes
                near, far, inverse = (values.take(lanes, axis=1) for values in (near, far, inverse))
                enter, leave = enter.take(lanes), leave.take(lanes)
            faces = self._faces[b]
            starts, starts_here = start.take(lanes), home.take(lanes) == b
            backwards = (inverse < 0).view(np.uint8)

            # rays leave through the first of the far planes, and enter through the last of the near ones
            face = faces.take(((far == leave) * (self._codes + 1 - backwards)).max(axis=0))
            t_box = leave / ((face >= 0) & (face != starts))
            enters = (enter > 0) & ~starts_here
            if enters.any():
                face_in = faces.take(((near == enter) * (self._codes + backwards)).max(axis=0))
                enters &= face_in >= 0
                t_box, face = np.where(enters, enter, t_box), np.where(enters, face_in, face)
            keep_nearer(t, primitive, t_box, face, lanes)


class Flats:
    """Flat shapes of one kind: quads, disks or triangles."""

    def __init__(
        self, centers: Array, axes: Array, excess: Callable[[Array, Array], Array], primitives: Indices
    ) -> None:
        """``excess(a, b)`` is ≤ 0 for the local coordinates inside the shape."""
        self._rows, self._offsets = frames(centers, axes)
        self._excess, self._primitives = excess, primitives
        self._one_based = np.arange(1, len(primitives) + 1, dtype=np.min_scalar_type(len(primitives)))[
            :, None
        ]

    def meet(self, x: Array, d: Array, start: Indices, t: Array, primitive: Indices) -> None:
        """See the module."""
        (along_a, along_b, across), (a0, b0, height) = self._rows, self._offsets
        t_flat = (across @ x + height) / -(across @ d + TINY)
        within = (t_flat > 0) & (t_flat < t) & (start != self._primitives[:, None])
        lanes = np.flatnonzero(within.any(axis=0))
        if len(lanes) < len(start):
            x, d, t_flat, within = (values.take(lanes, axis=1) for values in (x, d, t_flat, within))
        a = along_a @ x + a0 + t_flat * (along_a @ d)
        b = along_b @ x + b0 + t_flat * (along_b @ d)
        t_flat = np.maximum(t_flat, TINY) / (within & (self._excess(a, b) <= 0))
        nearest = t_flat.min(axis=0)
        which = ((t_flat == nearest) * self._one_based).max(axis=0)
        keep_nearer(t, primitive, nearest, self._primitives.take(which - 1, mode="clip"), lanes)


def quad_excess(a: Array, b: Array) -> Array:
    """A quad is |a|, |b| ≤ 1."""
    return np.maximum(np.abs(a), np.abs(b)) - 1


def disk_excess(a: Array, b: Array) -> Array:
    """A disk is a² + b² ≤ 1."""
    return a * a + b * b - 1


def triangle_excess(a: Array, b: Array) -> Array:
    """A triangle is a, b ≥ 0, a + b ≤ 1."""
    return np.maximum(-np.minimum(a, b), a + b - 1)


class Ellipsoids:
    """Spheres and ellipsoids."""

    def __init__(self, centers: Array, axes: Array, primitives: Sequence[int]) -> None:
        self._rows, self._offsets = frames(centers, axes)
        self._primitives = primitives

    def meet(self, x: Array, d: Array, start: Indices, t: Array, primitive: Indices) -> None:
        """See the module. The discriminant from the distance of the centre to the ray (Haines et al. 2019)."""
        for i, index in enumerate(self._primitives):
            o, local_d = self._rows[:, i] @ x + self._offsets[:, i], self._rows[:, i] @ d
            a = (local_d * local_d).sum(axis=0)
            middle = -(o * local_d).sum(axis=0) / a
            closest = o + middle * local_d
            square = (1 - (closest * closest).sum(axis=0)) / a
            half = np.sqrt(np.maximum(square, 0))
            starts_here = start == index
            near, far = middle - half, middle + half
            first = np.where(near > 0, near, far)
            first = np.where(starts_here, 2 * middle, first)  # one root is 0, the other one is this
            t_one = np.maximum(first, TINY) / ((first > 0) & ((square > 0) | starts_here))
            keep_nearer(t, primitive, t_one, np.full(len(start), index))


def keep_nearer(
    t: Array, primitive: Indices, t_new: Array, which: Indices, lanes: Indices | None = None
) -> None:
    """Update the nearest so far, ``t`` and ``primitive``, in these lanes (None: in all)."""
    if lanes is None or len(lanes) == len(t):
        np.copyto(primitive, np.where(t_new < t, which, primitive))
        np.minimum(t, t_new, out=t)
        return
    closer = np.flatnonzero(t_new < t.take(lanes))
    lanes = lanes.take(closer)
    t[lanes], primitive[lanes] = t_new.take(closer), which.take(closer)
