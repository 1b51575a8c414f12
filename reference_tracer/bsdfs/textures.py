"""Textures: values that depend on the texture coordinates (u, v) of a point.

An image lies with its top left corner at (0, 1) and its bottom right one at (1, 0); the centre of the pixel in
row r and column c of R × C is u = (c + ½) / C, v = 1 − (r + ½) / R.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from reference_tracer.bsdfs.bsdf import table
from reference_tracer.points import Points
from scenes import Checkerboard, ImageTexture, Texture

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class Albedo:
    """A reflectance per surface: a number per channel, or a texture of such."""

    def __init__(self, albedos: Sequence[tuple[float, ...] | Texture | None], channels: int) -> None:
        black = (0.0,) * channels
        self._table = table(albedos, lambda a: black if isinstance(a, Texture) else a, black)
        self._textures = [(i, evaluator(a)) for i, a in enumerate(albedos) if isinstance(a, Texture)]

    def __call__(self, points: Points, surface: Indices) -> Array:
        """Values at the points, ``(channels, n)``, as if their surfaces were the ones given, ``(n,)``."""
        values: Array = self._table.take(surface, axis=1)
        for i, texture in self._textures:
            lanes = np.flatnonzero(surface == i)
            if len(lanes):
                if points.uv is None:
                    raise ValueError(f"surface {i} has a texture; expected points with uv, found None")
                values[:, lanes] = texture(points.uv[:, lanes])
        return values


class CheckerboardTexture:
    """Squares in turn: even where ⌊columns · u⌋ + ⌊rows · v⌋ is even, beyond [0, 1] too."""

    def __init__(self, texture: Checkerboard) -> None:
        self._squares = np.array([[texture.columns], [texture.rows]], dtype=float)
        self._values = np.array([texture.even, texture.odd]).T

    def __call__(self, uv: Array) -> Array:
        """Values at texture coordinates ``(2, n)``, ``(channels, n)``."""
        square = np.floor(self._squares * uv).sum(axis=0) % 2
        values: Array = self._values.take(square.astype(np.intp), axis=1)
        return values


class NearestTexture:
    """The value of the pixel that holds the point; beyond the image that of its border."""

    def __init__(self, texture: ImageTexture) -> None:
        self._pixels = np.moveaxis(texture.image.array, 2, 0)

    def __call__(self, uv: Array) -> Array:
        """Values at texture coordinates ``(2, n)``, ``(channels, n)``."""
        rows, columns = self._pixels.shape[1:]
        row = np.clip(np.floor((1 - uv[1]) * rows), 0, rows - 1).astype(np.intp)
        column = np.clip(np.floor(uv[0] * columns), 0, columns - 1).astype(np.intp)
        return self._pixels[:, row, column]


class BilinearTexture:
    """Linear in u and in v between the centres of pixels, constant beyond the last of them."""

    def __init__(self, texture: ImageTexture) -> None:
        self._pixels = np.moveaxis(texture.image.array, 2, 0)

    def __call__(self, uv: Array) -> Array:
        """Values at texture coordinates ``(2, n)``, ``(channels, n)``."""
        rows, columns = self._pixels.shape[1:]
        top, below, down = _neighbours((1 - uv[1]) * rows - 0.5, rows)
        left, right, across = _neighbours(uv[0] * columns - 0.5, columns)
        upper = (1 - across) * self._pixels[:, top, left] + across * self._pixels[:, top, right]
        lower = (1 - across) * self._pixels[:, below, left] + across * self._pixels[:, below, right]
        return (1 - down) * upper + down * lower


def evaluator(texture: Texture) -> CheckerboardTexture | NearestTexture | BilinearTexture:
    """What evaluates a texture."""
    if isinstance(texture, Checkerboard):
        return CheckerboardTexture(texture)
    return BilinearTexture(texture) if texture.interpolation == "bilinear" else NearestTexture(texture)


def _neighbours(position: Array, count: int) -> tuple[Indices, Indices, Array]:
    """The pixels before and after a position in units of pixel centres, and how far it is between them."""
    position = np.clip(position, 0, count - 1)
    before = np.floor(position).astype(np.intp)
    return before, np.minimum(before + 1, count - 1), position - before
