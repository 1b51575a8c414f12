"""Regions of an image: the whole of it, and a grid of tiles. A verdict is about their means."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from comparisons.results import Place

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Regions:
    """The whole image (region 0) and its tiles (regions 1, 2, …, row by row).

    Attributes:
        height, width: of the image, pixels.
        rows, columns: of the grid; at most one tile per pixel.
    """

    height: int
    width: int
    rows: int
    columns: int

    @classmethod
    def of(cls, height: int, width: int, tiles: tuple[int, int]) -> Regions:
        """The grid for an image; a grid finer than the pixels is made as fine as the pixels."""
        return cls(height, width, min(tiles[0], height), min(tiles[1], width))

    def _edges(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        y = np.arange(self.rows + 1) * self.height // self.rows
        x = np.arange(self.columns + 1) * self.width // self.columns
        return y, x

    def means(self, images: Array) -> Array:
        """Means over the regions.

        Args:
            images: ``(bounces + 1, height, width, channels)``.

        Returns:
            ``(1 + tiles, bounces + 1, channels)``.
        """
        return self._sums(images) / self.pixels()[:, None]

    def stderr(self, stderr: Array) -> Array:
        """Standard errors of the means over the regions, from those of independent pixels; shapes as above."""
        return np.sqrt(self._sums(stderr**2)) / self.pixels()[:, None]

    def _sums(self, images: Array) -> Array:
        y, x = self._edges()
        tiles = np.add.reduceat(np.add.reduceat(images, y[:-1], axis=1), x[:-1], axis=2)
        tiles = np.moveaxis(tiles.reshape(len(images), -1, images.shape[-1]), 1, 0)
        return np.concatenate([tiles.sum(axis=0, keepdims=True), tiles])

    def pixels(self) -> Array:
        """How many pixels each region has, ``(1 + tiles, 1)``."""
        y, x = self._edges()
        tiles = np.outer(np.diff(y), np.diff(x)).ravel()
        return np.append(tiles.sum(), tiles).astype(float)[:, None]

    def place(self, region: int) -> Place:
        """Where a tile lies; ``region`` ≥ 1."""
        row, column = divmod(region - 1, self.columns)
        y, x = self._edges()
        return Place(
            row=row,
            column=column,
            x0=int(x[column]),
            y0=int(y[row]),
            x1=int(x[column + 1]),
            y1=int(y[row + 1]),
        )
