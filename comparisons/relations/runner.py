"""A run of relations: every claim of every relation, on every scene and renderer asked for, ends in a result.

The words are those of comparisons, and so is what they take: ``pass`` needs each region's own interval inside
± tolerance, ``fail`` an interval outside that is simultaneous over regions, bounces and channels. Looks come after
32, 64, 128, … replicates at α / (j (j + 1)). Instead of a truth there is the second side; see ``replicates.py``.
"""

from __future__ import annotations

import time
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from comparisons.crew import Crew as Processes
from comparisons.regions import Regions
from comparisons.relations.relation import Claim, Equal, NotApplicableError, Relation
from comparisons.relations.replicates import Crew, Pairs, split
from comparisons.renderers import Hits, Images, RendererError, Unsupported, canonical
from comparisons.results import BounceResult, Look, RelationResult
from comparisons.sequential import GRACE, MIN_REPLICATES, Job, Sampler, first_seed
from comparisons.settings import Observer, Settings
from comparisons.statistics.intervals import alpha_of_look, biases, denominators
from comparisons.verdict import Measured, judge, overall
from scenes import Scene, SceneError, Tolerance
from scenes.formats.exr import channel_names

DEFAULT_BOUNCES = 3
FIRST_LOOK = 0.4
"""Seconds that the first replicates of a claim should take: most claims hold, and that is soon seen."""

LEAST_WALKS = 8192
"""In a replicate of a side: with fewer, most of the time goes into what comes before them."""


@dataclass(frozen=True)
class Subject:
    """A scene that relations are tried on; it needs no answer.

    Attributes:
        name: what it is called.
        scene: the scene.
        bounces: the last bounce unless told otherwise.
    """

    name: str
    scene: Scene
    bounces: int = DEFAULT_BOUNCES


@dataclass(frozen=True)
class Task:
    """A relation to be tried on a scene.

    Attributes:
        relation, subject: which, on what.
        budget: seconds at most for each claim; None: those of the settings.
        tolerance: None: that of the relation.
        walks: from the sensor, in a replicate of a side, at least.
    """

    relation: Relation
    subject: Subject
    budget: float | None = None
    tolerance: Tolerance | None = None
    walks: int = LEAST_WALKS


def run(
    tasks: Sequence[Task],
    renderers: Sequence[str],
    settings: Settings,
    observer: Observer,
    crew: Crew | None = None,
) -> Iterator[RelationResult]:
    """Try every relation on its scene with every renderer; one result per claim.

    Args:
        tasks: what to try.
        renderers: their names.
        settings: bounces, tolerances, size, alpha, budget, seed, jobs.
        observer: who wants to see it.
        crew: who renders; None: processes of its own, which end with the run.

    Raises:
        UnknownNameError: there is no renderer of that name. Nothing has been rendered then.
    """
    names = {name: canonical(name) for name in renderers}
    if crew is None:
        with Processes(settings.jobs) as own:
            yield from run(tasks, renderers, settings, observer, own)
        return
    for shown, name in names.items():
        for task in tasks:
            observer.started(f"{task.relation.name} ({task.subject.name})", shown)
            trying = _Trying(task, shown, name, settings, crew, observer)
            yield from (found := trying.results())
            observer.related(found)
        crew.dismiss(name)


class _Trying:
    """One relation on one scene with one renderer."""

    def __init__(
        self, task: Task, shown: str, name: str, settings: Settings, crew: Crew, observer: Observer
    ) -> None:
        self.relation, self.shown, self.name = task.relation, shown, name
        self.settings, self.crew, self.observer = settings, crew, observer
        self.subject, self.walks = task.subject, task.walks
        self.budget = settings.budget if task.budget is None else min(task.budget, settings.budget)
        self.bounces = task.subject.bounces if settings.bounces is None else settings.bounces
        self.version = ""
        image, tile = settings.tolerance, settings.tile_tolerance
        usual = task.tolerance or self.relation.tolerance
        self.tolerance = Tolerance(
            image=usual.image if image is None else (image,), tile=usual.tile if tile is None else (tile,)
        )

    def results(self) -> list[RelationResult]:
        """One per claim; one in all where nothing can be claimed, or the renderer can't be loaded."""
        try:
            self.version = self.crew.version(self.name)
            scene = self.subject.scene
            if self.settings.size and scene.shape[:2] != (1, 1):
                scene = scene.resized(*self.settings.size)
            claims = self.relation.claims(scene, self.bounces, self.name)
        except (NotApplicableError, SceneError) as error:
            return [self._result("", 0.0, verdict="unsupported", message=f"not applicable: {error}")]
        except RendererError as error:
            return [self._failed("", error, 0.0)]
        return [self._judged(claim) for claim in claims]

    def _judged(self, claim: Claim) -> RelationResult:
        start = time.monotonic()
        try:
            if isinstance(claim, Equal):
                return self._compare(claim)
            told = claim.look(_Asked(self.crew, self.name, self.budget))
            seconds = time.monotonic() - start
            return self._result(claim.label, seconds, verdict=told.verdict, message=told.message)
        except RendererError as error:
            return self._failed(claim.label, error, time.monotonic() - start)

    def _compare(self, claim: Equal) -> RelationResult:
        """Look until every bounce is decided or the budget is used up.

        Raises:
            RendererError: see ``RendererProcess.render``.
        """
        bounces = list(range(self.bounces + 1)) if claim.bounces is None else list(claim.bounces)
        height, width, _ = _seen(claim)
        regions = Regions.of(height, width, self.relation.tiles)
        open_bounces, looks, found = list(bounces), list[Look](), dict[int, BounceResult]()

        def show(share: float) -> None:
            self.observer.progressed(share, f"open bounces: {', '.join(map(str, open_bounces))}")

        scene = claim.first[0].scene
        least = -(-self.walks // (scene.shape[0] * scene.shape[1]))
        # no two claims share random numbers, on whatever scene
        key = zlib.crc32(f"{self.relation.name} {claim.label} {self.subject.name}".encode())
        seed = first_seed(self.settings.seed << 32 | key)
        job = Job(self.name, scene, bounces, seed, self.budget, show, FIRST_LOOK, least)
        sampler = Sampler(job, Pairs(claim, self.crew, seed), regions)
        target = MIN_REPLICATES
        while True:
            sampler.draw(open_bounces, target)
            level = alpha_of_look(self.settings.alpha, len(looks) + 1)
            for measured in self._measured(claim, sampler, open_bounces, level, len(looks) + 1):
                found[measured.bounce] = judge(measured, self.tolerance, regions, None)
            replicates = sampler.regions[open_bounces[-1]].count
            open_bounces[:] = [k for k in open_bounces if found[k].verdict == "inconclusive"]
            looks.append(
                Look(
                    replicates=replicates,
                    seconds=sampler.seconds,
                    alpha=level,
                    open_bounces=list(open_bounces),
                )
            )
            if not open_bounces or sampler.exhausted:
                break
            target *= 2
        return self._compared(claim, sampler, [found[k] for k in bounces], looks)

    def _measured(
        self, claim: Equal, sampler: Sampler, of: Sequence[int], level: float, look: int
    ) -> Iterator[Measured]:
        """The deviation of the first side from the second, of each of these bounces.

        The second side is what the deviation is relative to. Its noise is already in that of the difference, so
        the truth that a bias is the deviation from is an exact 0.
        """
        sides = {k: split(moments) for k, moments in sampler.regions.items()}
        second = np.stack([second.mean for _, second in sides.values()], axis=1)
        relative_to = denominators(second)
        spp = claim.first[0].spp(sampler.spp)
        for row, (k, (difference, truth)) in enumerate(sides.items()):
            if k not in of:
                continue
            mean, relative = truth.mean, relative_to[:, row]
            zero = np.zeros_like(mean)
            yield Measured(
                bounce=k,
                biases=biases(difference, zero, zero, relative, level, family=second.size),
                mean=mean + difference.mean,
                truth=mean,
                denominator=relative,
                look=look,
                replicates=difference.count,
                spp=spp * difference.count,
                enough=difference.count >= MIN_REPLICATES,
            )

    def _compared(
        self, claim: Equal, sampler: Sampler, bounces: list[BounceResult], looks: list[Look]
    ) -> RelationResult:
        if all(b.mean == 0 == b.truth_mean and b.standard_error == 0 for b in bounces):
            message = "both sides are black in every bounce: that holds, and says nothing"
            return self._result(claim.label, sampler.seconds, verdict="inconclusive", message=message)
        return self._result(
            claim.label,
            sampler.seconds,
            verdict=overall(b.verdict for b in bounces),
            message=_undecided(bounces, self.budget),
            bounces=bounces,
            looks=looks,
            spp=max(b.spp for b in bounces),
            replicates=max(b.replicates for b in bounces),
        )

    def _failed(self, label: str, error: RendererError, seconds: float) -> RelationResult:
        verdict = "unsupported" if isinstance(error, Unsupported) else "error"
        return self._result(label, seconds, verdict=verdict, message=str(error), log=error.log)

    def _result(self, label: str, seconds: float, **changes: Any) -> RelationResult:
        return RelationResult(
            relation=self.relation.name,
            claim=label,
            operator=self.relation.operator,
            statement=self.relation.statement,
            blind_to=self.relation.blind_to,
            scene=self.subject.name,
            renderer=self.shown,
            renderer_version=self.version,
            channels=channel_names(self.subject.scene.channels),
            alpha=self.settings.alpha,
            seconds=seconds,
            **changes,
        )


@dataclass(frozen=True)
class _Asked:
    """A renderer that answers before the next question."""

    crew: Crew
    name: str
    budget: float

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        return self.crew.render(self.name, scene, bounces, spp, seed, self.budget + GRACE).result()

    def first_hits(self, scene: Scene) -> Hits:
        return self.crew.first_hits(self.name, scene, self.budget + GRACE).result()


def _seen(claim: Equal) -> tuple[int, int, int]:
    """The shape of the images of a claim."""
    part = claim.first[0]
    height, width, channels = part.view(np.zeros((1, *part.scene.shape))).shape[1:]
    return height, width, channels


def _undecided(bounces: Sequence[BounceResult], budget: float) -> str:
    """Why some bounce has no verdict; empty if all have one."""
    if not any(b.verdict == "inconclusive" for b in bounces):
        return ""
    seen = [f"{b.detectable_bias:.2%} in bounce {b.bounce}" for b in bounces if b.verdict == "inconclusive"]
    return (
        f"the budget of {budget:g} s was used up; a deviation could have been detected from {', '.join(seen)}"
    )
