"""Each fault of the estimator changes the bounces it says, and leaves the tracer as it was."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from comparisons.faults import estimator
from comparisons.faults.fault import Fault
from comparisons.renderers import Renderer, create
from scenes import library

BY_NAME = {fault.name: fault for fault in estimator.FAULTS}
BOUNCES = range(4)
CHANGED = {
    "two-heuristics": ("furnace-box", [1, 2, 3]),
    "emission-counted-twice": ("furnace-box", [1, 2, 3]),
    "chance-not-weighted": ("furnace-box", [1, 2, 3]),
    "mirrors-weighted": ("mirror-lamps", [1]),
    "lamps-lost-behind-mirrors": ("mirror-lamps", [1]),
    "weight-per-projected-angle": ("furnace-box", [1, 2, 3]),
    "light-choice-forgotten": ("furnace-box", [1, 2, 3]),
    "light-choice-forgotten-in-weights": ("furnace-box", [1, 2, 3]),
    "light-choice-uniform": ("four-points", [1]),
    "light-choice-outside-of-weights": ("furnace-box", [1, 2, 3]),
    "point-lights-weighted": ("four-points", [1]),
    "next-event-density-doubled": ("furnace-box", [1, 2, 3]),
    "next-event-without-cosine": ("furnace-box", [1, 2, 3]),
    "area-density-without-cosine": ("quad-over-plane", [1]),
    "area-density-without-distance": ("quad-over-plane", [1]),
    "area-density-converted-twice": ("quad-over-plane", [1]),
    "areas-weighed-against-angles": ("quad-over-plane", [1]),
    "sphere-density-from-inside": ("furnace-sphere", [1, 2, 3]),
    "solid-angle-in-sampling-alone": ("furnace-box", [1, 2, 3]),
    "triangle-for-mesh": ("furnace-mesh", [1, 2, 3]),
    "environment-density-without-sine": ("bright-texel", [1]),
}


def images_of(renderer: Renderer, case: str, spp: int = 16, seed: int = 1) -> NDArray[np.float64]:
    return renderer.render(library.case(case).scene.resized(8, 8), BOUNCES, spp, seed)


@pytest.mark.parametrize("fault", estimator.FAULTS, ids=lambda fault: fault.name)
def test_it_changes_the_bounces_it_claims_and_no_others(fault: Fault) -> None:
    case, claimed = CHANGED[fault.name]
    plain = create("reference")
    right, wrong = images_of(plain, case), images_of(fault.plant(plain), case)
    assert [k for k in BOUNCES if not np.array_equal(right[k], wrong[k])] == claimed


@pytest.mark.parametrize("fault", estimator.FAULTS, ids=lambda fault: fault.name)
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
    ("name", "case", "factor"),
    [
        ("light-choice-forgotten", "furnace-box", 1 / 6),  # six emitters of the same power
        ("next-event-density-doubled", "furnace-box", 1 / 2),
        ("triangle-for-mesh", "triangle-over-plane", 1.0),  # a mesh of one triangle
    ],
)
def test_next_event_alone_is_off_by_a_factor(name: str, case: str, factor: float) -> None:
    plain = create("reference:nee")
    right, wrong = images_of(plain, case)[1], images_of(BY_NAME[name].plant(plain), case)[1]
    np.testing.assert_allclose(wrong, factor * right, rtol=1e-12)


@pytest.mark.parametrize("name", ["two-heuristics", "chance-not-weighted", "weight-per-projected-angle"])
def test_a_single_strategy_has_no_weights(name: str) -> None:
    for strategy in ("reference:bsdf", "reference:nee"):
        plain = create(strategy)
        right, wrong = images_of(plain, "furnace-box"), images_of(BY_NAME[name].plant(plain), "furnace-box")
        np.testing.assert_array_equal(right, wrong)


def test_emission_counted_twice_doubles_every_bounce_but_the_first() -> None:
    """Of 4096 walks; three per cent are more than five standard errors."""
    images = images_of(BY_NAME["emission-counted-twice"].plant(create("reference")), "furnace-box", spp=64)
    np.testing.assert_allclose(images.mean(axis=(1, 2, 3)), [1, 1, 1 / 2, 1 / 4], rtol=0.03)


@pytest.mark.parametrize("name", [fault.name for fault in estimator.FAULTS if not fault.unseen])
def test_what_must_be_seen_is_biased(name: str) -> None:
    """By five standard errors of 16 replicates, and by more than 1 %, in the bounce that changes first."""
    case, (k, *_) = CHANGED[name]
    truth = library.case(case).answer.truth(library.case(case).scene.resized(8, 8), k)
    assert truth is not None
    planted, spp = BY_NAME[name].plant(create("reference")), 4 if case == "furnace-mesh" else 32
    found = np.array([images_of(planted, case, spp, 1000 + i)[k].mean() for i in range(16)])
    bias, error = found.mean() - truth.mean[k].mean(), found.std() / np.sqrt(15)
    assert abs(bias) > max(0.01 * truth.mean[k].mean(), 5 * error)


@pytest.mark.parametrize("name", [fault.name for fault in estimator.FAULTS if fault.unseen])
def test_what_is_called_unbiased_is(name: str) -> None:
    """Within four standard errors of 32 replicates, which are 2 % at most."""
    case, claimed = CHANGED[name]
    truth = library.case(case).answer.truth(library.case(case).scene.resized(8, 8), 3)
    assert truth is not None
    planted = BY_NAME[name].plant(create("reference"))
    found = np.array([images_of(planted, case, 32, i).mean(axis=(1, 2, 3)) for i in range(32)])
    error = found.std(axis=0) / np.sqrt(31)
    expected = truth.mean.mean(axis=(1, 2, 3))
    for k in claimed:
        assert 4 * error[k] < 0.02 * expected[k]
        assert abs(found[:, k].mean() - expected[k]) < 4 * error[k]
