"""A run of relations: every claim of every relation, on every scene and renderer asked for, ends in a result.

The words are those of comparisons, and so is what they take: ``pass`` needs each region's own interval inside
± tolerance, ``fail`` an interval outside that is simultaneous over regions, bounces and channels. Looks come after
32, 64, 128, … replicates at α / (j (j + 1)). Instead of a truth there is the second side; see ``replicates.py``.
A renderer that ignores its seed has no noise that intervals could be made of: an error, as in comparisons.
"""

from __future__ import annotations

import time
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from msgspec.structs import replace

from comparisons.crew import Crew as Processes
from comparisons.in_process import InProcess
from comparisons.known import declared
from comparisons.notes import notes
from comparisons.probe import Probe
from comparisons.regions import Regions
from comparisons.relations.relation import Claim, Equal, NotApplicableError, Relation
from comparisons.relations.replicates import Crew, Pairs, split
from comparisons.renderers import Entry, Hits, Images, Renderer, RendererError, Unsupported, canonical, traits
from comparisons.results import BounceResult, Look, RelationResult
from comparisons.sequential import GRACE, MIN_REPLICATES, Job, Sampler, first_seed
from comparisons.settings import Observer, Settings
from comparisons.statistics import skewness
from comparisons.statistics.intervals import Means, biases, denominators
from comparisons.statistics.rare_events import event_size, least_error
from comparisons.verdict import Measured, judge, overall
from scenes import Scene, SceneError, Tolerance
from scenes.channels import channel_names

DEFAULT_BOUNCES = 3
_ALL = 10**9  # replicates: as many as the budget has room for
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
        wavelengths: of each channel, nm; None where channels are just numbers.
    """

    name: str
    scene: Scene
    bounces: int = DEFAULT_BOUNCES
    wavelengths: tuple[float, ...] | None = None


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
    renderers: Sequence[str | Renderer],
    settings: Settings,
    observer: Observer,
    crew: Crew | None = None,
) -> Iterator[RelationResult]:
    """Try every relation on its scene with every renderer; one result per claim.

    Args:
        tasks: what to try.
        renderers: their names, or objects of this process; see ``comparisons.in_process``.
        settings: bounces, tolerances, size, alpha, budget, seed, jobs.
        observer: who wants to see it.
        crew: who renders what is named; None: processes of its own, which end with the run.

    Raises:
        UnknownNameError: there is no renderer of that name. Nothing has been rendered then.
    """
    for renderer in renderers:
        if isinstance(renderer, str):
            canonical(renderer)
    if crew is None:
        with Processes(settings.jobs) as own:
            yield from run(tasks, renderers, settings, observer, own)
        return
    for renderer in renderers:
        tried = _named(renderer, crew) if isinstance(renderer, str) else _of_this_process(renderer)
        probe = Probe(tried.crew, settings.budget + GRACE)
        for task in tasks:
            observer.started(f"{task.relation.name} ({task.subject.name})", tried.shown)
            yield from (found := _Trying(task, tried, settings, observer, probe).results())
            observer.related(found)
        tried.crew.dismiss(tried.name)


class _Tried(NamedTuple):
    """A renderer: what it is called in results, its full name, what is declared of it, and whom to ask."""

    shown: str
    name: str
    traits: Entry
    crew: Crew


def _named(name: str, crew: Crew) -> _Tried:
    return _Tried(name, full := canonical(name), traits(full), crew)


def _of_this_process(renderer: Renderer) -> _Tried:
    guest = InProcess(renderer)
    return _Tried(guest.short_name, guest.name, guest.traits, guest)


class _Trying:
    """One relation on one scene with one renderer."""

    def __init__(
        self, task: Task, renderer: _Tried, settings: Settings, observer: Observer, probe: Probe
    ) -> None:
        self.relation, self.subject, self.walks = task.relation, task.subject, task.walks
        self.shown, self.name, self.traits, self.crew = renderer
        self.settings, self.observer, self.probe = settings, observer, probe
        self.budget = settings.budget if task.budget is None else min(task.budget, settings.budget)
        self.bounces = task.subject.bounces if settings.bounces is None else settings.bounces
        self.version = ""
        image, tile = settings.tolerance, settings.tile_tolerance
        usual = task.tolerance or self.relation.tolerance
        self.tolerance = Tolerance(
            image=usual.image if image is None else image, tile=usual.tile if tile is None else tile
        )
        self.channels = channel_names(task.subject.scene.channels, task.subject.wavelengths)

    def results(self) -> list[RelationResult]:
        """One per claim; one in all where nothing can be claimed, or the renderer can't be loaded."""
        try:
            self.version = self.crew.version(self.name)
            scene = self.subject.scene
            if self.settings.size and scene.shape[:2] != (1, 1):
                scene = scene.resized(*self.settings.size)
            if self.relation.of_noise and self.traits.deterministic:
                raise NotApplicableError(f"{self.shown} declares that it has no noise")
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
                complaint = None if self.traits.deterministic else self.probe.complaint(self.name)
                return self._failed(claim.label, complaint, 0.0) if complaint else self._compare(claim)
            told = claim.look(_Asked(self.crew, self.name, self.budget))
            seconds = time.monotonic() - start
            result = self._result(claim.label, seconds, verdict=told.verdict, message=told.message)
            return replace(result, operator=told.operator) if told.operator else result
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
        known = list(self.settings.known)
        entries = declared(known, self.subject.name, self.name, self.version, self.relation.name)
        of_bounce = {k: entry for entry in entries for k in bounces if entry.speaks_of(k)}

        def show(share: float) -> None:
            self.observer.progressed(share, f"open bounces: {', '.join(map(str, open_bounces))}")

        deterministic = self.traits.deterministic
        sampler = Sampler(self._job(claim, bounces, show, deterministic), self._pairs(claim), regions)
        # without early stop there is one look, at the end
        count = sampler.enough if self.settings.early_stop or deterministic else _ALL
        while True:
            sampler.draw(open_bounces, count)
            level = self.settings.alpha_of(len(looks) + 1)
            for measured in self._measured(claim, sampler, regions, open_bounces, level, len(looks) + 1):
                found[measured.bounce] = judge(
                    measured, self.tolerance, regions, of_bounce.get(measured.bounce)
                )
            count = sampler.regions[open_bounces[-1]].count  # twice as many at the next look
            open_bounces[:] = [k for k in open_bounces if found[k].verdict == "inconclusive"]
            looks.append(
                Look(
                    replicates=count,
                    seconds=sampler.seconds,
                    alpha=level,
                    open_bounces=list(open_bounces),
                )
            )
            if not open_bounces or sampler.exhausted or deterministic:
                break
        return self._compared(claim, sampler, [found[k] for k in bounces], looks)

    def _job(
        self, claim: Equal, bounces: list[int], show: Callable[[float], None], deterministic: bool
    ) -> Job:
        scene = claim.first[0].scene
        return Job(
            self.name,
            scene,
            list(bounces),
            self._seed(claim),
            self.budget,
            show,
            first_look=FIRST_LOOK if self.settings.early_stop else self.budget / 12,
            least_spp=-(-self.walks // (scene.shape[0] * scene.shape[1])),
            deterministic=deterministic,
        )

    def _pairs(self, claim: Equal) -> Pairs:
        return Pairs(claim, self.crew, self._seed(claim))

    def _seed(self, claim: Equal) -> int:
        """Of replicate 0. No two claims share random numbers, on whatever scene."""
        key = zlib.crc32(f"{self.relation.name} {claim.label} {self.subject.name}".encode())
        return first_seed(self.settings.seed << 32 | key)

    def _measured(
        self, claim: Equal, sampler: Sampler, regions: Regions, of: Sequence[int], level: float, look: int
    ) -> Iterator[Measured]:
        """The deviation of the first side from the second, and relative to it, of each of these bounces."""
        sides = {k: split(moments) for k, moments in sampler.regions.items()}
        relative_to = denominators(np.stack([second.mean for _, second in sides.values()], axis=1))
        spp = [side[0].spp(sampler.spp) for side in (claim.first, claim.second)]
        for row, (k, (first, second)) in enumerate(sides.items()):
            if k not in of:
                continue
            light, n = (first.mean + second.mean) / 2, first.count
            least = [
                least_error(event_size(pixels, samples), light, regions.pixels() * samples * n)
                for pixels, samples in zip(split(sampler.pixels[k]), spp, strict=True)
            ]
            found = biases(
                Means.of(first),
                Means.of(second),
                relative_to[:, row],
                level,
                others=relative_to[0].size,
                least_error=np.hypot(*least),
            )
            yield Measured(
                bounce=k,
                channels=self.channels,
                biases=found,
                mean=first.mean,
                truth=second.mean,
                denominator=relative_to[:, row],
                skewness=skewness.of_the_mean(first) * np.sqrt(n),
                dominance=np.maximum(first.dominance, second.dominance),
                look=look,
                replicates=n,
                spp=spp[0] * n,
                enough=n >= sampler.enough,
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
            notes=notes(bounces, sampler, self.traits),
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
            channels=self.channels,
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

    def restart(self) -> None:
        self.crew.dismiss(self.name)


def _seen(claim: Equal) -> tuple[int, int, int]:
    """The shape of the images of a claim."""
    part = claim.first[0]
    height, width, channels = part.view(np.zeros((1, *part.scene.shape))).shape[1:]
    return height, width, channels


def _undecided(bounces: Sequence[BounceResult], budget: float) -> str:
    """Why some bounce has no verdict; empty if all have one."""
    if not any(b.verdict == "inconclusive" for b in bounces):
        return ""
    seen = [
        f"{b.worst_tile.detectable_bias:.2%} of a tile in bounce {b.bounce}"
        if b.decided_by == "tile"
        else f"{b.detectable_bias:.2%} in bounce {b.bounce}"
        for b in bounces
        if b.verdict == "inconclusive"
    ]
    spent = f"the budget of {budget:g} s was used up"
    if (count := max(b.replicates for b in bounces)) < MIN_REPLICATES:
        spent += f" after {count} replicates, and a verdict needs {MIN_REPLICATES}"
    return f"{spent}; a deviation could have been detected from {', '.join(seen)}"
