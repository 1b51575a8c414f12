"""``lightproof faults``: what it says of a matrix, in any terminal, and where it is interrupted."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console
from typer.testing import CliRunner

from comparisons.faults import matrix
from comparisons.faults.matrix import Row, Summary
from comparisons.results import Diagnosis
from lightproof import faults
from lightproof.cli import app


def planted(**what: Any) -> Row:
    return Row(**{"name": "a-fault", "what": "it is wrong", "operator": "R", "seconds": 1, "cases": 1} | what)


def test_faults_are_told_in_any_terminal() -> None:
    """In a table or, where that has no room, in lines; and why what was named, or not caught, is as it is."""
    named = Diagnosis(
        renderer="a-fault",
        suspect="R",
        sentence="R, reflection: it is.",
        evidence=[],
        also_possible=[],
        next_case="",
    )
    caught = planted(caught_by="furnace-box", bounce=2, bias=2.13, diagnosis=named)
    found = [caught, planted(name="hidden", unseen="it is too small"), planted(name="fine", operator=None)]
    for width in (60, 100):
        for in_detail in (False, True):
            out = Console(width=width, file=io.StringIO())
            faults.show(out, found, Summary.of(found, 3.0), in_detail)
            text = " ".join(out.file.getvalue().split())
            line = "caught by furnace-box · bounce 2, +210 %" if width == 60 else "furnace-box 2 +210 % 1.0 R"
            assert line in text
            assert "hidden: it is wrong. Not caught: it is too small" in text
            assert ("a-fault: it is wrong. Diagnosis: R, reflection: it is." in text) == in_detail
            assert (
                "1 of 2 faults were caught; 1 can't be seen, and say why. The diagnosis named 1 of 1" in text
            )


def test_faults_that_are_interrupted_say_how_far_they_came(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def rows(*_: Any) -> Iterator[Row]:
        yield planted()
        raise KeyboardInterrupt

    monkeypatch.setattr(matrix, "rows", rows)
    result = CliRunner().invoke(
        app, ["faults", "cosine-missing", "cosine-squared", "--out", str(tmp_path / "out")]
    )
    assert result.exit_code == 130
    assert "interrupted; 1 of 2 were done; what was seen of them is in" in " ".join(result.output.split())
