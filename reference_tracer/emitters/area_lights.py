"""Area lights: surfaces that emit, and how a direction towards each shape is chosen.

A density per area p_A becomes one per solid angle at the reference by dω = cos θ dA / t²:

    p = p_A t² / cos θ                                                      (Veach 1997, eq. 8.10)

with t the distance and θ the angle at the emitter. Flat shapes and meshes are chosen by area; quads that
look large, spheres and ellipsoids by solid angle, because t² / cos θ varies without bound close to them.

What ``sample`` and ``pdf`` share is a function of reference and direction alone, so that both always take the
same way. Neither looks at the normal of the reference.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from reference_tracer import sampling
from reference_tracer.emitters.angular_profile import AngularProfile
from reference_tracer.emitters.emitter_sample import EmitterSample
from reference_tracer.emitters.near_quads import near_quad
from reference_tracer.points import Points
from reference_tracer.vectors import dot, norm, unit
from scenes import Disk, Ellipsoid, Mesh, PolarRange, Quad, Scene, Sphere, Surface

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

LOOKS_LARGE = 0.5
"""area / distance² to its centre from which on a quad is chosen by solid angle.

What it buys, measured for a square: there one sample of the irradiance from the front has the relative standard
deviation 0.02 instead of 0.10, from a slant of 70° 0.17 instead of 0.76; at 16 it is 0.24 to 0.40 instead of
1.2 to 3.6. A direction costs fourteen times as much as one by area, of a parallelogram twice that, so that a
small lamp far away does without.
"""

SMALL_ANGLE = 1e-3
"""Solid angle, sr, below which a quad is chosen by area all the same: seen edge-on, differences of angles
have no more digits to give."""


def area_lights(scene: Scene) -> dict[int, AreaEmitter]:
    """The emitters of surfaces that emit, by index of the surface."""
    emitters: dict[int, AreaEmitter] = {}
    primitive = 0
    for i, surface in enumerate(scene.surfaces):
        if surface.emits:
            emitters[i] = _emitter(surface, primitive)
        primitive += len(surface.shape.triangles) if isinstance(surface.shape, Mesh) else 1
    return emitters


def _emitter(surface: Surface, primitive: int) -> AreaEmitter:
    assert surface.emission is not None
    shape, zone = surface.shape, surface.emission.polar_range
    if isinstance(shape, Sphere) and zone is not None and zone.fraction < 1:
        return ZoneEmitter(surface, primitive, shape, zone)
    if isinstance(shape, Sphere | Ellipsoid):
        return EllipsoidEmitter(surface, primitive, shape)
    if isinstance(shape, Mesh):
        return MeshEmitter(surface, primitive, shape)
    return FlatEmitter(surface, primitive, shape)


class AreaEmitter(ABC):
    """A surface that emits. Densities are per solid angle at the reference.

    Attributes:
        radiance: ``(channels, 1)``; where there is a profile, to be multiplied by its factors.
        profile: how emission depends on the angle; None if it does not.
        power: π A · radiance, averaged over channels, a profile by its mean; twice for two sides.
    """

    def __init__(self, surface: Surface, primitive: int, area: float) -> None:
        light = surface.emission
        assert light is not None
        self.radiance = np.array(light.radiance)[:, None]
        self.primitive, self.area, self.two_sided = primitive, area, surface.two_sided
        self.profile = None if light.angular_profile is None else AngularProfile(light)
        emitted = self.radiance if self.profile is None else self.radiance * self.profile.mean[:, None]
        self.power = float(emitted.mean()) * np.pi * area * (2 if surface.two_sided else 1)

    def sample(self, reference: Points, u: Array) -> EmitterSample:
        """A direction towards the emitter for each reference and each u, ``(2, n)``."""
        sample = self._sample(reference, u)
        if self.profile is not None:
            n = self._normals_at(reference.x + sample.distance * sample.wi, sample.primitive)
            sample.Li *= self.profile(np.abs(dot(n, sample.wi)))
        return sample

    @abstractmethod
    def _sample(self, reference: Points, u: Array) -> EmitterSample:
        """The same, as if there were no profile."""

    @abstractmethod
    def _normals_at(self, x: Array, primitive: NDArray[np.intp]) -> Array:
        """Unit normals at points of the surface, of either side, ``(3, n)``."""

    @abstractmethod
    def pdf(self, reference: Points, points: Points, wi: Array) -> Array:
        """Solid angle density with which ``sample`` chooses wi, which meets lit points of this emitter."""

    def in_zone(self, x: Array) -> Mask:
        """Whether points of the surface emit at all, ``(n,)``."""
        return np.ones(x.shape[1], dtype=bool)

    def _made(
        self, wi: Array, distance: Array, pdf: Array, lit: Mask, primitive: NDArray[np.intp] | None = None
    ) -> EmitterSample:
        if primitive is None:
            primitive = np.full(len(distance), self.primitive)
        return EmitterSample(wi, distance, self.radiance * lit, pdf, False, primitive)

    def _seen(self, height: Array) -> Mask:
        """Whether a flat emitter shows a side that emits to references that high above its front."""
        return height != 0 if self.two_sided else height > 0


class FlatEmitter(AreaEmitter):
    """A quad or a disk, by area; a quad that looks large by solid angle.

    From a height h above the plane cos θ = h / t, and the density by area is t³ / (A h).
    """

    def __init__(self, surface: Surface, primitive: int, shape: Quad | Disk) -> None:
        super().__init__(surface, primitive, shape.area)
        corner, u, v = _centred(shape)
        self._warp = _square_to_centred_square if isinstance(shape, Quad) else sampling.square_to_disk
        self._center, self._edges = corner[:, None], np.stack([u, v], axis=1)
        along = u / np.linalg.norm(u)
        # rows: an orthonormal frame about the centre, its first axis along u and its third the normal
        self._axes = np.array([along, np.cross(shape.normal, along), shape.normal])
        (along_u, along_v), (_, across) = self._axes[:2] @ self._edges
        self._near = near_quad(along_u, along_v, across) if isinstance(shape, Quad) else None

    def _sample(self, reference: Points, u: Array) -> EmitterSample:
        offset = reference.x - self._center
        height = self._axes[2] @ offset
        lit = self._seen(height) & (reference.primitive != self.primitive)
        segment = self._edges @ self._warp(u) - offset
        lanes, local, angle = self._by_solid_angle(offset, lit)
        if self._near is not None and len(lanes):
            flat = self._near.sample(u.take(lanes, axis=1), local)
            segment[:, lanes] = self._axes.T @ np.stack([*flat, -local[2]])
        squared = dot(segment, segment)
        squared += squared == 0  # the reference itself was chosen: not seen, and no NaN
        distance = np.sqrt(squared)
        pdf = squared * distance / (self.area * np.abs(height) + ~lit)
        pdf[lanes] = 1 / angle
        return self._made(segment / distance, distance, pdf, lit)

    def pdf(self, reference: Points, points: Points, wi: Array) -> Array:
        """As the base class says."""
        offset = reference.x - self._center
        height = np.abs(self._axes[2] @ offset)
        lit = height > 0
        pdf: Array = lit * _cube(_distance(reference, points)) / (self.area * height + ~lit)
        lanes, _, angle = self._by_solid_angle(offset, lit)
        pdf[lanes] = 1 / angle
        return pdf

    def _normals_at(self, x: Array, primitive: NDArray[np.intp]) -> Array:
        return np.broadcast_to(self._axes[2][:, None], x.shape)

    def _by_solid_angle(self, offset: Array, lit: Mask) -> tuple[NDArray[np.intp], Array, Array]:
        """The lit lanes to which a quad looks large; their local coordinates and its solid angle there."""
        near = lit & (dot(offset, offset) * LOOKS_LARGE < self.area)
        lanes = np.flatnonzero(near) if self._near is not None else np.empty(0, dtype=np.intp)
        local = self._axes @ offset.take(lanes, axis=1)
        if self._near is None or not len(lanes):
            return lanes, local, np.empty(0)
        angle = self._near.solid_angle(local)
        kept = np.flatnonzero(angle > SMALL_ANGLE)
        return lanes[kept], local[:, kept], angle[kept]


def _centred(shape: Quad | Disk) -> tuple[Array, Array, Array]:
    """The middle, and the edges of a quad or the radii of a disk."""
    if isinstance(shape, Disk):
        return np.array(shape.center), np.array(shape.axis_u), np.array(shape.axis_v)
    u, v = np.array(shape.edge_u), np.array(shape.edge_v)
    return shape.corner + (u + v) / 2, u, v


def _square_to_centred_square(u: Array) -> Array:
    return u - 0.5


def _cube(a: Array) -> Array:
    return a * a * a  # a power takes five times as long


def _distance(reference: Points, points: Points) -> Array:
    return norm(points.x - reference.x)


class MeshEmitter(AreaEmitter):
    """A mesh, uniform by area: a triangle by its area, then a point of it."""

    def __init__(self, surface: Surface, primitive: int, shape: Mesh) -> None:
        super().__init__(surface, primitive, shape.area)
        a, b, c = shape.corners.transpose(1, 2, 0)
        self._corner, self._u, self._v = a, b - a, c - a
        self._normal = np.cross(self._u, self._v, axis=0) / (2 * shape.areas)
        self._shares = shape.areas / shape.area
        self._ends = np.cumsum(self._shares)

    def _sample(self, reference: Points, u: Array) -> EmitterSample:
        triangle = np.searchsorted(self._ends[:-1], u[0], side="right")
        # within its share of [0, 1) the first number is uniform again
        rest = (u[0] - self._ends[triangle]) / self._shares[triangle] + 1
        s, t = sampling.square_to_triangle(np.stack([np.clip(rest, 0, 1), u[1]]))
        chosen = self._corner[:, triangle] + s * self._u[:, triangle] + t * self._v[:, triangle]
        segment = chosen - reference.x
        distance = norm(segment)
        distance[distance == 0] = 1
        height = self._height(reference, triangle)
        primitive = self.primitive + triangle
        lit = self._seen(height) & (reference.primitive != primitive)
        pdf = _cube(distance) / (self.area * np.where(lit, np.abs(height), 1))
        return self._made(segment / distance, distance, pdf, lit, primitive)

    def pdf(self, reference: Points, points: Points, wi: Array) -> Array:
        """As the base class says."""
        height = np.abs(self._height(reference, points.primitive - self.primitive))
        density: Array = _cube(_distance(reference, points)) / (self.area * np.where(height > 0, height, 1))
        return density

    def _normals_at(self, x: Array, primitive: NDArray[np.intp]) -> Array:
        normals: Array = self._normal.take(primitive - self.primitive, axis=1)
        return normals

    def _height(self, reference: Points, triangle: NDArray[np.intp]) -> Array:
        """Of the references above the planes of triangles."""
        return dot(self._normal[:, triangle], reference.x - self._corner[:, triangle])


class EllipsoidEmitter(AreaEmitter):
    """A whole sphere or ellipsoid, by solid angle, in the coordinates in which it is the unit sphere.

    There a reference o sees it

        from outside   in the cone sin θ = 1 / |o|, uniform            p = 1 / 2π(1 − cos θ)
        from inside    all around, uniform                             p = 1 / 4π
        from itself    in a half space, by the cosine                  p = cos θ / π

    all about the direction to the centre. The last is the same as uniform by area: t = 2 cos θ, and
    t² / (4π cos θ) = cos θ / π. For the unit sphere mapped by a matrix M, the direction ŵ becomes
    w = M ŵ / |M ŵ|, and p becomes p |M ŵ|³ / |det M|; for a sphere that factor is 1.

    From outside the nearer of the two points along ŵ is meant, so the surface never hides what is chosen.
    """

    def __init__(self, surface: Surface, primitive: int, shape: Sphere | Ellipsoid) -> None:
        self._matrix = shape.radius * np.eye(3) if isinstance(shape, Sphere) else shape.matrix
        self._inverse, self._volume = np.linalg.inv(self._matrix), abs(np.linalg.det(self._matrix))
        super().__init__(surface, primitive, self._surface_area())
        self._center = np.array(shape.center)[:, None]
        self._lit_inside = surface.two_sided or shape.inward
        self._lit_outside = surface.two_sided or not shape.inward

    def _surface_area(self) -> float:
        """4π times the mean of dA / dω = |det M| |M⁻ᵀ ω| over the unit sphere, well enough for a choice."""
        z, weights = np.polynomial.legendre.leggauss(32)
        around = np.arange(64) / 64
        omega = sampling.from_versine(np.repeat(1 - z, 64), np.tile(around, 32))
        stretch = np.linalg.norm(self._inverse.T @ omega, axis=0).reshape(32, 64)
        return float(4 * np.pi * self._volume * (weights / 2) @ stretch.mean(axis=1))

    def _sample(self, reference: Points, u: Array) -> EmitterSample:
        o, outside, on = self._local(reference)
        squared = dot(o, o)
        radius = np.sqrt(squared)
        versine = np.where(outside, _cone(squared), 2.0) * u[0]
        versine = np.where(on, u[0] / (1 + np.sqrt(1 - u[0])), versine)  # 1 − √(1 − u)
        cosine = 1 - versine
        to_center = np.where(radius > 0, -o / np.where(radius > 0, radius, 1), [[0.0], [0.0], [1.0]])
        d = sampling.to_world(sampling.from_versine(versine, u[1]), to_center)

        # the distance t solves |o + t d|² = 1: the nearer root from outside, the farther from inside
        root = np.sqrt(np.maximum(1 - squared * versine * (2 - versine), 0))
        t = np.where(on, 2 * cosine, radius * cosine + np.where(outside, -root, root))

        world = self._matrix @ d
        stretch = norm(world)
        lit = np.where(outside, self._lit_outside, self._lit_inside)
        pdf = self._local_pdf(squared, outside, on, cosine) * _cube(stretch) / self._volume
        return self._made(world / stretch, np.maximum(t, 0) * stretch, np.where(lit, pdf, 1), lit)

    def pdf(self, reference: Points, points: Points, wi: Array) -> Array:
        """As the base class says."""
        o, outside, on = self._local(reference)
        d = self._inverse @ wi
        squeeze = norm(d)
        cosine = -dot(o, d) / squeeze
        density = self._local_pdf(dot(o, o), outside, on, cosine)
        world: Array = density / (_cube(squeeze) * self._volume)
        return world

    def _normals_at(self, x: Array, primitive: NDArray[np.intp]) -> Array:
        return unit(self._inverse.T @ (self._inverse @ (x - self._center)))

    def _local(self, reference: Points) -> tuple[Array, Mask, Mask]:
        """References where the surface is the unit sphere; whether they are outside of it; whether on it."""
        o: Array = self._inverse @ (reference.x - self._center)
        on = reference.primitive == self.primitive
        return o, (dot(o, o) > 1) & ~on, on

    def _local_pdf(self, squared: Array, outside: Mask, on: Mask, cosine: Array) -> Array:
        density = np.where(outside, sampling.square_to_cone_pdf(_cone(squared)), 1 / (4 * np.pi))
        return np.where(on, sampling.square_to_cosine_hemisphere_pdf(cosine), density)


def _cone(squared: Array) -> Array:
    """1 − cos θ of the cone in which the unit sphere is seen from the squared distance; 2 from within."""
    sine_squared = 1 / np.maximum(squared, 1)
    versine: Array = sine_squared / (1 + np.sqrt(1 - sine_squared))
    return versine


class ZoneEmitter(AreaEmitter):
    """A zone of a sphere, uniform by area."""

    def __init__(self, surface: Surface, primitive: int, shape: Sphere, zone: PolarRange) -> None:
        super().__init__(surface, primitive, shape.area * zone.fraction)
        self._center, self._radius = np.array(shape.center)[:, None], shape.radius
        self._axis, self._cosines = np.array(zone.axis), zone.cosines
        self._lit_inside = surface.two_sided or shape.inward
        self._lit_outside = surface.two_sided or not shape.inward

    def in_zone(self, x: Array) -> Mask:
        """Whether points of the sphere belong to the zone."""
        cosine = self._axis @ ((x - self._center) / self._radius)
        inside: Mask = (self._cosines[0] <= cosine) & (cosine <= self._cosines[1])
        return inside

    def _sample(self, reference: Points, u: Array) -> EmitterSample:
        axis = np.broadcast_to(self._axis[:, None], reference.x.shape)
        outward = sampling.to_world(sampling.square_to_zone(u, *self._cosines), axis)
        segment = self._center + self._radius * outward - reference.x
        distance = norm(segment)
        distance[distance == 0] = 1
        wi = segment / distance
        cosine = self._cosine(reference, outward, wi, distance)
        lit = self._lit(reference, cosine)
        pdf = distance**2 / (self.area * np.where(lit, np.abs(cosine), 1))
        return self._made(wi, distance, pdf, lit)

    def pdf(self, reference: Points, points: Points, wi: Array) -> Array:
        """As the base class says."""
        outward, distance = (points.x - self._center) / self._radius, _distance(reference, points)
        cosine = np.abs(self._cosine(reference, outward, wi, distance))
        density = distance**2 / (self.area * np.where(cosine > 0, cosine, 1))
        return np.where((cosine > 0) & self.in_zone(points.x), density, 0)

    def _normals_at(self, x: Array, primitive: NDArray[np.intp]) -> Array:
        outward: Array = (x - self._center) / self._radius
        return outward

    def _cosine(self, reference: Points, outward: Array, wi: Array, distance: Array) -> Array:
        """Of the angle between the outward normal and the way back to the reference; from itself −t / 2r."""
        on = reference.primitive == self.primitive
        return np.where(on, -distance / (2 * self._radius), -dot(outward, wi))

    def _lit(self, reference: Points, cosine: Array) -> Mask:
        """Whether the side seen emits. The inner side is seen from within alone; else the sphere hides it."""
        o = (reference.x - self._center) / self._radius
        within = (dot(o, o) <= 1) | (reference.primitive == self.primitive)
        lit: Mask = np.where(within, (cosine < 0) & self._lit_inside, (cosine > 0) & self._lit_outside)
        return lit
