"""Pictures that are data of a scene: textures and environment maps."""

from __future__ import annotations

import msgspec
import numpy as np
from numpy.typing import NDArray

from scenes.tables import table

Pixel = tuple[float, ...]


class Image(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A grid of values per channel.

    Attributes:
        pixels: rows from the top, each a list of pixels, each one number ≥ 0 per channel.
    """

    pixels: tuple[tuple[Pixel, ...], ...]

    def __post_init__(self) -> None:
        table(self, "pixels", (None, None, None), low=0.0)

    @property
    def array(self) -> NDArray[np.float64]:
        """The pixels, ``(rows, columns, channels)``."""
        return np.array(self.pixels)

    @property
    def channels(self) -> int:
        """Numbers per pixel."""
        return len(self.pixels[0][0])
