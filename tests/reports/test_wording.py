"""Numbers and sentences."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest

from comparisons.results import Results
from reports import quantities, wording
from reports.plain import plain


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"),
        (0.12345, "0.1235"),
        (1.2e-7, "1.200×10⁻⁷"),
        (-0.5, "−0.5"),
        (12345.6, "12,346"),
        (2e9, "2.000×10⁹"),
    ],
)
def test_numbers(value: float, text: str) -> None:
    assert quantities.number(value) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.013, "1.3 %"),
        (0, "0 %"),
        (1e-16, "0 %"),
        (-0.04, "−4.0 %"),
        (0.00001, "0.0010 %"),
        (-1e-7, "−1.0×10⁻⁵ %"),
        (25, "2,500 %"),
    ],
)
def test_percentages(value: float, text: str) -> None:
    assert quantities.percent(value) == text


def test_a_bias_has_the_digits_of_its_interval() -> None:
    assert quantities.bias(0.01304, (0.0089, 0.0173)) == "+1.30 ± 0.42 %"
    assert quantities.bias(-0.2, (-0.5, 0.1)) == "−20 ± 30 %"
    assert quantities.bias(-1e-9, (-0.01, 0.01)) == "+0.0 ± 1.0 %"
    assert quantities.interval((-0.004, 0.012)) == "−0.40 to +1.20 %"


@pytest.mark.parametrize(
    ("value", "half", "bias", "interval"),
    [
        (0.0, 0.0, "0 (exact)", "0 to 0 %"),
        (-2e-8, 1e-17, "0 (exact)", "0 to 0 %"),  # as two sides in 32 bits differ
        (0.0037, 0.0, "+0.37 ± 0 %", "+0.37 to +0.37 %"),
        (-3.3e-5, 1e-9, "−0.0033 ± 0 %", "−0.0033 to −0.0033 %"),
        (0.0, 1e-6, "+0.0000 ± 0.0001 %", "−0.0001 to +0.0001 %"),
        (2e-7, 0.003, "+0.00 ± 0.30 %", "−0.30 to +0.30 %"),
    ],
)
def test_without_noise_no_digits_are_made_up(value: float, half: float, bias: str, interval: str) -> None:
    ends = (value - half, value + half)
    assert quantities.bias(value, ends) == bias
    assert quantities.interval(ends) == interval


def test_terms_and_sums() -> None:
    assert [quantities.term(k) for k in (0, 1, 2, 12)] == ["E", "TE", "T²E", "T¹²E"]
    assert [quantities.partial_sum(k) for k in (0, 1, 3)] == ["E", "E + TE", "E + … + T³E"]


@pytest.mark.parametrize(
    ("iso", "text"),
    [
        ("2025-11-03T09:30:00Z", "2025-11-03 09:30 UTC"),
        ("2025-11-03T09:30:00+02:00", "2025-11-03 07:30 UTC"),
        ("yesterday", "yesterday"),
    ],
)
def test_dates(iso: str, text: str) -> None:
    assert quantities.date(iso) == text


@pytest.mark.parametrize(("seconds", "text"), [(4.21, "4.2 s"), (187, "3 min 7 s"), (7800, "2 h 10 min")])
def test_durations(seconds: float, text: str) -> None:
    assert quantities.duration(seconds) == text


def test_plain_text() -> None:
    assert plain("\x1b[1;31mred\x1b[0m\x00\ud800\uffff\tü😀\x1b]0;title\x07.\n") == "red\tü😀.\n"


@pytest.mark.parametrize(
    ("verdicts", "outcome", "sentence"),
    [
        (["pass"], "pass", "The only comparison passed."),
        (["pass", "pass"], "pass", "All 2 comparisons passed."),
        (["pass", "unsupported"], "pass", "1 of 2 comparisons passed; the rest is unsupported."),
        (["pass", "known"], "known", "Nothing failed: 1 passed, 1 with a known deviation."),
        (["unsupported"], "unsupported", "Nothing was compared."),
        ([], "unsupported", "Nothing was compared."),
        (["pass", "inconclusive"], "inconclusive", "1 of 2 comparisons stayed inconclusive."),
        (["error", "fail"], "fail", "1 of 2 comparisons failed, 1 ended in an error."),
    ],
)
def test_outcomes(results: Results, verdicts: list[Any], outcome: str, sentence: str) -> None:
    found = [msgspec.structs.replace(results.comparisons[0], verdict=verdict) for verdict in verdicts]
    assert wording.outcome(found) == (outcome, sentence)
