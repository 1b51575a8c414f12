"""The command line: validate, check, render, answer, export, list, report."""

from __future__ import annotations

import json
import os
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import typer
from rich.console import Console

import reports
from comparisons import known as known_deviations
from comparisons.relations import RELATIONS, Task, cheap_tasks
from comparisons.renderers import ConfigError, RendererError, canonical, resolve
from comparisons.renderers.process import RendererProcess
from comparisons.results import Results, ResultsError
from comparisons.settings import DEFAULT_ALPHA, DEFAULT_BUDGET, Settings
from lightproof import exports, images, listing, options, terminal
from lightproof.answer import answer
from lightproof.cases import CaseError, announced, from_entry_point
from lightproof.check import check
from lightproof.choice import relation_tasks, several_cases, subject
from lightproof.faults import faults
from lightproof.folder import prepare
from lightproof.parameters import percents, size
from lightproof.stop import stop
from lightproof.validate import exit_status
from lightproof.validate import validate as run_validation
from scenes import Case, UnknownNameError, library
from scenes.features import features
from scenes.formats import exr
from scenes.formats.export import UnsupportedFeatureError

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
    family: options.Families = None,
    everything: options.Everything = False,
    own: options.Owns = None,
    scene: options.SceneFile = None,
    answer: options.AnswerFile = None,
    renderer: options.Renderers = None,
    bounces: options.Bounces = None,
    tolerance: options.Tolerance = None,
    tile_tolerance: options.TileTolerance = None,
    alpha: options.Alpha = DEFAULT_ALPHA,
    budget: options.Budget = DEFAULT_BUDGET,
    early_stop: options.EarlyStop = True,
    total: options.Total = True,
    size_text: options.Size = None,
    seed: options.Seed = 0,
    jobs: options.Jobs = None,
    known: options.Known = "",
    relations: options.Relations = None,
    relation: options.RelationNames = None,
    out: options.OutFolder = DEFAULT_OUT,
) -> None:
    """Hold renderers against cases whose every bounce is known; ends in a verdict per bounce and a report.

    With --relations there need be no answer: cases lend their scenes to checks that hold for any of them.

    Example: lightproof validate furnace-box cornell-box --renderer mitsuba --budget 60
    """
    resolution = size(size_text)
    named = (cases or [], own or [], family or [], everything)
    if relations or relation:
        lending = several_cases(*named, (None, None), None, None, default=())
        chosen, tasks = [], relation_tasks(relation or [], lending, scene)
    else:
        chosen = lending = several_cases(*named, (scene, answer), bounces, resolution)
        tasks = [] if any((*named, scene, relations is not None)) else cheap_tasks()
    renderers = _distinct(renderer or DEFAULT_RENDERERS)
    settings = Settings(
        bounces=bounces,
        tolerance=percents(tolerance, "--tolerance"),
        tile_tolerance=percents(tile_tolerance, "--tile-tolerance"),
        size=resolution,
        alpha=alpha,
        budget=budget,
        seed=seed,
        jobs=jobs or os.cpu_count() or 1,
        known=tuple(_known(known, lending, tasks)),
        early_stop=early_stop,
        total=total,
    )
    prepare(out)
    console = terminal.console()
    outcome = _run_and_show(console, chosen, renderers, settings, out, tasks)
    terminal.show_verdicts(console, outcome)
    console.print(f"Report: {(out / reports.REPORT_FILE).resolve()}", soft_wrap=True)
    raise typer.Exit(exit_status(outcome))


def _run_and_show(
    console: Console,
    cases: Sequence[Case],
    renderers: Sequence[str],
    settings: Settings,
    out: Path,
    tasks: Sequence[Task],
) -> Results:
    """What the run finds; how far it is shows meanwhile. Interrupted, it keeps in the folder what it has."""
    with terminal.Show(console, (len(cases) + len(tasks)) * len(renderers)) as show:
        try:
            return run_validation(cases, renderers, settings, out, show, tasks)
        except KeyboardInterrupt:
            what = "checks" if tasks else "comparisons"
            stop(f"interrupted; {show.done} of {show.total} {what} are in {out}/results.json", 130)
        except CaseError as error:  # an answer is asked for only when its turn comes
            stop(str(error), 2)


def _distinct(names: Sequence[str]) -> list[str]:
    """Each renderer once, by the first name that it was given: the same one by two names is one."""
    return list({_renderer(name): name for name in reversed(names)}.values())[::-1]


app.command(epilog="Exit status as of 'lightproof validate'.")(check)
app.command(epilog="Exit status: 0 all that can be seen was caught and nothing sound failed, 1 not so.")(
    faults
)


@app.command()
def render(
    case: options.Subject = None,
    own: options.Own = None,
    renderer: Annotated[str, typer.Option(help="See 'lightproof list renderers'.")] = "reference",
    bounces: options.Bounces = None,
    spp: options.Spp = 64,
    seed: options.Seed = 0,
    size_text: options.Size = None,
    out: options.OutFile = None,
) -> None:
    """Render a case, or a scene of your own, and write its bounces to an EXR file, a layer each.

    Example: lightproof render cornell-box --renderer mitsuba --spp 256 --out box.exr
    """
    chosen, name = subject(case, own, bounces), _renderer(renderer)
    scene = images.resized(chosen.scene, size_text)
    path = images.exr_file(out or Path(f"{chosen.name}-{renderer.replace(':', '-')}.exr"))
    console = terminal.console()
    last = chosen.bounces if bounces is None else bounces
    status = console.status(f"{chosen.name} × {renderer}: bounces 0 to {last}, {spp} spp")
    try:
        with status, RendererProcess(name) as process:
            image = process.render(scene, range(last + 1), spp, seed, timeout=RENDER_TIMEOUT)
            made = f"{chosen.name}, {name} {process.version}, {spp} spp, seed {seed}"
        header, replaced = images.header(made, chosen.name, scene), path.exists()
        exr.write_bounces(path, image, attributes=header, wavelengths=chosen.wavelengths)
    except KeyboardInterrupt:
        stop("interrupted; nothing was written", 130)
    except RendererError as error:
        stop(str(error), 3, error.log)
    except exr.ImageError as error:
        raise typer.BadParameter(str(error), param_hint="--out") from None
    console.print(images.written(path, last, chosen.wavelengths, replaced), soft_wrap=True)


app.command()(answer)


@app.command()
def export(
    case: options.Subject = None,
    own: options.Own = None,
    format: options.Format = None,
    size_text: options.Size = None,
    channel: options.Channel = None,
    out: options.ExportFile = None,
) -> None:
    """Write a case's scene for another renderer; what its format lacks, or means differently, is an error.

    Example: lightproof export cornell-box --format mitsuba-xml --out box.xml
    """
    chosen = subject(case, own)
    scene = exports.one_channel(images.resized(chosen.scene, size_text), channel)
    format_name, path = exports.format_and_file(chosen.name, format, out)
    try:
        made = exports.made(chosen, scene, channel, format_name, images.in_a_folder(path))
        exports.refuse_to_overwrite(made, path)
        written = made.write(path)
    except UnsupportedFeatureError as error:
        stop(str(error), 5)
    except OSError as error:
        raise typer.BadParameter(f"{error.filename}: {error.strerror}", param_hint="--out") from None
    for file in written:
        typer.echo(file)


@app.command("list")
def list_(
    what: Annotated[Literal["cases", "renderers", "relations"], typer.Argument(help="What to list.")],
    as_json: options.AsJson = False,
) -> None:
    """List the cases, the renderers or the relations there are."""
    rows = {"cases": _cases, "renderers": _renderers, "relations": _relations}[what]()
    if as_json:
        typer.echo(json.dumps(rows, indent=2, ensure_ascii=False))
        return
    if what == "renderers":
        listing.show_renderers(terminal.console(), rows)
    else:
        terminal.show_rows(terminal.console(), listing.table(rows))


@app.command()
def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder that 'lightproof validate' wrote.")],
) -> None:
    """Render the report again from results.json and the images."""
    try:
        written = reports.render(folder)
    except ResultsError as error:
        stop(str(error), 2)
    for path in written:
        typer.echo(path)


def _cases() -> list[dict[str, Any]]:
    rows = [_row(library.case(name)) for name in library.CASES]
    for name, point in announced().items():
        try:
            rows.append(_row(from_entry_point(point)))
        except CaseError as error:  # someone else's mistake hides no other case
            rows.append({**dict.fromkeys(rows[0]), "name": name, "title": str(error)})
    return rows


def _row(case: Case) -> dict[str, Any]:
    return {
        "name": case.name,
        "family": case.family,
        "title": case.title,
        "features": list(features(case.scene)),
        "truth": case.answer.kind,
        "bounces": case.bounces,
        "max_bounces": case.max_bounces,
    }


def _relations() -> list[dict[str, Any]]:
    return [
        {
            "name": relation.name,
            "tests": relation.operator,
            "title": relation.statement,
            "blind_to": relation.blind_to,
            "scenes": list(relation.scenes),
            "default_run": "yes" if relation.cheap else None,
        }
        for relation in RELATIONS.values()
    ]


def _renderers() -> list[dict[str, Any]]:
    try:
        return listing.renderers()
    except ConfigError as error:
        stop(str(error), 2)


def _renderer(name: str) -> str:
    """The full name."""
    try:
        resolve(name)
        return canonical(name)
    except (UnknownNameError, ConfigError) as error:
        raise typer.BadParameter(str(error), param_hint="--renderer") from None


def _known(file: str, cases: Sequence[Case], tasks: Sequence[Task]) -> list[known_deviations.Deviation]:
    """What is declared: by this project, and by the user's file, which may speak of any case or scene of the run."""
    if file == "none":
        return []
    cases_of_run = [*announced(), *(case.name for case in cases)]
    scenes = [task.subject.name for task in tasks]
    try:
        own = known_deviations.load(Path(file), cases_of_run, scenes) if file else []
        return known_deviations.load(known_deviations.SHIPPED) + own
    except known_deviations.KnownError as error:
        raise typer.BadParameter(str(error), param_hint="--known") from None


def main() -> None:
    """Run the command. An error of its own ends it with 70, which no verdict does."""
    try:
        app()
    except MemoryError as error:
        typer.echo(f"Error: out of memory: {error}; a smaller --size or fewer --bounces need less", err=True)
        sys.exit(2)
    except Exception:
        traceback.print_exc()
        typer.echo("This is a bug in lightproof, not a verdict.", err=True)
        sys.exit(INTERNAL_ERROR)
