"""The command line: validate, render, list, report."""

from __future__ import annotations

import json
import os
import shutil
import sys
import traceback
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Annotated, Any, Literal, NoReturn

import typer
from rich.table import Table

import reports
from comparisons import known as known_deviations
from comparisons.renderers import RENDERERS, SHORT_NAMES, RendererError, canonical
from comparisons.renderers.process import RendererProcess
from comparisons.results import RESULTS_FILE, ResultsError
from comparisons.settings import DEFAULT_ALPHA, DEFAULT_BUDGET, Settings
from lightproof import options, terminal
from lightproof.parameters import check_bounces, percent, size
from lightproof.validate import exit_status
from lightproof.validate import validate as run_validation
from scenes import Case, UnknownNameError, library
from scenes.formats import exr

app = typer.Typer(
    name="lightproof",
    help="Proves a renderer's light transport right, bounce by bounce: E, TE, T²E, … each against a known answer.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback()
def _global(version: options.Version = False) -> None:
    pass


DEFAULT_OUT = Path("lightproof-report")
DEFAULT_RENDERERS = ["reference", "mitsuba"]
INTERNAL_ERROR = 70
RENDER_TIMEOUT = 24 * 3600.0
"""Seconds that a single image may take."""


@app.command(
    epilog="Exit status: 0 nothing wrong, 1 fail, 2 wrong usage, 3 a renderer's error, 4 inconclusive, "
    "5 nothing could be compared, 70 a bug in lightproof, 130 interrupted."
)
def validate(
    cases: options.Cases = None,
    renderer: options.Renderers = None,
    bounces: options.Bounces = None,
    tolerance: options.Tolerance = None,
    tile_tolerance: options.TileTolerance = None,
    alpha: options.Alpha = DEFAULT_ALPHA,
    budget: options.Budget = DEFAULT_BUDGET,
    size_text: options.Size = None,
    seed: options.Seed = 0,
    jobs: options.Jobs = None,
    known: options.Known = "",
    out: options.OutFolder = DEFAULT_OUT,
) -> None:
    """Hold renderers against cases whose every bounce is known; ends in a verdict per bounce and a report.

    Example: lightproof validate furnace-box cornell-box --renderer mitsuba --budget 60
    """
    chosen = [_case(name, bounces) for name in dict.fromkeys(cases or library.DEFAULT)]
    # the same renderer by two names is one
    renderers = list({_renderer(name): name for name in reversed(renderer or DEFAULT_RENDERERS)}.values())[
        ::-1
    ]
    settings = Settings(
        bounces=bounces,
        tolerance=percent(tolerance, "--tolerance"),
        tile_tolerance=percent(tile_tolerance, "--tile-tolerance"),
        size=size(size_text),
        alpha=alpha,
        budget=budget,
        seed=seed,
        jobs=jobs or os.cpu_count() or 1,
        known=tuple(_known(known)),
    )
    _prepare(out)
    console = terminal.console()
    with terminal.Show(console, len(chosen) * len(renderers)) as show:
        try:
            outcome = run_validation(chosen, renderers, settings, out, show)
        except KeyboardInterrupt:
            _stop(f"interrupted; {show.done} of {show.total} comparisons are in {out}/results.json", 130)
    terminal.show_verdicts(console, outcome)
    console.print(f"Report: {(out / reports.REPORT_FILE).resolve()}", soft_wrap=True)
    raise typer.Exit(exit_status(outcome))


@app.command()
def render(
    case: Annotated[str, typer.Argument(help="See 'lightproof list cases'.")],
    renderer: Annotated[str, typer.Option(help="See 'lightproof list renderers'.")] = "reference",
    bounces: options.Bounces = None,
    spp: options.Spp = 64,
    seed: options.Seed = 0,
    size_text: options.Size = None,
    out: options.OutFile = None,
) -> None:
    """Render a case and write its bounces to an EXR file, a layer each.

    Example: lightproof render cornell-box --renderer mitsuba --spp 256 --out box.exr
    """
    chosen, name, resolution = _case(case, bounces), _renderer(renderer), size(size_text)
    scene = chosen.scene.resized(*resolution) if resolution else chosen.scene
    path = out or Path(f"{case}-{renderer.replace(':', '-')}.exr")
    if path.suffix != ".exr":
        raise typer.BadParameter(f"{path}: expected a name that ends in .exr", param_hint="--out")
    if not path.resolve().parent.is_dir():
        raise typer.BadParameter(f"{path}: there is no folder {path.parent}", param_hint="--out")
    console = terminal.console()
    last = chosen.bounces if bounces is None else bounces
    status = console.status(f"{case} × {renderer}: bounces 0 to {last}, {spp} spp")
    try:
        with status, RendererProcess(name) as process:
            image = process.render(scene, range(last + 1), spp, seed, timeout=RENDER_TIMEOUT)
            made = f"{case}, {name} {process.version}, {spp} spp, seed {seed}"
        exr.write_bounces(path, image, attributes={"lightproof:source": made})
    except KeyboardInterrupt:
        _stop("interrupted; nothing was written", 130)
    except RendererError as error:
        _stop(str(error), 3, error.log)
    except exr.ImageError as error:
        raise typer.BadParameter(str(error), param_hint="--out") from None
    console.print(f"{path}: layers bounce0 to bounce{last}", soft_wrap=True)


@app.command("list")
def list_(
    what: Annotated[Literal["cases", "renderers"], typer.Argument(help="What to list.")],
    as_json: options.AsJson = False,
) -> None:
    """List the cases or the renderers there are."""
    rows = _cases() if what == "cases" else _renderers()
    if as_json:
        typer.echo(json.dumps(rows, indent=2, ensure_ascii=False))
        return
    table = Table(box=None, pad_edge=False)
    for heading in rows[0]:
        table.add_column(heading, no_wrap=heading == "name")
    for row in rows:
        table.add_row(*(_text(value) for value in row.values()))
    terminal.console().print(table)


@app.command()
def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder that 'lightproof validate' wrote.")],
) -> None:
    """Render the report again from results.json and the images."""
    try:
        written = reports.render(folder)
    except ResultsError as error:
        _stop(str(error), 2)
    for path in written:
        typer.echo(path)


def _prepare(out: Path) -> None:
    """Make the folder; what an earlier run left goes, so that the folder holds one run."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        if (out / RESULTS_FILE).exists():
            shutil.rmtree(out / "images", ignore_errors=True)
            for name in (RESULTS_FILE, reports.REPORT_FILE, reports.JUNIT_FILE):
                (out / name).unlink(missing_ok=True)
    except OSError as error:
        message = f"{error.filename}: {error.strerror}; expected a folder that can be written"
        raise typer.BadParameter(message, param_hint="--out") from None


def _cases() -> list[dict[str, Any]]:
    return [
        {
            "name": case.name,
            "family": case.family,
            "title": case.title,
            "truth": case.answer.kind,
            "bounces": case.bounces,
        }
        for case in (library.case(name) for name in library.CASES)
    ]


def _renderers() -> list[dict[str, Any]]:
    short = {full: name for name, full in SHORT_NAMES.items()}
    rows = []
    for name, entry in RENDERERS.items():
        try:
            installed = version(entry.package)
        except PackageNotFoundError:
            installed = None
        row = {"name": name, "short": short.get(name), "title": entry.title, "version": installed}
        rows.append({**row, "install": f"pip install {entry.package}"})
    return rows


def _text(value: object) -> str:
    return "–" if value is None else str(value)


def _case(name: str, bounces: int | None) -> Case:
    try:
        case = library.case(name)
    except UnknownNameError as error:
        raise typer.BadParameter(str(error), param_hint="CASE") from None
    check_bounces(case, bounces)
    return case


def _renderer(name: str) -> str:
    """The full name."""
    try:
        return canonical(name)
    except UnknownNameError as error:
        raise typer.BadParameter(str(error), param_hint="--renderer") from None


def _known(file: str) -> list[known_deviations.Deviation]:
    if file == "none":
        return []
    try:
        own = known_deviations.load(Path(file)) if file else []
        return known_deviations.load(known_deviations.SHIPPED) + own
    except known_deviations.KnownError as error:
        raise typer.BadParameter(str(error), param_hint="--known") from None


def _stop(message: str, status: int, log: list[str] | None = None) -> NoReturn:
    for line in [*(log or []), f"Error: {message}"]:
        typer.echo(line, err=True)
    raise typer.Exit(status)


def main() -> None:
    """Run the command. An error of its own ends it with 70, which no verdict does."""
    try:
        app()
    except Exception:
        traceback.print_exc()
        typer.echo("This is a bug in lightproof, not a verdict.", err=True)
        sys.exit(INTERNAL_ERROR)
