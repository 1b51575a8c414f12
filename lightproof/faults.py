"""``lightproof faults``: what is planted, what catches it, and whether the diagnosis names it.

Who names some of them reads the diagnosis with its evidence below the table; of all there are too many for that.
"""

from __future__ import annotations

import errno
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
from rich.padding import Padding
from rich.progress import Progress
from rich.table import Table
from rich.text import Text

from lightproof import options, terminal
from lightproof.stop import stop
from reports import wording
from scenes.names import UnknownNameError, look_up

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
    # here alone, and below: no other command should wait for them
    from comparisons.faults.matrix import Matrix, Summary, rows

    chosen = _chosen(names)
    console = terminal.console()
    if list_them:
        _show_list(console, chosen, as_json)
        return
    seen = _prepared(out)
    start, date = time.monotonic(), datetime.now(UTC)
    found: dict[str, Row] = {}
    at_once = jobs or os.cpu_count() or 1
    with Progress(console=terminal.console(stderr=True), transient=True) as progress:
        bar = progress.add_task("", total=len(chosen))
        try:
            for row in rows(chosen, at_once, seed, seen):
                found[row.name] = row
                progress.update(bar, advance=1, description=row.name)
        except KeyboardInterrupt:
            kept = f"; what was seen of them is in {seen}" if seen and found else ""
            stop(f"interrupted; {len(found)} of {len(chosen)} were done{kept}", 130)
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

        (out / "faults.json").write_bytes(text + b"\n")
        write_page(matrix, out)
    if as_json:
        typer.echo(text)
    else:
        show(console, ordered, matrix.summary, in_detail=bool(names))
    raise typer.Exit(0 if matrix.summary.kept else 1)


def _chosen(names: Sequence[str] | None) -> list[str]:
    """Each once; all of them where none is named.

    Raises:
        typer.BadParameter: there is none of that name.
    """
    from comparisons.faults import FAULTS, SOUND_VARIANTS

    catalogue = {**FAULTS, **SOUND_VARIANTS}
    try:
        for name in names or ():
            look_up("fault", name, catalogue)
    except UnknownNameError as error:
        raise typer.BadParameter(f"{error} See lightproof faults --list.", param_hint="NAME") from None
    return list(dict.fromkeys(names or catalogue))


def _prepared(out: Path | None) -> Path | None:
    """The folder for what is seen, which is made before anything is run.

    Raises:
        typer.BadParameter: it can't be.
    """
    if out is None:
        return None
    try:
        (out / "seen").mkdir(parents=True, exist_ok=True)
        if not os.access(out, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(out))
    except OSError as error:
        message = f"{error.filename}: {error.strerror}; expected a folder that can be written"
        raise typer.BadParameter(message, param_hint="--out") from None
    return out / "seen"


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


def show(out: Console, found: Sequence[Row], summary: Summary, in_detail: bool) -> None:
    """A table, or where the terminal is too narrow for it, a paragraph for each; then what is said of some.

    Args:
        out: where to.
        found, summary: what.
        in_detail: whether to tell the diagnosis of each; else only why faults were not caught.
    """
    table = Table(box=box.SIMPLE_HEAD)
    for heading in ("fault", "of", "caught by", "bounce", "bias", "s", "diagnosis"):
        table.add_column(heading, no_wrap=True)
    for row in found:
        table.add_row(*_cells(row))
    if terminal.fits(out, table):
        out.print(table)
    else:
        for row in found:
            out.print(Text.assemble((row.name, "bold"), f"  {row.what}"))
            out.print(Padding(_in_a_line(row), (0, 0, 0, 4), expand=False))
        out.print()
    for row in found:
        if row.operator and (in_detail or not row.caught_by):
            out.print(Text.assemble((f"{row.name}: ", "bold"), _explained(row)), soft_wrap=True)
    for line in summary.sentences():
        out.print(line, soft_wrap=True)


def _cells(row: Row) -> tuple[str | Text, ...]:
    bounce = "" if row.bounce is None else str(row.bounce)
    return (
        *(row.name, row.operator or "sound", _caught(row), bounce, row.size, f"{row.seconds:.1f}"),
        _named(row),
    )


def _in_a_line(row: Row) -> Text:
    parts = [
        Text(row.operator or "sound"),
        Text("caught by " if row.caught_by and row.operator else "") + _caught(row),
    ]
    parts += [Text(f"bounce {row.bounce}, {row.size}")] if row.size else []
    parts += [Text(f"{row.seconds:.1f} s")]
    parts += [Text("diagnosis ") + _named(row)] if _named(row) else []
    return Text(" · ").join(parts)


def _caught(row: Row) -> Text:
    if row.operator is None:
        return Text("fails: " + row.caught_by, "bold red") if row.caught_by else Text("passes", "green")
    return Text(row.caught_by) if row.caught_by else Text("not caught", "dim" if row.unseen else "bold red")


def _named(row: Row) -> Text:
    """What the diagnosis names; nothing where there was none to be made."""
    if row.operator is None or not row.caught_by:
        return Text()
    return Text((row.diagnosis and row.diagnosis.suspect) or "can't tell", "green" if row.right else "yellow")


def _explained(row: Row) -> str:
    """What it is, and the diagnosis of it, or why it was not caught."""
    if row.diagnosis and row.caught_by:
        return f"{row.what}. Diagnosis: {wording.diagnosis(row.diagnosis)}"
    why = row.unseen or f"the nearest was {row.nearest}"
    return f"{row.what}. Not caught: {why}"
