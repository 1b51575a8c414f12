"""What the command takes, shows and returns."""

from __future__ import annotations

import argparse
import os
import sys
from importlib.metadata import version

from rich.console import Console
from rich.table import Table

from benchmarks import scaling
from benchmarks.row import Row, as_json
from benchmarks.rows import FULL, QUICK, ROWS
from benchmarks.timing import Progress

_STYLE = {"below must": "bold red", "must": "yellow", "aim": "green"}
_PLAIN_WIDTH = 200  # of a table that goes to a file or a pipe


def main(arguments: list[str] | None = None) -> int:
    """Measure, show, and say by the exit code whether all rows are what they must be: 0 or 1."""
    options = _parser().parse_args(arguments)
    effort = QUICK if options.quick else FULL
    if options.scaling:
        measured = scaling.measure(options.quick, _progress("scaling"))
        if options.json:
            print(scaling.as_json(measured).decode())
        else:
            _console().print(scaling.table(measured))
        return 0
    chosen, load = options.row or list(ROWS), os.getloadavg()[0]
    rows = [row for name in ROWS if name in chosen for row in ROWS[name](effort, _progress(name))]
    if options.json:
        print(as_json(rows).decode())
    else:
        _console().print(_table(rows, load))
    return int(any(row.decides and row.verdict == "below must" for row in rows))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=main.__doc__)
    parser.add_argument("--json", action="store_true", help="a list of objects, for programs")
    parser.add_argument("--row", action="append", choices=list(ROWS), help="only this one; may be repeated")
    parser.add_argument(
        "--quick",
        action="store_true",
        help="tiny renders, to try the command: figures and exit code mean nothing",
    )
    parser.add_argument(
        "--scaling", action="store_true", help="nanoseconds per path over shapes, spp, bounces, channels"
    )
    return parser


def _progress(name: str) -> Progress:
    """Lines on the standard error, so that the standard output holds the result alone."""
    return lambda message: print(f"{name}: {message}", file=sys.stderr, flush=True)


def _console() -> Console:
    console = Console(highlight=False)
    return console if console.is_terminal else Console(highlight=False, width=_PLAIN_WIDTH, no_color=True)


def _table(rows: list[Row], load: float) -> Table:
    """To read; with the load of the machine before, since on a busy one two processes can't be twice one."""
    versions = f"Mitsuba {version('mitsuba')} scalar_rgb, NumPy {version('numpy')}"
    caption = (
        f"one core per side; low–high: 95 %; {versions}; load before: {load:.1f} of {os.cpu_count()} cores"
    )
    table = Table(caption=caption, caption_justify="left")
    table.add_column("what")
    for column in ("ratio", "low–high", "must", "aim"):
        table.add_column(column, justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    table.add_column("how")
    for row in rows:
        table.add_row(
            row.title,
            f"{row.ratio:.2f}",
            f"{row.low:.2f}–{row.high:.2f}",
            f"{row.must:g}",
            f"{row.aim:g}",
            f"[{_STYLE[row.verdict]}]{row.verdict}[/]",
            row.note,
        )
    return table
