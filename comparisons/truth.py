"""Where the truth of a case comes from: its formula, its committed data, or an estimate that is kept for later.

python -m comparisons.truth cornell-box --spp 131072     makes the committed data of a case anew: an estimate,
python -m comparisons.truth cornell-box-empty            or finite elements
python -m comparisons.truth cornell-box --later          makes the sum of all later bounces, which the total needs
"""

from __future__ import annotations

import argparse
import hashlib
import os
from collections.abc import Callable
from concurrent.futures import as_completed
from importlib.metadata import version
from pathlib import Path

import numpy as np
import platformdirs

from comparisons.crew import Crew
from comparisons.later import LATER_SPP, sum_later
from comparisons.statistics.moments import Moments
from scenes import Case, Computed, Formula, Scene, Truth
from scenes.formats import exr
from scenes.library import case as find_case

ESTIMATOR = "reference:mis:sobol"
"""The renderer that estimates a truth. It can't be judged by its own work."""

STAND_IN = "reference:nee"
"""What is held against such a truth where the estimator is asked for."""

BATCHES = 64
"""Independent replicates behind the standard error of an estimated truth."""

COMMITTED_BOUNCES = 6

CACHED_SAMPLES = 4096 * 16384
"""Pixels × spp of a truth that is estimated on the fly: some ten times what a renderer makes in a default budget."""

_SEED = 20_000_000  # below all seeds that a validation draws, so that truth and renderer share no numbers
_SOURCE = "lightproof:source"  # the name of the header's text that says how the data was made
_TIMEOUT = 24 * 3600.0

Progress = Callable[[float], None]


def truth_of(case: Case, crew: Crew, progress: Progress = lambda done: None) -> Truth:
    """The answer of the case, for its bounces and its scene's resolution.

    Without committed data for these it is computed or estimated once, and cached in the user's cache directory.

    Raises:
        ValueError: the case has no answer for so many bounces.
        RendererError: the estimator failed.
        OSError: the cache can't be written.
    """
    if case.max_bounces is not None and case.bounces > case.max_bounces:
        raise ValueError(
            f"{case.name} has an answer for bounces 0 to {case.max_bounces}, not for {case.bounces}"
        )
    truth = case.answer.truth(case.scene, case.bounces)
    if truth is not None:
        return truth
    spp = default_spp(case.scene)
    path = _cache_path(case, spp)
    try:
        return _read(path)
    except exr.ImageError:  # there is none, or it is damaged
        if isinstance(case.answer, Computed):
            from comparisons.computed import compute  # finite elements; most truths are there already

            compute(case.scene, case.bounces, case.answer, path, _of(case.scene))
        else:
            estimate(case.scene, case.bounces, spp, crew, path, progress)
    return _read(path)


def _read(path: Path) -> Truth:
    return Truth(*exr.read_bounces(path), exr.read_attribute(path, _SOURCE))


def _cache_path(case: Case, spp: int) -> Path:
    """Where the estimate is kept: by all that it depends on."""
    how = case.answer if isinstance(case.answer, Computed) else (spp, BATCHES, ESTIMATOR, _SEED)
    what = (scene_hash(case.scene), case.bounces, how, version("lightproof"))
    key = hashlib.sha256(repr(what).encode()).hexdigest()[:16]
    return platformdirs.user_cache_path("lightproof", ensure_exists=True) / f"{case.name}-{key}.exr"


def scene_hash(scene: Scene) -> str:
    """Tells whether data belongs to a scene."""
    return scene.sha256


def default_spp(scene: Scene) -> int:
    """Samples per pixel of a truth that is estimated on the fly."""
    height, width, _ = scene.shape
    return max(BATCHES, CACHED_SAMPLES // (height * width))


def estimate(
    scene: Scene, bounces: int, spp: int, crew: Crew, path: Path, progress: Progress = lambda done: None
) -> None:
    """Estimate the truth and write it to a file."""
    truth = estimated(scene, bounces, spp, crew, progress)
    partial = path.with_suffix(f".{os.getpid()}.exr")  # a run that is cut short leaves no half a truth behind
    exr.write_bounces(partial, truth.mean, truth.stderr, {_SOURCE: truth.source} | _of(scene))
    partial.replace(path)


def estimated(
    scene: Scene, bounces: int, spp: int, crew: Crew, progress: Progress = lambda done: None
) -> Truth:
    """Estimate the truth, with spp samples per pixel, rounded down to a multiple of ``BATCHES``.

    The mean is that of ``BATCHES`` independent renders, the standard error that of their spread.

    Raises:
        RendererError: the estimator failed.
    """
    total: Moments | None = None
    wanted, seeds = range(bounces + 1), range(_SEED, _SEED + BATCHES)
    batches = [crew.render(ESTIMATOR, scene, wanted, spp // BATCHES, seed, _TIMEOUT) for seed in seeds]
    try:
        for batch in as_completed(batches):
            moments = Moments.of(batch.result())
            total = moments if total is None else total + moments
            progress(total.count / BATCHES)
    finally:
        for batch in batches:
            batch.cancel()
        crew.dismiss(ESTIMATOR)
    assert total is not None
    made = f"{ESTIMATOR} of lightproof {version('lightproof')}, {BATCHES} batches of {spp // BATCHES} spp"
    return Truth(total.mean, total.standard_error, f"{made}, seeds from {_SEED}")


def _of(scene: Scene) -> dict[str, str]:
    """Which scene the data belongs to."""
    return {"lightproof:scene": scene_hash(scene)}


def main() -> None:
    """Make the committed data of a case."""
    parser = argparse.ArgumentParser(prog="python -m comparisons.truth", description=main.__doc__)
    parser.add_argument("case")
    parser.add_argument("--spp", type=int, help="of an estimate")
    parser.add_argument("--later", action="store_true", help="the sum of all bounces after those of the data")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args()
    case = find_case(options.case)
    if isinstance(case.answer, Formula):
        parser.error(f"{case.name} has a formula and needs no data")
    path = case.answer.path
    if options.later:
        sum_later(case.scene, case.answer, options.spp or LATER_SPP, options.jobs)
        print(case.answer.path_of_later)
        return
    if isinstance(case.answer, Computed):
        from comparisons.computed import compute

        compute(case.scene, COMMITTED_BOUNCES, case.answer, path, _of(case.scene))
        print(
            f"{path}: error (root mean square, relative), per bounce: {', '.join(map(str, case.answer.error))}"
        )
        return
    if options.spp is None:
        parser.error(f"{case.name} is an estimate: say how good, --spp 131072")

    def show(done: float) -> None:
        print(f"\r{case.name}: {done:.0%}", end="", flush=True)

    with Crew(options.jobs) as crew:
        estimate(case.scene, COMMITTED_BOUNCES, options.spp, crew, path, show)
    mean, stderr = exr.read_bounces(path)
    relative = np.sqrt((stderr**2).sum(axis=(1, 2))) / mean.sum(axis=(1, 2))
    print(f"\n{path}: relative standard error of the image mean, per bounce: {relative.max(axis=-1)}")


if __name__ == "__main__":
    main()
