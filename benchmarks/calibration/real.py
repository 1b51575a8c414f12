"""Whole comparisons of real renders, held against a truth that is off by exactly the tolerance.

Some thousand replicates of a scene are rendered once; a comparison draws its own from these at random. The mean
of all of them is then the exact expectation of what it draws, and that mean divided by 1 + b the truth of a
renderer that is b too bright everywhere: with real noise, real looks, and nothing else different. The budget counts
questions for the time, so a run can be repeated to the bit.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from unittest.mock import patch

import numpy as np

from benchmarks.calibration.rates import Rate
from comparisons import sequential
from comparisons.comparison import Comparing
from comparisons.renderers import Images, create
from comparisons.results import Verdict
from comparisons.settings import Settings, Silent
from scenes import Case, Scene, Tolerance, Truth, library

RUNS = 2_000
TOLERANCE = 0.02
TICKS = 800
"""Questions for the time; about three looks."""

SUBJECTS = (
    ("integrating-sphere", "reference:mis"),
    ("cornell-box", "reference:bsdf"),  # light is found by chance: few paths carry all of it
    ("cornell-box", "mitsuba:scalar_rgb"),
)

_POOL = 4_096
_SIZE, _TILES, _BOUNCES, _SPP = 8, (2, 2), 2, 4


@lru_cache(maxsize=1)
def _pool(case: str, renderer: str) -> Images:
    """Replicates, ``(replicates, bounces + 1, height, width, channels)``."""
    scene, one = library.case(case).scene.resized(_SIZE, _SIZE), create(renderer)
    return np.stack([one.render(scene, range(_BOUNCES + 1), _SPP, seed) for seed in range(_POOL)])


@dataclass
class Drawing:
    """A crew of one that draws from a pool."""

    pool: Images
    rng: np.random.Generator
    jobs: int = 1

    def version(self, name: str) -> str:
        """None of its own."""
        return "0"

    def dismiss(self, name: str) -> None:
        """Nothing to be ended."""

    def render(
        self, name: str, scene: Scene, bounces: Sequence[int], spp: int, seed: int, timeout: float
    ) -> Future[Images]:
        """One of the replicates, in a future that is done."""
        future: Future[Images] = Future()
        future.set_result(self.pool[self.rng.integers(len(self.pool))][list(bounces)])
        return future


def rates(runs: int = RUNS, jobs: int = 2) -> Iterator[Rate]:
    """Wrong verdicts with the bias at the limit, and with none at all where none is allowed."""
    for case, renderer in SUBJECTS:
        with ProcessPoolExecutor(jobs) as executor:
            for alpha in (1e-2, 1e-3):
                for bias, tolerance in ((TOLERANCE, TOLERANCE), (-TOLERANCE, TOLERANCE), (0.0, 0.0)):
                    verdict = partial(_verdict, case, renderer, bias, tolerance, alpha)
                    found = list(executor.map(verdict, range(runs), chunksize=50))
                    where = (
                        f"{case} × {renderer}; bias {bias:+.0%}, tolerance {tolerance:.0%}, α = {alpha:.1%}"
                    )
                    yield Rate(f"{where}: fail", found.count("fail"), runs, 0.0, alpha)
                    if tolerance:
                        yield Rate(f"{where}: pass", found.count("pass"), runs, 0.0, alpha)


def _verdict(case: str, renderer: str, bias: float, tolerance: float, alpha: float, run: int) -> Verdict:
    pool = _pool(case, renderer)
    mean = pool.mean(axis=0) / (1 + bias)
    settings = Settings(alpha=alpha, budget=TICKS, seed=run)
    clock = SimpleNamespace(monotonic=itertools.count().__next__)
    crew = Drawing(pool, np.random.default_rng(run))
    truth = Truth(mean, np.zeros_like(mean), "the mean of all replicates")
    with TemporaryDirectory() as folder, patch.object(sequential, "time", clock):
        (Path(folder) / "images" / case).mkdir(parents=True)
        comparing = Comparing(_case(case, tolerance), renderer, truth, settings, crew, Silent())  # type: ignore[arg-type]
        return comparing.run(Path(folder)).verdict


def _case(name: str, tolerance: float) -> Case:
    case = library.case(name)
    return replace(
        case,
        scene=case.scene.resized(_SIZE, _SIZE),
        bounces=_BOUNCES,
        tiles=_TILES,
        tolerance=Tolerance(image=(tolerance,), tile=(tolerance,)),
    )
