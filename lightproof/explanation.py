"""A verdict as the message of a failed test: what was found, the table, what would help, where the report is."""

from __future__ import annotations

import io
import math
from pathlib import Path

from rich.console import Console

from comparisons.results import BounceResult, Comparison, Results, TileResult
from comparisons.sequential import MIN_REPLICATES
from comparisons.total import SHARE
from lightproof.terminal import show_verdicts
from reports.plain import plain
from reports.quantities import percent
from reports.wording import finding
from reports.wording import outcome as outcome_of

_WIDTH = 100  # of the table: beside the margin that pytest draws
_NOISE = 1.4  # half an interval is some 3½ standard errors; 1½ more, and its middle seldom lies further off
_MARGIN = 1.25  # of forecasts: later looks are stricter, and many regions have to pass at once


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
    of_run = outcome_of(outcome.comparisons)[1]  # of a single comparison: the headline says it
    return "\n".join(line for line in lines if line not in ("", of_run))


def needed(comparison: Comparison) -> str:
    """What a renderer without bias would have needed to pass: a budget, or tolerances. Empty if nothing is open.

    An interval narrows with the square root of the time, and lies inside the tolerance with some 90 % power once
    its half, and the noise of its middle, fit in there.
    """
    undecided = [b for b in comparison.bounces if b.verdict == "inconclusive"]
    totals = [t for t in comparison.totals if t.result and t.verdict == "inconclusive"]
    spent = max([comparison.seconds if undecided else 0.0, *(t.seconds / SHARE for t in totals)])
    undecided += [t.result for t in totals if t.result]
    if not undecided:
        return ""
    replicates = min(b.replicates for b in undecided)
    if replicates < MIN_REPLICATES:  # too few for any forecast
        seconds = 2 * spent * MIN_REPLICATES / replicates
        return f"A verdict needs a budget of at least {_rounded(seconds):g} s"
    tiles = [b.worst_tile.detectable_bias - b.tile_tolerance for b in undecided]  # their resolutions
    ratios = [_NOISE * _half(b) / b.tolerance for b in undecided]
    ratios += [_NOISE * _half(b.worst_tile) / b.tile_tolerance for b in undecided]
    image = max(_MARGIN * max(b.resolution, _reach(b)) for b in undecided)
    tile = _MARGIN * max(
        max(resolution, _reach(b.worst_tile)) for resolution, b in zip(tiles, undecided, strict=True)
    )
    image = max(image, *(b.tolerance for b in (*comparison.bounces, *undecided)))
    tile = max(tile, *(b.tile_tolerance for b in (*comparison.bounces, *undecided)))
    tolerances = f"a tolerance of {percent(image)}, and {percent(tile)} for tiles"
    if _MARGIN * max(ratios) < 1:
        return f"A renderer without bias would have passed by now; this one should with {tolerances}"
    seconds = spent * (_MARGIN * max(ratios)) ** 2
    return (
        f"A renderer without bias should pass with a budget of {_rounded(seconds):g} s, or with {tolerances}"
    )


def _half(found: BounceResult | TileResult) -> float:
    low, high = found.interval
    return (high - low) / 2


def _reach(found: BounceResult | TileResult) -> float:
    """The largest |bias| that its interval holds."""
    return max(map(abs, found.simultaneous_interval))


def _rounded(seconds: float) -> float:
    """Up, to two digits."""
    unit = 10.0 ** (math.floor(math.log10(seconds)) - 1)
    return math.ceil(seconds / unit) * unit


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:].rstrip('.')}."
