"""The sensor: rays through pixels, and the mean over each pixel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference_tracer.points import Points
from scenes import Pinhole

Array = NDArray[np.float64]


def camera_rays(sensor: Pinhole, pixels: NDArray[np.intp], rng: np.random.Generator) -> tuple[Points, Array]:
    """Rays through uniformly random points of pixels: the box filter, sampled.

    Args:
        sensor: the camera.
        pixels: row-major pixel indices, ``(n,)``.
        rng: two numbers are drawn for each ray.

    Returns:
        Their origins, and unit directions ``(3, n)``.
    """
    u = rng.random((2, len(pixels)))
    rows, columns = np.divmod(pixels, sensor.width)
    d = sensor.pixel_to_direction @ np.stack([columns + u[0], rows + u[1], np.ones(len(pixels))])
    d /= np.linalg.norm(d, axis=0)
    return Points.nowhere(np.tile(np.array(sensor.origin)[:, None], len(pixels))), d
