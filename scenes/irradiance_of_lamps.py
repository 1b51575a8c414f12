"""Irradiance of a plane by lamps of constant radiance, in closed form.

All of it is one integral, E = ∫ L n·l dl over the directions l of the lamp, so E = L n·v with the vector
v = ∫ l dl, as long as the lamp is above the horizon of n:

- polygon: v = −½ Σ Θᵢ Γᵢ, Θᵢ the angle that edge i subtends and Γᵢ the unit normal of the plane through the point
  and the edge (Lambert 1760; Arvo 1995, Analytic Methods for Simulated Light Transport). What is below
  the horizon is cut off first;
- sphere of radius r at distance d: a round cone of sine r/d; v points to its centre, |v| = π (r/d)²;
- disk, ellipse, ellipsoid: an elliptic cone dᵀQd > 0. By its two planes of symmetry v points along its axis.
  Projected onto the plane across that axis it is an ellipse with the half axes 1/√(1 + |λ₁|/λ₃) and
  1/√(1 + |λ₂|/λ₃), where λ₁, λ₂ < 0 < λ₃ are the eigenvalues of Q, and |v| is its area (Nusselt 1928).

Nothing here looks for what stands in between, except ``clipped``, which cuts a polygon by a plane per point.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenes.shapes import Disk, Ellipsoid, Mesh, Quad, Shape, Sphere

Array = NDArray[np.float64]


def irradiance_per_radiance(shape: Shape, x: Array, normal: Array) -> Array:
    """Irradiance at points of a plane by a shape whose front emits radiance 1, ``(n,)``, in sr.

    Args:
        shape: the lamp; a mesh must be flat or convex, for its triangles not to hide one another.
        x: points ``(3, n)``, all in one plane.
        normal: that plane's unit normal ``(3,)``.

    Raises:
        ValueError: a curved lamp that is not wholly above the plane.
    """
    match shape:
        case Quad() | Mesh():
            parts = np.stack([polygon_irradiance(corners, x, normal) for corners in polygons(shape)])
            return np.asarray(parts.sum(axis=0))
        case Sphere():
            return _sphere(shape, x, normal)
        case Disk() | Ellipsoid():
            return _elliptic_cone(shape, x, normal)


def polygons(shape: Quad | Mesh) -> list[Array]:
    """What the shape consists of: corners ``(k, 3)``, counterclockwise seen from the front."""
    if isinstance(shape, Mesh):
        return list(shape.corners)
    corner, u, v = np.array(shape.corner), np.array(shape.edge_u), np.array(shape.edge_v)
    return [np.stack([corner, corner + u, corner + u + v, corner + v])]


def polygon_irradiance(corners: Array, x: Array, normal: Array) -> Array:
    """Irradiance at points of a plane by a flat, convex polygon of radiance 1, ``(n,)``.

    Args:
        corners: ``(k, 3)``, or ``(k, 3, n)`` where they differ from point to point.
        x: ``(3, n)``, all in one plane.
        normal: that plane's unit normal ``(3,)``.
    """
    corners = np.broadcast_to(corners if corners.ndim == 3 else corners[..., None], (len(corners), *x.shape))
    above = clipped(corners, x[:, :1], np.broadcast_to(normal[:, None], x.shape))
    if not len(above):
        return np.zeros(x.shape[1])
    v = np.zeros(x.shape)
    for a, b in zip(above - x, np.roll(above, -1, axis=0) - x, strict=True):
        across = np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
        sine, cosine = np.sqrt((across**2).sum(axis=0)), (a * b).sum(axis=0)
        # Θ / |a × b| tends to 1 / |a||b| where the edge shrinks to nothing
        ratio = np.divide(np.arctan2(sine, cosine), sine, out=np.zeros_like(sine), where=sine > 0)
        v -= 0.5 * ratio * across
    irradiance: Array = np.maximum(normal @ v, 0)  # negative where the point sees the back, which is black
    return irradiance


def clipped(corners: Array, origin: Array, normal: Array) -> Array:
    """The part of a convex polygon on the front of a plane, ``(k, 3, n)``; one polygon and one plane per point.

    Args:
        corners: ``(k, 3, n)``.
        origin: a point of each plane, ``(3, n)`` or ``(3, 1)``.
        normal: of each plane, ``(3, n)``, of any length.

    Raises:
        ValueError: the plane cuts off other corners for one point than for another.
    """
    height = ((corners - origin) * normal).sum(axis=1)  # (k, n)
    front = height > 0
    if (front != front[:, :1]).any():
        raise ValueError("expected a plane that cuts off the same corners for all points")
    kept = []
    for i, inside in enumerate(front[:, 0]):
        j = (i + 1) % len(corners)
        if inside:
            kept.append(corners[i])
        if inside != front[j, 0]:
            share = height[i] / (height[i] - height[j])
            kept.append(corners[i] + share * (corners[j] - corners[i]))
    return np.stack(kept) if kept else np.empty((0, *corners.shape[1:]))


def _sphere(sphere: Sphere, x: Array, normal: Array) -> Array:
    """π (r/d)² cos θ, θ the angle between the normal and the direction of the centre."""
    d = np.reshape(sphere.center, (3, 1)) - x
    if not (normal @ d >= sphere.radius).all():
        raise ValueError(f"expected a sphere above the plane that it lights: {sphere}")
    squared = (d**2).sum(axis=0)
    irradiance: Array = np.pi * sphere.radius**2 / squared * (normal @ d) / np.sqrt(squared)
    return irradiance


def _elliptic_cone(shape: Disk | Ellipsoid, x: Array, normal: Array) -> Array:
    """|v| times the cosine of the angle between the axis of the cone and the normal."""
    Q = cone_of_disk(shape, x) if isinstance(shape, Disk) else cone_of_ellipsoid(shape, x)
    eigenvalues, eigenvectors = np.linalg.eigh(Q)  # ascending: two below zero, one above
    axis, toward = eigenvectors[:, :, 2], (np.reshape(shape.center, (3, 1)) - x).T
    axis = axis * np.sign((axis * toward).sum(axis=1, keepdims=True))
    # no direction of the cone is below the horizon if the normal is in the dual cone
    dual = np.einsum("i,nij,j->n", normal, np.linalg.inv(Q), normal)
    if not ((dual >= 0) & (axis @ normal > 0)).all():
        raise ValueError(f"expected a lamp above the plane that it lights: {shape}")
    area = np.pi / np.sqrt(np.prod(1 - eigenvalues[:, :2] / eigenvalues[:, 2:], axis=1))
    irradiance: Array = area * (axis @ normal)
    if isinstance(shape, Disk):
        irradiance = np.where(toward @ shape.normal < 0, irradiance, 0)
    return irradiance


def cone_of_ellipsoid(ellipsoid: Ellipsoid, x: Array) -> Array:
    """Q of the cone dᵀQd > 0 under which each point sees an ellipsoid, ``(n, 3, 3)``.

    In the coordinates in which it is the unit sphere, the ray o + td meets it if (o·d)² > (o² − 1) d².
    """
    A = np.linalg.inv(ellipsoid.matrix)
    o = (A @ (x - np.reshape(ellipsoid.center, (3, 1)))).T
    discriminant = o[:, :, None] * o[:, None, :] - ((o**2).sum(axis=1) - 1)[:, None, None] * np.eye(3)
    cone: Array = A.T @ discriminant @ A
    return cone


def cone_of_disk(disk: Disk, x: Array) -> Array:
    """Q of the cone dᵀQd > 0 under which each point sees a disk, ``(n, 3, 3)``.

    With m the normal, w the point seen from the centre and s = −m·w, the ray meets the plane at t = s / m·d. With
    p, q the coordinates (p·axis_u, q·axis_v the hit), it is inside if p² + q² < 1, which times (m·d)² is
    (d·b₁)² + (d·b₂)² < (m·d)², b = (a·w) m + s a for the row a that gives the coordinate.
    """
    m = disk.normal
    w = x - np.reshape(disk.center, (3, 1))
    rows = np.linalg.pinv(np.stack([disk.axis_u, disk.axis_v], axis=1))  # (2, 3)
    b = np.einsum("kn,i->nki", rows @ w, m) - (m @ w)[:, None, None] * rows
    cone: Array = np.outer(m, m) - np.einsum("nki,nkj->nij", b, b)
    return cone
