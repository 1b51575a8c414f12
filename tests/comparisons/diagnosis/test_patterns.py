from __future__ import annotations

from collections.abc import Callable

import pytest

from comparisons.diagnosis.patterns import pattern
from comparisons.results import Comparison

Make = Callable[..., Comparison]

TRUTH = [1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125]


def off(*factors: float) -> list[float]:
    return [t * f for t, f in zip(TRUTH, factors, strict=True)]


PATTERNS = {
    "same factor": off(*[1.02] * 6),
    "same factor from 1": off(1, *[1.5] * 5),
    "factor by factor": off(*(1.03**k for k in range(6))),
    "one bounce": off(1, 1, 1, 0.97, 1, 1),
    "later bounces": off(1, 1, 1, 0.9, 0.95, 0.8),
    "only E": off(0.9, 1, 1, 1, 1, 1),
    "none of E": off(0, 1, 1, 1, 1, 1),
    "dark from": off(1, 1, 1, 1, 1, 0),
    "counted from another number": [*TRUTH[1:], TRUTH[-1] / 2],
    "sums": [sum(TRUTH[: k + 1]) for k in range(6)],
    "irregular": off(1, 1.5, 0.7, 1.2, 1.0, 0.6),
}


@pytest.mark.parametrize("kind", PATTERNS)
def test_bounces_together_have_a_pattern(made: Make, kind: str) -> None:
    found = pattern(made(TRUTH, PATTERNS[kind]))
    assert found is not None
    assert found.kind == kind


def test_small_deviations_have_the_same_patterns(made: Make) -> None:
    """One percent per bounce, of which the first is right."""
    grows = pattern(made(TRUTH, off(*(1.01**k for k in range(6)))))
    same = pattern(made(TRUTH, off(1, *[0.99] * 5)))
    assert (grows and grows.kind, same and same.kind) == ("factor by factor", "same factor from 1")


def test_what_passes_has_none(made: Make) -> None:
    assert pattern(made(TRUTH, TRUTH)) is None


def test_direct_light_alone_has_no_pattern_over_bounces(made: Make) -> None:
    found = pattern(made([1.0, 0.5, 0.0], [1.0, 0.6, 0.0]))
    assert found is not None
    assert (found.kind, found.first) == ("direct", 1)


def test_light_after_the_last_bounce(made: Make) -> None:
    found = pattern(made([1.0, 0.5, 0.0], [1.0, 0.5, 0.2]))
    assert found is not None
    assert found.kind == "light after the last"


def test_the_right_mean_in_the_wrong_places(made: Make) -> None:
    found = pattern(made(TRUTH, TRUTH, by_tile=(0, 1)))
    assert found is not None
    assert (found.kind, found.text) == (
        "places",
        "bounces 0, 1 have the right mean, and light in the wrong places",
    )


def test_an_error_is_no_pattern_of_bounces(made: Make) -> None:
    found = pattern(made([], [], verdict="error", message="it crashed"))
    assert found is not None
    assert (found.kind, found.text) == ("error", "it crashed")


def test_sums_that_end_a_bounce_late_begin_with_two_terms(made: Make) -> None:
    """Bounce 0 is E + TE, and each later one is the difference of two sums: its neighbour."""
    truth = [1.0, 0.6, 0.2, 0.1, 0.03]
    found = pattern(made(truth, [1.6, 0.2, 0.1, 0.03, 0.01]))
    assert found is not None
    assert found.kind == "counted from another number"
