"""Pictures that are data of a scene: textures and environment maps."""

from __future__ import annotations

import msgspec
import numpy as np
from numpy.typing import NDArray

from scenes.validation import SceneError, path

Pixel = tuple[float, ...]


class Image(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A grid of values per channel.

    Attributes:
        pixels: rows from the top, each a list of pixels, each one number ≥ 0 per channel.
    """

    pixels: tuple[tuple[Pixel, ...], ...]

    def __post_init__(self) -> None:
        rows = (
            np.asarray(self.pixels, dtype=object) if not isinstance(self.pixels, np.ndarray) else self.pixels
        )
        if rows.ndim != 3 or 0 in rows.shape:
            raise SceneError(path(self, "pixels"), "no rectangle", "rows × columns × channels of numbers")
        try:
            values = rows.astype(float)
        except (TypeError, ValueError):
            values = np.full(rows.shape, np.nan)
        if not (np.isfinite(values) & (values >= 0)).all():
            place = tuple(np.argwhere(~(np.isfinite(values) & (values >= 0)))[0])
            field = "pixels" + "".join(f"[{i}]" for i in place)
            raise SceneError(path(self, field), rows[place], "a finite number ≥ 0")
        frozen = tuple(tuple(tuple(pixel) for pixel in row) for row in values.tolist())
        msgspec.structs.force_setattr(self, "pixels", frozen)

    @property
    def array(self) -> NDArray[np.float64]:
        """The pixels, ``(rows, columns, channels)``."""
        return np.array(self.pixels)

    @property
    def channels(self) -> int:
        """Numbers per pixel."""
        return len(self.pixels[0][0])
