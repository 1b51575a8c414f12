"""What other ways say, on made-up results: alike, right, or wrong by something else, and what that speaks for."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest
from msgspec.structs import replace

from comparisons.diagnosis import diagnose
from comparisons.diagnosis.ways import WAYS, Heard, clues_of_ways, heard, later_by_one, other_ways
from comparisons.results import Comparison

Make = Callable[..., Comparison]
LAMP, POINT = ["quad", "lambertian", "area"], ["quad", "lambertian", "point"]
CHANCE, NEXT_EVENT, NUMBERS = WAYS


@pytest.fixture
def by(made: Make) -> Callable[..., Comparison]:
    """``by(renderer, factors)``: bounces 1, 2, … of a lamp's light, each off by its factor; E is right."""

    def comparison(renderer: str, factors: Sequence[float], **changes: object) -> Comparison:
        truth = [0.5**k for k in range(len(factors) + 1)]
        mean = [t * f for t, f in zip(truth, [1.0, *factors], strict=True)]
        return made(truth, mean, renderer=renderer, features=changes.pop("features", LAMP), **changes)

    return comparison


def weights(comparisons: Sequence[Comparison], others: Sequence[Comparison]) -> dict[str, float]:
    total: dict[str, float] = {}
    for clue in clues_of_ways(comparisons, others):
        for operator, weight in clue.weights.items():
            total[operator] = total.get(operator, 0) + weight
    return total


def test_ways_agree_or_not(by: Callable[..., Comparison]) -> None:
    wrong = by("mine", [0.8])
    others = [by(CHANCE, [1.0]), by(NEXT_EVENT, [0.8]), by(NUMBERS, [0.5])]
    assert heard([wrong], others) == {
        "chance": Heard(right=["box"]),
        "next event": Heard(alike=["box"]),
        "numbers": Heard(unlike=["box"]),
    }


def test_noise_says_nothing(by: Callable[..., Comparison]) -> None:
    """An interval that holds the same bias and none."""
    wrong, noisy = by("mine", [0.98]), by(CHANCE, [0.985])
    noisy.bounces[1] = replace(noisy.bounces[1], standard_error=0.02, channels=[], verdict="inconclusive")
    assert heard([wrong], [noisy]) == {}


def test_light_that_nothing_is_drawn_for_tells_where_ways_differ(by: Callable[..., Comparison]) -> None:
    wrong = by("mine", [0.8], features=POINT)
    assert heard([wrong], [by(CHANCE, [0.8], features=POINT)]) == {}
    assert heard([wrong], [by(CHANCE, [1.0], features=POINT)]) == {"chance": Heard(right=["box"])}


def test_both_alone_right_means_the_weights(by: Callable[..., Comparison]) -> None:
    found = weights([by("mine", [0.9])], [by(CHANCE, [1.0]), by(NEXT_EVENT, [1.0])])
    assert max(found, key=lambda operator: found[operator]) == "estimator"


def test_both_as_wrong_is_not_the_estimator(by: Callable[..., Comparison]) -> None:
    assert weights([by("mine", [0.9])], [by(CHANCE, [0.9]), by(NEXT_EVENT, [0.9])])["estimator"] < 0


def test_wrong_where_lamps_are_looked_at(by: Callable[..., Comparison]) -> None:
    """Everywhere: a density. Where points shine wrongly too: shadow rays. In stretched lamps alone: their area."""
    others = [by(CHANCE, [1.0]), by(NEXT_EVENT, [0.5])]
    everywhere = weights([by("mine", [0.6])], others)
    assert max(everywhere, key=lambda operator: everywhere[operator]) == "estimator"
    points = weights([by("mine", [0.6]), by("mine", [0.6], case="point", features=POINT)], others)
    assert max(points, key=lambda operator: points[operator]) == "G"
    disk = [*LAMP, "disk"]
    stretched = weights(
        [by("mine", [0.6], features=disk)],
        [by(CHANCE, [1.0], features=disk), by(NEXT_EVENT, [0.5], features=disk)],
    )
    assert max(stretched, key=lambda operator: stretched[operator]) == "E"


def test_points_that_are_too_bright_are_no_shadows(by: Callable[..., Comparison]) -> None:
    others = [by(CHANCE, [1.0]), by(NEXT_EVENT, [1.5])]
    found = weights([by("mine", [1.4]), by("mine", [1.5], case="point", features=POINT)], others)
    assert max(found, key=lambda operator: found[operator]) == "estimator"


def test_a_sky_is_too_dark_where_it_is_missed_and_too_bright_by_its_density(
    by: Callable[..., Comparison],
) -> None:
    sky = ["quad", "lambertian", "constant"]
    for factor, operator in ((0.6, "E"), (1.4, "estimator")):
        others = [by(CHANCE, [1.0], features=sky), by(NEXT_EVENT, [factor], features=sky)]
        found = weights([by("mine", [factor], features=sky)], others)
        assert max(found, key=lambda o: found[o]) == operator


def test_what_chance_alone_gets_wrong_is_its_rays(by: Callable[..., Comparison]) -> None:
    """It knows of no density of lamps, and of no weight; on rough metals alone it is their sampling."""
    found = weights([by("mine", [0.9])], [by(CHANCE, [0.8]), by(NEXT_EVENT, [1.0])])
    assert max(found, key=lambda operator: found[operator]) == "G"
    metal = ["quad", "rough_conductor", "area"]
    others = [by(CHANCE, [0.8], features=metal), by(NEXT_EVENT, [1.0], features=metal)]
    found = weights([by("mine", [0.9], features=metal)], others)
    assert max(found, key=lambda operator: found[operator]) == "R"


def test_other_numbers_that_are_right_mean_the_sampler(by: Callable[..., Comparison]) -> None:
    found = weights([by("mine", [0.9])], [by(NUMBERS, [1.0])])
    assert max(found, key=lambda operator: found[operator]) == "sampler"


def test_rays_that_are_lost_are_lost_a_bounce_later_by_next_event(by: Callable[..., Comparison]) -> None:
    chance = by(CHANCE, [0.97, 0.94, 0.91])
    next_event = by(NEXT_EVENT, [1.0, 0.97, 0.94])
    assert later_by_one([chance, next_event]) == ["box"]
    assert later_by_one([chance, by(NEXT_EVENT, [0.97, 0.94, 0.91])]) == []


def test_the_diagnosis_listens(by: Callable[..., Comparison]) -> None:
    """One case by itself says nothing; that its weights are wrong, two others do."""
    wrong = by("mine", [0.9])
    assert diagnose([wrong]).suspect is None
    found = diagnose([wrong], others=[by(CHANCE, [1.0]), by(NEXT_EVENT, [1.0]), by(NUMBERS, [0.9])])
    assert found.suspect == "estimator"
    assert "by chance alone and by next event alone it is right" in found.sentence


def test_only_the_weighted_tracer_has_other_ways() -> None:
    assert other_ways("reference") == other_ways("reference:mis") == tuple(WAYS)
    assert other_ways("mitsuba") == ()
