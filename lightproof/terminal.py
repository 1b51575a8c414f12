"""What a run shows in the terminal: progress while it works, a table of verdicts at the end."""

from __future__ import annotations

from types import TracebackType
from typing import Self

from rich import box
from rich.console import Console
from rich.measure import Measurement
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from comparisons.results import BounceResult, Comparison, Results
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
    """Shows a run as it goes on: bars on a terminal, a line per comparison elsewhere.

    Attributes:
        total, done: comparisons.
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
        """Show which comparison begins."""
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
    """Case × renderer × bounce: the bias of the whole image ± half its interval, in percent.

    A table, or a list where the terminal is too narrow for it.
    """
    bounces = max((len(c.bounces) for c in outcome.comparisons), default=0)
    table = Table(box=box.SIMPLE_HEAD)
    for heading in ("case", "renderer", "verdict", *map(term, range(bounces))):
        table.add_column(heading, no_wrap=True)
    for comparison in outcome.comparisons:
        cells = [_cell(b) for b in comparison.bounces]
        table.add_row(comparison.case, comparison.renderer, _verdict(comparison), *cells)
    needed = Measurement.get(out, out.options.update(max_width=_PLAIN_WIDTH), table).maximum
    if needed <= out.width:
        out.print(table)
    else:
        for comparison in outcome.comparisons:
            out.print(Text(f"{comparison.case} × {comparison.renderer}: ").append(_verdict(comparison)))
            for b in comparison.bounces:
                out.print(Text(f"  {term(b.bounce):>5} ").append(_cell(b)))
    if bounces:
        out.print(_CAPTION)


def _verdict(comparison: Comparison) -> Text:
    return Text(comparison.verdict, _STYLE[comparison.verdict])


_CAPTION = (
    "Bias of the whole image in percent, in the channel closest to failing, ± half its interval.\n"
    "! fail   ? inconclusive   ~ known deviation   t the tiles decided"
)


def _cell(result: BounceResult) -> Text:
    mark = {"pass": "", "fail": "!", "inconclusive": "?", "known": "~"}[result.verdict]
    half = (result.interval[1] - result.interval[0]) / 2
    tile = "t" if result.decided_by == "tile" else ""
    return Text(f"{100 * result.bias:+.2f}±{100 * half:.2f}{mark}{tile}", _STYLE[result.verdict])
