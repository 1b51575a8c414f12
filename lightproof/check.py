"""``lightproof check``: one finished image from anywhere, held against a case."""

from __future__ import annotations

import os
import time
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import msgspec
import typer

import reports
from comparisons import results
from comparisons.crew import Crew
from comparisons.renderers import RendererError
from comparisons.results import Comparison, Images, Results
from comparisons.settings import DEFAULT_ALPHA, Settings
from comparisons.single_image import TooSmallError, expectation
from comparisons.single_image import check as check_image
from comparisons.truth import truth_of
from lightproof import options, terminal
from lightproof.cases import CaseError
from lightproof.choice import check_size, one_case
from lightproof.folder import prepare
from lightproof.parameters import check_bounces, percents
from lightproof.validate import EXIT_STATUS, provenance
from scenes import Case, SceneError, Tolerance, Truth
from scenes.formats import exr, finished
from scenes.formats.finished import Finished


def check(
    image: options.FinishedImage,
    case: options.OfCase,
    bounces: options.Bounces = None,
    layers: options.Layers = False,
    independent: options.Independent = False,
    tolerance: options.Tolerance = None,
    tile_tolerance: options.TileTolerance = None,
    alpha: options.Alpha = DEFAULT_ALPHA,
    jobs: options.Jobs = None,
    out: options.ReportFolder = None,
    as_json: options.AsJson = False,
) -> None:
    """Hold one finished image from anywhere against a case; its noise is estimated from its residuals.

    It is the sum E + TE + … of all bounces up to --bounces, or has a layer for each.
    Each pixel is the average of radiance over its square (a box filter), neither clamped nor denoised.
    One image tells less than 'lightproof validate' does; what it can't tell is said.

    Example: lightproof check box.exr --case cornell-box --bounces 5
    """
    if layers and bounces is not None:
        raise typer.BadParameter(
            "a file with --layers says itself how many bounces it has", param_hint="--bounces"
        )
    start, date = time.monotonic(), datetime.now(UTC)
    chosen = one_case(case, None, bounces, hint="--case")
    picture = _read(image, layers, chosen)
    settings = Settings(
        tolerance=percents(tolerance, "--tolerance"),
        tile_tolerance=percents(tile_tolerance, "--tile-tolerance"),
        alpha=alpha,
        budget=0.0,
        jobs=jobs or os.cpu_count() or 1,
    )
    asked = _asked(chosen, picture, bounces, settings, image)
    if out is not None:
        prepare(out)
    truth = _truth(asked, settings.jobs)
    try:
        comparison = check_image(asked, truth, image.name, picture, alpha, independent)
    except TooSmallError as error:
        raise typer.BadParameter(str(error), param_hint="IMAGE") from None
    if out is not None:
        made = provenance(settings, date, time.monotonic() - start)
        made = msgspec.structs.replace(made, seeds="none: one finished image")
        comparison = _write(out, comparison, picture, truth, made)
    if as_json:
        typer.echo(msgspec.json.format(msgspec.json.encode(comparison), indent=2))
    else:
        console = terminal.console()
        terminal.show_single_image(console, comparison)
        if out is not None:
            console.print(f"Report: {(out / reports.REPORT_FILE).resolve()}", soft_wrap=True)
    raise typer.Exit(EXIT_STATUS[comparison.verdict])


def _read(path: Path, layers: bool, case: Case) -> Finished:
    try:
        picture = finished.read(path, layers, case.scene.channels)
    except exr.ImageError as error:
        raise typer.BadParameter(str(error), param_hint="IMAGE") from None
    found = picture.images.shape[-1]
    if found not in (case.scene.channels, 1):
        message = f"{path} has {found} channels, {case.name} has {case.scene.channels}"
        raise typer.BadParameter(message, param_hint="IMAGE")
    return picture


def _asked(case: Case, picture: Finished, bounces: int | None, settings: Settings, path: Path) -> Case:
    """The case at the picture's size, with its bounces and the tolerances that are asked for.

    Raises:
        typer.BadParameter: the case has no answer for these.
    """
    layers, height, width, _ = picture.images.shape
    last = (case.bounces if bounces is None else bounces) if picture.summed else layers - 1
    check_bounces(case, last)
    check_size(case, last, (width, height))
    try:
        scene = case.scene.resized(width, height)
    except SceneError as error:
        message = f"{path} has {width}x{height} pixels, which {case.name} can't have: {error}"
        raise typer.BadParameter(message, param_hint="IMAGE") from None
    own = case.tolerance
    image = own.image if settings.tolerance is None else settings.tolerance
    tile = own.tile if settings.tile_tolerance is None else settings.tile_tolerance
    return replace(case, scene=scene, bounces=last, tolerance=Tolerance(image=image, tile=tile))


def _truth(case: Case, jobs: int) -> Truth:
    height, width, _ = case.scene.shape
    # not on the standard output, which --json has for itself
    status = terminal.console(stderr=True).status(f"{case.name}: the truth at {width}x{height}")
    try:
        with status, Crew(jobs) as crew:
            return truth_of(case, crew)
    except KeyboardInterrupt:
        typer.echo("Error: interrupted; there is no verdict", err=True)
        raise typer.Exit(130) from None
    except CaseError as error:
        typer.echo(f"Error: {error}", err=True)
        raise typer.Exit(2) from None
    except (RendererError, exr.ImageError, OSError) as error:
        typer.echo(f"Error: there is no truth: {error}", err=True)
        raise typer.Exit(3) from None


def _write(
    out: Path, comparison: Comparison, picture: Finished, truth: Truth, made: results.Provenance
) -> Comparison:
    """The folder, as ``lightproof validate`` writes it."""
    if comparison.bounces:
        names = Images(truth="images/truth.exr", renderer="images/image.exr")
        (out / "images").mkdir(exist_ok=True)
        _, expected = expectation(truth, picture)
        exr.write_bounces(out / names.truth, expected)
        exr.write_bounces(out / names.renderer, picture.images)
        comparison = msgspec.structs.replace(comparison, images=names)
    results.write(Results(provenance=made, comparisons=[comparison]), out)
    reports.render(out)
    return comparison
