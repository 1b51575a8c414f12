"""Whether what rays have met is what another camera would have seen: then the sensor is wrong, and no shape.

The closed forms of ``scenes.first_hit`` are tried for cameras that are wrong in the usual ways: pixels looked at
through another point of them, rows or columns in reverse order, the angle of view along the other axis.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from math import atan, degrees, radians, tan

import msgspec
import numpy as np
from numpy.typing import NDArray

from comparisons.renderers import Hits
from scenes import Orthographic, Pinhole, Scene, ThinLens
from scenes.first_hit import FirstHits, first_hits

Array = NDArray[np.float64]

_STEPS = (-1.0, -0.5, 0.0, 0.5, 1.0)
_ENOUGH = 0.98
"""Share of pixels that another camera explains; the rest lie on edges. The right one must explain fewer."""

_DISTANCE = 1e-3


def other_camera(scene: Scene, found: Hits) -> str:
    """Which wrong camera sees this, as a clause; empty if none of those that are tried does.

    Args:
        scene: with the right camera.
        found: what the renderer's rays have met; see ``renderers.protocol.SeesFirstHits``.
    """
    shares = {what: _share(hits, found) for what, hits in _cameras(scene)}
    best = max(shares, key=lambda what: shares[what])
    right = _share(first_hits(scene), found)
    return best if shares[best] >= _ENOUGH and shares[best] - right >= 1 - _ENOUGH else ""


def _cameras(scene: Scene) -> Iterator[tuple[str, FirstHits]]:
    height, width, _ = scene.shape
    for right, down in product(_STEPS, _STEPS):
        if right or down:
            at = (0.5 + right, 0.5 + down)
            yield f"as if it looked {right:+g} pixels to the right and {down:+g} down", first_hits(scene, at)
    straight, grid = first_hits(scene), np.arange(height * width).reshape(height, width)
    for what, order in (
        ("as if left were right", grid[:, ::-1]),
        ("as if the first row were the lowest", grid[::-1]),
        ("as if the image were turned upside down", grid[::-1, ::-1]),
    ):
        i = order.ravel()
        yield what, FirstHits(straight.distance[i], straight.normal[:, i], straight.surface[i])
    if height != width:
        yield "as if its angle of view were along the other axis", first_hits(_along_the_other(scene))


def _along_the_other(scene: Scene) -> Scene:
    sensor = scene.sensor
    narrower = min(sensor.width, sensor.height) / max(sensor.width, sensor.height)
    if isinstance(sensor, Pinhole | ThinLens):
        fov = 2 * degrees(atan(tan(radians(sensor.fov) / 2) * narrower))
        return msgspec.structs.replace(scene, sensor=msgspec.structs.replace(sensor, fov=fov))
    assert isinstance(sensor, Orthographic)
    return msgspec.structs.replace(
        scene, sensor=msgspec.structs.replace(sensor, extent=sensor.extent * narrower)
    )


def _share(expected: FirstHits, found: Hits) -> float:
    """Of the pixels that would see just this."""
    distance, surface = found[0], found[4].astype(int)
    with np.errstate(invalid="ignore"):
        near = np.abs(distance - expected.distance) <= _DISTANCE * expected.distance
    near |= np.isinf(distance) & np.isinf(expected.distance)
    return float(np.mean(near & (surface == expected.surface)))
