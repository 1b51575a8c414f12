"""The row ``total``: the sum of all bounces, as its users have the renderer make it.

To show single terms an adapter switches off Russian roulette and other economies, so nothing of them is seen in the
bounces. Here the renderer runs with its own defaults, unlimited depth and Russian roulette, and its image is held
against Σ TᵏE (``whole_sum``), by the rules of any bounce. Its tolerance is what the sum would use up if every bounce
used its own. Where the truth is known up to a tail,

    Σ TᵏE in [S, S + t],    bias = (m̂ − S − t/2) / D,    its interval reaches t / 2D further to either side,

so a pass holds for every truth in between, and so does a fail. A tail so long that nothing could pass is told
beforehand: ``unsupported``.

It takes up to half of the case's budget, beside it. α is shared: the sum is one bounce more to be wrong about.

A renderer that makes nothing but totals is held against Σ sᵏ TᵏE with every albedo times s, for several s: s = 0
leaves E by itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import special

from comparisons.crew import Crew
from comparisons.known import Deviation, declared_of_sum
from comparisons.regions import Regions
from comparisons.renderers import Entry, Images, RendererError, Unsupported
from comparisons.results import Look, TotalResult, Verdict
from comparisons.sequential import Job, Sampler, first_seed, too_few
from comparisons.settings import Settings
from comparisons.statistics.intervals import Biases, Means, Range, biases, denominators
from comparisons.statistics.rare_events import event_size, least_error
from comparisons.verdict import Measured, judge
from comparisons.whole_sum import Series, WholeSum
from scenes import Case, Scene, SceneError
from scenes.channels import channel_names
from scenes.variations import darker

Array = NDArray[np.float64]

SHARE = 0.5
"""Of the budget of the case, that the total gets beside it."""

FIRST_LOOK = 0.5
"""Seconds that its first look should take: the sum has less noise than its terms."""

LEAST_PATHS = 4096
"""Of a replicate: the longest walks take as long for a few paths as for some thousand."""

_LUCK = 1.5  # standard errors that the bias of a right renderer seldom exceeds

SCALES = (0.25, 0.5, 0.75, 1.0)
"""Of all albedos, for a renderer that makes nothing but totals; and 0, which leaves bounce 0."""


class _Totals:
    """A crew that is asked for bounce images and makes totals: one, in place of any bounce."""

    def __init__(self, crew: Crew) -> None:
        self.jobs, self._crew = crew.jobs, crew

    def render(
        self, name: str, scene: Scene, bounces: Sequence[int], spp: int, seed: int, timeout: float
    ) -> Future[Images]:
        """As ``Crew.total``, whatever the bounces."""
        return self._crew.total(name, scene, spp, seed, timeout)


class Totalling:
    """The totals of one case and one renderer.

    Args:
        case: at its size.
        name: the renderer's full name.
        series: what is known of the case's bounces.
        settings, crew: as of a comparison.
        traits: what is declared of the renderer.
        known: the declared deviations of this comparison.
        others: how many intervals each region has in it: (bounces + total) × channels.
        show: told the share of the budget that is used.
    """

    def __init__(
        self,
        case: Case,
        name: str,
        series: Series,
        settings: Settings,
        crew: Crew,
        traits: Entry,
        known: Sequence[Deviation],
        others: int,
        show: Callable[[float], None],
    ) -> None:
        self.case, self.name, self.series, self.settings, self.crew = case, name, series, settings, crew
        self.traits, self.known, self.others, self.show = traits, known, others, show
        self.regions = Regions.of(*case.scene.shape[:2], case.tiles)

    def row(self, scale: float = 1.0, budget: float | None = None) -> tuple[TotalResult, Sampler | None]:
        """Hold the total against Σ sᵏ TᵏE; whatever the renderer does, a result.

        Args:
            scale: s.
            budget: seconds; the share of a total by default.

        Returns:
            The result, and the images behind it if there are any.
        """
        truth = self.series.total(scale)
        one = _One(self, truth, scale)
        if one.hopeless:
            return one.without("unsupported", one.hopeless), None
        try:
            scene = self.case.scene if scale == 1 else darker(self.case.scene, scale)
        except SceneError as error:
            return one.without("unsupported", f"total: albedos × {scale:g}: {error}"), None
        job = Job(
            self.name,
            scene,
            [0],
            first_seed(self.settings.seed),
            SHARE * self.settings.budget if budget is None else budget,
            self.show,
            first_look=min(FIRST_LOOK, self.settings.first_look),
            least_spp=-(-LEAST_PATHS // (scene.sensor.height * scene.sensor.width)),
            deterministic=self.traits.deterministic,
            spp_unit=self.traits.spp_unit,
        )
        try:
            sampler = Sampler(job, _Totals(self.crew), self.regions)
            return one.judged(sampler), sampler
        except RendererError as error:
            verdict: Verdict = "unsupported" if isinstance(error, Unsupported) else "error"
            return one.without(verdict, _named(error), error.log), None


class _One:
    """One total, for one scale."""

    def __init__(self, of: Totalling, truth: WholeSum, scale: float) -> None:
        self.of, self.truth, self.scale = of, truth, scale
        case, regions = of.case, of.regions
        self.mean = regions.means(truth.mean[None])
        self.error = regions.stderr(truth.stderr[None])[:, 0]
        self.denominator = denominators(self.mean)[:, 0]
        with np.errstate(invalid="ignore"):
            self.tail = regions.means(truth.tail[None])[:, 0] / self.denominator
        # of darker scenes the bounces have other shares, and s = 0 leaves bounce 0 by itself
        self.tolerance = case.tolerance.of_sum(truth.terms.mean(axis=1))
        names = channel_names(case.scene.channels, case.wavelengths)
        known = [entry for entry in of.known if entry.total is None or scale == 1]
        self.declared = declared_of_sum(known, truth.terms, names, case.tolerance)

    @property
    def hopeless(self) -> str:
        """Why nothing could pass, whatever the renderer makes; empty if something could."""
        image, tiles = float(self.tail[0].max()), float(self.tail[1:].max(initial=0.0))
        if image <= self.tolerance.of_image(0) and tiles <= self.tolerance.of_tile(0):
            return ""
        worst = max(image, tiles)
        known = f"to {100 * worst:.2g} % of the sum at best" if worst < 1 else "by no bound of any use"
        return (
            f"total: the truth adds up {self.truth.how}; what later bounces hold is known {known}, and must be "
            f"within the tolerance of ±{100 * self.tolerance.of_image(0):.2g} %"
        )

    def without(self, verdict: Verdict, message: str, log: Sequence[str] = ()) -> TotalResult:
        """The result where there are no numbers."""
        return TotalResult(
            verdict=verdict, scale=self.scale, truth=self.truth.how, message=message, log=list(log)
        )

    def judged(self, sampler: Sampler) -> TotalResult:
        """Sample and look until there is a verdict or the budget is used up."""
        settings, looks, more = self.of.settings, list[Look](), sampler.enough
        while True:
            sampler.draw([0], more)
            count = more = sampler.pixels[0].count
            if not (settings.early_stop or sampler.exhausted or self.of.traits.deterministic):
                continue
            look = len(looks) + 1
            measured = self._measured(sampler, look)
            result = judge(measured, self.tolerance, self.of.regions, self.declared)
            undecided = result.verdict == "inconclusive"
            looks.append(
                Look(
                    replicates=count,
                    seconds=sampler.seconds,
                    alpha=settings.alpha_of(look),
                    open_bounces=[self.truth.last] if undecided else [],
                )
            )
            if not undecided or sampler.exhausted or self.of.traits.deterministic:
                return TotalResult(
                    verdict=result.verdict,
                    result=result,
                    tail=float(self.tail.max()),
                    seconds=sampler.seconds,
                    looks=looks,
                    message=self._undecided(measured, sampler) if undecided else "",
                    scale=self.scale,
                    truth=self.truth.how,
                )
            more = math.ceil(count * self._longer(measured, look + 1))

    def _longer(self, measured: Measured, look: int) -> float:
        """Which share of the samples so far is to be added: what makes a right renderer pass, at most all of it."""
        found, tile = measured.biases, self.tolerance.of_tile(0)
        tolerances = np.array([[self.tolerance.of_image(0)]] + [[tile]] * (len(found.bias) - 1))
        q = -float(special.ndtri(self.of.settings.alpha_of(look) / 2))
        noise = float(np.max((found.own.high - found.own.low) / 2 / tolerances))
        times = ((1 + _LUCK / q) * noise) ** 2
        return 1.0 if times < 1 else float(np.clip(times - 1, 0.25, 1.0))

    def _measured(self, sampler: Sampler, look: int) -> Measured:
        replicates = sampler.regions[0]
        found = biases(
            Means.of(replicates),
            Means.known(self.mean[:, 0], self.error),
            self.denominator,
            self.of.settings.alpha_of(look),
            others=self.of.others,
            least_error=least_error(
                event_size(sampler.pixels[0], sampler.spp),
                self.mean[:, 0],
                self.of.regions.pixels() * sampler.spp * replicates.count,
            ),
        )
        return Measured.of(
            replicates,
            up_to(found, self.tail),
            self.mean[:, 0],
            self.denominator,
            bounce=self.truth.last if self.scale else 0,
            channels=channel_names(self.of.case.scene.channels, self.of.case.wavelengths),
            look=look,
            spp=sampler.spp,
            least=sampler.enough,
        )

    def _undecided(self, measured: Measured, sampler: Sampler) -> str:
        spent = "its part of the budget was used up"
        if not measured.enough:
            seconds = self.of.settings.budget * max(sampler.seconds / sampler.budget, 1.0)
            return f"total: {spent} {too_few(measured.replicates, seconds)}"
        widths = measured.biases.own.high - measured.biases.own.low
        half_known = bool((self.tail[0] > 0.5 * widths[0]).any())
        why = "the tail is not known well enough" if half_known else spent
        seen = float(measured.biases.resolution[0].max() + self.tolerance.of_image(0))
        return f"total: {why}; a bias could have been detected from {100 * seen:.2g} %"


def up_to(found: Biases, tail: Array) -> Biases:
    """Biases that hold whatever the truth is between the one that was taken and so much more, relative.

    Args:
        found: relative to the lower end, ``(regions, channels)``.
        tail: how much further the truth may lie, of the same shape.
    """

    def lower(limits: Range) -> Range:
        return Range(limits.low - tail, limits.high)

    return replace(
        found,
        bias=found.bias - tail / 2,
        own=lower(found.own),
        simultaneous=lower(found.simultaneous),
        resolution=found.resolution + tail / 2,
    )


def _named(error: RendererError) -> str:
    """Its message, which says that it is about the total."""
    message = str(error)
    return message if message.startswith("total") else f"total: {message}"


def counted(totals: Sequence[TotalResult]) -> list[Verdict]:
    """The verdicts that count for a comparison: all but ``unsupported``, which is told and nothing more."""
    return [total.verdict for total in totals if total.verdict != "unsupported"]


def said_of(totals: Sequence[TotalResult]) -> str:
    """What a reader must know of totals without a verdict, or that went wrong; empty if there is nothing."""
    said: dict[str, list[float]] = {}
    for total in totals:
        if total.message and total.verdict in ("inconclusive", "error"):
            said.setdefault(total.message, []).append(total.scale)
    everywhere = len(said) == 1 and len(totals) == len(next(iter(said.values())))
    return "; ".join(
        message
        if everywhere or scales == [1.0]
        else f"albedo × {', '.join(f'{s:g}' for s in scales)}: {message}"
        for message, scales in said.items()
    )
