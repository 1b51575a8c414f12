"""Every relation holds where it should, and is broken by a fault that is planted for it."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest

from comparisons.crew import Crew
from comparisons.relations import RELATIONS
from comparisons.results import RelationResult

Try = Callable[..., list[RelationResult]]

relations = pytest.mark.parametrize("relation", RELATIONS)
LAST = {"reciprocity": 1, "mirroring": 1, "roll": 1}
"""Bounces where two would take long; what these test shows in the first."""


def verdicts(found: list[RelationResult]) -> list[str]:
    return [result.verdict for result in found]


@relations
def test_the_reference_tracer_holds_it(attempt: Try, relation: str) -> None:
    """At ± 8 % of the image and ± 40 % of a tile; 25 % of the image would have failed with 90 % power."""
    found = attempt(relation, last=LAST.get(relation, 2))
    assert set(verdicts(found)) == {"pass"}, found
    for result in found:
        assert all(b.detectable_bias < 0.25 for b in result.bounces)


@pytest.fixture(scope="module")
def mitsuba() -> Any:
    with Crew(1) as crew:
        yield crew


@relations
def test_mitsuba_holds_it(attempt: Try, mitsuba: Any, relation: str) -> None:
    found = attempt(relation, renderer="mitsuba", crew=mitsuba, last=LAST.get(relation, 2))
    expected = "unsupported" if relation == "strategies" else "pass"
    assert set(verdicts(found)) == {expected}, found
    for result in found:
        assert result.renderer_version.startswith("3.")
        assert all(b.detectable_bias < 0.25 for b in result.bounces)


PLANTED = {
    "superposition": ("one_lamp_lost", [1, 2]),
    "linearity": ("clamped", [0, 1]),
    "homogeneity": ("albedo_twice", [1, 2]),
    "partial-sums": ("last_bounce_open", [0, 1]),  # the last one is wrong on both sides
    "reciprocity": ("not_reciprocal", [1]),
    "rotation": ("normal_in_object_space", [1, 2]),
    "mirroring": ("one_pixel_right", [0]),
    "roll": ("one_row_low", [0]),
    "scaling": ("fixed_offset", [1, 2]),
    "channels": ("swapped_channels", [0, 1]),
    "spp": ("one_sample_short", [0, 1]),
}


@pytest.mark.parametrize("relation", PLANTED)
def test_a_planted_fault_breaks_it(attempt: Try, wrong: Any, relation: str) -> None:
    fault, bounces = PLANTED[relation]
    last = 2 if relation == "partial-sums" else max(bounces)
    for result in attempt(relation, getattr(wrong, fault), last=last):
        assert result.verdict == "fail", result
        assert set(bounces) <= {b.bounce for b in result.bounces if b.verdict == "fail"}


def test_every_relation_has_a_fault() -> None:
    """The others are below, since no image tells them."""
    assert set(RELATIONS) - set(PLANTED) == {"first-hits", "seeds", "strategies"}


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("through_the_nearest", "have another surface, the first in row"),
        ("too_far", "have another distance"),
        ("normals_behind", "have another normal"),
        ("half_a_pixel_off", "have another surface"),
        ("too_far_without_normals", "have another distance"),
    ],
)
def test_wrong_first_hits(attempt: Try, wrong: Any, fault: str, message: str) -> None:
    [result] = attempt("first-hits", hits=getattr(wrong, fault), stage="room")
    assert result.verdict == "fail"
    assert message in result.message


def test_normals_that_nobody_tells_are_not_judged(attempt: Try, wrong: Any) -> None:
    [result] = attempt("first-hits", hits=wrong.without_normals, stage="metal")
    assert result.verdict == "pass"
    assert re.search(r"\d+ normals were not told$", result.message)
    [told] = attempt("first-hits", stage="metal")
    assert told.verdict == "pass"
    assert "not told" not in told.message


@pytest.mark.parametrize(
    ("fault", "expected"),
    [
        ("deaf_to_its_seed", ["fail", "error"]),
        ("never_the_same", ["fail", "pass"]),
        ("small_seeds_are_dark", ["pass", "fail"]),
    ],
)
def test_wrong_seeds(attempt: Try, wrong: Any, fault: str, expected: list[str]) -> None:
    assert verdicts(attempt("seeds", getattr(wrong, fault))) == expected


def test_a_strategy_with_wrong_weights_disagrees_with_each_of_the_others(attempt: Try, wrong: Any) -> None:
    found = attempt("strategies", wrong.weights_beyond_one)
    assert [result.claim for result in found] == [
        "against reference:nee",
        "against reference:bsdf",
        "against reference:mis:sobol",
    ]
    assert verdicts(found) == ["fail"] * 3


def test_what_no_relation_sees(attempt: Try, wrong: Any) -> None:
    """Relations ask for consistency, not for the truth: a reflectance that is wrong everywhere is consistent."""
    assert verdicts(attempt("homogeneity", wrong.mirrors_are_dull, stage="room")) == ["pass"]
