"""Each fault of the series changes the bounces it says, by as much, and leaves the tracer as it was."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from comparisons.faults import series
from comparisons.faults.fault import Fault
from comparisons.renderers import Renderer, create
from scenes import library

BY_NAME = {fault.name: fault for fault in series.FAULTS}
BOUNCES = range(7)
CHANGED = {
    "depth-counted-from-one": ("furnace-box", [0, 1, 2, 3, 4, 5, 6]),
    "one-bounce-too-many": ("furnace-box", [0, 1, 2, 3, 4, 5, 6]),
    "one-bounce-too-few": ("furnace-box", [0, 1, 2, 3, 4, 5, 6]),
    "sums-for-terms": ("furnace-box", [1, 2, 3, 4, 5, 6]),
    "last-bounce-lost": ("furnace-box", [6]),
    "last-ray-not-traced": ("furnace-box", [6]),
    "roulette-not-reweighted": ("furnace-box", [3, 4, 5, 6]),
    "roulette-by-another-channel": ("furnace-channels", [3, 4, 5, 6]),
    "roulette-takes-direct-light": ("furnace-box", [3, 4, 5, 6]),
    "throughput-not-updated": ("furnace-box", [2, 3, 4, 5, 6]),
    "throughput-clamped-to-one": (
        "inside-glass",
        [1, 2, 3, 4, 6],
    ),  # nothing is found in bounce 5, with this seed
    "throughput-loses-half-a-percent": ("furnace-box", [4, 5, 6]),
    "bounce-counted-twice": ("furnace-box", [2]),
    "third-bounce-low": ("furnace-box", [3]),
    "late-bounces-low": ("furnace-box", [4, 5, 6]),
    "late-bounces-very-little-low": ("furnace-box", [4, 5, 6]),
    "direct-light-only": ("furnace-box", [2, 3, 4, 5, 6]),
}


def images_of(renderer: Renderer, case: str, spp: int = 16) -> NDArray[np.float64]:
    return renderer.render(library.case(case).scene.resized(8, 8), BOUNCES, spp, 1)


@pytest.mark.parametrize("fault", series.FAULTS, ids=lambda fault: fault.name)
def test_it_changes_the_bounces_it_claims_and_no_others(fault: Fault) -> None:
    case, claimed = CHANGED[fault.name]
    plain = create("reference")
    right, wrong = images_of(plain, case), images_of(fault.plant(plain), case)
    assert [k for k in BOUNCES if not np.array_equal(right[k], wrong[k])] == claimed


@pytest.mark.parametrize("fault", series.FAULTS, ids=lambda fault: fault.name)
def test_the_tracer_is_left_as_it_was(fault: Fault) -> None:
    case, _ = CHANGED[fault.name]
    plain = create("reference")
    before, planted = images_of(plain, case), fault.plant(plain)
    images_of(planted, case)
    np.testing.assert_array_equal(images_of(plain, case), before)
    with pytest.raises(ValueError, match="spp"):
        images_of(planted, case, spp=0)
    np.testing.assert_array_equal(images_of(plain, case), before)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("depth-counted-from-one", [1 / 2, 1 / 4, 1 / 8, 1 / 16, 1 / 32, 1 / 64, 1 / 128]),
        ("one-bounce-too-many", [3 / 2, 1 / 4, 1 / 8, 1 / 16, 1 / 32, 1 / 64, 1 / 128]),
        ("one-bounce-too-few", [0, 1, 1 / 2, 1 / 4, 1 / 8, 1 / 16, 1 / 32]),
        ("sums-for-terms", [1, 3 / 2, 7 / 4, 15 / 8, 31 / 16, 63 / 32, 127 / 64]),
        ("last-bounce-lost", [1, 1 / 2, 1 / 4, 1 / 8, 1 / 16, 1 / 32, 0]),
        ("last-ray-not-traced", [1, 1 / 2, 1 / 4, 1 / 8, 1 / 16, 1 / 32, 0]),
        ("throughput-not-updated", [1, 1 / 2, 1 / 2, 1 / 2, 1 / 2, 1 / 2, 1 / 2]),
        (
            "throughput-loses-half-a-percent",
            [1, 1 / 2, 1 / 4, 1 / 8] + [0.995**i / 2 ** (i + 3) for i in (1, 2, 3)],
        ),
        ("bounce-counted-twice", [1, 1 / 2, 1 / 2, 1 / 8, 1 / 16, 1 / 32, 1 / 64]),
        ("third-bounce-low", [1, 1 / 2, 1 / 4, 0.99 / 8, 1 / 16, 1 / 32, 1 / 64]),
        ("direct-light-only", [1, 1 / 2, 0, 0, 0, 0, 0]),
    ],
)
def test_what_becomes_of_a_furnace(name: str, expected: list[float]) -> None:
    """Emission 1 and albedo 1/2: found by chance, every walk is worth exactly TᵏE = 1/2ᵏ."""
    images = images_of(BY_NAME[name].plant(create("reference:bsdf")), "furnace-box", spp=1)
    np.testing.assert_allclose(images, np.reshape(expected, (-1, 1, 1, 1)) * np.ones_like(images), rtol=1e-12)


def test_roulette_that_does_not_reweight_keeps_half_of_every_late_bounce() -> None:
    """Walks go on with the albedo 1/2; of 16384 walks, 2048 reach bounce 5: five standard errors are 11 %."""
    images = images_of(BY_NAME["roulette-not-reweighted"].plant(create("reference:bsdf")), "furnace-box", 256)
    np.testing.assert_allclose(
        images.mean(axis=(1, 2, 3)) * 2.0 ** np.arange(7), [1, 1, 1, 1 / 2, 1 / 4, 1 / 8, 1 / 16], rtol=0.15
    )


def test_the_fifth_of_direct_light_that_roulette_takes() -> None:
    """By next event alone bounces from 3 on lose it, and the walks that go on lose nothing."""
    planted = BY_NAME["roulette-takes-direct-light"].plant(create("reference:nee"))
    ratio = images_of(planted, "furnace-box", 256).mean(axis=(1, 2, 3)) * 2.0 ** np.arange(7)
    np.testing.assert_allclose(ratio[1:6], [1, 1, 0.8, 0.8, 0.8], atol=0.05)
