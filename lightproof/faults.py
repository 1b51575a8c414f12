"""``lightproof faults``: what is planted, what catches it, and whether the diagnosis names it."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from typing import Annotated

import msgspec
import typer
from rich import box
from rich.console import Console
from rich.progress import Progress
from rich.table import Table
from rich.text import Text

from comparisons.faults import FAULTS, SOUND_VARIANTS
from comparisons.faults.matrix import Row, Summary, rows
from lightproof import options, terminal
from scenes.names import look_up

Names = Annotated[list[str] | None, typer.Argument(metavar="[NAME]…", help="Some of them; all by default.")]
ListThem = Annotated[bool, typer.Option("--list", help="Say what there is, and run nothing.")]


def faults(
    names: Names = None,
    list_them: ListThem = False,
    as_json: options.AsJson = False,
    seed: options.Seed = 0,
    jobs: options.Jobs = None,
) -> None:
    """Plant faults in the reference tracer, and show which case catches each; sound variants, which none may fail.

    Faults live in comparisons/faults/. Each is put to the same cases in the same order, until one fails and the
    diagnosis is clear.

    Example: lightproof faults lambertian-without-pi
    """
    catalogue = {**FAULTS, **SOUND_VARIANTS}
    for name in names or ():
        look_up("fault", name, catalogue)
    chosen = list(dict.fromkeys(names or catalogue))
    console = terminal.console()
    if list_them:
        _show_list(console, chosen, as_json)
        return
    start, found = time.monotonic(), dict[str, Row]()
    with Progress(console=terminal.console(stderr=True), transient=True) as progress:
        bar = progress.add_task("", total=len(chosen))
        for row in rows(chosen, jobs or os.cpu_count() or 1, seed):
            found[row.name] = row
            progress.update(bar, advance=1, description=row.name)
    ordered = [found[name] for name in chosen]
    summary = Summary.of(ordered, time.monotonic() - start)
    if as_json:
        text = msgspec.json.encode({"rows": ordered, "summary": summary})
        typer.echo(msgspec.json.format(text, indent=2))
    else:
        _show(console, ordered, summary)
    raise typer.Exit(0 if summary.kept else 1)


def _show_list(out: Console, names: Sequence[str], as_json: bool) -> None:
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
