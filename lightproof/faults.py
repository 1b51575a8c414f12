"""``lightproof faults``: what is planted, what catches it, and whether the diagnosis names it."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import msgspec
import typer
from rich import box
from rich.console import Console
from rich.progress import Progress
from rich.table import Table
from rich.text import Text

from lightproof import options, terminal
from scenes.names import look_up

if TYPE_CHECKING:
    from comparisons.faults.matrix import Row, Summary

Names = Annotated[list[str] | None, typer.Argument(metavar="[NAME]…", help="Some of them; all by default.")]
OutFolder = Annotated[
    Path | None,
    typer.Option(
        "--out",
        metavar="FOLDER",
        help="Also write there faults.json, the page faults.html, and what was seen of each in seen/.",
    ),
]
ListThem = Annotated[bool, typer.Option("--list", help="Say what there is, and run nothing.")]


def faults(
    names: Names = None,
    list_them: ListThem = False,
    as_json: options.AsJson = False,
    seed: options.Seed = 0,
    jobs: options.Jobs = None,
    out: OutFolder = None,
) -> None:
    """Plant faults in the reference tracer, and show which case catches each; sound variants, which none may fail.

    Faults live in comparisons/faults/. Each is put to the same cases in the same order, until one fails and the
    diagnosis is clear.

    Example: lightproof faults lambertian-without-pi
    """
    # here alone: no other command should wait for them
    from comparisons.faults import FAULTS, SOUND_VARIANTS
    from comparisons.faults.matrix import Matrix, Summary, rows

    catalogue = {**FAULTS, **SOUND_VARIANTS}
    for name in names or ():
        look_up("fault", name, catalogue)
    chosen = list(dict.fromkeys(names or catalogue))
    console = terminal.console()
    if list_them:
        _show_list(console, chosen, as_json)
        return
    start, date, found = time.monotonic(), datetime.now(UTC), dict[str, Row]()
    at_once = jobs or os.cpu_count() or 1
    with Progress(console=terminal.console(stderr=True), transient=True) as progress:
        bar = progress.add_task("", total=len(chosen))
        for row in rows(chosen, at_once, seed, out and out / "seen"):
            found[row.name] = row
            progress.update(bar, advance=1, description=row.name)
    ordered = [found[name] for name in chosen]
    matrix = Matrix(
        version=version("lightproof"),
        date=date.isoformat(timespec="seconds"),
        processors=os.cpu_count() or 1,
        jobs=at_once,
        seed=seed,
        rows=ordered,
        summary=Summary.of(ordered, time.monotonic() - start),
    )
    text = msgspec.json.format(msgspec.json.encode(matrix), indent=2)
    if out is not None:
        from reports.faults import write as write_page  # the plots of a report take long to import

        out.mkdir(parents=True, exist_ok=True)
        (out / "faults.json").write_bytes(text + b"\n")
        write_page(matrix, out)
    if as_json:
        typer.echo(text)
    else:
        _show(console, ordered, matrix.summary)
    raise typer.Exit(0 if matrix.summary.kept else 1)


def _show_list(out: Console, names: Sequence[str], as_json: bool) -> None:
    from comparisons.faults import FAULTS, SOUND_VARIANTS

    entries = [
        {
            "name": name,
            "title": (FAULTS.get(name) or SOUND_VARIANTS[name]).what,
            "operator": FAULTS[name].operator if name in FAULTS else "",
            "happened": ", ".join(FAULTS[name].happened) if name in FAULTS else "",
        }
        for name in names
    ]
    if as_json:
        typer.echo(msgspec.json.format(msgspec.json.encode(entries), indent=2))
    else:
        terminal.show_rows(out, entries)


def _show(out: Console, found: Sequence[Row], summary: Summary) -> None:
    table = Table(box=box.SIMPLE_HEAD)
    for heading in ("fault", "of", "caught by", "bounce", "bias", "s", "diagnosis"):
        table.add_column(heading, no_wrap=heading != "diagnosis")
    for row in found:
        table.add_row(*_cells(row))
    out.print(table)
    for line in summary.sentences():
        out.print(line, soft_wrap=True)


def _cells(row: Row) -> tuple[str | Text, ...]:
    bias = "" if row.bias is None else f"{100 * row.bias:+.2g} %"
    bounce = "" if row.bounce is None else str(row.bounce)
    seconds = f"{row.seconds:.1f}"
    if row.operator is None:
        caught = Text("fails: " + row.caught_by, "bold red") if row.caught_by else Text("passes", "green")
        return row.name, "sound", caught, bounce, bias, seconds, ""
    if not row.caught_by:
        why = row.unseen or row.nearest
        return row.name, row.operator, Text("–", "dim" if row.unseen else "bold red"), "", "", seconds, why
    suspect = (row.diagnosis and row.diagnosis.suspect) or "can't tell"
    named = Text(suspect, "green" if row.right else "yellow")
    return row.name, row.operator, row.caught_by, bounce, bias, seconds, named
