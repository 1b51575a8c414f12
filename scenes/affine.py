"""Affine maps x ↦ A x + b: what moves, turns, scales, mirrors and shears."""

from __future__ import annotations

import math
from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes.tables import table
from scenes.validation import SceneError, Vector, path, vector

Array = NDArray[np.float64]

_ORIGIN: Vector = (0.0, 0.0, 0.0)
_UNCHANGED: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class Affine(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """x ↦ A x + b with an invertible A. ``F @ G`` first applies G, then F.

    Attributes:
        linear: A, row by row.
        offset: b, world units.
    """

    linear: tuple[Vector, Vector, Vector] = _UNCHANGED
    offset: Vector = _ORIGIN

    def __post_init__(self) -> None:
        matrix = table(self, "linear", (3, 3))
        vector(self, "offset")
        largest = np.abs(matrix).max()
        if not (largest > 0 and abs(np.linalg.det(matrix / largest)) > 1e-12):
            raise SceneError(path(self, "linear"), self.linear, "a matrix that can be inverted")

    @classmethod
    def translation(cls, by: Sequence[float]) -> Affine:
        """Moves by a vector."""
        return cls(offset=by)  # type: ignore[arg-type]

    @classmethod
    def rotation(cls, axis: Sequence[float], degrees: float) -> Affine:
        """Turns about an axis through the origin, counterclockwise seen from its tip (Rodrigues 1840)."""
        x, y, z = _unit("axis", axis)
        K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        angle = math.radians(degrees)
        return cls._of(np.eye(3) + math.sin(angle) * K + (1 - math.cos(angle)) * K @ K)

    @classmethod
    def scaling(cls, factor: float | Sequence[float]) -> Affine:
        """Scales about the origin: by one factor, or by one per axis; a negative one mirrors as well."""
        factors = np.asarray(factor, dtype=float)
        if factors.shape not in ((), (3,)):
            raise SceneError("Affine.factor", factor, "one number, or three x, y, z")
        return cls._of(np.diag(np.broadcast_to(factors, 3)))

    @classmethod
    def reflection(cls, normal: Sequence[float]) -> Affine:
        """Mirrors in the plane through the origin with that normal: A = I − 2 n nᵀ."""
        n = _unit("normal", normal)
        return cls._of(np.eye(3) - 2 * np.outer(n, n))

    @classmethod
    def _of(cls, matrix: ArrayLike, offset: ArrayLike = _ORIGIN) -> Affine:
        return cls(matrix, offset)  # type: ignore[arg-type]  # frozen into tuples

    def __matmul__(self, first: Affine) -> Affine:
        return self._of(self.matrix @ first.matrix, self.points(first.offset))

    @property
    def inverse(self) -> Affine:
        """What takes it back."""
        back = np.linalg.inv(self.matrix)
        return self._of(back, -back @ self.offset)

    @property
    def matrix(self) -> Array:
        """A, ``(3, 3)``."""
        return np.array(self.linear)

    @property
    def mirrors(self) -> bool:
        """Whether right hands become left ones: det A < 0."""
        return bool(np.linalg.det(self.matrix / np.abs(self.matrix).max()) < 0)

    @property
    def scale(self) -> float | None:
        """The factor s of a similarity, AᵀA = s² I to rounding; None for any other map."""
        A = self.matrix
        s = float(np.linalg.norm(A, axis=0).mean())
        return s if np.allclose(A.T @ A / s**2, np.eye(3), rtol=0, atol=1e-9) else None

    def points(self, x: ArrayLike) -> Array:
        """A x + b, ``(3, …)``."""
        moved = self.vectors(x)
        offset: Array = np.reshape(self.offset, (3,) + (1,) * (moved.ndim - 1))
        return moved + offset

    def vectors(self, v: ArrayLike) -> Array:
        """A v, ``(3, …)``: differences of points."""
        return np.tensordot(self.matrix, np.asarray(v, dtype=float), axes=1)

    def normals(self, n: ArrayLike) -> Array:
        """A⁻ᵀ n, ``(3, …)``, not normalised: across whatever was across n, and still on its side."""
        return np.tensordot(np.linalg.inv(self.matrix).T, np.asarray(n, dtype=float), axes=1)


def _unit(field: str, direction: Sequence[float]) -> Array:
    n = np.asarray(direction, dtype=float)
    length = math.hypot(*n) if n.shape == (3,) else 0.0
    if not 0 < length < math.inf:
        raise SceneError(f"Affine.{field}", direction, "a direction x, y, z, not the zero vector")
    unit: Array = n / length
    return unit
