"""A run: every case held against every renderer, each comparison a result, whatever happens."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from comparisons.comparison import Comparing, failed
from comparisons.crew import Crew
from comparisons.probe import Probe
from comparisons.renderers import RendererError, canonical
from comparisons.results import Comparison
from comparisons.settings import Observer, Settings
from comparisons.truth import truth_of
from scenes import Case, Tolerance
from scenes.formats import exr


def run(
    cases: Sequence[Case], renderers: Sequence[str], settings: Settings, folder: Path, observer: Observer
) -> Iterator[Comparison]:
    """Compare, one after the other; images go to ``folder/images``, one folder per case.

    Raises:
        UnknownNameError: there is no renderer of that name. Nothing has been rendered then.
        ValueError: a case has no answer for so many bounces.
    """
    for name in renderers:
        canonical(name)
    with Crew(settings.jobs) as crew:
        probe = Probe(crew)
        for case in cases:
            yield from _against_all(
                _adjusted(case, settings), renderers, settings, folder, crew, probe, observer
            )


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
    renderers: Sequence[str],
    settings: Settings,
    folder: Path,
    crew: Crew,
    probe: Probe,
    observer: Observer,
) -> Iterator[Comparison]:
    """The truth once, then every renderer against it."""
    observer.started(case.name, renderers[0])
    images = folder / "images" / case.name
    images.mkdir(parents=True, exist_ok=True)
    try:
        truth = truth_of(case, crew, lambda share: observer.progressed(share, "estimating the truth"))
        exr.write_bounces(images / "truth.exr", truth.mean, truth.stderr, wavelengths=case.wavelengths)
    except (RendererError, exr.ImageError, OSError) as error:
        for renderer in renderers:
            comparison = failed(case, renderer, settings, RendererError(f"there is no truth: {error}"))
            observer.finished(comparison)
            yield comparison
        return
    for i, renderer in enumerate(renderers):
        if i:
            observer.started(case.name, renderer)
        complaint = probe.complaint(canonical(renderer))
        comparison = (
            failed(case, renderer, settings, complaint)
            if complaint
            else Comparing(case, renderer, truth, settings, crew, observer).run(folder)
        )
        observer.finished(comparison)
        yield comparison
