"""Faults of R leave E as it is and change the bounces after the first of their kind."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from comparisons.faults import Fault
from comparisons.faults.reflection import FAULTS
from scenes import library

CASES = {
    "lambertian-without-pi": ("furnace-box", [1, 2, 3]),
    "cosine-missing": ("quad-over-plane", [1]),
    "cosine-squared": ("furnace-box", [1, 2, 3]),
    "cosine-of-wo": ("quad-over-plane", [1]),
    "cosine-clamped": ("furnace-box", [1, 2, 3]),
    "albedo-gamma-encoded": ("furnace-box", [1, 2, 3]),
    "albedo-gamma-decoded": ("furnace-box", [1, 2, 3]),
    "albedo-of-next-channel": ("furnace-channels", [1, 2, 3]),
    "albedo-of-first-channel-high": ("furnace-channels", [1, 2, 3]),
    "albedo-slightly-low": ("furnace-box", [1, 2, 3]),
    "albedo-in-8-bits": ("furnace-box", [1, 2, 3]),
    "late-reflections-low": ("furnace-box", [3]),
    "texture-upside-down": ("sphere-zones", [1, 2, 3]),
    "texture-blurred": ("sphere-zones", [1, 2, 3]),
    "surfaces-reflect-behind": ("lit-from-behind", [1]),
    "mirror-reflectance-twice": ("two-mirrors", [1, 2, 3]),
    "blend-weights-swapped": ("blend-sky", [1]),
    "blend-density-of-one-lobe": ("furnace-blend", [1, 2, 3]),
    "blend-value-of-one-lobe": ("blend-sun", [1]),
    "fresnel-swapped": ("glass-ball", [1, 2, 3]),
    "indices-swapped": ("glass-ball", [1, 2, 3]),
    "fresnel-of-one-polarisation": ("glass-slab", [1, 2, 3]),
    "schlick-for-glass": ("cie-171-glass", [2]),
    "schlick-for-metal": ("metal-angles", [1]),
    "metal-of-large-index": ("metal-angles", [1]),
    "metal-without-absorption": ("metal-angles", [1]),
    "eta-squared-missing": ("lamp-under-water", [1]),
    "total-reflection-missed": ("snells-window", [1]),
    "rough-eta-squared-missing": ("rough-glass-tank", [1]),
    "rough-glass-jacobian": ("rough-glass-sun", [1]),
    "alpha-is-roughness": ("rough-metal-sky", [1]),
    "alpha-squared-twice": ("rough-metal-sun", [1]),
    "ggx-without-4": ("rough-metal-sky", [1]),
    "ggx-density-of-facets": ("rough-metal-sky", [1]),
    "ggx-jacobian-of-the-normal": ("rough-metal-sky", [1]),
    "ggx-denominator-clamped": ("rough-metal-sky", [1]),
    "ggx-without-shadowing": ("rough-metal-sky", [1]),
    "ggx-other-shadowing": ("rough-metal-sky", [1]),
}
"""A case that shows the fault, and the bounces that it changes there, up to the third."""


@pytest.mark.parametrize(
    "fault", [fault for fault in FAULTS if not fault.unseen], ids=lambda fault: fault.name
)
def test_changes_what_it_says(fault: Fault, changed: Callable[..., list[int]]) -> None:
    name, bounces = CASES[fault.name]
    case = library.case(name)
    assert changed(fault, case.scene.resized(8, 8), min(case.bounces, 3)) == bounces
