"""One case held against one renderer, from the first sample to the verdict."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np

from comparisons.crew import Crew
from comparisons.known import Deviation, declared
from comparisons.metrics import partial_sum_metrics, term_metrics
from comparisons.regions import Regions
from comparisons.renderers import RendererError, RendererFailed, Unsupported, canonical
from comparisons.results import BounceResult, Comparison, Images, Look
from comparisons.sequential import MIN_REPLICATES, Job, Sampler, first_seed
from comparisons.settings import Observer, Settings
from comparisons.statistics.intervals import alpha_of_look, biases, denominators
from comparisons.truth import ESTIMATOR, STAND_IN
from comparisons.verdict import Measured, judge, overall
from scenes import Case, Estimate, Truth
from scenes.formats import exr


class Comparing:
    """The work of one comparison; ``run`` does it."""

    def __init__(
        self, case: Case, renderer: str, truth: Truth, settings: Settings, crew: Crew, observer: Observer
    ) -> None:
        self.case, self.truth, self.settings, self.crew, self.observer = case, truth, settings, crew, observer
        self.shown_name, (self.name, self.notes) = renderer, _judged_as(case, canonical(renderer))
        self.regions = Regions.of(*case.scene.shape[:2], case.tiles)
        self.truth_means = self.regions.means(truth.mean)
        self.truth_errors = self.regions.stderr(truth.stderr)
        self.denominators = denominators(self.truth_means)
        self.found: dict[int, BounceResult] = {}
        self.looks: list[Look] = []

    def run(self, folder: Path) -> Comparison:
        """Render, judge, write the images; a renderer's failure is a result too."""
        start, version = time.monotonic(), ""
        try:
            version = self.crew.version(self.name)
            sampler = self._sample(declared(list(self.settings.known), self.case.name, self.name, version))
        except RendererError as error:
            seconds = time.monotonic() - start
            return failed(self.case, self.shown_name, self.settings, error, seconds, version)
        finally:
            self.crew.dismiss(self.name)
        return self._result(sampler, version, folder)

    def _sample(self, known: list[Deviation]) -> Sampler:
        """Look after 32, 64, 128, … replicates, and at the end of the budget.

        Between looks only the bounces that are still open are sampled: that is where samples decide. A bounce
        that is decided keeps the numbers of the look that decided it.

        Raises:
            RendererError: see ``RendererProcess.render``; or it takes no notice of its seed.
        """
        open_bounces = list(range(self.case.bounces + 1))
        entries = {k: entry for entry in known for k in open_bounces if entry.bias_of(k) is not None}

        def show(share: float) -> None:
            self.observer.progressed(share, f"open bounces: {', '.join(map(str, open_bounces))}")

        seed = first_seed(self.settings.seed)
        job = Job(self.name, self.case.scene, list(open_bounces), seed, self.settings.budget, show)
        sampler = Sampler(job, self.crew, self.regions)
        target = MIN_REPLICATES
        while True:
            sampler.draw(open_bounces, target)
            look = len(self.looks) + 1
            for k in open_bounces:
                measured = self._measure(k, sampler, look)
                self.found[k] = judge(measured, self.case.tolerance, self.regions, entries.get(k))
            replicates = sampler.regions[open_bounces[-1]].count
            open_bounces[:] = [k for k in open_bounces if self.found[k].verdict == "inconclusive"]
            alpha = alpha_of_look(self.settings.alpha, look)
            self.looks.append(
                Look(
                    replicates=replicates,
                    seconds=sampler.seconds,
                    alpha=alpha,
                    open_bounces=list(open_bounces),
                )
            )
            if look == 1:
                self._refuse_identical(sampler)
            if not open_bounces or sampler.exhausted:
                return sampler
            target *= 2

    def _measure(self, k: int, sampler: Sampler, look: int) -> Measured:
        replicates, truth, denominator = sampler.regions[k], self.truth_means[:, k], self.denominators[:, k]
        found = biases(
            replicates,
            truth,
            self.truth_errors[:, k],
            denominator,
            alpha_of_look(self.settings.alpha, look),
            family=self.truth_means.size,
        )
        return Measured(
            bounce=k,
            biases=found,
            mean=replicates.mean,
            truth=truth,
            denominator=denominator,
            look=look,
            replicates=replicates.count,
            spp=sampler.spp * replicates.count,
            enough=replicates.count >= MIN_REPLICATES,
        )

    def _refuse_identical(self, sampler: Sampler) -> None:
        """Replicates without any spread prove nothing, unless they are the truth."""
        identical = all(not moments.m2.any() for moments in sampler.pixels.values())
        if identical and any(b.verdict != "pass" for b in self.found.values()):
            raise RendererFailed(
                f"{sampler.replicates} renders with different seeds are identical, and not the truth: "
                "it takes no notice of its seed, so its noise can't be told from a deviation"
            )

    def _result(self, sampler: Sampler, version: str, folder: Path) -> Comparison:
        bounces = [self.found[k] for k in sorted(self.found)]
        mean, stderr = (
            np.stack([getattr(sampler.pixels[b.bounce], name) for b in bounces])
            for name in ("mean", "standard_error")
        )
        stem = Path("images", self.case.name)
        images = Images(
            truth=(stem / "truth.exr").as_posix(),
            renderer=(stem / f"{self.shown_name.replace(':', '-')}.exr").as_posix(),
        )
        made = f"{self.case.name}, {self.name} {version}, first seed {first_seed(self.settings.seed)}"
        exr.write_bounces(folder / images.renderer, mean, stderr, {"lightproof:source": made})
        gone = [b.bounce for b in bounces if b.known is not None and b.known.state == "vanished"]
        vanished = [f"Bounce {k}: the declared deviation has vanished; remove its entry." for k in gone]
        return Comparison(
            **about(self.case, self.shown_name, self.settings),
            verdict=overall(b.verdict for b in bounces),
            seconds=sampler.seconds,
            spp=max(b.spp for b in bounces),
            replicates=max(b.replicates for b in bounces),
            bounces=bounces,
            renderer_version=version,
            looks=self.looks,
            metrics=partial_sum_metrics(mean, self.truth.mean),
            term_metrics=term_metrics(mean, self.truth.mean),
            images=images,
            truth_source=self.truth.source,
            message=_undecided(bounces, self.settings.budget),
            notes=self.notes + vanished,
        )


def failed(
    case: Case,
    renderer: str,
    settings: Settings,
    error: RendererError,
    seconds: float = 0.0,
    version: str = "",
) -> Comparison:
    """The comparison that an error, or a feature that is missing, has made of it."""
    return Comparison(
        **about(case, renderer, settings),
        verdict="unsupported" if isinstance(error, Unsupported) else "error",
        seconds=seconds,
        spp=0,
        replicates=0,
        bounces=[],
        renderer_version=version,
        truth_source=case.answer.source,
        message=str(error),
        log=error.log,
    )


def about(case: Case, renderer: str, settings: Settings) -> dict[str, Any]:
    """The fields of a comparison that its outcome has no part in."""
    height, width, channels = case.scene.shape
    regions = Regions.of(height, width, case.tiles)
    return {
        "case": case.name,
        "renderer": renderer,
        "truth": case.answer.kind,
        "title": case.title,
        "derivation": case.derivation,
        "blind_to": case.blind_to,
        "width": width,
        "height": height,
        "channels": exr.channel_names(channels),
        "tiles": (regions.rows, regions.columns),
        "alpha": settings.alpha,
    }


def _judged_as(case: Case, name: str) -> tuple[str, list[str]]:
    """Which renderer is held against the case where this one is asked for, and what is to be said of it."""
    if not isinstance(case.answer, Estimate) or name.split(":")[0] != ESTIMATOR.split(":")[0]:
        return name, []
    # whatever its numbers come from, a strategy can't judge itself
    judged = STAND_IN if name.split(":")[:2] == ESTIMATOR.split(":")[:2] else name
    return judged, [
        f"The truth was estimated by {ESTIMATOR}, which can't judge itself; {judged} is held against it. This tests "
        "one strategy of the reference tracer against another, and nothing else."
    ]


def _undecided(bounces: list[BounceResult], budget: float) -> str:
    """Why some bounce has no verdict, and what could have been seen in it; empty if all have one."""
    undecided = [b for b in bounces if b.verdict == "inconclusive"]
    if not undecided:
        return ""
    image = [f"{b.detectable_bias:.2%} in bounce {b.bounce}" for b in undecided if b.decided_by == "image"]
    tiles = [
        f"{b.worst_tile.detectable_bias:.2%} of a tile in bounce {b.bounce}"
        for b in undecided
        if b.decided_by == "tile"
    ]
    spent = f"the budget of {budget:g} s was used up"
    if (count := undecided[0].replicates) < MIN_REPLICATES:
        spent += f" after {count} replicates, and a verdict needs {MIN_REPLICATES}"
    return f"{spent}; a bias could have been detected from {', '.join(image + tiles)}"
