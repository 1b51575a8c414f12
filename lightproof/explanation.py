"""A verdict as the message of a failed test: what was found, the table, what would help, where the report is."""

from __future__ import annotations

import io
import math
from pathlib import Path

from rich.console import Console

from comparisons.results import BounceResult, Comparison, Results
from comparisons.sequential import MIN_REPLICATES
from lightproof.terminal import show_verdicts
from reports.plain import plain
from reports.quantities import percent
from reports.wording import finding

_WIDTH = 100  # of the table: beside the margin that pytest draws


def headline(comparison: Comparison) -> str:
    """One line: ``furnace-box × mitsuba: Bounce 2 is 3.0 % high (…): fail.``"""
    said = finding(comparison)
    if comparison.verdict in ("error", "unsupported") and comparison.message:
        said = f"{comparison.verdict}, {comparison.message.splitlines()[0]}"
    return f"{comparison.case} × {comparison.renderer}: {plain(said)}"


def explanation(outcome: Results, report: Path) -> str:
    """The message of a comparison that is no pass, as plain text.

    Args:
        outcome: of a single comparison.
        report: the page to open.
    """
    [comparison] = outcome.comparisons
    parts = [headline(comparison)]
    if comparison.bounces:
        parts += ["", table(outcome), ""]
    if comparison.message and comparison.verdict not in ("error", "unsupported"):
        parts.append(_sentence(comparison.message))
    parts += [_sentence(text) for text in (needed(comparison), *comparison.notes) if text]
    if comparison.log:
        parts += ["The last that was heard of it:", *(f"    {line}" for line in comparison.log)]
    return plain("\n".join([*parts, f"Report: {report}"]))


def table(outcome: Results) -> str:
    """The table of verdicts that the command shows, without colours."""
    text = io.StringIO()
    out = Console(file=text, width=_WIDTH, highlight=False, no_color=True, force_terminal=False)
    show_verdicts(out, outcome)
    lines = [line.rstrip() for line in text.getvalue().splitlines()]
    return "\n".join(line for line in lines if line)


def needed(comparison: Comparison) -> str:
    """What would decide the bounces that are open: a budget, or tolerances. Empty if none is.

    An interval narrows with the square root of the time. A renderer without bias is told with 90 % power once
    ``resolution`` lies within the tolerance; one with a bias once its interval does not reach the tolerance.
    """
    undecided = [b for b in comparison.bounces if b.verdict == "inconclusive"]
    if not undecided:
        return ""
    replicates = min(b.replicates for b in undecided)
    if replicates < MIN_REPLICATES:
        seconds = 2 * comparison.seconds * MIN_REPLICATES / replicates
        return f"A verdict needs a budget of at least {_rounded(seconds):g} s"
    seconds = comparison.seconds * max(_stretch(b) for b in undecided) ** 2
    image = max(max(b.resolution, _reach(b.bias, b.simultaneous_interval)) for b in undecided)
    tile = max(
        max(_tile_resolution(b), _reach(b.worst_tile.bias, b.worst_tile.simultaneous_interval))
        for b in undecided
    )
    image = max(image, *(b.tolerance for b in comparison.bounces))
    tile = max(tile, *(b.tile_tolerance for b in comparison.bounces))
    return (
        f"A budget of about {_rounded(seconds):g} s should decide it, or a tolerance of {percent(image)} "
        f"with {percent(tile)} for tiles"
    )


def _stretch(b: BounceResult) -> float:
    """How much narrower the intervals of a bounce must become; at least √2, which is twice the time."""
    image = _narrower(b.resolution, b.bias, b.simultaneous_interval, b.tolerance)
    tile = b.worst_tile
    return max(
        image,
        _narrower(_tile_resolution(b), tile.bias, tile.simultaneous_interval, b.tile_tolerance),
        math.sqrt(2),
    )


def _narrower(resolution: float, bias: float, interval: tuple[float, float], tolerance: float) -> float:
    if resolution > tolerance:
        return resolution / tolerance
    margin = max(abs(abs(bias) - tolerance), 0.05 * tolerance)  # of a bias at the tolerance there is no end
    return (interval[1] - interval[0]) / 2 / margin


def _tile_resolution(b: BounceResult) -> float:
    return b.worst_tile.detectable_bias - b.tile_tolerance


def _reach(bias: float, interval: tuple[float, float]) -> float:
    """The largest |bias| of an interval."""
    return abs(bias) + (interval[1] - interval[0]) / 2


def _rounded(seconds: float) -> float:
    """Up, to two digits."""
    unit = 10.0 ** (math.floor(math.log10(seconds)) - 1)
    return math.ceil(seconds / unit) * unit


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:].rstrip('.')}."
