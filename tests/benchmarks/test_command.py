"""The command in a process of its own, with renders so small that its figures mean nothing."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from benchmarks import command
from benchmarks.row import Row, asked
from benchmarks.rows import ERROR, ROWS, judged
from benchmarks.scaling import COUNTS, ball, with_channels, with_shapes
from benchmarks.statistics import Ratio

ROOT = Path(__file__).parents[2]


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "benchmarks", "--quick", *arguments]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=200)


def test_every_row_has_its_fields() -> None:
    done = run("--json")
    rows: list[dict[str, Any]] = json.loads(done.stdout)
    limits = {row["name"]: (row["must"], row["aim"]) for row in rows}
    assert limits == {
        "paths-per-second": (0.6, 1.0),
        "bounce-images": (2.5, 4.0),
        "equal-error": (3.0, 8.0),
        "equal-error-tiles": (3.0, 8.0),
        "processes": (1.8, 1.95),
        "finite-elements": (1.0, 5.0),
    }
    for row in rows:
        assert 0 < row["low"] <= row["high"], row
        if not row["name"].startswith(
            "equal-error"
        ):  # of eight trials, a bootstrap may lie beside what it is for
            assert row["low"] <= row["ratio"] <= row["high"], row
        assert row["verdict"] == ("below must" if row["ratio"] < row["must"] else
                                  "must" if row["ratio"] < row["aim"] else "aim")  # fmt: skip
    below = [row for row in rows if row["decides"] and row["verdict"] == "below must"]
    assert done.returncode == int(bool(below)), done.stderr
    [exact] = [row for row in rows if row["name"] == "finite-elements"]
    assert float(exact["note"].rpartition("error ")[2]) <= ERROR


def test_scaling() -> None:
    done = run("--scaling", "--json")
    assert done.returncode == 0, done.stderr
    costs = json.loads(done.stdout)
    assert {cost["over"] for cost in costs} >= {"triangles", "quads", "spheres", "spp", "bounces", "channels"}
    assert all(0 < cost["low"] <= cost["nanoseconds"] <= cost["high"] for cost in costs)


def test_an_answer_that_is_not_exact_enough_fails_however_fast() -> None:
    row, fast = asked("finite-elements", "", must=1.0, aim=5.0), Ratio(50.0, 49.0, 51.0)
    assert judged(row, fast, 0.9e-5).verdict == "aim"
    for error in (1.1e-5, float("nan")):
        failed = judged(row, fast, error)
        assert failed.verdict == "below must"
        assert "above 1e-05" in failed.note
        assert "0.1 s" in failed.note


@pytest.mark.parametrize(
    ("ratio", "decides", "code"),
    [(2.99, True, 1), (2.99, False, 0), (3.0, True, 0), (8.0, True, 0), (float("nan"), True, 1)],
)
def test_the_exit_code(
    ratio: float,
    decides: bool,
    code: int,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    row = Row("one", "one thing ÷ another", ratio, ratio, ratio, 3.0, 8.0, decides, "a note")
    monkeypatch.setattr(command, "ROWS", {"one": lambda effort, progress: [row]})
    assert command.main([]) == code
    shown = capsys.readouterr().out
    assert all(text in shown for text in ("one thing ÷ another", f"{ratio:.2f}", row.verdict, "a note"))


def test_unknown_rows_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        command.main(["--row", "path-per-second"])
    complaint = capsys.readouterr().err
    assert all(name in complaint for name in ROWS)


@pytest.mark.parametrize("count", COUNTS["triangles"])
def test_a_ball_has_the_triangles_that_were_asked_for(count: int) -> None:
    assert len(ball(count).triangles) == count


@pytest.mark.parametrize("kind", ["quads", "spheres"])
def test_clouds_have_the_shapes_that_were_asked_for(kind: str) -> None:
    empty = len(with_shapes("triangles", 1).surfaces) - 1
    assert len(with_shapes(kind, 30).surfaces) == empty + 30


def test_channels() -> None:
    assert with_channels(16).channels == 16
