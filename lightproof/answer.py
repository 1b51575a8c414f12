"""``lightproof answer``: the truth of a case, or an estimate of it for a scene of one's own, as an image."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import typer

from comparisons.crew import Crew
from comparisons.renderers import RendererError
from comparisons.truth import Progress, default_spp, estimated, truth_of
from lightproof import images, options, terminal
from lightproof.cases import CaseError
from lightproof.choice import check_size, one_case, subject
from lightproof.parameters import size
from lightproof.stop import stop
from scenes import Scene, Truth
from scenes.formats import exr


@dataclass(frozen=True)
class _Asked:
    """What is asked for, and who answers."""

    name: str
    scene: Scene
    last: int
    kind: str
    wavelengths: tuple[float, ...] | None
    find: Callable[[Crew, Progress], Truth]


def answer(
    case: options.Answered = None,
    own: options.Own = None,
    bounces: options.Bounces = None,
    spp: options.EstimateSpp = None,
    size_text: options.Size = None,
    jobs: options.Jobs = None,
    out: options.TruthFile = None,
) -> None:
    """Write the answer of a case to an EXR file: the truth, a layer per bounce, and its standard error if it has one.

    Of a scene, my-scene.json, the reference tracer estimates it; 'lightproof validate' takes both, as --scene and
    --answer.

    Example: lightproof answer furnace-box --bounces 3 --out truth.exr
    """
    if case and case.endswith(".json") and own is None:
        asked = _of_a_scene(case, bounces, spp, size_text)
    else:
        asked = _of_a_case(case, own, bounces, spp, size_text)
    path, console = images.exr_file(out or Path(f"{asked.name}-answer.exr")), terminal.console()
    label = f"{asked.name}: bounces 0 to {asked.last}"
    try:
        with console.status(label) as status, Crew(jobs or os.cpu_count() or 1) as crew:
            truth = asked.find(crew, lambda done: status.update(f"{label}, {done:.0%}"))
        stderr, replaced = (truth.stderr if truth.stderr.any() else None), path.exists()
        header = images.header(truth.source, asked.name, asked.scene)
        exr.write_bounces(path, truth.mean, stderr, header, asked.wavelengths)
    except KeyboardInterrupt:
        stop("interrupted; nothing was written", 130)
    except RendererError as error:
        stop(f"there is no truth: {error}", 3, error.log)
    except CaseError as error:
        stop(str(error), 2)
    except exr.ImageError as error:
        raise typer.BadParameter(str(error), param_hint="--out") from None
    line = images.written(path, asked.last, asked.wavelengths, replaced)
    console.print(f"{line}, {asked.kind}", soft_wrap=True)


def _of_a_case(
    named: str | None, own: str | None, bounces: int | None, spp: int | None, size_text: str | None
) -> _Asked:
    chosen = one_case(named, own, bounces, or_else=" or a scene, my-scene.json,")
    if spp is not None:
        message = f"{chosen.name} is a case, which has its answer; it is for a scene, my-scene.json"
        raise typer.BadParameter(message, param_hint="--spp")
    last = chosen.bounces if bounces is None else bounces
    check_size(chosen, last, size(size_text))
    case = replace(chosen, scene=images.resized(chosen.scene, size_text), bounces=last)
    return _Asked(
        name=case.name,
        scene=case.scene,
        last=last,
        kind=case.answer.kind,
        wavelengths=case.wavelengths,
        find=lambda crew, progress: truth_of(case, crew, progress),
    )


def _of_a_scene(file: str, bounces: int | None, spp: int | None, size_text: str | None) -> _Asked:
    chosen = subject(file, None)
    scene, last = images.resized(chosen.scene, size_text), chosen.bounces if bounces is None else bounces
    samples = default_spp(scene) if spp is None else spp
    return _Asked(
        name=chosen.name,
        scene=scene,
        last=last,
        kind="estimated, with its standard error",
        wavelengths=None,
        find=lambda crew, progress: estimated(scene, last, samples, crew, progress),
    )
