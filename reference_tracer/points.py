"""Points of surfaces, in blocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

NOWHERE = -1
"""The surface index of a point on no surface: the pinhole, or where a ray leaves the scene."""


@dataclass
class Points:
    """A block of n points of surfaces.

    Attributes:
        x: positions, ``(3, n)``.
        n: unit normals, ``(3, n)``: of the front, and of the side that was met where there are two; +z NOWHERE,
            so that a frame about it exists.
        surface: index of the surface in the scene, ``(n,)``; NOWHERE where there is none.
        primitive: index among all primitives, ``(n,)``: a mesh has one per triangle, other surfaces have one.
            None: as ``surface``, in a scene without meshes.
        ns: unit shading normals, ``(3, n)``. None: ``n`` itself, where no mesh has its own.
        uv: texture coordinates, ``(2, n)``; None in a scene without textures.
    """

    x: Array
    n: Array
    surface: Indices
    primitive: Indices = None  # type: ignore[assignment]
    ns: Array = None  # type: ignore[assignment]
    uv: Array | None = None

    def __post_init__(self) -> None:
        self.primitive = self.surface if self.primitive is None else self.primitive
        self.ns = self.n if self.ns is None else self.ns

    def __len__(self) -> int:
        return len(self.surface)

    def __getitem__(self, lanes: Indices | NDArray[np.bool_]) -> Points:
        if lanes.dtype == bool:
            lanes = np.flatnonzero(lanes)
        # take is several times faster than indexing
        n = self.n.take(lanes, axis=1)
        surface = self.surface.take(lanes)
        return Points(
            self.x.take(lanes, axis=1),
            n,
            surface,
            surface if self.primitive is self.surface else self.primitive.take(lanes),
            n if self.ns is self.n else self.ns.take(lanes, axis=1),
            None if self.uv is None else self.uv.take(lanes, axis=1),
        )

    @classmethod
    def nowhere(cls, x: Array) -> Points:
        """Points in empty space, such as a pinhole."""
        count = x.shape[1]
        n, none = np.tile([[0.0], [0.0], [1.0]], count), np.full(count, NOWHERE)
        return cls(x, n, none)
