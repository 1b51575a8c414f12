"""Pixels of an orthographic camera as rectangles on a rectangle, where its rows run along an edge of that rectangle.

Parallel rays carry the grid of pixels to the plane of the rectangle, stretched along the slope if they come
slantwise: a pixel of area a covers a / cos β there, β the angle between ray and normal. What is linear in an area on
the rectangle, such as the flux that arrives there, then has an exact average over a pixel, also over one that sees
the rectangle's edge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenes.sensor import Orthographic
from scenes.shapes import Quad

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PixelsOnRectangle:
    """Where the columns and the rows of an image begin and end on a rectangle.

    Attributes:
        frame: unit vectors along a row of the image, along a column, and the rectangle's normal, as rows, ``(3, 3)``.
            The first two run along the rectangle's edges, from its corner.
        corner: of the rectangle, ``(3,)``.
        columns, rows: in units of the world from the corner, cut off where the rectangle ends, ``(width + 1,)`` and
            ``(height + 1,)``.
        area: of a whole pixel in the plane of the rectangle.
    """

    frame: Array
    corner: Array
    columns: Array
    rows: Array
    area: float

    def local(self, points: Array) -> Array:
        """Coordinates of points ``(n, 3)``: along a row, along a column, above the rectangle, ``(3, n)``."""
        coordinates: Array = self.frame @ (points - self.corner).T
        return coordinates


def pixels_on(rectangle: Quad, sensor: Orthographic) -> PixelsOnRectangle:
    """The grid of pixels in the plane of a rectangle.

    Raises:
        ValueError: the camera does not see the front, or its rows do not run along an edge.
    """
    corner, n = np.array(rectangle.corner), rectangle.normal
    lengths = np.linalg.norm([rectangle.edge_u, rectangle.edge_v], axis=1)
    axes = np.stack([*(np.array([rectangle.edge_u, rectangle.edge_v]) / lengths[:, None]), n])
    forward = axes @ sensor.frame[:, 2]
    if not forward[2] < -1e-9:
        raise ValueError("expected a camera that looks at the front of the receiver")

    # pixels → where their rays meet the plane, in the rectangle's coordinates
    M = axes @ sensor.pixel_to_offset
    M[:, 2] += axes @ (np.array(sensor.origin) - corner)
    M -= np.outer(forward / forward[2], M[2])
    across = 0 if abs(M[0, 0]) > abs(M[1, 0]) else 1  # which coordinate runs along a row of the image
    if not np.allclose([M[1 - across, 0], M[across, 1]], 0, rtol=0, atol=1e-12 * abs(M[across, 0])):
        raise ValueError("expected a camera whose rows run along an edge of the receiver")
    columns = M[across, 2] + M[across, 0] * np.arange(sensor.width + 1)
    rows = M[1 - across, 2] + M[1 - across, 1] * np.arange(sensor.height + 1)
    return PixelsOnRectangle(
        axes[[across, 1 - across, 2]],
        corner,
        np.clip(columns, 0, lengths[across]),
        np.clip(rows, 0, lengths[1 - across]),
        float(abs(M[across, 0] * M[1 - across, 1])),
    )
