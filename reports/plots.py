"""The plots of a comparison: energy per bounce on a log axis, bias per bounce against its tolerance."""

from __future__ import annotations

import math
from typing import Any

from bokeh.models import ColumnDataSource, FixedTicker, HoverTool, Range1d, Whisker
from bokeh.plotting import figure

from comparisons.results import BounceResult, Comparison
from reports.quantities import decimal_label, image_name

_TRUTH, _RENDERER, _TILE = "#2b6cb0", "#c2410c", "#6b7280"
_TEXT, _GRID = "#4b5563", "#d1d5db"


def energy(comparison: Comparison) -> tuple[Any, list[int]]:
    """Mean radiance of truth and renderer per bounce, with the renderer's interval.

    Returns:
        The figure, or None if no bounce holds any energy, and the bounces that the log axis can't show
        because truth, renderer or both are zero or negative there.
    """
    bounces = comparison.bounces
    dark = [b.bounce for b in bounces if b.truth_mean <= 0 or b.mean <= 0]
    positive = [value for b in bounces for value in (b.truth_mean, b.mean) if value > 0]
    if not positive:
        return None, dark
    bottom, top = min(positive) / 3, max(positive) * 3
    plot = _figure(comparison, "mean radiance", y_axis_type="log", y_range=Range1d(bottom, top))
    # Bokeh's own ticks crowd below two decades and look linear there
    labels = _log_ticks(bottom, top)
    plot.yaxis.ticker = FixedTicker(ticks=list(labels))
    plot.yaxis.major_label_overrides = labels

    truth = [b for b in bounces if b.truth_mean > 0]
    _series(plot, "truth", _TRUTH, "square", [b.bounce for b in truth], [b.truth_mean for b in truth])
    ours = [b for b in bounces if b.mean > 0]
    ends = [_ends(b) for b in ours]
    source = _series(plot, "renderer", _RENDERER, "circle", [b.bounce for b in ours], [b.mean for b in ours])
    # an interval that reaches below zero ends at the axis, since a log axis has no zero
    source.data["low"] = [max(low, bottom) for low, _ in ends]
    source.data["high"] = [max(high, bottom) for _, high in ends]
    _whiskers(plot, source, _RENDERER)
    _legend(plot)
    return plot, dark


def bias(comparison: Comparison) -> Any:
    """Relative bias per bounce in percent, whole image and worst tile, on bars that are ± the tolerance.

    Returns:
        The figure, or None if nothing was compared.
    """
    bounces = comparison.bounces
    if not bounces:
        return None
    tiles = [b.worst_tile for b in bounces]
    ends = [
        end for b in bounces for end in (*b.interval, *b.worst_tile.interval, b.tolerance, b.tile_tolerance)
    ]
    limit = 108 * max(map(abs, ends))
    plot = _figure(comparison, "bias, %", y_range=Range1d(-limit, limit))
    x = [b.bounce for b in bounces]
    for name, width, colour, tolerances in (
        ("tile tolerance", 0.9, "#eceff3", [100 * b.tile_tolerance for b in bounces]),
        ("tolerance", 0.6, "#c9e8d2", [100 * b.tolerance for b in bounces]),
    ):
        bottoms = [-tolerance for tolerance in tolerances]
        plot.vbar(x=x, width=width, top=tolerances, bottom=bottoms, color=colour, legend_label=name)
    for name, colour, marker, shift, values, intervals in (
        ("whole image", _RENDERER, "circle", -0.1, [b.bias for b in bounces], [b.interval for b in bounces]),
        ("worst tile", _TILE, "diamond", 0.1, [t.bias for t in tiles], [t.interval for t in tiles]),
    ):
        xs = [b.bounce + shift for b in bounces]
        source = _series(plot, name, colour, marker, xs, [100 * value for value in values], line=False)
        source.data["low"] = [100 * low for low, _ in intervals]
        source.data["high"] = [100 * high for _, high in intervals]
        _whiskers(plot, source, colour)
    _legend(plot)
    return plot


def _log_ticks(bottom: float, top: float) -> dict[float, str]:
    """Ticks of a log axis and their labels: 1, 2, 5 and 10 over a short range, else whole decades."""
    decades = range(math.floor(math.log10(bottom)), math.ceil(math.log10(top)) + 1)
    mantissas = (1, 2, 5) if len(decades) <= 4 else (1,)
    ticks = [(m, k) for k in decades[:: math.ceil(len(decades) / 8)] for m in mantissas]
    values = {float(f"{m}e{k}"): decimal_label(m, k) for m, k in ticks}
    return {value: label for value, label in values.items() if bottom <= value <= top}


def _ends(bounce: BounceResult) -> tuple[float, float]:
    """The interval of the renderer's mean radiance that belongs to the interval of its relative bias."""
    low, high = bounce.interval
    return bounce.truth_mean + low * bounce.denominator, bounce.truth_mean + high * bounce.denominator


def _figure(comparison: Comparison, label: str, **options: Any) -> Any:
    bounces = comparison.bounces
    plot = figure(
        height=270,
        sizing_mode="stretch_width",
        tools="",
        toolbar_location=None,
        y_axis_label=label,
        x_range=Range1d(bounces[0].bounce - 0.6, bounces[-1].bounce + 0.6),
        **options,
    )
    plot.background_fill_color = plot.border_fill_color = None
    plot.outline_line_color = None
    plot.xaxis.ticker = FixedTicker(ticks=[b.bounce for b in bounces])
    plot.xaxis.major_label_overrides = {b.bounce: image_name(comparison, b.bounce) for b in bounces}
    plot.xgrid.grid_line_color = None
    plot.ygrid.grid_line_color = _GRID
    plot.axis.axis_line_color = plot.axis.major_tick_line_color = _TEXT
    plot.axis.minor_tick_line_color = None
    plot.axis.major_label_text_color = plot.axis.axis_label_text_color = _TEXT
    plot.axis.axis_label_text_font_style = "normal"
    plot.axis.major_label_text_font_size = plot.axis.axis_label_text_font_size = "12px"
    return plot


def _series(
    plot: Any, name: str, colour: str, marker: str, x: list[float], y: list[float], *, line: bool = True
) -> ColumnDataSource:
    source = ColumnDataSource({"x": x, "y": y})
    if line:
        plot.line("x", "y", source=source, color=colour, line_alpha=0.5, legend_label=name)
    # a hollow square round a dot: the two sides coincide as long as the renderer is right
    fill, size = (None, 13) if marker == "square" else (colour, 7)
    style = {"line_color": colour, "fill_color": fill, "size": size, "marker": marker, "legend_label": name}
    dots = plot.scatter("x", "y", source=source, **style)
    plot.add_tools(HoverTool(renderers=[dots], tooltips=[(name, "@y{%.4g}")], formatters={"@y": "printf"}))
    return source


def _whiskers(plot: Any, source: ColumnDataSource, colour: str) -> None:
    whisker = Whisker(
        source=source, base="x", lower="low", upper="high", line_color=colour, level="annotation"
    )
    whisker.upper_head.size = whisker.lower_head.size = 8
    whisker.upper_head.line_color = whisker.lower_head.line_color = colour
    plot.add_layout(whisker)


def _legend(plot: Any) -> None:
    legend = plot.legend[0]
    plot.add_layout(legend, "above")
    legend.orientation = "horizontal"
    legend.background_fill_alpha = legend.border_line_alpha = 0
    legend.label_text_color = _TEXT
    legend.label_text_font_size = "12px"
    legend.padding = legend.margin = 0
