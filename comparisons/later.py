"""What comes after the bounces of committed data: the sum of all later ones, as one image beside them.

Finite elements have it exactly, (I − T)⁻¹E − Σ_{k ≤ n} TᵏE. An estimate walks on without Russian roulette, which is
what the total is to test, up to the bounce from which ``scenes.tail`` leaves ``NEGLIGIBLE`` of the image's mean.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from comparisons.crew import Crew
from comparisons.statistics.moments import Moments
from scenes import Computed, Estimate, Scene
from scenes.formats import exr
from scenes.tail import tail_bound

Array = NDArray[np.float64]

LATER_SPP = 2048
"""Of an estimate: later bounces hold a hundredth of the light, so a hundredth of its samples will do."""

NEGLIGIBLE = 1e-5

_ESTIMATOR, _BATCHES, _SEED, _TIMEOUT = "reference:mis", 32, 30_000_000, 24 * 3600.0


def sum_later(scene: Scene, answer: Computed | Estimate, spp: int, jobs: int) -> None:
    """Make the file of the sum of all bounces after those of the committed data.

    Args:
        scene: at the size of the data.
        answer: the data.
        spp, jobs: of an estimate: samples per pixel in all, and processes.
    """
    data, _ = exr.read_bounces(answer.path)
    last = len(data) - 1
    if isinstance(answer, Computed):
        later, error, how = _solved(scene, answer, data)
    else:
        later, error, how = _estimated(scene, last, float(data.sum(axis=0).mean()), spp, jobs)
    texts = {
        "lightproof:source": f"sum of all bounces after {last}: {how}",
        "lightproof:scene": scene.sha256,
    }
    _write(answer.path_of_later, later[None], None if error is None else error[None], texts)


def _solved(scene: Scene, answer: Computed, data: Array) -> tuple[Array, None, str]:
    from reference_tracer.finite_elements import solve  # sparse matrices, which only this needs

    coarse = solve(scene, 0, order=answer.order, levels=answer.levels, splits=answer.splits)
    fine = coarse.refined()
    found = fine.image(fine.inverse) - data.sum(axis=0)
    return (
        np.maximum(found, 0.0),
        None,
        f"finite elements of lightproof {version('lightproof')}, (I − T)⁻¹E less those",
    )


def _estimated(scene: Scene, last: int, mean: float, spp: int, jobs: int) -> tuple[Array, Array, str]:
    end = last + 1
    while tail_bound(scene, end).max() > NEGLIGIBLE * mean:
        end += 1
    seeds = range(_SEED, _SEED + _BATCHES)
    wanted = range(last + 1, end + 1)
    with Crew(jobs) as crew:
        batches = [crew.render(_ESTIMATOR, scene, wanted, spp // _BATCHES, seed, _TIMEOUT) for seed in seeds]
        found = Moments.of_all(np.stack([batch.result().sum(axis=0) for batch in batches]))
    how = f"{_ESTIMATOR} of lightproof {version('lightproof')} up to bounce {end}, without Russian roulette, "
    return (
        found.mean,
        found.standard_error,
        f"{how}{_BATCHES} batches of {spp // _BATCHES} spp, seeds from {_SEED}",
    )


def _write(path: Path, mean: Array, error: Array | None, texts: Mapping[str, str]) -> None:
    partial = path.with_suffix(f".{os.getpid()}.exr")  # a run that is cut short leaves no half a truth behind
    exr.write_bounces(partial, mean, error, texts)
    partial.replace(path)
