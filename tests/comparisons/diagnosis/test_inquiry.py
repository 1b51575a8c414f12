"""What is asked once a case has failed: of a renderer that can tell, and of one that has no other ways."""

from __future__ import annotations

from pathlib import Path

from comparisons.diagnosis.inquiry import RELATIONS, inquire
from comparisons.diagnosis.ways import WAYS, heard
from comparisons.faults import FAULTS
from comparisons.faults.planting import Named
from comparisons.faults.suite import case
from comparisons.renderers import create
from comparisons.settings import Settings

SETTINGS = Settings(budget=4.0, first_look=0.2)


def test_the_case_is_asked_again_in_every_way(tmp_path: Path) -> None:
    fault = FAULTS["second-triangle-lost"]
    renderer = Named(fault.plant(create("reference")), fault.name)
    ways = [Named(fault.plant(create(way)), way) for way in WAYS]
    answers, others = inquire(case("quad-over-plane"), RELATIONS, renderer, ways, SETTINGS, tmp_path)
    assert [answer.relation for answer in answers] == list(RELATIONS)
    assert {answer.scene for answer in answers} == {"quad-over-plane"}
    assert [other.renderer for other in others] == list(WAYS)
    # the camera sees the floor, half of which is not met
    assert answers[0].verdict == "fail"


def test_a_renderer_without_other_ways_is_asked_about_relations_alone(tmp_path: Path) -> None:
    answers, others = inquire(
        case("quad-over-plane"), ["first-hits"], "reference:nee", (), SETTINGS, tmp_path
    )
    assert [answer.verdict for answer in answers] == ["pass"]
    assert others == []
    assert heard([], others) == {}
