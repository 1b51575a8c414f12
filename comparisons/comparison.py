"""One case held against one renderer, from the first sample to the verdict."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path

import msgspec
import numpy as np

from comparisons.crew import Crew
from comparisons.known import Deviation, declared
from comparisons.metrics import partial_sum_metrics
from comparisons.regions import Regions
from comparisons.renderers import RendererError, Unsupported, canonical
from comparisons.results import BounceResult, Comparison, Images, Look
from comparisons.sequential import MIN_REPLICATES, Job, Sampler, first_seed
from comparisons.settings import Observer, Settings
from comparisons.statistics.intervals import alpha_of_look, biases, denominators
from comparisons.verdict import Measured, judge, overall
from scenes import Case, Estimate, Truth
from scenes.formats import exr


class Comparing:
    """The work of one comparison; ``run`` does it."""

    def __init__(
        self, case: Case, renderer: str, truth: Truth, settings: Settings, crew: Crew, observer: Observer
    ) -> None:
        self.case, self.truth, self.settings, self.crew, self.observer = case, truth, settings, crew, observer
        self.shown_name, self.name = renderer, canonical(renderer)
        self.notes: list[str] = []
        if isinstance(case.answer, Estimate) and self.name == case.answer.renderer:
            self.name = case.answer.stand_in
            self.notes.append(
                f"The truth was estimated by {case.answer.renderer}, which can't judge itself: {self.name} is held "
                "against it. This tests one strategy of the reference tracer against another, and nothing else."
            )
        self.regions = Regions.of(*case.scene.shape[:2], case.tiles)
        self.truth_means = self.regions.means(truth.mean)
        self.truth_errors = self.regions.stderr(truth.stderr)
        self.denominators = denominators(self.truth_means)
        self.found: dict[int, BounceResult] = {}
        self.looks: list[Look] = []

    def run(self, folder: Path) -> Comparison:
        """Render, judge, write the images; a renderer's failure is a result too."""
        start = time.monotonic()
        blank = self._blank()
        try:
            version = self.crew.version(self.name)
            blank = msgspec.structs.replace(blank, renderer_version=version)
            sampler = self._sample(declared(list(self.settings.known), self.case.name, self.name, version))
        except RendererError as error:
            return msgspec.structs.replace(
                blank,
                verdict="unsupported" if isinstance(error, Unsupported) else "error",
                seconds=time.monotonic() - start,
                message=str(error),
                log=error.log,
            )
        finally:
            self.crew.dismiss(self.name)
        return self._result(blank, sampler, folder)

    def _sample(self, known: Mapping[int, Deviation]) -> Sampler:
        """Look after 32, 64, 128, … replicates, and at the end of the budget.

        Between looks only the bounces that are still open are sampled: that is where samples decide. A bounce
        that is decided keeps the numbers of the look that decided it.
        """
        open_bounces = list(range(self.case.bounces + 1))

        def show(share: float) -> None:
            self.observer.progressed(share, f"open bounces: {', '.join(map(str, open_bounces))}")

        seed = first_seed(self.settings.seed)
        job = Job(self.name, self.case.scene, list(open_bounces), seed, self.settings.budget, show)
        sampler = Sampler(job, self.crew, self.regions)
        target = MIN_REPLICATES
        while True:
            sampler.draw(open_bounces, target)
            alpha = alpha_of_look(self.settings.alpha, len(self.looks) + 1)
            for k in open_bounces:
                measured = self._measure(k, sampler, alpha)
                self.found[k] = judge(measured, self.case.tolerance, self.regions, known.get(k))
            replicates = sampler.regions[open_bounces[0]].count
            open_bounces[:] = [k for k in open_bounces if self.found[k].verdict == "inconclusive"]
            self.looks.append(
                Look(
                    replicates=replicates,
                    seconds=sampler.seconds,
                    alpha=alpha,
                    open_bounces=list(open_bounces),
                )
            )
            if not open_bounces or sampler.exhausted:
                return sampler
            target *= 2

    def _measure(self, k: int, sampler: Sampler, alpha: float) -> Measured:
        replicates, truth = sampler.regions[k], self.truth_means[:, k]
        found = biases(
            replicates,
            truth,
            self.truth_errors[:, k],
            self.denominators[:, k],
            alpha,
            family=self.truth_means.size,
        )
        return Measured(
            bounce=k,
            biases=found,
            mean=replicates.mean,
            truth=truth,
            denominator=self.denominators[:, k],
            replicates=replicates.count,
            spp=sampler.spp * replicates.count,
            enough=replicates.count >= MIN_REPLICATES,
        )

    def _result(self, blank: Comparison, sampler: Sampler, folder: Path) -> Comparison:
        bounces = [self.found[k] for k in sorted(self.found)]
        stem = Path("images", self.case.name)
        images = Images(
            truth=(stem / "truth.exr").as_posix(),
            renderer=(stem / f"{self.shown_name.replace(':', '-')}.exr").as_posix(),
        )
        mean, stderr = (
            np.stack([getattr(sampler.pixels[k], name) for k in sorted(self.found)])
            for name in ("mean", "standard_error")
        )
        exr.write_bounces(folder / images.renderer, mean, stderr)
        for b in bounces:
            if b.known is not None and b.known.state == "vanished":
                self.notes.append(
                    f"Bounce {b.bounce}: the declared deviation has vanished; remove its entry."
                )
        return msgspec.structs.replace(
            blank,
            verdict=overall(b.verdict for b in bounces),
            seconds=sampler.seconds,
            message=self._undecided(bounces),
            spp=max(b.spp for b in bounces),
            replicates=max(b.replicates for b in bounces),
            bounces=bounces,
            metrics=partial_sum_metrics(mean, self.truth.mean),
            images=images,
        )

    def _undecided(self, bounces: list[BounceResult]) -> str:
        """Why some bounce has no verdict, and what could have been seen in it; empty if all have one."""
        undecided = [b for b in bounces if b.verdict == "inconclusive"]
        if not undecided:
            return ""
        seen = ", ".join(f"{b.detectable_bias:.2%} in bounce {b.bounce}" for b in undecided)
        spent = f"the budget of {self.settings.budget:g} s was used up"
        if (count := undecided[0].replicates) < MIN_REPLICATES:
            spent += f" after {count} replicates, and a verdict needs {MIN_REPLICATES}"
        return f"{spent}; a bias of the whole image could have been detected from {seen}"

    def _blank(self) -> Comparison:
        """What is known before the renderer has started."""
        height, width, channels = self.case.scene.shape
        return Comparison(
            case=self.case.name,
            renderer=self.shown_name,
            verdict="inconclusive",
            truth=self.case.answer.kind,
            seconds=0.0,
            spp=0,
            replicates=0,
            bounces=[],
            title=self.case.title,
            blind_to=self.case.blind_to,
            renderer_version="",
            truth_source=self.case.answer.source,
            width=width,
            height=height,
            channels=exr.channel_names(channels),
            tiles=(self.regions.rows, self.regions.columns),
            alpha=self.settings.alpha,
            looks=self.looks,
            notes=self.notes,
        )
