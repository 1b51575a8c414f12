"""Mitsuba 3, variant ``scalar_rgb``, integrator ``path``.

Conventions that are translated here, and nowhere else:

- ``max_depth = d`` holds bounces 0 … d − 1, so TᵏE is the difference of depths k + 1 and k. Both are rendered
  one sample at a time with the sampler ``independent`` and the same seed: each pixel then restarts the same
  stream of random numbers at every depth, the two share their paths, and the difference is the single term
  with the noise of that term alone.
- What a scene is made of: ``mitsuba_scene.py``.

Switched off, because it makes an image inexact on purpose: Russian roulette (``rr_depth``), the Gaussian
reconstruction filter (``box``) and half-precision output.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.renderers.mitsuba_scene import scene_dict
from comparisons.renderers.protocol import Hits, Images, Unsupported
from scenes import Orthographic, Scene

Array = NDArray[np.float64]

_NO_ROULETTE = 1 << 30


class MitsubaRenderer:
    """Mitsuba 3 in one of its variants."""

    def __init__(self, variant: str) -> None:
        import drjit
        import mitsuba

        mitsuba.set_variant(variant)
        mitsuba.set_log_level(mitsuba.LogLevel.Warn)
        drjit.set_thread_count(1)  # work is split over processes, by replicate
        self._mi: Any = mitsuba
        self._load = lru_cache(maxsize=8)(self._load_scene)  # relations take scenes in turn

    def version(self) -> str:
        """Of Mitsuba."""
        return str(self._mi.__version__)

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        """Coupled differences of depths, averaged over one-sample renders; see the protocol.

        Mitsuba's scalar sampler starts the stream of a pixel at the state pixel + seed × pixels, modulo 2³².
        Streams of consecutive states begin alike: with consecutive seeds, a sample each, the errors of TE form
        a lattice over the image. So seeds are drawn at random; now and then one comes twice, which does no
        harm.
        """
        mi_scene = self._load(scene)
        depths = sorted({d for k in bounces for d in (k, k + 1)} - {0})  # depth 0 holds nothing
        paths = {d: self._path(d) for d in depths}
        height, width, _ = scene.shape
        streams = np.random.default_rng(seed).integers(2**32 // (height * width), size=spp)
        total, sums = np.zeros((len(bounces), *scene.shape)), np.zeros(len(bounces))
        for stream in map(int, streams):
            partial_sums = {0: np.zeros(scene.shape)} | {
                d: np.array(self._mi.render(mi_scene, integrator=path, spp=1, seed=stream), dtype=np.float64)
                for d, path in paths.items()
            }
            total += np.array([partial_sums[k + 1] - partial_sums[k] for k in bounces])
            sums += np.array([partial_sums[k + 1].mean() for k in bounces])
        _refuse_cancellation(bounces, total.mean(axis=(1, 2, 3)), sums)
        return total / spp

    def total(self, scene: Scene, spp: int, seed: int) -> Images:
        """The integrator ``path`` as it comes: no last bounce, Russian roulette from its own depth on."""
        path = self._mi.load_dict({"type": "path"})
        image = self._mi.render(self._load(scene), integrator=path, spp=spp, seed=seed)
        return np.array(image, dtype=np.float64)

    def first_hits(self, scene: Scene) -> Hits:
        """Its camera's rays through the centres of pixels, met by its ``ray_intersect``; see the protocol.

        Optimised, Mitsuba would merge shapes of the same material, and none could be told from the others.
        """
        mi_scene = self._load(scene)
        [sensor], (height, width, _) = mi_scene.sensors(), scene.shape
        hits = np.tile([[np.inf], [0.0], [0.0], [0.0], [-1.0]], height * width)
        origin, forward = np.array(scene.sensor.origin), None
        if isinstance(scene.sensor, Orthographic):
            forward = scene.sensor.frame[:, 2]
        for i in range(height * width):
            row, column = divmod(i, width)
            film = [(column + 0.5) / width, (row + 0.5) / height]
            ray, _ = sensor.sample_ray(0.0, 0.5, film, [0.5, 0.5])
            found = mi_scene.ray_intersect(ray)
            if found.is_valid():
                # its rays begin at the near plane, so its own distance is not the one from the sensor
                to_hit = np.array(found.p) - origin
                distance = np.linalg.norm(to_hit) if forward is None else forward @ to_hit
                hits[:, i] = distance, *found.n, int(found.shape.id().removeprefix("surface"))
        return hits

    def _path(self, depth: int) -> Any:
        return self._mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": _NO_ROULETTE})

    def _load_scene(self, scene: Scene) -> Any:
        with TemporaryDirectory() as folder:  # meshes are read when the dictionary is loaded, and not again
            # optimised, shapes come in the order of their addresses in memory, and so do the emitters among which a
            # random number chooses: the same seed would give another image each time
            return self._mi.load_dict(scene_dict(self._mi, scene, Path(folder)), optimize=False)


def _refuse_cancellation(bounces: Sequence[int], terms: Array, sums: Array) -> None:
    """Refuse terms so small that single precision can't hold them as a difference of two sums.

    A sum is rounded to 2⁻²⁴ of itself, so a term of 2⁻¹³ of the sum is exact to 2⁻¹¹, a twentieth of a percent.
    A term that is exactly 0 is judged: a lost bounce must fail, not be refused.

    Raises:
        Unsupported: naming the bounce.
    """
    for k, term, partial_sum in zip(bounces, terms, sums, strict=True):
        if 0 < abs(term) < 2**-13 * partial_sum:
            share = term / partial_sum
            raise Unsupported(
                f"bounce {k}, {share:.0e} of the sum: too little for a difference in single precision"
            )
