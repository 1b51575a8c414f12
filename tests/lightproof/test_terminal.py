"""Verdicts and lists in terminals of any width."""

from __future__ import annotations

import io
import re
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace
from typing import Any

import pytest
from rich.console import Console

from lightproof.terminal import show_rows, show_verdicts

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("command.py"))))
flat = shared.flat


def test_a_narrow_terminal_gets_a_list() -> None:
    tiny, narrow, wide = (Console(width=width, file=io.StringIO()) for width in (30, 60, 200))
    shown = {"verdict": "pass", "bias": 0.001, "interval": (-0.001, 0.003), "decided_by": "image"}
    bounces = [SimpleNamespace(bounce=k, **shown) for k in range(6)]
    comparison = SimpleNamespace(case="furnace-box", renderer="mitsuba", verdict="pass", bounces=bounces)
    outcome: Any = SimpleNamespace(comparisons=[comparison], relations=[], diagnoses=[])
    for out in (tiny, narrow, wide):
        show_verdicts(out, outcome)
        assert "The only comparison passed." in out.file.getvalue()
    assert "T⁵E +0.10±0.20" in tiny.file.getvalue()
    assert "furnace-box × mitsuba: pass\n" in narrow.file.getvalue()
    assert re.search(r"  E \+0.10±0.20 +TE \+0.10±0.20 +T²E \+0.10±0.20 *\n", narrow.file.getvalue())
    assert "furnace-box   mitsuba    pass" in wide.file.getvalue()


def test_where_nothing_was_compared_there_is_no_bounce_to_show() -> None:
    out = Console(width=20, file=io.StringIO())
    comparison = SimpleNamespace(case="furnace-box", renderer="mitsuba", verdict="unsupported", bounces=[])
    outcome: Any = SimpleNamespace(comparisons=[comparison], relations=[], diagnoses=[])
    show_verdicts(out, outcome)
    assert flat(out.file.getvalue()) == "furnace-box × mitsuba: unsupported Nothing was compared."


@pytest.mark.parametrize("width", [60, 80, 120, 200])
def test_lists_cut_no_name(width: int) -> None:
    out = Console(width=width, file=io.StringIO())
    row = {"name": "a-case-of-a-rather-long-name", "title": "What it is", "max_bounces": ""}
    show_rows(out, [row, {**row, "name": "other", "max_bounces": "7"}])
    text = out.file.getvalue()
    assert "a-case-of-a-rather-long-name  " in text
    assert "What it is" in text
    assert "max_bounces" in text if width == 200 else "    max bounces 7" in text
