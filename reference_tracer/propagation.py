"""G, propagation: the ray-cast function r(x, l), where the ray from x along l first meets a surface.

There is no ray offset. A ray that starts on a surface knows which: a plane is not met again, and a sphere only
at the other root of its quadratic, which is then −2 (x − c)·l. Scenes of any size give the same radiance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenes import Quad, Scene, Sphere

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

NOWHERE = -1
"""The surface index of a point on no surface: the pinhole, or where a ray leaves the scene."""


@dataclass
class Points:
    """A block of n points of surfaces.

    Attributes:
        x: positions, ``(3, n)``.
        n: unit normals of the front, ``(3, n)``; +z NOWHERE, so that a frame about it exists.
        surface: index of the surface in the scene, ``(n,)``; NOWHERE where there is none.
        ns: shading normals, ``(3, n)``; the array n itself where no mesh has its own.
        uv: texture coordinates, ``(2, n)``; None in a scene without textures.
    """

    x: Array
    n: Array
    surface: Indices
    ns: Array = None  # type: ignore[assignment]
    uv: Array | None = None

    def __post_init__(self) -> None:
        if self.ns is None:
            self.ns = self.n

    def __len__(self) -> int:
        return len(self.surface)

    def __getitem__(self, lanes: NDArray[np.bool_] | Indices) -> Points:
        n = self.n[:, lanes]
        ns = n if self.ns is self.n else self.ns[:, lanes]
        uv = None if self.uv is None else self.uv[:, lanes]
        return Points(self.x[:, lanes], n, self.surface[lanes], ns, uv)

    @classmethod
    def nowhere(cls, x: Array) -> Points:
        """Points in empty space, such as a pinhole."""
        count = x.shape[1]
        return cls(x, np.tile([[0.0], [0.0], [1.0]], count), np.full(count, NOWHERE))


class RayCaster:
    """The ray-cast function of a scene."""

    def __init__(self, scene: Scene) -> None:
        shapes = [surface.shape for surface in scene.surfaces]
        self.quads = np.array([i for i, s in enumerate(shapes) if isinstance(s, Quad)], dtype=np.intp)
        self.spheres = np.array([i for i, s in enumerate(shapes) if isinstance(s, Sphere)], dtype=np.intp)
        self._normals = np.tile([0.0, 0.0, 1.0], (len(shapes) + 1, 1))  # the last one is that of NOWHERE
        self._prepare_quads([s for s in shapes if isinstance(s, Quad)])
        self._prepare_spheres([s for s in shapes if isinstance(s, Sphere)])

    def _prepare_quads(self, quads: list[Quad]) -> None:
        """World to local: in the frame (edge_u, edge_v, normal) a quad is the square |a|, |b| ≤ 1, c = 0."""
        if not quads:
            return
        corner, u, v = (np.array([getattr(q, f) for q in quads]) for f in ("corner", "edge_u", "edge_v"))
        n = np.array([q.normal for q in quads])
        self._normals[self.quads] = n
        rows = np.linalg.inv(np.stack([u / 2, v / 2, n], axis=2))  # (quads, 3 local axes, 3 world axes)
        offsets = -np.einsum("qij,qj->qi", rows, corner + (u + v) / 2)
        # the same local axis of all quads lies together, so that each is one matrix product with all rays
        self._axes, self._offsets = rows.transpose(1, 0, 2).copy(), offsets.T[:, :, None].copy()

    def _prepare_spheres(self, spheres: list[Sphere]) -> None:
        self._centers = np.array([s.center for s in spheres]).reshape(-1, 3)
        self._radii = np.array([s.radius for s in spheres])
        self._signs = np.array([-1.0 if s.inward else 1.0 for s in spheres])

    def __call__(self, origin: Points, d: Array) -> Points:
        """r(x, d): the first points that rays meet.

        Args:
            origin: where they start, n points.
            d: unit directions, ``(3, n)``.

        Returns:
            n points, NOWHERE for rays that leave the scene.
        """
        t, surface = np.full(len(origin), np.inf), np.full(len(origin), NOWHERE)
        for nearest, which in ((self._nearest_quad, self.quads), (self._nearest_sphere, self.spheres)):
            if len(which):
                t_near, index = nearest(origin, d)
                closer = t_near < t
                t, surface = np.where(closer, t_near, t), np.where(closer, which[index], surface)
        x = origin.x + np.where(np.isfinite(t), t, 0) * d
        return self._on_surface(x, surface)

    def _nearest_quad(self, origin: Points, d: Array) -> tuple[Array, Indices]:
        """Distance to the nearest quad, inf where there is none, and its index among the quads."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # rays parallel to a plane
            t = (self._axes[2] @ origin.x + self._offsets[2]) / -(self._axes[2] @ d)
            met = t > 0
            for axis in (0, 1):
                local = self._axes[axis] @ origin.x + self._offsets[axis] + t * (self._axes[axis] @ d)
                met &= np.abs(local) <= 1
        met &= origin.surface != self.quads[:, None]
        t = np.where(met, t, np.inf)
        index = t.argmin(axis=0)
        return np.take_along_axis(t, index[None], axis=0)[0], index

    def _nearest_sphere(self, origin: Points, d: Array) -> tuple[Array, Indices]:
        """Distance to the nearest sphere, inf where there is none, and its index among the spheres."""
        t = np.empty((len(self.spheres), len(origin)))
        for i, (center, radius) in enumerate(zip(self._centers, self._radii, strict=True)):
            o = origin.x - center[:, None]
            b = np.einsum("in,in->n", o, d)
            root = b**2 - (np.einsum("in,in->n", o, o) - radius**2)
            starts_here = origin.surface == self.spheres[i]
            with np.errstate(invalid="ignore"):  # no real root: nan, which is not > 0
                near, far = -b - np.sqrt(root), -b + np.sqrt(root)
            first = np.where(near > 0, near, far)
            first = np.where(starts_here, -2 * b, first)
            t[i] = np.where(first > 0, first, np.inf)
        index = t.argmin(axis=0)
        return np.take_along_axis(t, index[None], axis=0)[0], index

    def _on_surface(self, x: Array, surface: Indices) -> Points:
        """The points with their normals; on a sphere, x is put back onto it, since t is rounded."""
        n = self._normals.T[:, surface]
        for i, center, radius, sign in zip(
            self.spheres, self._centers, self._radii, self._signs, strict=True
        ):
            lanes = surface == i
            outward = x[:, lanes] - center[:, None]
            outward /= np.linalg.norm(outward, axis=0)
            x[:, lanes], n[:, lanes] = center[:, None] + radius * outward, sign * outward
        return Points(x, n, surface)
