"""The command; see the package."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterable, Mapping
from functools import partial

from rich.console import Console
from rich.table import Table

from benchmarks.calibration import mitsuba, real, simulated
from benchmarks.calibration.limits import Limit
from benchmarks.calibration.rates import Rate

PARTS: Mapping[str, Callable[[int], Iterable[Rate | Limit]]] = {
    "simulated": simulated.rates,
    "real": real.rates,
    "mitsuba": lambda runs: mitsuba.limits(),
}


def main() -> int:
    """Count wrong verdicts, the power at the stated bias, and what a minute resolves; 1 if a promise is broken."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.calibration", description=main.__doc__)
    parser.add_argument("--part", action="append", choices=list(PARTS), help="only this one; may be repeated")
    parser.add_argument("--runs", type=int, default=2_000, help="comparisons per line of the table")
    parser.add_argument("--json", action="store_true", help="a list of objects, for programs")
    options = parser.parse_args()
    found: list[Rate | Limit] = []
    for name in options.part or PARTS:
        for line in PARTS[name](options.runs):
            found.append(line)
            print(f"{name}: {line.what}: {line.shown[0]}", file=sys.stderr, flush=True)
    (_as_json if options.json else _as_table)(found)
    return int(not all(line.kept for line in found))


def _as_json(found: list[Rate | Limit]) -> None:
    print(json.dumps([{**vars(line), "kept": line.kept} for line in found], indent=2, ensure_ascii=False))


def _as_table(found: list[Rate | Limit]) -> None:
    table = Table()
    for column in ("what", "found", "promised", "kept"):
        table.add_column(column)
    for line in found:
        table.add_row(line.what, *line.shown, "yes" if line.kept else "[bold red]no")
    wide = partial(Console, highlight=False)
    (wide() if sys.stdout.isatty() else wide(width=160, no_color=True)).print(table)


if __name__ == "__main__":
    raise SystemExit(main())
