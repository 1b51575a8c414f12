"""What a run shows in the terminal: progress while it works, a table of verdicts at the end."""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType
from typing import Any, Self

from rich import box
from rich.console import Console
from rich.measure import Measurement
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from comparisons.results import BounceResult, Comparison, RelationResult, Results
from reports.quantities import term

_STYLE = {
    "pass": "green",
    "known": "cyan",
    "fail": "bold red",
    "error": "bold magenta",
    "inconclusive": "yellow",
    "unsupported": "dim",
}

_PLAIN_WIDTH = 10_000  # of lines that go to a file or a pipe: as long as they are


def console() -> Console:
    """The standard output: colours and bars on a terminal, plain text elsewhere."""
    found = Console(highlight=False)
    return found if found.is_terminal else Console(highlight=False, width=_PLAIN_WIDTH, no_color=True)


class Show:
    """Shows a run as it goes on: bars on a terminal, a line per comparison or claim of a relation elsewhere.

    Attributes:
        total, done: comparisons and relations.
    """

    def __init__(self, out: Console, total: int) -> None:
        self.total, self.done = total, 0
        self._out, self._label = out, ""
        self._bars = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=24),
            TextColumn("{task.fields[message]}"),
            TimeElapsedColumn(),
            console=out,
            transient=True,
            disable=not out.is_terminal,
        )
        self._bar = self._bars.add_task("", total=1.0, message="")

    def started(self, case: str, renderer: str) -> None:
        """Show what begins."""
        self._label = f"[{self.done + 1}/{self.total}] {case} × {renderer}"
        self._bars.reset(self._bar, description=Text(self._label).markup, message="loading")

    def progressed(self, share: float, message: str) -> None:
        """Move the bar."""
        self._bars.update(self._bar, completed=share, message=message)

    def finished(self, comparison: Comparison) -> None:
        """Leave a line behind."""
        self.done += 1
        line = Text(f"{self._label}: ").append(comparison.verdict, _STYLE[comparison.verdict])
        line.append(f"  {comparison.seconds:.1f} s, {comparison.spp} spp")
        if comparison.message:
            line.append(f"  {comparison.message}")
        self._out.print(line, soft_wrap=True)
        for note in comparison.notes:
            self._out.print(f"      {note}", soft_wrap=True)
        self._last()

    def related(self, results: list[RelationResult]) -> None:
        """Leave a line behind for each claim of a relation."""
        self.done += 1
        for result in results:
            claim = f", {result.claim}" if result.claim else ""
            line = Text(f"{self._label}{claim}: ").append(result.verdict, _STYLE[result.verdict])
            line.append(f"  {result.seconds:.1f} s")
            if result.message:
                line.append(f"  {result.message}")
            self._out.print(line, soft_wrap=True)
        self._last()

    def _last(self) -> None:
        if self.done == self.total:
            self._bars.update(self._bar, completed=1.0, message="writing the report")

    def __enter__(self) -> Self:
        self._bars.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bars.stop()


def show_verdicts(out: Console, outcome: Results) -> None:
    """Case × renderer × bounce: the bias of the whole image ± half its interval, in percent; then the relations.

    A table, or a list where the terminal is too narrow for it.
    """
    if outcome.comparisons or not outcome.relations:
        rows = [(c.case, c.renderer, c) for c in outcome.comparisons]
        _show(out, ("case", "renderer"), rows)
    if outcome.relations:
        claims = [(f"{r.relation} {r.claim}".strip(), r.scene, r.renderer, r) for r in outcome.relations]
        _show(out, ("relation", "scene", "renderer"), claims)
    results: list[Comparison | RelationResult] = [*outcome.comparisons, *outcome.relations]
    if any(result.bounces for result in results):
        out.print(_CAPTION)


def _show(out: Console, headings: tuple[str, ...], rows: Sequence[tuple[Any, ...]]) -> None:
    """Rows of names and a result at the end, whose bounces have a column each."""
    bounces = range(max((1 + b.bounce for *_, result in rows for b in result.bounces), default=0))
    table = Table(box=box.SIMPLE_HEAD)
    for heading in (*headings, "verdict", *map(term, bounces)):
        table.add_column(heading, no_wrap=True)
    for *names, result in rows:
        cells = {b.bounce: _cell(b) for b in result.bounces}
        table.add_row(*names, _verdict(result), *(cells.get(k, "") for k in bounces))
    needed = Measurement.get(out, out.options.update(max_width=_PLAIN_WIDTH), table).maximum
    if needed <= out.width:
        out.print(table)
        return
    for *names, result in rows:
        out.print(Text(f"{' × '.join(names)}: ").append(_verdict(result)))
        for b in result.bounces:
            out.print(Text(f"  {term(b.bounce):>5} ").append(_cell(b)))


def _verdict(result: Comparison | RelationResult) -> Text:
    return Text(result.verdict, _STYLE[result.verdict])


_CAPTION = (
    "Bias of the whole image in percent, in the channel closest to failing, ± half its interval; of a relation,\n"
    "how far its first side lies from its second.\n"
    "! fail   ? inconclusive   ~ known deviation   t the tiles decided"
)


def _cell(result: BounceResult) -> Text:
    mark = {"pass": "", "fail": "!", "inconclusive": "?", "known": "~"}[result.verdict]
    half = (result.interval[1] - result.interval[0]) / 2
    tile = "t" if result.decided_by == "tile" else ""
    return Text(f"{100 * result.bias:+.2f}±{100 * half:.2f}{mark}{tile}", _STYLE[result.verdict])
