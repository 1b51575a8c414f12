"""Sequential sampling: double the replicates until every bounce is decided, or the budget is used up.

A replicate is an independent render of a few samples per pixel. Variances come from replicates alone, at least
``MIN_REPLICATES`` of them, since a renderer's pixels may be correlated. The end of the budget is a look.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass

import numpy as np

from comparisons.crew import Crew
from comparisons.regions import Regions
from comparisons.renderers import Images
from comparisons.statistics.moments import Moments
from scenes import Scene

MIN_REPLICATES = 32

FIRST_LOOK = 2.5
"""Seconds that the first look should take, or an eighth of the budget if that is less."""

_PILOT = 0.05  # seconds of rendering that are enough to foresee the time of more

GRACE = 60.0
"""Seconds beyond the budget after which a renderer that gives no answer is stopped."""


@dataclass(frozen=True)
class Sample:
    """What has been rendered so far.

    Attributes:
        pixels: moments of the images, ``(bounces + 1, height, width, channels)``.
        regions: moments of their means over regions, ``(1 + tiles, bounces + 1, channels)``.
        spp: of each replicate.
        seconds: since the start.
        exhausted: whether the budget is used up.
    """

    pixels: Moments
    regions: Moments
    spp: int
    seconds: float
    exhausted: bool

    @property
    def enough(self) -> bool:
        """Whether there are as many replicates as a verdict needs."""
        return self.pixels.count >= MIN_REPLICATES


@dataclass(frozen=True)
class Job:
    """What to sample.

    Attributes:
        renderer: its full name.
        scene, bounces: what is rendered.
        seed: replicate r gets seed + r.
        budget: seconds.
        on_progress: called with the share of the budget that is used.
    """

    renderer: str
    scene: Scene
    bounces: int
    seed: int
    budget: float
    on_progress: Callable[[float], None] = lambda done: None


def first_seed(seed: int) -> int:
    """Where the seeds of replicates begin: far apart for different seeds of the user, below 2³¹."""
    return int(np.random.SeedSequence(seed).generate_state(1)[0]) >> 1


def sample(job: Job, crew: Crew, regions: Regions) -> Iterator[Sample]:
    """Yield what there is after 32, 64, 128, … replicates, and at the end of the budget; then stop.

    Raises:
        RendererError: see ``RendererProcess.render``.
    """
    start = time.monotonic()
    spp = _pilot(job, crew)
    pixels, means = None, None
    running: set[Future[Images]] = set()
    try:
        target, submitted = MIN_REPLICATES, 0
        while True:
            used = (time.monotonic() - start) / job.budget
            job.on_progress(min(used, 1.0))
            count = pixels.count if pixels else 0
            # two replicates make the least sample that has a spread to speak of, however small the budget
            wanted = target if used < 1 else min(target, max(2, submitted))
            while submitted < wanted and len(running) < crew.jobs:
                running.add(_submit(job, crew, spp, job.seed + submitted))
                submitted += 1
            if running:
                done, running = wait(running, return_when=FIRST_COMPLETED)
                for image in (future.result() for future in done):
                    of_pixels, of_means = Moments.of(image), Moments.of(regions.means(image))
                    pixels, means = (
                        (pixels + of_pixels, means + of_means) if pixels and means else (of_pixels, of_means)
                    )
                continue
            assert pixels is not None
            assert means is not None
            yield Sample(pixels, means, spp, time.monotonic() - start, exhausted=count < target)
            if count < target:
                return
            target *= 2
    finally:
        for future in running:
            future.cancel()


def _pilot(job: Job, crew: Crew) -> int:
    """Samples per pixel of a replicate, such that the first look comes when it should."""
    _submit(job, crew, 1, job.seed).result()  # loads the scene, which must not be counted
    spp = 1
    while True:
        start = time.monotonic()
        _submit(job, crew, spp, job.seed).result()
        elapsed = time.monotonic() - start
        if elapsed > _PILOT or elapsed * 4 > job.budget / 8:
            break
        spp *= 4
    first_look = min(FIRST_LOOK, job.budget / 8)
    return max(1, int(first_look * crew.jobs / MIN_REPLICATES * spp / elapsed))


def _submit(job: Job, crew: Crew, spp: int, seed: int) -> Future[Images]:
    return crew.render(job.renderer, job.scene, job.bounces, spp, seed, timeout=job.budget + GRACE)
