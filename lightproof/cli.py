"""The command line: validate, render, list, report."""

from __future__ import annotations

import json
import os
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Annotated, Any, Literal, NoReturn

import typer
from rich.table import Table

import reports
from comparisons import known as known_deviations
from comparisons.renderers import RENDERERS, SHORT_NAMES, RendererError, canonical
from comparisons.renderers.process import RendererProcess
from comparisons.results import ResultsError
from comparisons.settings import DEFAULT_ALPHA, DEFAULT_BUDGET, Settings
from lightproof import terminal
from lightproof.parameters import bounce_count, percent, size
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

DEFAULT_OUT = Path("lightproof-report")
DEFAULT_RENDERERS = ["reference", "mitsuba"]
RENDER_TIMEOUT = 24 * 3600.0
"""Seconds that a single image may take."""

_Bounces = Annotated[
    int | None, typer.Option(help="Last bounce: 0 is E, 1 direct light. Default: the case's.", min=0)
]
_Seed = Annotated[int, typer.Option(help="Different seeds give independent images.", min=0)]
_Size = Annotated[str | None, typer.Option("--size", metavar="WxH", help="Resolution. Default: the case's.")]


@app.command(
    epilog="Exit status: 0 nothing wrong, 1 fail, 2 wrong usage, 3 a renderer's error, 4 inconclusive, "
    "5 nothing could be compared."
)
def validate(
    cases: Annotated[
        list[str] | None,
        typer.Argument(metavar="[CASE]...", help="See 'lightproof list cases'. Default: all."),
    ] = None,
    renderer: Annotated[
        list[str] | None, typer.Option(help="May be given several times. Default: reference and mitsuba.")
    ] = None,
    bounces: _Bounces = None,
    tolerance: Annotated[
        str | None,
        typer.Option(
            metavar="PERCENT", help="Largest bias of the whole image, such as 0.5%. Default: the case's."
        ),
    ] = None,
    tile_tolerance: Annotated[
        str | None,
        typer.Option(metavar="PERCENT", help="The same for tiles, such as 2%. Default: the case's."),
    ] = None,
    alpha: Annotated[
        float, typer.Option(help="Probability of a wrong verdict, per comparison.", min=1e-12, max=0.5)
    ] = DEFAULT_ALPHA,
    budget: Annotated[
        float,
        typer.Option(
            metavar="SECONDS",
            help="Time per case × renderer; less where the verdict is clear sooner.",
            min=0.001,
        ),
    ] = DEFAULT_BUDGET,
    size_text: _Size = None,
    seed: _Seed = 0,
    jobs: Annotated[
        int | None,
        typer.Option(help="Processes that render at the same time. Default: one per processor.", min=1),
    ] = None,
    known: Annotated[
        str,
        typer.Option(
            metavar="FILE",
            help="Declared deviations (TOML), besides the shipped ones; 'none' for none at all.",
        ),
    ] = "",
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Folder for results.json, report.html, junit.xml and images.")
    ] = DEFAULT_OUT,
) -> None:
    """Hold renderers against cases whose every bounce is known; ends in a verdict per bounce and a report.

    Example: lightproof validate furnace-box cornell-box --renderer mitsuba --budget 60
    """
    chosen = [_case(name, bounces) for name in dict.fromkeys(cases or library.CASES)]
    renderers = [_renderer(name) for name in dict.fromkeys(renderer or DEFAULT_RENDERERS)]
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
    if out.exists() and not out.is_dir():
        raise typer.BadParameter(f"{out} is a file; expected a folder to write into", param_hint="--out")
    console = terminal.console()
    try:
        with terminal.Show(console, len(chosen) * len(renderers)) as show:
            outcome = run_validation(chosen, renderers, settings, out, show)
    except KeyboardInterrupt:
        _stop("interrupted; nothing was written to results.json", 130)
    except OSError as error:
        raise typer.BadParameter(f"{error.filename}: {error.strerror}", param_hint="--out") from None
    console.print(terminal.verdict_table(outcome))
    console.print(f"Report: {(out / reports.REPORT_FILE).resolve()}", soft_wrap=True)
    raise typer.Exit(exit_status(outcome))


@app.command()
def render(
    case: Annotated[str, typer.Argument(help="See 'lightproof list cases'.")],
    renderer: Annotated[str, typer.Option(help="See 'lightproof list renderers'.")] = "reference",
    bounces: _Bounces = None,
    spp: Annotated[int, typer.Option(help="Samples per pixel.", min=1)] = 64,
    seed: _Seed = 0,
    size_text: _Size = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE.exr", help="Default: CASE-RENDERER.exr.")] = None,
) -> None:
    """Render a case and write its bounces to an EXR file, a layer each.

    Example: lightproof render cornell-box --renderer mitsuba --spp 256 --out box.exr
    """
    chosen, name = _case(case, bounces), canonical(_renderer(renderer))
    resolution = size(size_text)
    scene = chosen.scene.resized(*resolution) if resolution else chosen.scene
    path = out or Path(f"{case}-{renderer.replace(':', '-')}.exr")
    console = terminal.console()
    last = chosen.bounces if bounces is None else bounces
    try:
        with (
            console.status(f"{case} × {renderer}: bounces 0 to {last}, {spp} spp"),
            RendererProcess(name) as process,
        ):
            image = process.render(scene, range(last + 1), spp, seed, timeout=RENDER_TIMEOUT)
        exr.write_bounces(path, image)
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
    as_json: Annotated[bool, typer.Option("--json", help="For programs.")] = False,
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
    return bounce_count(case, bounces)


def _renderer(name: str) -> str:
    try:
        canonical(name)
    except UnknownNameError as error:
        raise typer.BadParameter(str(error), param_hint="--renderer") from None
    return name


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
    """Run the command."""
    app()
