"""Numbers as people read them: percentages with as many digits as their interval supports, names of terms."""

from __future__ import annotations

import math
from datetime import UTC, datetime

from comparisons.results import Comparison, Interval, TotalResult

EXACT = "0 (exact)"
"""A bias that has neither size nor noise."""

_ROUNDING = 5e-7  # relative; in images of 32 bits, and at the four decimals of a percentage, less is rounding
_NOTHING = 1e-12  # relative; less is rounding even in 64 bits
_FRACTIONS = {0.25: "¼", 0.5: "½", 0.75: "¾"}
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def percent(value: float) -> str:
    """A relative size as ``1.3 %``: two digits, no sign but a minus; ``0 %`` where there is only rounding."""
    if abs(value) < _NOTHING:
        return "0 %"
    if abs(value) < _ROUNDING:
        return f"{_scientific(100 * value, 1)} %"
    return f"{_fixed(100 * value, _decimals(100 * value))} %"


def bias(value: float, interval: Interval) -> str:
    """A relative bias and half the width of its interval, ``+1.30 ± 0.41 %``.

    Without noise it is ``+1.3 ± 0 %``, and ``0 (exact)`` if there is no bias either.
    """
    half = (interval[1] - interval[0]) / 2
    if half >= _ROUNDING:
        digits = _decimals(100 * half)
        return f"{_fixed(100 * value, digits, '+')} ± {_fixed(100 * half, digits)} %"
    if abs(value) < _ROUNDING:
        return EXACT
    return f"{_fixed(100 * value, _decimals(100 * value), '+')} ± 0 %"


def interval(value: Interval) -> str:
    """A relative interval, ``+0.9 to +1.7 %``."""
    half, largest = (value[1] - value[0]) / 2, max(map(abs, value))
    if largest < _ROUNDING:
        return "0 to 0 %"
    digits = _decimals(100 * (half if half >= _ROUNDING else largest))
    return f"{_fixed(100 * value[0], digits, '+')} to {_fixed(100 * value[1], digits, '+')} %"


def number(value: float) -> str:
    """Any number with four digits: ``0.1235``, ``1.2×10⁻⁷``."""
    if value == 0 or 1e-4 <= abs(value) < 1e6:
        return f"{value:.4g}".replace("-", "−") if abs(value) < 1e4 else _fixed(value, 0)
    return _scientific(value, 3)


def decimal_label(mantissa: int, exponent: int) -> str:
    """The label of a tick at mantissa × 10^exponent: ``0.02``, ``10⁻⁷``, ``5×10⁶``."""
    if -3 <= exponent <= 3:
        return f"{mantissa * 10.0**exponent:g}"
    power = f"10{str(exponent).translate(_SUPERSCRIPTS)}"
    return power if mantissa == 1 else f"{mantissa}×{power}"


def duration(seconds: float) -> str:
    """A time span: ``4.2 s``, ``3 min 5 s``, ``2 h 10 min``."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


def date(iso: str) -> str:
    """An ISO 8601 date in UTC, ``2025-11-03 09:30 UTC``; any other text as it is."""
    try:
        return f"{datetime.fromisoformat(iso).astimezone(UTC):%Y-%m-%d %H:%M} UTC"
    except ValueError:
        return iso


def term(bounce: int) -> str:
    """The term of the Neumann series: ``E``, ``TE``, ``T²E``."""
    return "E" if bounce == 0 else f"T{'' if bounce == 1 else str(bounce).translate(_SUPERSCRIPTS)}E"


def partial_sum(bounces: int) -> str:
    """The sum up to a bounce: ``E``, ``E + TE``, ``E + … + T²E``."""
    return ["E", "E + TE"][bounces] if bounces < 2 else f"E + … + {term(bounces)}"


def is_sum(comparison: Comparison) -> bool:
    """Whether its only entry is the sum of all bounces, of a finished image."""
    return comparison.single_image is not None and comparison.single_image.summed


def image_name(comparison: Comparison, bounce: int) -> str:
    """What an entry is about: a term of the series, or their sum."""
    return partial_sum(bounce) if is_sum(comparison) else term(bounce)


def total_name(total: TotalResult) -> str:
    """What a row of the total is called: ``total``, or of a darker scene ``total (albedo × ½)``."""
    if total.scale == 1:
        return "total"
    return f"total (albedo × {_FRACTIONS.get(total.scale, f'{total.scale:g}')})"


def _decimals(value: float) -> int:
    """How many decimals show two digits of the value, at most four."""
    return min(max(1 - math.floor(math.log10(abs(value))), 0), 4)


def _scientific(value: float, decimals: int) -> str:
    mantissa, exponent = f"{value:.{decimals}e}".split("e")
    return f"{mantissa}×10{str(int(exponent)).translate(_SUPERSCRIPTS)}".replace("-", "−")


def _fixed(value: float, decimals: int, sign: str = "-") -> str:
    """Fixed point, thousands grouped, a real minus sign, and never a negative zero."""
    return f"{value:{sign}z,.{decimals}f}".replace("-", "−")
