"""Rays that go on where they should have stopped, for faults of G."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reference_tracer import propagation
from reference_tracer.points import NOWHERE, Points
from reference_tracer.propagation import RayCaster
from reference_tracer.vectors import dot

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

LAYERS = 16
"""Surfaces that a ray passes at most."""


def farthest(nearest: Callable[..., Any]) -> Callable[..., Any]:
    """Goes on from each hit, as long as there is another."""

    def last(shapes: Any, origin: Points, d: Array) -> tuple[Array, Indices]:
        t, primitive = nearest(shapes, origin, d)
        lanes = np.flatnonzero(primitive != NOWHERE)
        for _ in range(LAYERS):
            here = replace(
                origin[lanes], x=origin.x[:, lanes] + t[lanes] * d[:, lanes], primitive=primitive[lanes]
            )
            further, then = nearest(shapes, here, d[:, lanes])
            goes_on = then != NOWHERE
            lanes = lanes[goes_on]
            if not len(lanes):
                break
            t[lanes] += further[goes_on]
            primitive[lanes] = then[goes_on]
        return t, primitive

    return last


def through_backs(cast: Callable[..., Any]) -> Callable[..., Any]:
    """``RayCaster.__call__`` that goes on from hits that are met from behind."""

    def culling(self: RayCaster, origin: Points, d: Array) -> Points:
        points: Points = cast(self, origin, d)
        for _ in range(LAYERS):
            lanes = np.flatnonzero((points.surface != NOWHERE) & (dot(points.n, d) > 0))
            if not len(lanes):
                break
            behind = cast(self, points[lanes], d[:, lanes])
            for field, values in vars(behind).items():
                if values is not None:
                    getattr(points, field)[..., lanes] = values
        return points

    return culling


def visible_through_backs(visible: Callable[..., Any]) -> Callable[..., Any]:
    """``RayCaster.visible`` for which what is met from behind is not in the way."""

    def culling(
        self: RayCaster, origin: Points, d: Array, distance: Array, target: Indices
    ) -> NDArray[np.bool_]:
        seen: NDArray[np.bool_] = visible(self, origin, d, distance, target)
        lanes = np.flatnonzero(~seen)
        passed, start = np.zeros(len(origin)), origin
        for _ in range(LAYERS):
            if not len(lanes):
                break
            start = start[lanes] if start is origin else start
            t, primitive = propagation._nearest(self._occluders, start, d[:, lanes])
            points = self._coordinates.points(start.x + t * d[:, lanes], d[:, lanes], primitive)
            back = dot(points.n, d[:, lanes]) > 0
            passed[lanes] += t
            start, lanes = points[back], lanes[back]
            now = visible(self, start, d[:, lanes], distance[lanes] - passed[lanes], target[lanes])
            seen[lanes] = now
            start, lanes = start[~now], lanes[~now]
        return seen

    return culling
