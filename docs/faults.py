"""The page of planted faults: ``python docs/faults.py faults.json`` writes docs/faults.md from a matrix.

``lightproof faults --out FOLDER`` makes the file.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec

from comparisons.faults.matrix import Matrix, Row

_HEAD = """# Planted faults

A suite that was never shown a wrong renderer is a hope. Each of these faults was planted in the reference tracer,
which was then put to the same cases in the same order, as somebody would who knows nothing of the fault. The first
case that fails has caught it; more follow until the diagnosis is clear. Sound variants differ from the tracer's
default and are right: no case may fail one.

The weights of the diagnosis were set with most of these faults in view. Those of comparisons/faults/held_out were
written by someone who had not seen the diagnosis, and nothing was tuned on them: theirs is the honest figure.

`lightproof faults NAME` runs one, `lightproof faults --list` says what there is.
"""


def page(matrix: Matrix) -> str:
    """The page, in Markdown."""
    cores = f"{matrix.jobs} at a time on {matrix.processors} processors"
    about = f"Lightproof {matrix.version}, {matrix.date[:10]}, {cores}."
    faults = [row for row in matrix.rows if row.operator]
    sound = [row for row in matrix.rows if not row.operator]
    lines = [
        _HEAD,
        about,
        *matrix.summary.sentences(),
        "",
        "## Faults",
        "",
        *_faults(faults),
        *_reasons(faults),
    ]
    lines += ["## Sound variants", "", "| variant | how it differs | cases | outcome |", "|---|---|---|---|"]
    for row in sound:
        outcome = f"failed by {row.caught_by}" if row.caught_by else "not failed"
        lines.append(f"| {row.name} | {_cell(row.what)} | {row.cases} | {outcome} |")
    return "\n".join(lines) + "\n"


def _faults(rows: Sequence[Row]) -> Iterator[str]:
    yield "| fault | of | what is wrong | caught by | bounce | bias | s | diagnosis |"
    yield "|---|---|---|---|---|---|---|---|"
    for row in rows:
        happened = "".join(f" ([happened]({link}))" for link in row.happened)
        bounce = "" if row.bounce is None else str(row.bounce)
        seconds = f"{row.seconds:.1f}" if row.caught_by else ""
        half = "" if row.tuned else " (held out)"
        named = (
            ((row.diagnosis and row.diagnosis.suspect) or "can't tell") + ("" if row.right else " ✗") + half
        )
        yield (
            f"| {row.name} | {row.operator} | {_cell(row.what)}{happened} | {row.caught_by or '–'} | {bounce} "
            f"| {row.size} | {seconds} | {named if row.caught_by else ''} |"
        )
    yield ""


def _reasons(rows: Sequence[Row]) -> Iterator[str]:
    missed = [row for row in rows if not row.caught_by]
    if missed:
        yield "Not caught:\n"
        yield from (f"- {row.name}: {row.unseen or row.nearest}" for row in missed)
        yield ""


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


if __name__ == "__main__":
    source = Path(sys.argv[1])
    found = msgspec.json.decode(source.read_bytes(), type=Matrix)
    Path(__file__).with_name("faults.md").write_text(page(found), encoding="utf-8")
