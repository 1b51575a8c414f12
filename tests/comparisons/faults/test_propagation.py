"""Faults of G change what rays find from the bounce on in which they go astray."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from comparisons.faults import Fault
from comparisons.faults.propagation import FAULTS
from scenes import library

CASES = {
    "ray-offset-large": ("furnace-tiny", [1, 2, 3]),
    "ray-offset-outward": ("glass-ball", [2, 3]),
    "ray-offset-missing": ("furnace-box", [1, 2, 3]),
    "shadow-offset-missing": ("quad-over-plane", [1]),
    "near-hits-skipped": ("furnace-tiny", [0, 1, 2, 3]),
    "farthest-hit": ("directional-on-sphere", [1]),
    "backs-culled": ("wall-behind-a-shelf", [2]),
    "one-ray-in-200-lost": ("furnace-box", [1, 2, 3]),
    "sphere-far-root": ("directional-on-sphere", [1]),
    "sphere-distance-before-scaling": ("furnace-channels", [1, 2, 3]),
    "normals-scaled-as-directions": ("ellipsoid-over-plane", [1]),
    "shading-normal-for-geometric": ("shading-normals-from-behind", [1]),
    "quads-met-in-their-bounding-disk": ("furnace-cornell", [0, 1, 2, 3]),
    "second-triangle-lost": ("furnace-mirrors", [0, 1, 2, 3]),
    "gaps-between-triangles": ("furnace-mesh", [0, 1, 2, 3]),
    "hierarchy-loses-a-child": ("furnace-mesh", [0, 1, 2, 3]),
    "shadows-of-half-the-scene": ("furnace-cornell", [1, 2, 3]),
    "meshes-cast-no-shadow": ("furnace-mesh", [1, 2, 3]),
    "spheres-cast-no-shadow": ("furnace-channels", [1, 2, 3]),
    "disks-cast-no-shadow": ("disk-shadow", [1]),
    "quads-cast-no-shadow": ("screened-lamp", [1]),
    "shadow-rays-short": ("furnace-cornell", [1, 2, 3]),
    "shadow-rays-of-length-1": ("furnace-huge", [1, 2, 3]),
    "shadow-rays-beyond-the-light": ("point-in-sphere", [1, 2, 3]),
    "sun-shadows-end": ("cie-171-opening", [1]),
    "environment-unseen": ("furnace-convex", [0, 1]),
}
"""A case that shows the fault, and the bounces that it changes there, up to the third."""


@pytest.mark.parametrize(
    "fault", [fault for fault in FAULTS if not fault.unseen], ids=lambda fault: fault.name
)
def test_changes_what_it_says(fault: Fault, changed: Callable[..., list[int]]) -> None:
    name, bounces = CASES[fault.name]
    case = library.case(name)
    assert changed(fault, case.scene.resized(8, 8), min(case.bounces, 3)) == bounces
