"""Faults of E change the bounces that the light they are about takes part in, and no other."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from comparisons.faults import Fault
from comparisons.faults.emission import FAULTS
from scenes import library

CASES = {
    "lamps-invisible": ("furnace-box", [0]),
    "emission-high": ("furnace-box", [0, 1, 2, 3]),
    "emission-slightly-low": ("furnace-box", [0, 1, 2, 3]),
    "emission-of-last-channel-low": ("furnace-channels", [0, 1, 2, 3]),
    "radiance-taken-for-exitance": ("furnace-box", [0, 1, 2, 3]),
    "lamps-emit-behind": ("cornell-box", [1, 2, 3]),
    "lamps-emit-by-the-cosine": ("quad-over-plane", [1]),
    "lamp-profile-ignored": ("constant-radiance-mirror", [0, 1, 2, 3]),
    "disk-area-before-scaling": ("moved-disk", [1]),
    "disk-area-by-the-scale": ("moved-disk", [1]),
    "disk-area-of-one-radius": ("elliptical-disk-over-plane", [1]),
    "ellipsoid-density-before-scaling": ("ellipsoid-over-plane", [1]),
    "environment-half-texel-off": ("bright-texel", [1]),
    "environment-mirrored": ("snells-window", [1]),
    "environment-clamped-at-1": ("bright-texel", [1]),
    "infinite-lights-missed": ("harmonics-on-sphere", [1]),
    "point-intensity-taken-for-power": ("point-over-plane", [1]),
    "point-falls-with-distance": ("point-over-plane", [1]),
    "spot-linear-in-cosine": ("spot-falloff", [1]),
    "spot-smooth": ("spot-falloff", [1]),
    "spot-half-as-wide": ("spot-falloff", [1]),
    "sun-with-two-cosines": ("directional-on-sphere", [1]),
}
"""A case that shows the fault, and the bounces that it changes there, up to the third."""


@pytest.mark.parametrize(
    "fault", [fault for fault in FAULTS if not fault.unseen], ids=lambda fault: fault.name
)
def test_changes_what_it_says(fault: Fault, changed: Callable[..., list[int]]) -> None:
    name, bounces = CASES[fault.name]
    case = library.case(name)
    assert changed(fault, case.scene.resized(8, 8), min(case.bounces, 3)) == bounces
