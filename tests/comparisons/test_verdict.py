"""Verdicts on numbers that were made up: no renderer, so every outcome can be had at will."""

from __future__ import annotations

from functools import partial
from typing import Any

import msgspec
import numpy as np
import pytest

from comparisons.known import Deviation
from comparisons.regions import Regions
from comparisons.results import BounceResult
from comparisons.statistics.intervals import Biases, Range
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
    biases = Biases(
        bias=b,
        error=full(half / 4),
        own=Range(b - half, b + half),
        simultaneous=Range(b - 1.3 * half, b + 1.3 * half),
        resolution=full(1.6 * half),
        p_value=full(0.5),
    )
    measured = Measured(
        bounce=1,
        channels="RGB",
        biases=biases,
        mean=1 + b,
        truth=full(1.0),
        denominator=full(1.0),
        skewness=full(0.0),
        dominance=full(0.1),
        look=1,
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


def test_a_tile_decides_where_the_image_is_undecided() -> None:
    b = np.zeros((17, 3))
    b[0, 1], b[4, 1] = 0.008, 0.2
    found = judged(b, 0.004, None)
    assert found.verdict == "fail"
    assert found.decided_by == "tile"


def test_the_worst_channel_is_shown_and_all_are_listed() -> None:
    found = verdict(0.016, 0.004)
    assert found.channel == "G"
    assert [c.bias for c in found.channels] == pytest.approx([0, 0.016, 0])
    assert found.interval == pytest.approx((0.012, 0.020))


def test_detectable_bias_and_resolution() -> None:
    found = verdict(0.0, 0.004)
    assert found.resolution == pytest.approx(1.6 * 0.004)
    assert found.detectable_bias == pytest.approx(0.01 + found.resolution)
    assert found.worst_tile.detectable_bias == pytest.approx(0.02 + found.resolution)


@pytest.mark.parametrize(("bias", "half"), [(0.0, 0.001), (0.5, 0.001)])
def test_too_few_replicates_decide_nothing(bias: float, half: float) -> None:
    assert verdict(bias, half, enough=False).verdict == "inconclusive"


def everywhere(bias: float, channels: str = "RGB") -> np.ndarray:
    """The same bias in every region of some channels."""
    return np.tile([bias if name in channels else 0.0 for name in "RGB"], (17, 1))


@pytest.mark.parametrize(
    ("measured", "half", "expected", "state"),
    [
        (0.050, 0.001, "known", "confirmed"),
        (0.051, 0.0005, "known", "confirmed"),
        (0.070, 0.001, "fail", "changed"),
        (0.030, 0.001, "fail", "changed"),
        (-0.050, 0.001, "fail", "changed"),
        (0.000, 0.001, "pass", "vanished"),
        (0.052, 0.001, "inconclusive", "undecided"),
        (0.050, 0.010, "inconclusive", "undecided"),
    ],
)
def test_known_deviations(measured: float, half: float, expected: str, state: str) -> None:
    found = judged(everywhere(measured), half, entry(0.05))
    assert found.verdict == expected
    assert found.known is not None
    assert found.known.state == state
    assert found.known.declared_bias == 0.05


def test_a_tolerance_too_loose_to_tell_does_not_make_a_declaration_vanish() -> None:
    found = judged(everywhere(0.009), 0.0005, entry(0.009))
    assert found.verdict == "pass"
    assert found.known is not None
    assert found.known.state == "tolerated"


@pytest.mark.parametrize("tile", [0.0, 0.12, -0.05])
def test_a_tile_that_deviates_otherwise_is_not_covered_by_a_declaration(tile: float) -> None:
    b = everywhere(0.05)
    b[3, 0] = tile
    assert judged(b, 0.0005, entry(0.05)).verdict == "fail"


def test_a_tile_alone_is_no_declared_deviation_of_the_image() -> None:
    b = everywhere(0.0)
    b[3, 0] = 0.05
    assert judged(b, 0.0005, entry(0.05)).verdict == "fail"


def test_a_declaration_covers_its_channels_alone() -> None:
    red = msgspec.structs.replace(entry(0.05), channels=["R"])
    assert judged(everywhere(0.05, "R"), 0.0005, red).verdict == "known"
    assert judged(everywhere(0.05, "RG"), 0.0005, red).verdict == "fail"
    assert judged(everywhere(0.05, "R"), 0.0005, entry(0.05)).verdict == "fail"


def test_channels_that_deviate_differently_are_each_held_against_their_own() -> None:
    each = msgspec.structs.replace(entry(0.05), bias=[[0.05, -0.08]], channels=["R", "B"])
    deviating = np.tile([0.05, 0.0, -0.08], (17, 1))
    found = judged(deviating, 0.0005, each)
    assert found.verdict == "known"
    assert found.known is not None
    assert (found.channel, found.known.declared_bias) == ("B", -0.08)
    assert judged(-deviating, 0.0005, each).verdict == "fail"
    assert judged(deviating[:, [2, 1, 0]], 0.0005, each).verdict == "fail"
    assert judged(everywhere(0.05, "R"), 0.0005, each).verdict == "fail"


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
