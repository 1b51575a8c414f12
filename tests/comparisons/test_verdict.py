"""Verdicts on numbers that were made up: no renderer, so every outcome can be had at will."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest

from comparisons.known import Deviation
from comparisons.regions import Regions
from comparisons.results import BounceResult
from comparisons.statistics.intervals import Biases
from comparisons.verdict import Measured, judge, overall
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


def verdict(
    bias: float, half: float, *, region: int = 0, known: Deviation | None = None, enough: bool = True
) -> BounceResult:
    """Bounce 1 of three channels; one tile is off in channel G, or all regions if region is 0."""
    b = np.zeros((17, 3))
    b[region if region else slice(None), 1] = bias
    return judged(b, half, known, enough)


def judged(b: np.ndarray, half: float, known: Deviation | None, enough: bool = True) -> BounceResult:
    full = partial(np.full, b.shape)
    biases = Biases(bias=b, error=full(half / 4), own=full(half), simultaneous=full(1.3 * half))
    measured = Measured(
        bounce=1,
        biases=biases,
        mean=1 + b,
        truth=full(1.0),
        denominator=full(1.0),
        replicates=32,
        spp=64,
        enough=enough,
    )
    return judge(measured, TOLERANCE, REGIONS, known)


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
    found = verdict(bias, half)
    assert found.verdict == expected
    assert found.decided_by == "image"


@pytest.mark.parametrize(("bias", "expected"), [(0.01, "pass"), (0.019, "inconclusive"), (0.03, "fail")])
def test_a_single_tile_decides(bias: float, expected: str) -> None:
    found = verdict(bias, 0.004, region=7)
    assert found.verdict == expected
    assert found.decided_by == ("image" if expected == "pass" else "tile")
    assert (found.worst_tile.place.row, found.worst_tile.place.column) == (1, 2)
    assert found.worst_tile.channel == "G"
    assert found.worst_tile.bias == pytest.approx(bias)


def test_the_worst_channel_is_shown_and_all_are_listed() -> None:
    found = verdict(0.016, 0.004)
    assert found.channel == "G"
    assert [c.bias for c in found.channels] == pytest.approx([0, 0.016, 0])
    assert found.interval == pytest.approx((0.012, 0.020))


def test_detectable_bias_and_resolution() -> None:
    found = verdict(0.0, 0.004)
    assert found.resolution == pytest.approx(1.3 * 0.004 + 1.2816 * 0.001, abs=1e-6)
    assert found.detectable_bias == pytest.approx(0.01 + found.resolution)
    assert found.worst_tile.detectable_bias == pytest.approx(0.02 + found.resolution)


@pytest.mark.parametrize(("bias", "half"), [(0.0, 0.001), (0.5, 0.001)])
def test_too_few_replicates_decide_nothing(bias: float, half: float) -> None:
    assert verdict(bias, half, enough=False).verdict == "inconclusive"


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
    found = verdict(measured, half, known=entry(0.05))
    assert found.verdict == expected
    assert found.known is not None
    assert found.known.state == state
    assert found.known.declared_bias == 0.05


def test_a_new_fault_in_a_tile_is_not_covered_by_a_declaration() -> None:
    """The whole image deviates as declared, but one tile by far more."""
    b = np.full((17, 3), 0.05)
    assert judged(b, 0.0005, entry(0.05)).verdict == "known"
    b[3, 0] = 0.12
    assert judged(b, 0.0005, entry(0.05)).verdict == "fail"


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
