"""Faults of G change what rays find from the bounce on in which they go astray."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from comparisons.faults import Fault
from comparisons.faults.propagation import FAULTS
from scenes import DirectionalLight, Lambertian, Mesh, Pinhole, Scene, Surface, library

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
    "quads-met-in-their-bounding-disk": ("furnace-cornell", [0, 1, 2, 3]),
    "second-triangle-lost": ("furnace-mirrors", [0, 1, 2, 3]),
    "gaps-between-triangles": ("furnace-mesh", [0, 1, 2, 3]),
    "hierarchy-loses-a-child": ("furnace-mesh", [0, 1, 2, 3]),
    "shadows-of-half-the-scene": ("furnace-cornell", [1, 2, 3]),
    "meshes-cast-no-shadow": ("furnace-mesh", [1, 2, 3]),
    "spheres-cast-no-shadow": ("furnace-channels", [1, 2, 3]),
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


def test_interpolated_normals_decide_the_side(changed: Callable[..., list[int]]) -> None:
    """Light from 10° below a triangle, whose normals at the vertices lean 30° towards it: black, as it should be."""
    [fault] = [fault for fault in FAULTS if fault.name == "shading-normal-for-geometric"]
    lean = (math.sin(math.radians(30)), 0.0, math.cos(math.radians(30)))
    mesh = Mesh(((-9.0, -9.0, 0.0), (9.0, -9.0, 0.0), (0.0, 9.0, 0.0)), ((0, 1, 2),), normals=(lean,) * 3)
    below = (-math.cos(math.radians(10)), 0.0, math.sin(math.radians(10)))
    scene = Scene(
        (Surface("floor", mesh, Lambertian((0.5,))),),
        Pinhole(
            origin=(0.0, 0.0, 2.0), target=(0.0, 0.0, 0.0), up=(0.0, 1.0, 0.0), fov=30.0, width=4, height=4
        ),
        (DirectionalLight(below, (1.0,)),),
    )
    assert changed(fault, scene, 1) == [1]
