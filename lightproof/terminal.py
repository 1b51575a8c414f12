"""What the command shows in the terminal: a run's progress, a table of verdicts at its end, lists."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any, Self

from rich import box
from rich.columns import Columns
from rich.console import Console
from rich.measure import Measurement
from rich.padding import Padding
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from comparisons.results import (
    BounceResult,
    Comparison,
    Interval,
    Metrics,
    RelationResult,
    ResidualNoise,
    Results,
    TotalResult,
)
from reports import quantities, wording
from reports.quantities import image_name, number, term, total_name

_STYLE = {
    "pass": "green",
    "known": "cyan",
    "fail": "bold red",
    "error": "bold magenta",
    "inconclusive": "yellow",
    "unsupported": "dim",
}

PLAIN_WIDTH = 10_000
"""Of lines that go to a file or a pipe: as long as they are."""

_TABLE_WIDTH = 160  # of a terminal in which the columns of a list are wide enough to be read


def console(stderr: bool = False) -> Console:
    """The standard output: colours and bars on a terminal, plain text elsewhere."""
    found = Console(highlight=False, stderr=stderr)
    if found.is_terminal:
        return found
    return Console(highlight=False, stderr=stderr, width=PLAIN_WIDTH, no_color=True)


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
        """Show what begins; what is asked again when all is done has no number."""
        number = f"[{self.done + 1}/{self.total}] " if self.done < self.total else ""
        self._label = f"{number}{case} × {renderer}"
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
            for note in result.notes:
                self._out.print(f"      {note}", soft_wrap=True)
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
    """Case × renderer × bounce: the bias of the whole image ± half its interval, in percent; the same of relations;
    and the outcome.

    A table, or where the terminal is too narrow for it, the bounces of each comparison below its name.
    """
    if outcome.comparisons or not outcome.relations:
        rows = [(c.case, c.renderer, c) for c in outcome.comparisons]
        _show(out, ("case", "renderer"), rows)
    if outcome.relations:
        claims = [(f"{r.relation} {r.claim}".strip(), r.scene, r.renderer, r) for r in outcome.relations]
        _show(out, ("relation", "scene", "renderer"), claims)
    results: list[Comparison | RelationResult] = [*outcome.comparisons, *outcome.relations]
    if any(result.bounces for result in results):
        caption = _caption(any(r.bounces for r in outcome.relations), any(map(_totals, outcome.comparisons)))
        out.print(caption, soft_wrap=True)
    for diagnosis in outcome.diagnoses:
        out.print(
            Text(f"{diagnosis.renderer}: ", "bold").append(wording.diagnosis(diagnosis), ""), soft_wrap=True
        )
    out.print(wording.outcome(results)[1])


def show_rows(out: Console, rows: Sequence[Mapping[str, str]]) -> None:
    """What there is, by its name: a table, or where the terminal is narrow, a paragraph for each.

    Args:
        out: where to.
        rows: of the same columns, name and title among them; an empty text is left out of a paragraph.
    """
    if out.width >= _TABLE_WIDTH:
        table = Table(box=None, pad_edge=False)
        for heading in rows[0]:
            table.add_column(heading, no_wrap=heading in ("name", "installed"))
        for row in rows:
            table.add_row(
                *(Text(value or "–") for value in row.values())
            )  # no markup: an extra stands in [ ]
        out.print(table)
        return
    for row in rows:
        out.print(Text.assemble((row["name"], "bold"), f"  {row['title']}"))
        others = {key: value for key, value in row.items() if value and key not in ("name", "title")}
        text = " · ".join(f"{key.replace('_', ' ')} {value}" for key, value in others.items())
        out.print(Padding(Text(text, "dim"), (0, 0, 0, 4), expand=False))


def fits(out: Console, table: Table) -> bool:
    """Whether it does without a line break, or a column that is left out."""
    return Measurement.get(out, out.options.update(max_width=PLAIN_WIDTH), table).maximum <= out.width


def _show(out: Console, headings: tuple[str, ...], rows: Sequence[tuple[Any, ...]]) -> None:
    """Rows of names and a result at the end, whose bounces have a column each."""
    bounces = range(max((1 + b.bounce for *_, result in rows for b in result.bounces), default=0))
    table = Table(box=box.SIMPLE_HEAD)
    last = list(dict.fromkeys(total_name(t) for *_, result in rows for t in _totals(result)))
    for heading in (*headings, "verdict", *map(term, bounces), *last):
        table.add_column(heading, no_wrap=True)
    for *names, result in rows:
        cells = {b.bounce: _cell(b) for b in result.bounces}
        totals = {total_name(t): _total_cell(t) for t in _totals(result)}
        sums = (totals.get(name, "") for name in last)
        table.add_row(*names, _verdict(result), *(cells.get(k, "") for k in bounces), *sums)
    if fits(out, table):
        out.print(table)
        return
    cells_of = [_labelled_cells(result) for *_, result in rows]
    width = max((len(cell) for cells in cells_of for cell in cells), default=0)
    for (*names, result), labelled in zip(rows, cells_of, strict=True):
        out.print(Text(f"{' × '.join(names)}: ").append(_verdict(result)))
        if labelled:
            out.print(Padding(Columns(labelled, width=width, padding=(0, 1)), (0, 0, 0, 2), expand=False))


def _totals(result: Comparison | RelationResult) -> list[TotalResult]:
    return result.totals if isinstance(result, Comparison) else []


def _verdict(result: Comparison | RelationResult) -> Text:
    return Text(result.verdict, _STYLE[result.verdict])


def _caption(relations: bool, totals: bool) -> str:
    lines = ["Bias of the whole image in percent, in the channel closest to failing, ± half its interval"]
    lines += ["total: the sum of all bounces, rendered with the renderer's own defaults"] if totals else []
    lines += ["Of a relation, how far its first side lies from its second"] if relations else []
    return "\n".join([*lines, "! fail   ? inconclusive   ~ known deviation   t the tiles decided"])


def _cell(result: BounceResult) -> Text:
    mark = {"pass": "", "fail": "!", "inconclusive": "?", "known": "~"}[result.verdict]
    tile = "t" if result.decided_by == "tile" else ""
    return Text(f"{_bias(result.bias, result.interval)}{mark}{tile}", _STYLE[result.verdict])


def _total_cell(total: TotalResult) -> Text:
    return _cell(total.result) if total.result else Text(total.verdict, _STYLE[total.verdict])


def _labelled_cells(result: Comparison | RelationResult) -> list[Text]:
    """Bounces and totals, each with its name."""
    bounces = [Text(f"{term(b.bounce):>4} ").append(_cell(b)) for b in result.bounces]
    return bounces + [Text(f"{total_name(t)} ").append(_total_cell(t)) for t in _totals(result)]


def _bias(bias: float, interval: Interval) -> str:
    return quantities.bias(bias, interval).removesuffix(" %").replace(" ± ", "±")


def show_single_image(out: Console, comparison: Comparison) -> None:
    """What was found of one finished image: a line per bounce, or one for the sum, and what can't be told."""
    size = f"{comparison.width}x{comparison.height}"
    out.print(Text(f"{comparison.renderer} × {comparison.case}, {size}: ").append(_verdict(comparison)))
    found = comparison.single_image
    if comparison.bounces:
        table = Table(box=box.SIMPLE_HEAD)
        of_region = ("bias", "tolerance", "detectable")
        for heading in ("image", *of_region, "worst tile", *of_region):
            table.add_column(heading, no_wrap=True)
        for b in comparison.bounces:
            table.add_row(image_name(comparison, b.bounce), *_of_image_and_tile(b))
        out.print(table)
        out.print(_SINGLE_CAPTION)
        out.print(f"{_metrics(comparison.metrics[-1])}: these inform, they decide nothing", soft_wrap=True)
    for line in filter(None, (comparison.message, *comparison.notes)):
        out.print(line, soft_wrap=True)
    if found is not None:
        for b, noise in zip(comparison.bounces, found.noise, strict=True):
            if noise.outliers:
                out.print(f"{image_name(comparison, b.bounce)}: {_outliers(noise)}", soft_wrap=True)
        for hint in found.hints:
            out.print(Text("Hint: ", "bold").append(hint, ""), soft_wrap=True)
        out.print("What can't be told:")
        for limit in found.limits:
            out.print(f"- {limit}", soft_wrap=True)


def _of_image_and_tile(b: BounceResult) -> tuple[str | Text, ...]:
    tile, place = b.worst_tile, b.worst_tile.place
    sizes = (b.tolerance, b.detectable_bias, b.tile_tolerance, tile.detectable_bias)
    tolerance, detectable, tile_tolerance, tile_detectable = (f"{100 * size:.2f}" for size in sizes)
    where = f"x {place.x0}-{place.x1 - 1}, y {place.y0}-{place.y1 - 1}"
    tile_bias = _bias(tile.bias, tile.interval)
    return _cell(b), tolerance, detectable, where, tile_bias, tile_tolerance, tile_detectable


def _metrics(of: Metrics) -> str:
    """Of the whole sum, those that are defined."""
    values = {
        "relMSE": of.rel_mse,
        "PSNR (dB)": of.psnr,
        "SSIM": of.ssim,
        "HDR-FLIP": of.flip,
        "ΔE₀₀": of.delta_e,
    }
    return "; ".join(f"{name} {number(value)}" for name, value in values.items() if value is not None)


def _outliers(noise: ResidualNoise) -> str:
    brightest = (
        f"({o.x}, {o.y}) {o.channel} {o.value:.3g} for {o.truth:.3g}" for o in noise.brightest_outliers
    )
    several = "s, the brightest" if noise.outliers > 1 else ""
    return f"{noise.outliers} outlier{several} at (x, y) = {', '.join(brightest)}"


_SINGLE_CAPTION = (
    "All in percent, in the channel closest to failing; a bias ± half its interval.\n"
    "! fail   ? inconclusive   t the tiles decided   detectable: what would have failed with 90 % power"
)
