"""A run that fails asks again, and says what is most likely at fault: a deviation of Mitsuba that is known."""

from __future__ import annotations

from pathlib import Path

import pytest

from comparisons.diagnosis import inquiry
from comparisons.settings import Settings, Silent
from lightproof.validate import compare
from scenes import library


def test_what_failed_is_asked_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Mitsuba's rays begin too far from surfaces of a millimetre: docs/findings/mitsuba-small-scenes.md."""
    monkeypatch.setattr(inquiry, "BUDGET", 60.0)  # a slow machine needs it
    settings = Settings(bounces=2, budget=60.0, first_look=0.5, total=False)
    case = library.case("furnace-tiny")
    outcome = compare([case], ["mitsuba"], settings, tmp_path, Silent(), why=True)
    assert [c.verdict for c in outcome.comparisons] == ["fail"]
    assert {r.relation: r.verdict for r in outcome.relations} == {
        "first-hits": "pass",
        "scaling": "fail",
        "spp": "pass",
    }
    [diagnosis] = outcome.diagnoses
    assert diagnosis.suspect == "G"
    quiet = compare([case], ["mitsuba"], settings, tmp_path, Silent())
    assert [c.verdict for c in quiet.comparisons] == ["fail"]
    assert quiet.relations == []
