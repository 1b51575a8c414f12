"""Images as PFM (portable float map): 32-bit floats, scene-linear, three channels, rows from the bottom."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def pfm(pixels: NDArray[np.float64]) -> bytes:
    """The content of the file.

    Args:
        pixels: ``(rows, columns, 3)``, row 0 at the top.
    """
    rows, columns, _ = pixels.shape
    # a negative scale says little-endian
    return f"PF\n{columns} {rows}\n-1.0\n".encode() + pixels[::-1].astype("<f4").tobytes()
