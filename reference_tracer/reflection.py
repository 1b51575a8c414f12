"""R, local reflection: the BSDFs, f and its sampling.

``wi`` points towards the light, ``wo`` towards the viewer, both away from the point; f carries no cosine.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference_tracer import sampling
from reference_tracer.points import Points
from scenes import Scene

Array = NDArray[np.float64]


class LambertianBSDF:
    """f = albedo / π on the front, 0 on the back (Lambert 1760)."""

    def __init__(self, scene: Scene) -> None:
        black = (0.0,) * scene.channels
        # one entry more than there are surfaces: NOWHERE = −1 finds it, and it is black
        self._albedo = np.array([*(s.material.albedo for s in scene.surfaces), black]).T

    def f(self, points: Points, wi: Array, wo: Array) -> Array:
        """BSDF value per channel, ``(channels, n)``, 1/sr."""
        front = (_cos(points, wi) > 0) & (_cos(points, wo) > 0)
        return self._albedo[:, points.surface] * (front / np.pi)

    def sample(self, points: Points, rng: np.random.Generator) -> Array:
        """Unit directions wi, ``(3, n)``, with density cos θ / π about the normal."""
        return sampling.to_world(sampling.square_to_cosine_hemisphere(rng.random((2, len(points)))), points.n)

    def pdf(self, points: Points, wi: Array) -> Array:
        """Solid angle density of ``sample``, ``(n,)``."""
        return sampling.square_to_cosine_hemisphere_pdf(_cos(points, wi))

    def weight(self, points: Points, wo: Array) -> Array:
        """f · cos / pdf of a sampled direction, ``(channels, n)``: just the albedo, seen from the front."""
        return self._albedo[:, points.surface] * (_cos(points, wo) > 0)


def _cos(points: Points, w: Array) -> Array:
    cosine: Array = np.einsum("in,in->n", points.n, w)
    return cosine
