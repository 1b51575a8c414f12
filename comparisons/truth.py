"""Where the truth of a case comes from: its formula, its committed data, or an estimate that is kept for later.

python -m comparisons.truth cornell-box --spp 131072     makes the committed data of a case anew
"""

from __future__ import annotations

import argparse
import hashlib
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import reduce
from importlib.metadata import version
from operator import add
from pathlib import Path

import numpy as np
import platformdirs

from comparisons.statistics.moments import Moments
from reference_tracer.random_walk import render
from scenes import Case, Formula, Scene, Truth
from scenes.formats import exr
from scenes.library import case as find_case

BATCHES = 64
"""Independent replicates behind the standard error of an estimated truth."""

COMMITTED_BOUNCES = 6

CACHED_SAMPLES = 4096 * 16384
"""Pixels × spp of a truth that is estimated on the fly: some ten times what a renderer makes in a default budget."""

_SEED = 20_000_000  # far from the seeds that a validation draws, so that truth and tracer share no numbers

Progress = Callable[[float], None]


def truth_of(
    case: Case, scene: Scene, bounces: int, jobs: int = 1, progress: Progress = lambda done: None
) -> Truth:
    """The answer of the case for a scene that differs from its own at most in resolution.

    An estimate without committed data for this resolution or bounce is made once and cached in the user's
    cache directory.

    Raises:
        ValueError: the case has no answer for so many bounces.
    """
    if case.max_bounces is not None and bounces > case.max_bounces:
        raise ValueError(f"{case.name} has an answer for bounces 0 to {case.max_bounces}, not for {bounces}")
    truth = case.answer.truth(scene, bounces)
    if truth is not None:
        return truth
    key = hashlib.sha256(scene.to_json() + f"{bounces} {CACHED_SAMPLES}".encode()).hexdigest()[:16]
    path = platformdirs.user_cache_path("lightproof", ensure_exists=True) / f"{case.name}-{key}.exr"
    if not path.exists():
        pixels = scene.sensor.width * scene.sensor.height
        estimate(case, scene, bounces, max(BATCHES, CACHED_SAMPLES // pixels), jobs, path, progress)
    return Truth(*exr.read_bounces(path))


def estimate(
    case: Case,
    scene: Scene,
    bounces: int,
    spp: int,
    jobs: int,
    path: Path,
    progress: Progress = lambda done: None,
) -> None:
    """Estimate the truth with the reference tracer, strategy mis, and write it to a file.

    The mean is that of ``BATCHES`` independent renders, the standard error that of their spread.
    """
    assert not isinstance(case.answer, Formula)
    total: Moments | None = None
    with ProcessPoolExecutor(jobs) as pool:
        batches = [
            pool.submit(_batch, scene.to_json(), bounces, spp // BATCHES, _SEED + i) for i in range(BATCHES)
        ]
        for done, batch in enumerate(batches, start=1):
            total = reduce(add, filter(None, [total, Moments.of(batch.result())]))
            progress(done / BATCHES)
    assert total is not None
    source = (
        f"reference tracer {version('lightproof')}, strategy mis, {BATCHES} batches of {spp // BATCHES} spp, "
        f"seeds {_SEED} to {_SEED + BATCHES - 1}"
    )
    partial = path.with_suffix(".partial.exr")  # a run that is cut short leaves no half a truth behind
    exr.write_bounces(partial, total.mean, total.standard_error, {"lightproof:source": source})
    partial.replace(path)


def _batch(scene: bytes, bounces: int, spp: int, seed: int) -> exr.Images:
    return render(Scene.from_json(scene), bounces, spp, seed, strategy="mis")


def main() -> None:
    """Make the committed data of a case."""
    parser = argparse.ArgumentParser(prog="python -m comparisons.truth", description=main.__doc__)
    parser.add_argument("case")
    parser.add_argument("--spp", type=int, required=True)
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    case = find_case(options.case)
    if isinstance(case.answer, Formula):
        parser.error(f"{case.name} has a formula and needs no data")
    path = case.answer.path

    def show(done: float) -> None:
        print(f"\r{case.name}: {done:.0%}", end="", flush=True)

    estimate(case, case.scene, COMMITTED_BOUNCES, options.spp, options.jobs, path, show)
    mean, stderr = exr.read_bounces(path)
    relative = np.sqrt((stderr**2).sum(axis=(1, 2))) / mean.sum(axis=(1, 2))
    print(f"\n{path}: relative standard error of the image mean, per bounce: {relative.max(axis=-1)}")


if __name__ == "__main__":
    main()
