"""What Mitsuba's rays meet first: its cameras and its ``ray_intersect``, without any light.

Optimised, Mitsuba would merge shapes of the same material, and none could be told from the others.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.renderers.mitsuba_names import Form
from comparisons.renderers.protocol import Hits
from scenes import Orthographic, Scene

Array = NDArray[np.float64]


def first_hits(mi: Any, loaded: Any, scene: Scene, form: Form) -> Hits:
    """See ``protocol.SeesFirstHits``.

    Args:
        mi: the module, its variant set.
        loaded: the scene, as Mitsuba has it.
        scene: the scene, as we do.
        form: whether rays go one by one or all at once.
    """
    p, n, surface = (_all_at_once if form.compiled else _one_by_one)(mi, loaded, scene)
    # its rays begin at the near plane, so its own distance is not the one from the sensor
    to_hit = p - np.array(scene.sensor.origin)[:, None]
    if isinstance(scene.sensor, Orthographic):
        distance = scene.sensor.frame[:, 2] @ to_hit
    else:
        distance = np.linalg.norm(to_hit, axis=0)
    hits = np.array([np.where(surface >= 0, distance, np.inf), *np.where(surface >= 0, n, 0.0), surface])
    return hits


def _one_by_one(mi: Any, loaded: Any, scene: Scene) -> tuple[Array, Array, Array]:
    """Points and normals, ``(3, pixels)``, and indices of surfaces, −1 where there is none."""
    [sensor], film = loaded.sensors(), _centres(scene)
    p, n = np.zeros((2, 3, film.shape[1]))
    surface = np.full(film.shape[1], -1.0)
    for i, point in enumerate(film.T.tolist()):
        ray, _ = sensor.sample_ray(0.0, 0.5, point, [0.5, 0.5])
        found = loaded.ray_intersect(ray)
        if found.is_valid():
            p[:, i], n[:, i], surface[i] = found.p, found.n, _index(found.shape)
    return p, n, surface


def _all_at_once(mi: Any, loaded: Any, scene: Scene) -> tuple[Array, Array, Array]:
    import drjit

    [sensor], film = loaded.sensors(), _centres(scene)
    ray, _ = sensor.sample_ray(0.0, 0.5, mi.Point2f(film.astype(np.float32)), mi.Point2f(0.5))
    found = loaded.ray_intersect(ray)

    def number(shape: Any) -> Any:
        return np.array(drjit.reinterpret_array(mi.UInt32, shape))

    indices = {int(number(mi.ShapePtr(shape))[0]): _index(shape) for shape in loaded.shapes()}
    surface = np.array([indices.get(int(i), -1) for i in number(found.shape)], dtype=np.float64)
    return np.array(found.p, dtype=np.float64), np.array(found.n, dtype=np.float64), surface


def _centres(scene: Scene) -> Array:
    """Of the pixels, row by row, on a film of 1 × 1, ``(2, pixels)``."""
    height, width, _ = scene.shape
    row, column = np.mgrid[:height, :width].reshape(2, -1) + 0.5
    return np.array([column / width, row / height])


def _index(shape: Any) -> int:
    return int(shape.id().removeprefix("surface"))
