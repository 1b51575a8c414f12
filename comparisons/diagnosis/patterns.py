"""What the bounces of one comparison look like together.

With r_k the measured over the true mean of bounce k, over the whole image:

    r_k = f for all k                   what is emitted, or the exposure, is off by f
    r_0 = 1, r_k = f for k ≥ 1          the last step, from a surface to its light, is: it occurs once in every term
    r_0 = 1, r_k = f^k                  every step is: reflection
    r_k = 1 for k < m                   something that happens at the m-th step alone
    m_k = t_{k ± 1}                     bounces are counted from another number
    m_k = t_0 + … + t_k                 sums are taken for terms
    r = 1, tiles apart from it          light is in the wrong place
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from comparisons.results import BounceResult, Comparison

Kind = Literal[
    "error",
    "none of E",
    "dark from",
    "light after the last",
    "sums",
    "counted from another number",
    "same factor",
    "same factor from 1",
    "factor by factor",
    "one bounce",
    "later bounces",
    "only E",
    "places",
    "direct",
    "irregular",
]

_GONE = 0.02
"""Share of its light below which a bounce is called dark."""

_ALIKE = 0.12
"""How far apart, of themselves, two deviations may be that are called the same."""

_LEAST_ERROR = 1e-4
"""Percent; a standard error below that is rounding, and not told."""


@dataclass(frozen=True)
class Pattern:
    """What the failed bounces of a comparison have in common.

    Attributes:
        kind: which pattern.
        case: where it was seen.
        first: the first bounce that is wrong.
        text: it, with its numbers, as a clause.
    """

    kind: Kind
    case: str
    first: int
    text: str


def pattern(comparison: Comparison) -> Pattern | None:
    """The pattern of a comparison that failed; None of another one."""
    if comparison.verdict == "error":
        return Pattern("error", comparison.case, 0, comparison.message)
    wrong = [b for b in comparison.bounces if b.verdict == "fail"]
    if not wrong:
        return None
    first = wrong[0].bounce
    kind, text = _kind(comparison.bounces, wrong)
    return Pattern(kind, comparison.case, first, text)


def _kind(bounces: Sequence[BounceResult], wrong: Sequence[BounceResult]) -> tuple[Kind, str]:
    lit = [b for b in bounces if b.truth_mean > 0]
    after = [b for b in wrong if b.truth_mean == 0 < b.mean]
    dark = [b for b in lit if b.mean < _GONE * b.truth_mean]
    first = wrong[0].bounce
    if after and not [b for b in wrong if b.truth_mean > 0]:
        return "light after the last", f"bounce {after[0].bounce} has light where there is none"
    if _are_sums(bounces):
        return "sums", "each bounce k has the light of all bounces up to k"
    if shift := _shift(bounces):
        return "counted from another number", f"each bounce k has the light of bounce k {shift:+d}"
    if dark and dark[0].bounce == 0 and len(dark) == 1:
        return "none of E", "bounce 0 is black"
    if _dark_from_there_on(lit, dark):
        return "dark from", f"bounces from {dark[0].bounce} on are black, those before it are right"
    if all(b.decided_by == "tile" for b in wrong):
        return "places", f"bounces {_list(wrong)} have the right mean, and light in the wrong places"
    if [b.bounce for b in wrong] == [0]:
        return "only E", f"bounce 0 is {_percent(wrong[0])}, all others are right"
    return _by_factors(lit, wrong, first)


def _by_factors(lit: Sequence[BounceResult], wrong: Sequence[BounceResult], first: int) -> tuple[Kind, str]:
    indirect = [b for b in lit if b.bounce > 0]
    emission = [b for b in lit if b.bounce == 0]
    if first == 0 and len(lit) > 1 and _alike([_log(b) for b in lit]):
        return "same factor", f"all bounces are {_percent(lit[0])} by the same factor"
    if first == 0 and emission:
        return "irregular", f"bounces {_list(wrong)} are wrong, bounce 0 among them, {_percent(wrong[0])}"
    if len(indirect) <= 1:
        return "direct", f"bounce {first} is {_percent(wrong[0])}"
    if first == 1 and _alike([_log(b) for b in indirect]):
        return "same factor from 1", f"bounces from 1 on are each {_percent(indirect[0])}, by the same factor"
    if first <= 2 and _alike([_log(b) / b.bounce for b in indirect]):
        text = f"bounce 1 is {_percent(indirect[0])}, and each further one by that factor more"
        return "factor by factor", text
    if len(wrong) == 1 and len(indirect) > 2:
        return "one bounce", f"bounce {first} alone is {_percent(wrong[0])}"
    if first >= 2:
        return "later bounces", f"bounces before {first} are right, bounce {first} is {_percent(wrong[0])}"
    return "irregular", f"bounces {_list(wrong)} are wrong, bounce {first} {_percent(wrong[0])}"


def _shift(bounces: Sequence[BounceResult]) -> int:
    """+1 or −1 if each bounce has the light of its neighbour, and that is not its own; else 0."""
    for shift in (1, -1):
        pairs = [(b, bounces[k + shift]) for k, b in enumerate(bounces) if 0 <= k + shift < len(bounces)]
        pairs = [(b, other) for b, other in pairs if b.truth_mean > 0 or other.truth_mean > 0]
        first = bounces[0]
        if first.truth_mean > 0 and first.verdict != "fail":
            return 0
        if shift == 1 and len(bounces) > 2 and _is_sum(first, bounces[1]):
            pairs = pairs[1:]  # sums that end one bounce late: the first of them is E + TE
        if len(pairs) >= 2 and all(_is_light_of(b, other) for b, other in pairs):
            return shift
    return 0


def _are_sums(bounces: Sequence[BounceResult]) -> bool:
    """Whether each bounce is the sum of all up to it, of at least two with light."""
    sums = np.cumsum([b.truth_mean for b in bounces])
    noise = np.array([4 * b.standard_error * b.denominator for b in bounces])
    means = np.array([b.mean for b in bounces])
    lit = sum(b.truth_mean > 0 for b in bounces)
    return lit >= 2 and bool((np.abs(means - sums) <= noise + 0.02 * sums).all())


def _is_sum(b: BounceResult, other: BounceResult) -> bool:
    """Whether it has the light of the other one besides its own."""
    noise = 4 * b.standard_error * b.denominator
    both = b.truth_mean + other.truth_mean
    return other.truth_mean > noise and abs(b.mean - both) <= noise + 0.02 * both


def _is_light_of(b: BounceResult, other: BounceResult) -> bool:
    noise = 4 * b.standard_error * b.denominator
    near = abs(b.mean - other.truth_mean) <= noise + 0.02 * other.truth_mean
    return near and abs(b.truth_mean - other.truth_mean) > noise + 0.05 * b.truth_mean


def _dark_from_there_on(lit: Sequence[BounceResult], dark: Sequence[BounceResult]) -> bool:
    """Whether no bounce is dark up to one that is not E, and each one from there on."""
    if not dark or dark[0].bounce == 0:
        return False
    before = [b for b in lit if b.bounce < dark[0].bounce]
    return [*before, *dark] == list(lit) and all(b.verdict != "fail" for b in before)


def _log(b: BounceResult) -> float:
    return float(np.log(max(1 + b.bias, 1e-3)))


def _alike(values: Sequence[float]) -> bool:
    """Whether they are the same but for the noise, and not nothing."""
    mean = float(np.mean(values))
    return (
        len(values) > 1
        and all(abs(v - mean) <= _ALIKE * abs(mean) + 0.002 for v in values)
        and abs(mean) > 0.004
    )


def _percent(b: BounceResult) -> str:
    """How far off it is, with its standard error where that says anything."""
    way = f"too {'bright' if b.bias > 0 else 'dark'}"
    if abs(b.bias) > 10:
        return f"{abs(b.bias):.3g} times {way}"
    error = 100 * b.standard_error
    noise = f" ± {_digits(error, 1)}" if error >= _LEAST_ERROR else ""
    return f"{_digits(100 * abs(b.bias), 2)}{noise} % {way}"


def _digits(value: float, digits: int) -> str:
    """So many of them that count, and zeros: ``210``, not 2.1e+02."""
    return f"{float(f'{value:.{digits}g}'):,.10g}"


def _list(bounces: Sequence[BounceResult]) -> str:
    return ", ".join(str(b.bounce) for b in bounces)
