"""The truth of the whole sum: against closed sums, longer series, and another method; and how far it is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from comparisons.renderers.reference import ReferenceRenderer
from comparisons.whole_sum import LEAST, NEGLIGIBLE, Series
from scenes import Case, Formula, Scene, Truth, library
from scenes.tail import tail_bound

FORMULAS = (
    "furnace-box",
    "furnace-cornell",
    "furnace-channels",
    "furnace-bright",
    "integrating-sphere",
    "sphere-flat-port",
    "sphere-zones",
    "dome-on-mirror",
    "point-in-sphere",
    "two-mirrors",
    "glass-ball",
    "inside-glass",
)


def small(name: str, size: int = 16) -> Case:
    case = library.case(name)
    return replace(case, scene=case.scene.resized(size, size))


def truth(case: Case) -> Truth:
    found = case.answer.truth(case.scene, case.bounces)
    assert found is not None
    return found


def series(case: Case) -> Series:
    return Series.of(case, truth(case))


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("furnace-box", (2.0, 2.0, 2.0)),  # 1 / (1 − ρ)
        ("furnace-channels", (10.0, 4.0, 0.625)),
        ("furnace-bright", (20.0, 20.0, 10 / 3)),
        ("glass-ball", (3.0, 1.0, 2.0)),  # a lossless ball in a constant sky can't be seen
        ("constant-radiance-mirror", (1.0, 2.0, 3.0)),
        ("constant-radiance-rough", (1.0, 2.0, 3.0)),
    ],
)
def test_closed_sums_lie_between_the_mean_and_the_tail(name: str, expected: tuple[float, ...]) -> None:
    whole = series(small(name)).total()
    off = np.asarray(expected) - whole.mean
    assert (off >= -2e-5 * np.asarray(expected)).all()
    assert (off <= whole.tail + 2e-5 * np.asarray(expected)).all()
    # a tail so long that it held anything would prove nothing
    assert (whole.tail <= 5 * NEGLIGIBLE * np.asarray(expected)).all()


@pytest.mark.parametrize("name", FORMULAS)
def test_longer_series_lie_there_too(name: str) -> None:
    case = small(name)
    found = series(case)
    assert isinstance(case.answer, Formula)
    longer = case.answer.truth(case.scene, 4 * len(found.terms)).mean.sum(axis=0)
    whole = found.total()
    regions = (
        longer.reshape(4, 4, 4, 4, -1).mean(axis=(1, 3)),
        whole.mean.reshape(4, 4, 4, 4, -1).mean(axis=(1, 3)),
    )
    off = regions[0] - regions[1]
    assert (off >= -1e-12).all()
    assert (off <= whole.tail.max(axis=(0, 1)) + 1e-12).all()


@pytest.mark.parametrize("scale", [0.0, 0.25, 0.5, 0.75, 1.0])
@pytest.mark.parametrize("name", ["furnace-channels", "furnace-mirrors"])
def test_darker_furnaces_are_geometric_series_too(name: str, scale: float) -> None:
    """From TE on, each bounce is ρ times the one before it: E + s TE / (1 − s ρ)."""
    case = small(name, 4)
    E, TE, T2E = truth(case).mean[:3]
    expected = E + scale * TE / (1 - scale * T2E / TE)
    whole = series(case).total(scale)
    np.testing.assert_allclose(whole.mean, expected, rtol=1e-4)
    if scale == 0:
        np.testing.assert_array_equal(whole.mean, E)
        assert not whole.tail.any()


def test_an_answer_that_ends_is_bounded_by_its_albedos() -> None:
    case = small("wall-by-reflection")
    found = series(case)
    np.testing.assert_array_equal(found.bound, tail_bound(case.scene, 3))
    assert "all that its answer has" in found.how
    # with albedos a tenth of that, three bounces are nearly everything
    tail = found.total(0.1).tail
    np.testing.assert_allclose(tail, np.broadcast_to(1e-4 * found.bound, tail.shape))


def test_an_answer_that_has_died_away_before_its_end_needs_no_bound() -> None:
    case = small("glass-slab")
    assert np.isinf(tail_bound(case.scene, 12)).all()
    assert np.isfinite(series(case).bound).all()


def test_light_that_comes_late_is_waited_for() -> None:
    """Five dark bounces between two bright ones are not the end."""

    def evaluate(scene: Scene, bounces: int) -> np.ndarray:
        terms = np.zeros((bounces + 1, *scene.shape))
        for k in range(bounces + 1):
            terms[k] = 1.0 if k in (0, 6) else 0.0
        return terms

    case = replace(small("furnace-box"), answer=Formula(evaluate, "made up"), bounces=2)
    np.testing.assert_array_equal(series(case).total().mean, np.full(case.scene.shape, 2.0))
    assert LEAST >= 12


def test_a_formula_that_can_not_go_on_is_bounded_by_its_albedos() -> None:
    def evaluate(scene: Scene, bounces: int) -> np.ndarray:
        if bounces > 5:
            raise IndexError("a table of six")
        return np.ones((bounces + 1, *scene.shape))

    case = replace(small("furnace-box", 4), answer=Formula(evaluate, "made up"))
    found = series(case)
    assert len(found.terms) == 6
    assert "IndexError: a table of six" in found.how
    np.testing.assert_array_equal(found.bound, tail_bound(case.scene, 5))


def test_a_series_that_does_not_die_away_has_no_sum() -> None:
    def evaluate(scene: Scene, bounces: int) -> np.ndarray:
        return np.ones((bounces + 1, *scene.shape))

    surface = library.case("constant-radiance-mirror")
    case = replace(surface, scene=surface.scene.resized(2, 2), answer=Formula(evaluate, "made up"))
    assert np.isinf(series(case).bound).all()


@pytest.mark.parametrize("name", ["cornell-box-empty", "facing-squares", "cornell-box"])
def test_committed_later_bounces_are_what_the_tracer_finds(name: str) -> None:
    """Finite elements and the walk share no code; in the box with blocks roulette meets a walk without it."""
    case = small(name)
    found = series(case)
    tracer = ReferenceRenderer("mis")
    last = len(found.terms) - 1
    images = [tracer.render(case.scene, range(last + 1, 61), 32, seed).sum(axis=0) for seed in range(8)]
    means = np.array(images).mean(axis=(1, 2))
    error = means.std(axis=0, ddof=1) / np.sqrt(len(means))
    z = (means.mean(axis=0) - found.later.mean(axis=(0, 1))) / error
    assert np.abs(z).max() < 6  # of Student's t with 7 degrees of freedom: once in 2 000, in three channels
    assert (error / found.later.mean(axis=(0, 1))).max() < 0.1
    sums = found.terms.sum(axis=0).mean(axis=(0, 1))
    assert (found.later.mean(axis=(0, 1)) / sums > 1e-4).any()  # it is worth the trouble


def test_at_a_size_that_does_not_divide_the_data_only_the_bound_is_left() -> None:
    case = small("cornell-box-empty", 16)
    odd = replace(case, scene=case.scene.resized(24, 24))
    found = Series.of(odd, Truth(np.ones((3, *odd.scene.shape)), np.zeros((3, *odd.scene.shape)), "made up"))
    assert not found.later.any()
    np.testing.assert_array_equal(found.bound, tail_bound(odd.scene, 2))


def test_errors_of_bounces_from_the_same_walks_add() -> None:
    case = small("cornell-box")
    found = series(case)
    assert found.errors.any()
    np.testing.assert_allclose(found.total().stderr, found.errors.sum(axis=0) + found.later_error)
    np.testing.assert_array_equal(found.total(0.0).stderr, found.errors[0])
