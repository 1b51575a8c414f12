"""A run: every case held against every renderer, each comparison a result, whatever happens."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from comparisons import sequential
from comparisons.comparison import Comparing, failed
from comparisons.crew import Crew
from comparisons.in_process import InProcess
from comparisons.probe import Probe
from comparisons.renderers import Renderer, RendererError, canonical
from comparisons.renderers.protocol import NO_BOUNCES
from comparisons.results import Comparison
from comparisons.settings import Observer, Settings
from comparisons.shown import write_truth
from comparisons.totals_only import by_totals
from comparisons.truth import truth_of
from comparisons.whole_sum import Series
from scenes import Case, Tolerance, Truth
from scenes.formats import exr


def run(
    cases: Iterable[Case],
    renderers: Sequence[str | Renderer],
    settings: Settings,
    folder: Path | None,
    observer: Observer,
) -> Iterator[Comparison]:
    """Compare, one after the other.

    Images go to ``folder/images``, one folder per case; without a folder there are none, and no image metrics.
    Renderers are names, or objects of this process; see ``in_process``.

    Raises:
        UnknownNameError: there is no renderer of that name. Nothing has been rendered then.
        ValueError: a case has no answer for so many bounces.
    """
    for renderer in renderers:
        if isinstance(renderer, str):
            canonical(renderer)
    with Crew(settings.jobs) as crew:
        patience = settings.budget + sequential.GRACE
        probe = Probe(crew, patience)
        contenders = [_contender(renderer, probe, patience) for renderer in renderers]
        for case in cases:
            yield from _against_all(_adjusted(case, settings), contenders, settings, folder, crew, observer)


class _Contender(NamedTuple):
    """A renderer of the run, by the name that it is shown by; one of this process is a guest."""

    name: str
    probe: Probe
    guest: InProcess | None = None

    def complaint(self) -> RendererError | None:
        """What is wrong with it whatever the case; see ``Probe``."""
        if self.guest is None:
            return self.probe.complaint(canonical(self.name))
        return None if self.guest.traits.deterministic else self.probe.complaint(self.guest.name)


def _contender(renderer: str | Renderer, probe: Probe, patience: float) -> _Contender:
    if isinstance(renderer, str):
        return _Contender(renderer, probe)
    guest = InProcess(renderer)
    return _Contender(guest.short_name, Probe(guest, patience), guest)


def _adjusted(case: Case, settings: Settings) -> Case:
    """The case as the user asks for it: resolution, bounces and tolerances."""
    return replace(
        case,
        scene=case.scene.resized(*settings.size) if settings.size else case.scene,
        bounces=case.bounces if settings.bounces is None else settings.bounces,
        tolerance=Tolerance(
            image=case.tolerance.image if settings.tolerance is None else settings.tolerance,
            tile=case.tolerance.tile if settings.tile_tolerance is None else settings.tile_tolerance,
        ),
    )


def _against_all(
    case: Case,
    contenders: Sequence[_Contender],
    settings: Settings,
    folder: Path | None,
    crew: Crew,
    observer: Observer,
) -> Iterator[Comparison]:
    """The truth once, then every renderer against it."""
    observer.started(case.name, contenders[0].name)
    try:
        truth = truth_of(case, crew, lambda share: observer.progressed(share, "estimating the truth"))
        write_truth(folder, case, truth.mean, truth.stderr)
        series = Series.of(case, truth) if settings.total else None
    except (RendererError, exr.ImageError, OSError) as error:
        for contender in contenders:
            comparison = failed(case, contender.name, settings, RendererError(f"there is no truth: {error}"))
            observer.finished(comparison)
            yield comparison
        return
    for i, contender in enumerate(contenders):
        if i:
            observer.started(case.name, contender.name)
        comparison = _against(case, contender, truth, series, settings, folder, crew, observer)
        observer.finished(comparison)
        yield comparison


def _against(
    case: Case,
    contender: _Contender,
    truth: Truth,
    series: Series | None,
    settings: Settings,
    folder: Path | None,
    crew: Crew,
    observer: Observer,
) -> Comparison:
    """One renderer: bounce by bounce if it can, else by the totals that it makes."""
    start = time.monotonic()
    if complaint := contender.complaint():
        return failed(case, contender.name, settings, complaint, time.monotonic() - start)
    guest = contender.guest
    found = Comparing(case, contender.name, truth, settings, guest or crew, observer, guest, series).run(
        folder
    )
    if found.verdict != "unsupported" or not found.message.startswith(NO_BOUNCES):
        return found
    return by_totals(
        found, case, series or Series.of(case, truth), settings, guest or crew, observer, guest, folder
    )
