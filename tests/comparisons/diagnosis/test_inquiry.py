"""What is asked once a case has failed: of a renderer that can tell, and of one that has no other ways."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest

from comparisons import campaign
from comparisons.diagnosis import inquiry
from comparisons.diagnosis.inquiry import inquire, questions
from comparisons.diagnosis.ways import WAYS
from comparisons.faults import FAULTS
from comparisons.faults.planting import Named
from comparisons.faults.suite import case
from comparisons.renderers import create
from comparisons.results import Comparison, RelationResult
from comparisons.settings import Settings, Silent

SETTINGS = Settings(budget=60.0, first_look=0.2, total=False)
"""A budget that is used up only where nothing is clear: how fast a machine is must not matter."""


def planted(fault: str, name: str) -> tuple[Comparison, Named, list[Named]]:
    """A case that a planted fault fails, the renderer of that fault, and its other ways."""
    entry = FAULTS[fault]
    renderer = Named(entry.plant(create("reference")), fault)
    ways = [Named(entry.plant(create(way)), way) for way in WAYS]
    [failed] = campaign.run([case(name)], [renderer], SETTINGS, None, Silent())
    assert failed.verdict == "fail"
    return failed, renderer, ways


def asked(fault: str, name: str, thoroughly: bool = True) -> tuple[list[RelationResult], list[Comparison]]:
    """A planted fault fails a case, and is asked about it."""
    failed, renderer, ways = planted(fault, name)
    return inquire(case(name), failed, renderer, ways, SETTINGS, thoroughly)


def verdicts(answers: Sequence[RelationResult]) -> dict[str, str]:
    return {answer.relation: answer.verdict for answer in answers}


@pytest.fixture
def only(monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[list[str]]]:
    """``only("roll")``: of all that would be asked, which is kept, nothing but this is."""

    def choose(*names: str) -> list[list[str]]:
        suggested = []

        def chosen(failed: Comparison, others: Sequence[Comparison]) -> Sequence[str]:
            suggested.append(list(questions(failed, others)))
            return names

        monkeypatch.setattr(inquiry, "questions", chosen)
        return suggested

    return choose


def test_the_case_is_asked_again_in_every_way(only: Callable[..., list[list[str]]]) -> None:
    only("first-hits")
    answers, others = asked("second-triangle-lost", "quad-over-plane")
    assert {answer.scene for answer in answers} == {"quad-over-plane"}
    assert [other.renderer for other in others] == list(WAYS)
    # the camera sees the floor, half of which is not met
    assert verdicts(answers)["first-hits"] == "fail"


@pytest.mark.parametrize(
    ("fault", "name", "relation"),
    [
        ("image-one-row-low", "furnace-convex", "roll"),
        ("one-sample-too-many", "quad-over-plane", "spp"),
        ("last-bounce-lost", "furnace-sphere", "partial-sums"),
    ],
)
def test_what_the_failure_suggests_is_asked_and_found(
    fault: str, name: str, relation: str, only: Callable[..., list[list[str]]]
) -> None:
    suggested = only(relation)
    answers, _ = asked(fault, name)
    assert relation in suggested[0]
    assert verdicts(answers)[relation] == "fail"


def test_of_further_cases_only_first_hits_are_asked() -> None:
    answers, others = asked("cosine-missing", "quad-over-plane", thoroughly=False)
    assert verdicts(answers) == {"first-hits": "pass"}
    assert len(others) == len(WAYS)


def test_what_could_tell_nothing_is_not_asked() -> None:
    failed, _, ways = planted("cosine-missing", "furnace-sphere")
    others = list(campaign.run([case("furnace-sphere")], ways, SETTINGS, None, Silent()))
    assert len(others) == len(WAYS)
    assert not {"roll", "spp"} & set(questions(failed, others))


def test_without_other_ways_more_relations_are_asked(only: Callable[..., list[list[str]]]) -> None:
    only("spp")
    entry = FAULTS["cosine-missing"]
    renderer = Named(entry.plant(create("reference:nee")), entry.name)
    [failed] = campaign.run([case("quad-over-plane")], [renderer], SETTINGS, None, Silent())
    assert "spp" in list(questions(failed, []))
    answers, others = inquire(case("quad-over-plane"), failed, renderer, (), SETTINGS)
    assert verdicts(answers)["spp"] == "pass"
    assert others == []
