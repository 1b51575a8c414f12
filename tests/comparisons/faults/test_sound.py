"""Every sound variant is another renderer than the plain tracer, and has the same mean.

Means of 32 replicates with fixed seeds are held against the exact answer of a case on which it differs: whole image
and quarters, in each channel, which are 3000 means at most over all variants. With 31 degrees of freedom one of so
many lies beyond 6.5 standard errors by chance in a thousand such tests. A deviation of 5 % of the whole image would.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from comparisons.faults import FAULTS, SOUND_VARIANTS
from comparisons.faults.fault import Sound
from comparisons.faults.sound import VARIANTS
from comparisons.regions import Regions
from comparisons.renderers import Renderer, create
from scenes import Scene, library

Array = NDArray[np.float64]

REPLICATES, LIMIT, POWER = 32, 6.5, 0.05
SPP = {"four-points": 256, "disk-over-plane": 32, "furnace-mesh": 2}
"""Where eight are too noisy, or too many."""

SHOWN_BY = {
    "disks-turned": "disk-over-plane",
    "spheres-as-ellipsoids": "sphere-over-plane",
    "point-lights-in-two": "four-points",
    "lights-chosen-alike": "four-points",
    "lights-chosen-by-root-of-power": "four-points",
    "lights-chosen-anyhow": "four-points",
    "roulette": "furnace-box",
    "quads-by-area": "furnace-box",
    "no-boxes": "furnace-box",
    "small-leaves": "furnace-mesh",
    "parts-in-reverse-order": "furnace-box",
}
MANY = ("small-blocks", "large-blocks", "blocks-in-reverse-order")
"""They differ where there is more than one block."""
THE_SAME = ("everything-occludes",)
"""More is asked, and the answers are the same."""


def case_of(variant: Sound) -> str:
    return SHOWN_BY.get(variant.name, "quad-over-plane")


def scene_of(case: str, size: int = 8) -> Scene:
    return library.case(case).scene.resized(size, size)


@pytest.mark.parametrize("variant", VARIANTS, ids=lambda variant: variant.name)
def test_it_differs_from_the_plain_tracer(variant: Sound) -> None:
    plain = create("reference")
    scene, spp = scene_of(case_of(variant)), 700 if variant.name in MANY else 16
    right, other = (r.render(scene, range(5), spp, 4) for r in (plain, variant.plant(plain)))
    assert right.shape == other.shape
    assert np.array_equal(right, other) == (variant.name in THE_SAME)
    np.testing.assert_array_equal(plain.render(scene, range(5), spp, 4), right)  # it is left as it was


def deviations(renderer: Renderer, case: str) -> tuple[Array, Array]:
    """Of the means from the answer in standard errors, and these, relative, for the whole image."""
    scene, bounces = scene_of(case), range(4) if case == "furnace-box" else [1]
    truth = library.case(case).answer.truth(scene, max(bounces))
    assert truth is not None
    regions = Regions.of(*scene.shape[:2], (2, 2))
    found = np.array(
        [regions.means(renderer.render(scene, bounces, SPP.get(case, 8), 500 + i)) for i in range(REPLICATES)]
    )
    expected = regions.means(truth.mean[list(bounces)])
    # 0.1 % for half precision, and for what has no noise at all
    error = found.std(axis=0, ddof=1) / np.sqrt(REPLICATES) + 1e-3 * expected[0]
    return np.abs(found.mean(axis=0) - expected) / error, error[0] / expected[0]


NOISY = ("chance-alone", "strategies-in-turn")
"""Their power is less: the lamp is seldom found by chance."""


@pytest.mark.parametrize("variant", VARIANTS, ids=lambda variant: variant.name)
def test_it_has_the_right_mean(variant: Sound) -> None:
    off, error = deviations(variant.plant(create("reference")), case_of(variant))
    assert off.max() < LIMIT
    assert LIMIT * error.max() < (POWER if variant.name not in NOISY else 10 * POWER)


@pytest.mark.parametrize("name", ["next-event-density-doubled", "two-heuristics", "last-bounce-lost"])
def test_a_fault_would_have_been_seen(name: str) -> None:
    assert deviations(FAULTS[name].plant(create("reference")), "furnace-box")[0].max() > LIMIT


def test_there_are_enough_of_them() -> None:
    assert len(SOUND_VARIANTS) == len(VARIANTS) >= 32
