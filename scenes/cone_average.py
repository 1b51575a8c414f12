"""The average over each pixel of a radiance that bends or jumps at a cone of rays: a critical angle, a shadow's rim.

Inside the cone dᵀQd > 0 the radiance may depend on √(dᵀQd), as Fresnel's equations and a refracted direction do. In
a row of the image the inside is a segment [l, r], where dᵀQd is a smooth factor times (x − l)(r − x): with
x = l + (r − l) sin² φ the root is smooth in φ. The integral along a row has kinks where the rim crosses a side of the
pixel, and roots at its top and bottom; between two of them y goes by sin², too. So Gauss's quadrature converges in
both, however the rim lies. Pixels away from the rim are left to ``pixel_average``.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from scenes.coverage import chord, cone_coverage, conic, kinks
from scenes.pixel_average import TOLERANCE, NotSmoothError, Radiance, pixel_averages, rays
from scenes.sensor import Pinhole

Array = NDArray[np.float64]

NODES = (12, 18, 27, 40)
"""Per axis and piece, one after the other until two agree."""

_AT_ONCE = 16  # pixels, with all their nodes


def average_across_cone(sensor: Pinhole, radiance: Radiance, cone: Array, axis: Array) -> Array:
    """The mean of a radiance over every pixel, ``(height, width, channels)``.

    Args:
        sensor: the cone must meet its image plane in an ellipse.
        radiance: as of ``pixel_average``; smooth outside of the rim, and inside in √(dᵀQd) as well.
        cone: Q, symmetric ``(3, 3)``, world coordinates.
        axis: a direction inside the nappe that is meant, ``(3,)``.

    Raises:
        ValueError: the conic is no ellipse.
        NotSmoothError: naming a pixel on which two quadratures disagree.
    """
    share = cone_coverage(cone, axis, sensor)
    crossed = np.pad((share > 1e-9) & (share < 1 - 1e-9), 1)
    near = np.lib.stride_tricks.sliding_window_view(crossed, (3, 3)).any(axis=(2, 3)).ravel()
    apart = pixel_averages(sensor, radiance, np.flatnonzero(~near))
    image = np.empty((len(apart), sensor.height * sensor.width))
    image[:, ~near] = apart
    q = conic(cone, axis, sensor)
    if q is not None:
        for pixels in _blocks(np.flatnonzero(near)):
            image[:, pixels] = _settled(sensor, radiance, q, pixels)
    return image.T.reshape(sensor.height, sensor.width, -1)


def _blocks(pixels: NDArray[np.intp]) -> Iterator[NDArray[np.intp]]:
    for start in range(0, len(pixels), _AT_ONCE):
        yield pixels[start : start + _AT_ONCE]


def _settled(sensor: Pinhole, radiance: Radiance, q: Array, pixels: NDArray[np.intp]) -> Array:
    """Averages over pixels near the rim, ``(channels, len(pixels))``."""
    averages = _averages(sensor, radiance, q, pixels, NODES[0])
    for count in NODES[1:]:
        finer = _averages(sensor, radiance, q, pixels, count)
        off = np.abs(finer - averages).max(axis=0)
        averages = finer
        if (off <= TOLERANCE * np.abs(averages).max()).all():
            return averages
    row, column = divmod(int(pixels[off.argmax()]), sensor.width)
    raise NotSmoothError(
        f"row {row}, column {column}: quadrature of {NODES[-2]}² and {NODES[-1]}² nodes disagree; expected a pixel "
        "that sees no edge but the cone's"
    )


def _averages(sensor: Pinhole, radiance: Radiance, q: Array, pixels: NDArray[np.intp], count: int) -> Array:
    """By Gauss's quadrature with count² nodes per piece, ``(channels, len(pixels))``."""
    rows, columns = (number.astype(float) for number in np.divmod(pixels, sensor.width))
    sides = np.broadcast_to([[0.0], [1.0]], (2, len(pixels))) + rows
    breaks = np.sort(np.concatenate([np.clip(kinks(q, columns), *sides), sides]), axis=0)
    y, dy = _along(breaks[:-1], breaks[1:], 0.0, np.pi / 2, count)  # (count, pieces, pixels)

    left, right = chord(q, y)
    start, end = np.clip(left, columns, columns + 1), np.clip(right, columns, columns + 1)
    length = np.where(right > left, right - left, 1)
    low, high = (np.arcsin(np.sqrt(np.clip((x - left) / length, 0, 1))) for x in (start, end))
    pieces = (
        _along(columns + 0 * y, start, 0.0, np.pi / 2, count),
        _along(left, left + length, low, high, count),
        _along(end, columns + 1 + 0 * y, 0.0, np.pi / 2, count),
    )
    x, dx = (np.stack(parts) for parts in zip(*pieces, strict=True))  # (3, count, count, pieces, pixels)
    y = np.broadcast_to(y, x.shape)
    values = radiance(*rays(sensor, x.ravel(), y.ravel())).reshape(-1, *x.shape)
    averages: Array = np.einsum("capijn,apijn,ijn->cn", values, dx, dy)
    return averages


def _along(
    low: Array, high: Array, start: Array | float, end: Array | float, count: int
) -> tuple[Array, Array]:
    """Nodes low + (high − low) sin² φ for φ in [start, end], and their weights, ``(count, …)`` each."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    shape = (count, *[1] * np.ndim(low))
    phi = start + (np.subtract(end, start)) * (nodes.reshape(shape) + 1) / 2
    x = low + (high - low) * np.sin(phi) ** 2
    dx = (high - low) * np.sin(2 * phi) * weights.reshape(shape) * np.subtract(end, start) / 2
    return x, dx
