"""Faults that change scene, request or image are planted in any renderer: here in a real Mitsuba."""

from __future__ import annotations

import pytest

from comparisons import campaign
from comparisons.faults import FAULTS
from comparisons.faults.planting import Named
from comparisons.faults.suite import case
from comparisons.renderers import Renderer, create
from comparisons.results import Comparison
from comparisons.settings import Settings, Silent

CASE = "quad-over-plane"
"""One that Mitsuba is right in."""


def compared(renderer: Renderer) -> Comparison:
    [comparison] = campaign.run([case(CASE)], [renderer], Settings(budget=6.0, total=False), None, Silent())
    return comparison


@pytest.fixture(scope="module")
def mitsuba() -> Renderer:
    return create("mitsuba")


def test_it_passes_as_it_is(mitsuba: Renderer) -> None:
    assert compared(Named(mitsuba, "as-it-is")).verdict == "pass"


@pytest.mark.parametrize(
    "name",
    ["emission-high", "exposure-too-high", "image-upside-down", "one-bounce-too-few", "sums-for-terms"],
)
def test_it_fails_with_a_fault(mitsuba: Renderer, name: str) -> None:
    found = compared(Named(FAULTS[name].plant(mitsuba), name))
    assert found.verdict == "fail", found.message
