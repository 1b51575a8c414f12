"""A run: every case held against every renderer, each comparison a result, whatever happens."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from comparisons.comparison import Comparing, failed
from comparisons.crew import Crew
from comparisons.in_process import InProcess, short_name
from comparisons.renderers import Renderer, RendererError, canonical
from comparisons.results import Comparison
from comparisons.settings import Observer, Settings
from comparisons.truth import truth_of
from scenes import Case, Tolerance, Truth
from scenes.formats import exr


def run(
    cases: Sequence[Case],
    renderers: Sequence[str | Renderer],
    settings: Settings,
    folder: Path,
    observer: Observer,
) -> Iterator[Comparison]:
    """Compare, one after the other; images go to ``folder/images``, one folder per case.

    Renderers are names, or objects of this process; see ``in_process``.

    Raises:
        UnknownNameError: there is no renderer of that name. Nothing has been rendered then.
        ValueError: a case has no answer for so many bounces.
    """
    for renderer in renderers:
        if isinstance(renderer, str):
            canonical(renderer)
    with Crew(settings.jobs) as crew:
        for case in cases:
            yield from _against_all(_adjusted(case, settings), renderers, settings, folder, crew, observer)


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


def _against_all(
    case: Case,
    renderers: Sequence[str | Renderer],
    settings: Settings,
    folder: Path,
    crew: Crew,
    observer: Observer,
) -> Iterator[Comparison]:
    """The truth once, then every renderer against it."""
    names = [renderer if isinstance(renderer, str) else short_name(renderer) for renderer in renderers]
    observer.started(case.name, names[0])
    images = folder / "images" / case.name
    images.mkdir(parents=True, exist_ok=True)
    try:
        truth = truth_of(case, crew, lambda share: observer.progressed(share, "estimating the truth"))
        exr.write_bounces(images / "truth.exr", truth.mean, truth.stderr, wavelengths=case.wavelengths)
    except (RendererError, exr.ImageError, OSError) as error:
        for name in names:
            comparison = failed(case, name, settings, RendererError(f"there is no truth: {error}"))
            observer.finished(comparison)
            yield comparison
        return
    for i, renderer in enumerate(renderers):
        if i:
            observer.started(case.name, names[i])
        comparison = _comparing(case, renderer, truth, settings, crew, observer).run(folder)
        observer.finished(comparison)
        yield comparison


def _comparing(
    case: Case, renderer: str | Renderer, truth: Truth, settings: Settings, crew: Crew, observer: Observer
) -> Comparing:
    if isinstance(renderer, str):
        return Comparing(case, renderer, truth, settings, crew, observer)
    guest = InProcess(renderer)
    return Comparing(case, short_name(renderer), truth, settings, guest, observer, guest.name)
