"""One case held against one renderer, from the first sample to the verdict."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import special

from comparisons.crew import Crew
from comparisons.hints import BLOCKS, hints_of_terms
from comparisons.in_process import InProcess
from comparisons.known import Deviation, declared, of_other_versions
from comparisons.notes import notes
from comparisons.regions import Regions
from comparisons.renderers import RendererError, Unsupported, canonical, traits
from comparisons.results import BounceResult, Comparison, Hint, Look, TotalResult
from comparisons.sequential import MIN_REPLICATES, Job, Sampler, first_seed, too_few
from comparisons.settings import Observer, Settings
from comparisons.shown import shown
from comparisons.statistics.intervals import Biases, Means, biases, denominators
from comparisons.statistics.rare_events import event_size, least_error
from comparisons.total import Totalling, counted, said_of
from comparisons.truth import ESTIMATOR, STAND_IN
from comparisons.verdict import Measured, judge, overall
from comparisons.whole_sum import Series
from scenes import Case, Estimate, Truth
from scenes.channels import channel_names
from scenes.features import features

Array = NDArray[np.float64]

_AS_NOISY = 0.95
"""Bounces are sampled together if their noise is at least this share of the largest."""

_LUCK = 1.5
"""Standard errors that the bias of a right renderer seldom exceeds; so far from the middle its interval lies."""


class Comparing:
    """The work of one comparison; ``run`` does it."""

    def __init__(
        self,
        case: Case,
        renderer: str,
        truth: Truth,
        settings: Settings,
        crew: Crew,
        observer: Observer,
        guest: InProcess | None = None,
        series: Series | None = None,
    ) -> None:
        """Of a renderer by its name; or of the guest, an object of this process, which is the crew then.

        With the series of the case, its total is compared, too.
        """
        full_name = guest.name if guest else canonical(renderer)
        self.shown_name, (self.name, self.notes) = renderer, _judged_as(case, full_name)
        self.traits = guest.traits if guest else traits(self.name)
        case, truth, unheld = _as_far_as_it_goes(case, truth, self.traits.last_bounce)
        self.case, self.truth, self.settings, self.crew, self.observer = case, truth, settings, crew, observer
        self.notes += unheld + _noise_of_truth(truth)
        self.regions = Regions.of(*case.scene.shape[:2], case.tiles)
        self.truth_means = self.regions.means(truth.mean)
        self.truth_errors = self.regions.stderr(truth.stderr)
        self.denominators = denominators(self.truth_means)
        last = self.traits.last_bounce
        self.series = series if last is None else None
        ends = TotalResult(verdict="unsupported", message=f"total: the renderer stops at bounce {last}")
        self.no_totals = [] if series is None or last is None else [ends]
        # the total is one image more to be wrong about
        self.others = self.truth_means[0].size + (case.scene.channels if self.series else 0)
        self.found: dict[int, BounceResult] = {}
        self.looks: list[Look] = []

    def run(self, folder: Path | None) -> Comparison:
        """Render, judge, write the images where there is a folder for them; a failure is a result too."""
        start, version = time.monotonic(), ""
        try:
            version = self.crew.version(self.name)
            known = declared(list(self.settings.known), self.case.name, self.name, version)
            self.notes += of_other_versions(list(self.settings.known), self.case.name, self.name, version)
            sampler = self._sample(known)
            seconds = sampler.seconds
            totals = [self._total(self.series, known)] if self.series else self.no_totals
        except RendererError as error:
            seconds = time.monotonic() - start
            return failed(self.case, self.shown_name, self.settings, error, seconds, version)
        finally:
            self.crew.dismiss(self.name)
        return self._result(sampler, version, folder, seconds, totals)

    def _total(self, series: Series, known: list[Deviation]) -> TotalResult:
        def show(share: float) -> None:
            self.observer.progressed(share, "the total, by its own defaults")

        work = Totalling(
            self.case, self.name, series, self.settings, self.crew, self.traits, known, self.others, show
        )
        return work.row()[0]

    def _sample(self, known: list[Deviation]) -> Sampler:
        """Sample and look, at most twice as late each time, until every bounce is decided or the budget is used up.

        Without early stop there is one look, at the end. A bounce that is decided keeps the numbers of the look
        that decided it, and is not sampled any more.

        Raises:
            RendererError: see ``RendererProcess.render``.
        """
        open_bounces = list(range(self.case.bounces + 1))
        entries = {k: entry for entry in known for k in open_bounces if entry.speaks_of(k)}

        def show(share: float) -> None:
            if (drawn := sampler.replicates) < sampler.enough:
                self.observer.progressed(share, f"{drawn} of {sampler.enough} replicates")
            else:
                self.observer.progressed(share, f"open bounces: {', '.join(map(str, open_bounces))}")

        sampler = Sampler(self._job(show), self.crew, self.regions)
        sampler.draw(open_bounces, sampler.enough)
        while True:
            if self.settings.early_stop or self.traits.deterministic:
                open_bounces[:] = self._look(sampler, open_bounces, entries)
                if not open_bounces or sampler.exhausted or self.traits.deterministic:
                    return sampler
            elif sampler.exhausted:
                self._look(sampler, open_bounces, entries)
                return sampler
            self._draw_where_it_decides(sampler, open_bounces, until=self._next_look(sampler, open_bounces))

    def _job(self, show: Callable[[float], None]) -> Job:
        budget = self.settings.budget
        return Job(
            self.name,
            self.case.scene,
            list(range(self.case.bounces + 1)),
            first_seed(self.settings.seed),
            budget,
            show,
            # where the only look is at the end, replicates may be longer, which are cheaper to ask for
            first_look=self.settings.first_look if self.settings.early_stop else budget / 12,
            deterministic=self.traits.deterministic,
            spp_unit=self.traits.spp_unit,
        )

    def _next_look(self, sampler: Sampler, bounces: list[int]) -> float:
        """When all of these bounces would pass if they were right, but no later than twice the time; seconds.

        The noise alone says when, as in ``_draw_where_it_decides``. If it is small enough already, something else
        keeps a bounce open, and only many more samples can tell what.
        """
        q = -float(special.ndtri(self.settings.alpha_of(len(self.looks) + 1) / 2))
        noise = max(self._noise(k, sampler) for k in bounces)
        longer = ((1 + _LUCK / q) * noise) ** 2
        return sampler.seconds * (2.0 if longer < 1 else float(np.clip(longer, 1.25, 2.0)))

    def _draw_where_it_decides(self, sampler: Sampler, bounces: list[int], until: float) -> None:
        """Sample the noisiest of these bounces, again and again; what is measured has no say in which.

        Args:
            until: seconds since the start.
        """
        noise = {k: self._noise(k, sampler) for k in bounces}
        while sampler.seconds < until and not sampler.exhausted:
            noisy = [k for k in bounces if noise[k] >= _AS_NOISY * max(noise.values())]
            if self.traits.one_walk:
                noisy = [k for k in bounces if k <= max(noisy)]
            sampler.draw(noisy, max(4 * self.crew.jobs, min(sampler.pixels[k].count for k in noisy) // 8))
            noise |= {k: self._noise(k, sampler) for k in noisy}

    def _noise(self, k: int, sampler: Sampler) -> float:
        """Half the interval that is widest beside its tolerance, of the image and of the tiles.

        Of the own interval, which can pass; where samples are to be used up anyway, what they resolve.
        """
        found = self._biases(k, sampler, len(self.looks) + 1)
        width = (found.own.high - found.own.low) / 2 if self.settings.early_stop else found.resolution
        image, tile = self.case.tolerance.of_image(k), self.case.tolerance.of_tile(k)
        tolerance = np.maximum([[image]] + [[tile]] * (len(width) - 1), 1e-12)
        return float(np.max(width / tolerance))

    def _look(self, sampler: Sampler, bounces: list[int], known: dict[int, Deviation]) -> list[int]:
        """Judge these bounces with what there is now; those that stay open."""
        look = len(self.looks) + 1
        for k in bounces:
            measured = self._measure(k, sampler, look)
            self.found[k] = judge(measured, self.case.tolerance, self.regions, known.get(k))
        still_open = [k for k in bounces if self.found[k].verdict == "inconclusive"]
        self.looks.append(
            Look(
                replicates=max(sampler.regions[k].count for k in bounces),
                seconds=sampler.seconds,
                alpha=self.settings.alpha_of(look),
                open_bounces=still_open,
            )
        )
        return still_open

    def _biases(self, k: int, sampler: Sampler, look: int) -> Biases:
        replicates, truth = sampler.regions[k], self.truth_means[:, k]
        return biases(
            Means.of(replicates),
            Means.known(truth, self.truth_errors[:, k]),
            self.denominators[:, k],
            self.settings.alpha_of(look),
            others=self.others,
            least_error=least_error(
                event_size(sampler.pixels[k], sampler.spp),
                truth,
                self.regions.pixels() * sampler.spp * replicates.count,
            ),
        )

    def _measure(self, k: int, sampler: Sampler, look: int) -> Measured:
        return Measured.of(
            sampler.regions[k],
            self._biases(k, sampler, look),
            self.truth_means[:, k],
            self.denominators[:, k],
            bounce=k,
            channels=channel_names(self.case.scene.channels, self.case.wavelengths),
            look=look,
            spp=sampler.spp,
            least=sampler.enough,
        )

    def _result(
        self, sampler: Sampler, version: str, folder: Path | None, seconds: float, totals: list[TotalResult]
    ) -> Comparison:
        bounces = [self.found[k] for k in sorted(self.found)]
        mean, stderr = (
            np.stack([getattr(sampler.pixels[b.bounce], name) for b in bounces])
            for name in ("mean", "standard_error")
        )
        made = f"{self.case.name}, {self.name} {version}, first seed {first_seed(self.settings.seed)}"
        by_bounce = overall(b.verdict for b in bounces)
        return Comparison(
            **about(self.case, self.shown_name, self.settings),
            verdict=overall([by_bounce, *counted(totals)]),
            seconds=seconds + sum(t.seconds for t in totals),
            spp=max(b.spp for b in bounces),
            replicates=max(b.replicates for b in bounces),
            bounces=bounces,
            renderer_version=version,
            looks=self.looks,
            truth_source=self.truth.source,
            message="; ".join(filter(None, (self._undecided(bounces), said_of(totals)))),
            log=[line for total in totals for line in total.log],
            notes=self.notes + notes(bounces, sampler, self.traits, totals),
            hints=self._hints(mean) if by_bounce == "fail" else [],
            totals=totals,
            **shown(folder, self.case, self.shown_name, made, mean, stderr, self.truth.mean),
        )

    def _undecided(self, bounces: list[BounceResult]) -> str:
        return _undecided(bounces, self.settings.budget, self.looks[-1].seconds)

    def _hints(self, mean: Array) -> list[Hint]:
        """What the sum seems to have gone through, if the image is large enough to tell."""
        if min(mean.shape[1:3]) < BLOCKS:
            return []
        return hints_of_terms(mean, self.truth.mean, self.found[0].verdict != "fail")


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
        "channels": channel_names(channels, case.wavelengths),
        "tiles": (regions.rows, regions.columns),
        "alpha": settings.alpha,
        "features": list(features(case.scene)),
    }


def _judged_as(case: Case, name: str) -> tuple[str, list[str]]:
    """Which renderer is held against the case where this one is asked for, and what is to be said of it."""
    tracer = ESTIMATOR.split(":")[0]
    if not isinstance(case.answer, Estimate) or name.split(":")[0] != tracer:
        return name, []
    if f"{tracer}:" not in case.answer.source:  # an image of the user's, made by something else
        return name, []
    # whatever its numbers come from, a strategy can't judge itself
    judged = STAND_IN if name.split(":")[:2] == ESTIMATOR.split(":")[:2] else name
    return judged, [
        f"The truth was estimated by the {tracer} tracer, which can't judge itself; {judged} is held against it. "
        "This tests one strategy of the reference tracer against another, and nothing else."
    ]


def _as_far_as_it_goes(case: Case, truth: Truth, last: int | None) -> tuple[Case, Truth, list[str]]:
    """The bounces that a renderer has, and what is to be said of those that it does not."""
    if last is None or case.bounces <= last:
        return case, truth, []
    truth = replace(truth, mean=truth.mean[: last + 1], stderr=truth.stderr[: last + 1])
    several = f"Bounces {last + 1} to {case.bounces} are"
    unheld = f"Bounce {case.bounces} is" if case.bounces == last + 1 else several
    return (
        replace(case, bounces=last),
        truth,
        [f"{unheld} unsupported: the renderer stops at bounce {last}"],
    )


def _noise_of_truth(truth: Truth) -> list[str]:
    """A warning where the truth is a rendered image, as its header says, without the size of its noise."""
    if truth.stderr.any() or not (spp := re.search(r"\b\d+ spp\b", truth.source)):
        return []
    return [
        f"The truth is an image of {spp[0]} without standard errors (layers bounce0.stderr, …): its own noise is "
        "taken for bias of the renderer, and a fail may come from it"
    ]


def _undecided(bounces: list[BounceResult], budget: float, seconds: float) -> str:
    """Why some bounce has no verdict, and what could have been seen in it; empty if all have one.

    Args:
        bounces: all of them.
        budget, seconds: that there were, and that were used.
    """
    undecided = [b for b in bounces if b.verdict == "inconclusive"]
    if not undecided:
        return ""
    image = [
        f"{_percent(b.detectable_bias)} in bounce {b.bounce}" for b in undecided if b.decided_by == "image"
    ]
    tiles = [
        f"{_percent(b.worst_tile.detectable_bias)} of a tile in bounce {b.bounce}"
        for b in undecided
        if b.decided_by == "tile"
    ]
    spent = f"the budget of {budget:g} s was used up"
    if (count := undecided[0].replicates) < MIN_REPLICATES:
        spent += f" {too_few(count, max(seconds, budget))}"
    return f"{spent}; a bias could have been detected from {', '.join(image + tiles)}"


def _percent(value: float) -> str:
    return f"{100 * value:,.{2 if value < 0.1 else 0}f} %"
