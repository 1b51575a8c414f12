"""What was found, in sentences. Every sentence follows from the numbers of results.json alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import get_args

from comparisons.results import (
    BounceResult,
    Comparison,
    Diagnosis,
    Interval,
    RelationResult,
    TotalResult,
    Verdict,
)
from reports import quantities

VERDICTS: tuple[Verdict, ...] = get_args(Verdict)
MEANINGS: dict[Verdict, str] = {
    "pass": "Every region's interval lies inside ± its tolerance.",
    "fail": "Some interval, simultaneous over regions, bounces and channels, lies outside ± its tolerance.",
    "inconclusive": "Neither of the two, and the budget is used up. Never to be read as a pass.",
    "known": "A deviation that was declared beforehand, and measured to be the declared one.",
    "unsupported": "The renderer can't express the scene, or a relation says nothing of it; nothing was compared.",
    "error": "The renderer crashed, hung, or returned something that is no image.",
}
# the most urgent first: it names the outcome of the whole run
_ENDINGS: dict[Verdict, str] = {
    "fail": "failed",
    "error": "ended in an error",
    "inconclusive": "stayed inconclusive",
}


Result = Comparison | RelationResult


def counts(results: Sequence[Result]) -> dict[Verdict, int]:
    """How many comparisons and relations ended in each verdict, all six of them."""
    found = Counter(result.verdict for result in results)
    return {verdict: found[verdict] for verdict in VERDICTS}


def outcome(results: Sequence[Result]) -> tuple[Verdict, str]:
    """The verdict of the run, and a sentence that says it.

    A run passes only if something was compared and nothing failed, crashed or stayed undecided.
    """
    found, total = counts(results), len(results)
    noun = "check" if any(isinstance(result, RelationResult) for result in results) else "comparison"
    if urgent := [verdict for verdict in _ENDINGS if found[verdict]]:
        first, *rest = urgent
        others = "".join(f", {found[verdict]} {_ENDINGS[verdict]}" for verdict in rest)
        return first, f"{_share(found[first], total, noun)} {_ENDINGS[first]}{others}."
    if found["pass"] + found["known"] == 0:
        return "unsupported", "Nothing was compared."
    if found["known"]:
        others = f"{found['pass']} passed, " if found["pass"] else ""
        return "known", f"Nothing failed: {others}{found['known']} with a known deviation."
    if found["unsupported"]:
        return "pass", f"{_share(found['pass'], total, noun)} passed; the rest is unsupported."
    return "pass", f"{_share(total, total, noun)} passed."


def diagnosis(found: Diagnosis) -> str:
    """What is most likely at fault, and which case would tell more."""
    advice = (
        f" The case that would tell more in the least time: {found.next_case}." if found.next_case else ""
    )
    return found.sentence + advice


def finding(comparison: Comparison) -> str:
    """One comparison's result in a sentence or two."""
    verdict = comparison.verdict
    if verdict == "unsupported":
        return f"{comparison.renderer} can't express this scene, so nothing was compared: unsupported."
    if verdict == "error":
        return f"{comparison.renderer} gave no image that could be judged: error."
    if verdict == "pass":
        return _agreement(comparison)
    totals = " ".join(total_finding(t) for t in comparison.totals if t.verdict == verdict)
    found = [bounce for bounce in comparison.bounces if bounce.verdict == verdict]
    if not found:
        return totals or f"The comparison ended as {verdict}."
    first, rest = found[0], [str(bounce.bounce) for bounce in found[1:]]
    sentence = bounce_finding(first, subject(comparison, first))
    if rest:
        noun = "Bounce" if len(rest) == 1 else "Bounces"
        sentence += f" {noun} {_enumeration(rest)} ended the same way."
    return f"{sentence} {totals}".rstrip()


def subject(comparison: Comparison, bounce: BounceResult) -> str:
    """What the sentence about an entry is about: ``Bounce 1``, or a finished image's ``sum of bounces 0 to 5``."""
    summed = quantities.is_sum(comparison)
    return f"The sum of bounces 0 to {bounce.bounce}" if summed else f"Bounce {bounce.bounce}"


def bounce_finding(bounce: BounceResult, subject: str) -> str:
    """One bounce in a sentence: ``Bounce 1 is 1.3 % high (interval …, tolerance ±0.5 %): fail.``"""
    bias, interval, tolerance = _evidence(bounce)
    where = subject + (f" in {tile_name(bounce)}" if bounce.decided_by == "tile" else "")
    numbers = f"interval {quantities.interval(interval)}, tolerance ±{quantities.percent(tolerance)}"
    if bounce.verdict == "pass":
        return f"{where} agrees with the truth ({numbers}): pass."
    if bounce.verdict == "inconclusive":
        return f"{where} is undecided ({numbers}): inconclusive, which is not a pass."
    size = f"{quantities.percent(abs(bias))} {'high' if bias > 0 else 'low'}"
    declared = ", as declared" if bounce.verdict == "known" else ""
    return f"{where} is {size} ({numbers}){declared}: {bounce.verdict}."


def total_finding(total: TotalResult) -> str:
    """A total in a sentence, with what is said of it where it has no numbers."""
    name = quantities.total_name(total)
    if total.result is None:
        return f"The {name}: {total.message.removeprefix('total: ')}: {total.verdict}."
    return bounce_finding(total.result, f"The {name}, by the renderer's own defaults,")


def relation_finding(result: RelationResult) -> str:
    """One claim of a relation in a sentence."""
    if not result.bounces:
        return f"{result.message or 'Nothing was found'}: {result.verdict}."
    found = [b for b in result.bounces if b.verdict == result.verdict]
    if result.verdict == "pass":
        seen = quantities.percent(max(b.detectable_bias for b in found))
        return f"Both sides agree: pass. A deviation of {seen} of the whole image would have failed with 90 % power."
    bias, interval, tolerance = _evidence(first := found[0])
    where = f"bounce {first.bounce}" + (f", {tile_name(first)}" if first.decided_by == "tile" else "")
    numbers = f"interval {quantities.interval(interval)}, tolerance ±{quantities.percent(tolerance)}"
    size = f"{quantities.percent(abs(bias))} {'above' if bias > 0 else 'below'} the second"
    declared = ", as declared" if result.verdict == "known" else ""
    return f"In {where} the first side is {size} ({numbers}){declared}: {result.verdict}."


def tile_name(bounce: BounceResult) -> str:
    """Where the worst tile lies, ``tile row 2, column 5 (channel G)``; rows and columns count from 0."""
    tile = bounce.worst_tile
    return f"tile row {tile.place.row}, column {tile.place.column} (channel {tile.channel})"


def _evidence(bounce: BounceResult) -> tuple[float, Interval, float]:
    """Bias, interval and tolerance of the region that decided."""
    if bounce.decided_by == "tile":
        return bounce.worst_tile.bias, bounce.worst_tile.interval, bounce.tile_tolerance
    return bounce.bias, bounce.interval, bounce.tolerance


def _agreement(comparison: Comparison) -> str:
    bounces = comparison.bounces
    totals = [total for total in comparison.totals if total.result]
    if not bounces:
        return " ".join(map(total_finding, totals)) or "The comparison ended as pass."
    who = "The only bounce agrees" if len(bounces) == 1 else f"All {len(bounces)} bounces agree"
    who = f"{subject(comparison, bounces[0])} agrees" if quantities.is_sum(comparison) else who
    if totals:
        several = f"{len(totals)} totals" if len(totals) > 1 else "the total"
        who = who.removesuffix("agrees").removesuffix("agree").rstrip() + f" and {several} agree"
    whole = quantities.percent(max(bounce.detectable_bias for bounce in bounces))
    tile = quantities.percent(max(bounce.worst_tile.detectable_bias for bounce in bounces))
    of = " of a bounce" if totals else ""
    return (
        f"{who} with the {comparison.truth} truth within tolerance: pass. A bias of {whole} of the whole "
        f"image{of}, or of {tile} in the worst tile, would have failed with 90 % power."
    )


def _share(part: int, total: int, noun: str) -> str:
    if part == total:
        return f"The only {noun}" if total == 1 else f"All {total} {noun}s"
    return f"{part} of {total} {noun}s"


def _enumeration(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
