"""Sequential sampling: draw until so many replicates, or until the budget is used up.

A replicate is an independent render of a few samples per pixel. Variances come from replicates alone, at least
``MIN_REPLICATES`` of them, since a renderer's pixels may be correlated.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from comparisons.regions import Regions
from comparisons.renderers import Images
from comparisons.statistics.moments import Moments
from scenes import Scene

MIN_REPLICATES = 32

FIRST_LOOK = 1.25
"""Seconds that the first ``MIN_REPLICATES`` should take, or an eighth of the budget if that is less."""

GRACE = 60.0
"""Seconds beyond the budget after which a renderer that gives no answer is stopped."""

MOST_SPP = 4096
"""Of a replicate, for a renderer whose time does not depend on it."""

_PILOT = 0.0125
"""Seconds of rendering, from which on four times the samples tell how long more will take."""


@dataclass(frozen=True)
class Job:
    """What to sample.

    Attributes:
        renderer: its full name.
        scene, bounces: what is rendered.
        seed: replicate r gets seed + r.
        budget: seconds.
        on_progress: called with the share of the budget that is used.
        first_look: seconds that the first ``MIN_REPLICATES`` should take, if an eighth of the budget is not less.
        least_spp: of a replicate, however long they take: few samples, and most of the time is not rendering.
        deterministic: whether it has no noise; two replicates tell all then.
        spp_unit: samples per pixel of a replicate are a multiple of this.
    """

    renderer: str
    scene: Scene
    bounces: Sequence[int]
    seed: int
    budget: float
    on_progress: Callable[[float], None] = lambda done: None
    first_look: float = FIRST_LOOK
    least_spp: int = 1
    deterministic: bool = False
    spp_unit: int = 1


class Renders(Protocol):
    """Who renders: a crew, or who asks one."""

    jobs: int

    def render(
        self, name: str, scene: Scene, bounces: Sequence[int], spp: int, seed: int, timeout: float
    ) -> Future[Images]:
        """As ``Crew.render``."""


def too_few(replicates: int, seconds: float) -> str:
    """What is said where there was time for less than a verdict needs, and what would do.

    Args:
        replicates: how many there were.
        seconds: how long they took, on the scale of the budget that the user gives.
    """
    enough = max(1.1 * seconds * MIN_REPLICATES / replicates, 1.0)
    power = 10 ** math.floor(math.log10(enough))
    budget = next(step * power for step in (1, 2, 3, 5, 10) if step * power >= enough)
    return f"after {replicates} replicates, and a verdict needs {MIN_REPLICATES}: try --budget {budget:g}"


def first_seed(seed: int) -> int:
    """Where the seeds of replicates begin: anywhere in [2³⁰, 2³¹), so two of the user's seeds seldom overlap."""
    return 2**30 + (int(np.random.SeedSequence(seed).generate_state(1)[0]) >> 2)


class Sampler:
    """Draws replicates, and keeps the moments of each bounce.

    Attributes:
        pixels: by bounce, moments of its images, ``(height, width, channels)``.
        regions: by bounce, moments of their means over regions, ``(1 + tiles, channels)``.
        spp: of each replicate.
    """

    def __init__(self, job: Job, crew: Renders, regions: Regions) -> None:
        """Find out how long the renderer takes.

        Raises:
            RendererError: see ``RendererProcess.render``.
        """
        self.pixels: dict[int, Moments] = {}
        self.regions: dict[int, Moments] = {}
        self._job, self._crew, self._grid = job, crew, regions
        self._start, self._submitted = time.monotonic(), 0
        self.spp = self._pilot()

    @property
    def seconds(self) -> float:
        """Since the start."""
        return time.monotonic() - self._start

    @property
    def budget(self) -> float:
        """Seconds that it may take."""
        return self._job.budget

    @property
    def exhausted(self) -> bool:
        """Whether the budget is used up."""
        return self.seconds >= self._job.budget

    @property
    def replicates(self) -> int:
        """Of the bounce that has most."""
        return max(moments.count for moments in self.regions.values())

    @property
    def enough(self) -> int:
        """How many replicates a verdict needs."""
        return 2 if self._job.deterministic else MIN_REPLICATES

    def draw(self, bounces: Sequence[int], count: int) -> None:
        """Draw so many replicates more of these bounces, or until the budget is used up.

        Two are drawn however small the budget: the least that has a spread to speak of.

        Raises:
            RendererError: see ``RendererProcess.render``.
        """
        drawn, first = 0, bounces[0] not in self.pixels
        running: set[Future[Images]] = set()
        try:
            while True:
                while (
                    drawn < count
                    and len(running) < self._crew.jobs
                    and ((first and drawn < 2) or not self.exhausted)
                ):
                    running.add(self._submit(bounces, self.spp, self._job.seed + self._submitted))
                    self._submitted, drawn = self._submitted + 1, drawn + 1
                if not running:
                    return
                done, running = wait(running, return_when=FIRST_COMPLETED)
                for future in done:
                    self._add(bounces, future.result())
                self._job.on_progress(min(self.seconds / self._job.budget, 1.0))
        finally:
            for future in running:
                future.cancel()

    def _add(self, bounces: Sequence[int], images: Images) -> None:
        means = self._grid.means(images)
        for row, k in enumerate(bounces):
            for kept, replicate in ((self.pixels, images[row]), (self.regions, means[:, row])):
                kept[k] = kept[k].including(replicate) if k in kept else Moments.of(replicate)

    def _pilot(self) -> int:
        """Samples per pixel of a replicate.

        As many as let the first look come when it should; more, where asking for an image would take longer than
        rendering it, as long as the first look comes within a quarter of the budget.
        """
        budget = self._job.budget
        self._time(1)  # loads the scene, which must not be counted
        spp, elapsed = 1, (one := self._time(1))
        while elapsed <= max(_PILOT, 2 * one) and elapsed * 4 <= budget / 8 and spp < MOST_SPP:
            spp *= 4
            elapsed = self._time(spp)
        each = max((elapsed - one) / (spp - 1), 1e-9) if spp > 1 else one
        asking = max(one - each, 0.0)

        def affordable(first_look: float) -> float:
            return (first_look * self._crew.jobs / MIN_REPLICATES - asking) / each

        wanted = max(affordable(min(self._job.first_look, budget / 8)), asking / each)
        spp = int(np.clip(min(wanted, affordable(budget / 4)), self._job.least_spp, MOST_SPP))
        return -(-spp // self._job.spp_unit) * self._job.spp_unit

    def _time(self, spp: int) -> float:
        start = time.monotonic()
        self._submit(self._job.bounces, spp, self._job.seed).result()
        return time.monotonic() - start

    def _submit(self, bounces: Sequence[int], spp: int, seed: int) -> Future[Images]:
        job = self._job
        return self._crew.render(job.renderer, job.scene, bounces, spp, seed, timeout=job.budget + GRACE)
