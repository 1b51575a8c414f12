"""A run: every case held against every renderer, each comparison a result, whatever happens."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import msgspec

from comparisons import sequential
from comparisons.crew import Crew
from comparisons.known import Deviation, declared
from comparisons.metrics import partial_sum_metrics
from comparisons.regions import Regions
from comparisons.renderers import RendererError, Unsupported, canonical
from comparisons.results import BounceResult, Comparison, Images, Look, Verdict
from comparisons.sequential import Sample, sample
from comparisons.statistics.intervals import alpha_of_look, biases
from comparisons.truth import truth_of
from comparisons.verdict import judge, overall
from scenes import Case, Estimate, Tolerance, Truth
from scenes.formats import exr

DEFAULT_BUDGET = 30.0
DEFAULT_ALPHA = 1e-3


@dataclass(frozen=True)
class Settings:
    """How to validate. What is None is left to the case.

    Attributes:
        bounces: the last bounce.
        tolerance, tile_tolerance: relative, for all bounces.
        size: (width, height) in pixels.
        alpha: probability of a wrong verdict in a comparison.
        budget: seconds per case × renderer.
        seed: of the user.
        jobs: processes that render at the same time.
        known: declared deviations.
    """

    bounces: int | None = None
    tolerance: float | None = None
    tile_tolerance: float | None = None
    size: tuple[int, int] | None = None
    alpha: float = DEFAULT_ALPHA
    budget: float = DEFAULT_BUDGET
    seed: int = 0
    jobs: int = 1
    known: tuple[Deviation, ...] = ()


class Observer(Protocol):
    """Who wants to see how a run goes on."""

    def started(self, case: str, renderer: str) -> None:
        """A comparison begins."""

    def progressed(self, share: float, message: str) -> None:
        """So much of its budget is used; the message says what is done or what is still open."""

    def finished(self, comparison: Comparison) -> None:
        """A comparison has its verdict."""


def run(
    cases: Sequence[Case], renderers: Sequence[str], settings: Settings, folder: Path, observer: Observer
) -> list[Comparison]:
    """Compare; images go to ``folder/images``, one folder per case.

    Raises:
        UnknownNameError: there is no renderer of that name. Nothing has been rendered then.
    """
    for name in renderers:
        canonical(name)
    comparisons = []
    with Crew(settings.jobs) as crew:
        for case in cases:
            comparisons += list(_compare_case(case, renderers, settings, folder, crew, observer))
    return comparisons


def _compare_case(
    case: Case, renderers: Sequence[str], settings: Settings, folder: Path, crew: Crew, observer: Observer
) -> Iterator[Comparison]:
    """The truth once, then every renderer against it."""
    case = _adjusted(case, settings)
    answer: Truth | None = None
    images = folder / "images" / case.name
    for renderer in renderers:
        observer.started(case.name, renderer)
        if answer is None:
            answer = truth_of(
                case,
                case.scene,
                case.bounces,
                settings.jobs,
                lambda share: observer.progressed(share, "estimating the truth"),
            )
            images.mkdir(parents=True, exist_ok=True)
            exr.write_bounces(images / "truth.exr", answer.mean, answer.stderr)
        comparison = _Comparison(case, renderer, answer, settings, crew, observer).result(folder)
        observer.finished(comparison)
        yield comparison


def _adjusted(case: Case, settings: Settings) -> Case:
    """The case as the user asks for it: resolution, bounces and tolerances."""
    return replace(
        case,
        scene=case.scene.resized(*settings.size) if settings.size else case.scene,
        bounces=case.bounces if settings.bounces is None else settings.bounces,
        tolerance=Tolerance(
            image=case.tolerance.image if settings.tolerance is None else (settings.tolerance,),
            tile=case.tolerance.tile if settings.tile_tolerance is None else (settings.tile_tolerance,),
        ),
    )


class _Comparison:
    """One case, one renderer."""

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
        self.looks: list[Look] = []
        self.version = ""

    def result(self, folder: Path) -> Comparison:
        """Render, judge, write the images; a renderer's failure is a result too."""
        start = time.monotonic()
        try:
            self.version = self.crew.version(self.name)
            known = declared(list(self.settings.known), self.case.name, self.name, self.version)
            final, bounces = self._sequential(known)
        except RendererError as error:
            verdict: Verdict = "unsupported" if isinstance(error, Unsupported) else "error"
            return self._comparison(verdict, time.monotonic() - start, message=str(error), log=error.log)
        finally:
            self.crew.dismiss(self.name)
        return self._judged(final, bounces, folder)

    def _sequential(self, known: Mapping[int, Deviation]) -> tuple[Sample, list[BounceResult]]:
        """Look until every bounce is decided at the same look, or the budget is used up."""
        truth = self.regions.means(self.truth.mean)
        truth_error = self.regions.stderr(self.truth.stderr)
        open_bounces = list(range(self.case.bounces + 1))

        def show(share: float) -> None:
            self.observer.progressed(share, f"open bounces: {', '.join(map(str, open_bounces))}")

        job = sequential.Job(
            self.name,
            self.case.scene,
            self.case.bounces,
            sequential.first_seed(self.settings.seed),
            self.settings.budget,
            show,
        )
        for drawn in sample(job, self.crew, self.regions):
            alpha = alpha_of_look(self.settings.alpha, len(self.looks) + 1)
            intervals = biases(drawn.regions, truth, truth_error, alpha)
            bounces = judge(
                intervals, drawn.regions.mean, truth, self.case.tolerance, self.regions, known, drawn.enough
            )
            open_bounces[:] = [b.bounce for b in bounces if b.verdict == "inconclusive"]
            self.looks.append(
                Look(
                    replicates=drawn.regions.count,
                    seconds=drawn.seconds,
                    alpha=alpha,
                    open_bounces=list(open_bounces),
                )
            )
            if not open_bounces or drawn.exhausted:
                break
        return drawn, bounces

    def _judged(self, final: Sample, bounces: list[BounceResult], folder: Path) -> Comparison:
        stem = Path("images", self.case.name)
        images = Images(
            truth=(stem / "truth.exr").as_posix(),
            renderer=(stem / f"{self.shown_name.replace(':', '-')}.exr").as_posix(),
        )
        exr.write_bounces(folder / images.renderer, final.pixels.mean, final.pixels.standard_error)
        verdict = overall(b.verdict for b in bounces)
        for b in bounces:
            if b.known is not None and b.known.state == "vanished":
                self.notes.append(
                    f"Bounce {b.bounce}: the declared deviation has vanished; remove its entry."
                )
        comparison = self._comparison(verdict, final.seconds, message=self._undecided(final, bounces))
        return msgspec.structs.replace(
            comparison,
            spp=final.spp * final.regions.count,
            replicates=final.regions.count,
            bounces=bounces,
            metrics=partial_sum_metrics(final.pixels.mean, self.truth.mean),
            images=images,
        )

    def _undecided(self, final: Sample, bounces: list[BounceResult]) -> str:
        """Why some bounce has no verdict, and what could have been seen in it; empty if all have one."""
        undecided = [b for b in bounces if b.verdict == "inconclusive"]
        if not undecided:
            return ""
        seen = ", ".join(f"{b.detectable_bias:.2%} in bounce {b.bounce}" for b in undecided)
        spent = f"the budget of {self.settings.budget:g} s was used up"
        if not final.enough:
            needed = sequential.MIN_REPLICATES
            spent += f" after {final.regions.count} replicates, and a verdict needs {needed}"
        return f"{spent}; a bias of the whole image could have been detected from {seen}"

    def _comparison(
        self, verdict: Verdict, seconds: float, message: str, log: Sequence[str] = ()
    ) -> Comparison:
        height, width, channels = self.case.scene.shape
        return Comparison(
            case=self.case.name,
            renderer=self.shown_name,
            verdict=verdict,
            truth=self.case.answer.kind,
            seconds=seconds,
            spp=0,
            replicates=0,
            bounces=[],
            title=self.case.title,
            blind_to=self.case.blind_to,
            renderer_version=self.version,
            truth_source=self.case.answer.source,
            width=width,
            height=height,
            channels=exr.channel_names(channels),
            tiles=(self.regions.rows, self.regions.columns),
            alpha=self.settings.alpha,
            looks=self.looks,
            message=message,
            log=list(log),
            notes=self.notes,
        )
