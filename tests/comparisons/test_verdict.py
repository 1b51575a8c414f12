"""Verdicts on numbers that were made up: no renderer, so every outcome can be had at will."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from comparisons.known import Deviation
from comparisons.regions import Regions
from comparisons.results import BounceResult
from comparisons.statistics.intervals import Biases
from comparisons.verdict import judge, overall
from scenes import Tolerance

REGIONS = Regions.of(16, 16, (4, 4))
TOLERANCE = Tolerance(image=(0.005, 0.01), tile=(0.02,))


def entry(bias: float, within: float = 0.002) -> Deviation:
    return Deviation(
        case="c",
        renderer="r",
        versions=">=1",
        bounces=[1],
        bias=[bias],
        within=within,
        tile_within=0.02,
        reason="why",
        link="where",
    )


def verdicts(
    bias: float, half: float, *, region: int = 0, known: Deviation | None = None, enough: bool = True
) -> list[BounceResult]:
    """Two bounces of three channels; one region of bounce 1, channel G, is off, or all if region is 0."""
    shape = (17, 2, 3)
    b = np.zeros(shape)
    b[region if region else slice(None), 1, 1] = bias
    intervals = Biases(
        bias=b,
        denominator=np.ones(shape),
        error=np.full(shape, half / 4),
        own=np.full(shape, half),
        simultaneous=np.full(shape, 1.3 * half),
    )
    ones = np.ones(shape)
    return judge(intervals, ones + b, ones, TOLERANCE, REGIONS, {1: known} if known else {}, enough)


@pytest.mark.parametrize(
    ("bias", "half", "expected"),
    [
        (0.0, 0.004, "pass"),
        (0.005, 0.004, "pass"),
        (0.007, 0.004, "inconclusive"),
        (0.012, 0.004, "inconclusive"),  # the own interval is clear of the limit, the simultaneous is not
        (0.016, 0.004, "fail"),
        (-0.016, 0.004, "fail"),
        (0.0, 0.02, "inconclusive"),
    ],
)
def test_whole_image(bias: float, half: float, expected: str) -> None:
    untouched, judged = verdicts(bias, half)
    assert judged.verdict == expected
    assert judged.decided_by == "image"
    assert untouched.verdict == ("pass" if half <= 0.005 else "inconclusive")


@pytest.mark.parametrize(("bias", "expected"), [(0.01, "pass"), (0.019, "inconclusive"), (0.03, "fail")])
def test_a_single_tile_decides(bias: float, expected: str) -> None:
    _, judged = verdicts(bias, 0.004, region=7)
    assert judged.verdict == expected
    assert judged.decided_by == ("image" if expected == "pass" else "tile")
    assert (judged.worst_tile.place.row, judged.worst_tile.place.column) == (1, 2)
    assert judged.worst_tile.channel == "G"
    assert judged.worst_tile.bias == pytest.approx(bias)


def test_the_worst_channel_is_shown_and_all_are_listed() -> None:
    _, judged = verdicts(0.016, 0.004)
    assert judged.channel == "G"
    assert [c.bias for c in judged.channels] == pytest.approx([0, 0.016, 0])
    assert judged.interval == pytest.approx((0.012, 0.020))


def test_detectable_bias_and_resolution() -> None:
    _, judged = verdicts(0.0, 0.004)
    assert judged.resolution == pytest.approx(1.3 * 0.004 + 1.2816 * 0.001, abs=1e-6)
    assert judged.detectable_bias == pytest.approx(0.01 + judged.resolution)
    assert judged.worst_tile.detectable_bias == pytest.approx(0.02 + judged.resolution)


@pytest.mark.parametrize(("bias", "half"), [(0.0, 0.001), (0.5, 0.001)])
def test_too_few_replicates_decide_nothing(bias: float, half: float) -> None:
    assert {b.verdict for b in verdicts(bias, half, enough=False)} == {"inconclusive"}


@pytest.mark.parametrize(
    ("measured", "half", "expected", "state"),
    [
        (0.050, 0.001, "known", "confirmed"),
        (0.051, 0.0005, "known", "confirmed"),
        (0.070, 0.001, "fail", "changed"),
        (0.030, 0.001, "fail", "changed"),
        (0.000, 0.001, "pass", "vanished"),
        (0.052, 0.001, "inconclusive", "undecided"),
        (0.050, 0.010, "inconclusive", "undecided"),
    ],
)
def test_known_deviations(measured: float, half: float, expected: str, state: str) -> None:
    _, judged = verdicts(measured, half, known=entry(0.05))
    assert judged.verdict == expected
    assert judged.known is not None
    assert judged.known.state == state
    assert judged.known.declared_bias == 0.05


def test_a_new_fault_in_a_tile_is_not_covered_by_a_declaration() -> None:
    """The whole image deviates as declared, but one tile by far more."""
    shape = (17, 2, 3)
    b = np.full(shape, 0.05)
    b[:, 0] = 0
    b[3, 1, 0] = 0.12
    small = np.full(shape, 0.0005)
    intervals = Biases(bias=b, denominator=np.ones(shape), error=small / 4, own=small, simultaneous=small)
    _, judged = judge(intervals, 1 + b, np.ones(shape), TOLERANCE, REGIONS, {1: entry(0.05)}, True)
    assert judged.verdict == "fail"


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (["pass", "pass"], "pass"),
        (["pass", "known"], "known"),
        (["pass", "inconclusive", "known"], "inconclusive"),
        (["error", "inconclusive"], "error"),
        (["fail", "error", "pass"], "fail"),
        (["unsupported", "pass"], "pass"),
        (["unsupported"], "unsupported"),
        ([], "unsupported"),
    ],
)
def test_overall(found: list[Any], expected: str) -> None:
    assert overall(found) == expected
