"""``lightproof validate`` as people meet it: what it says, what it writes, how it ends."""

from __future__ import annotations

import dataclasses
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace
from typing import Any

import pytest

from comparisons.diagnosis import inquiry
from comparisons.relations import RELATIONS
from comparisons.relations.relation import Exact, Told
from scenes import library

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("command.py"))))
invoke, validate = shared.invoke, shared.validate

RUN = [sys.executable, "-P", "-m", "lightproof"]
QUICK = ("--bounces", "0", "--no-total")
"""Of a run whose verdict is not what is looked at."""


@pytest.fixture(scope="module")
def agreed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any]:
    """A run without anything wrong, whose folder is left as it is: a pass, and a declared deviation of Mitsuba."""
    folder = tmp_path_factory.mktemp("agreed")
    # two of these names are one renderer
    names = ("--renderer", "reference", "--renderer", "reference:mis", "--renderer", "mitsuba")
    return folder / "out", validate(folder, "furnace-sphere", "--bounces", "1", *names, jobs=2)


one_run = pytest.mark.xdist_group("agreed")


@one_run
def test_a_pass_ends_with_0_and_writes_everything(agreed: tuple[Path, Any]) -> None:
    out, result = agreed
    assert result.exit_code == 0, result.output
    for name in ("results.json", "report.html", "junit.xml", "images/furnace-sphere/truth.exr"):
        assert (out / name).exists()
    assert "furnace-sphere × reference: pass" in result.output
    assert "furnace-sphere × mitsuba: known" in result.output
    assert str(out / "report.html") in result.output
    assert "\x1b[" not in result.output, "no colours where there is no terminal"
    document = json.loads((out / "results.json").read_bytes())
    assert document["provenance"]["versions"]["mitsuba"]
    assert [total["verdict"] for total in document["comparisons"][0]["totals"]] == ["pass"]
    assert "total: the sum of all bounces" in result.output


@one_run
def test_a_report_can_be_rendered_again(agreed: tuple[Path, Any], tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(agreed[0], out)
    before = (out / "report.html").read_bytes()
    (out / "report.html").unlink()
    assert invoke("report", out).exit_code == 0
    assert (out / "report.html").stat().st_size == pytest.approx(len(before), rel=0.01)


@one_run
def test_one_renderer_by_two_names_is_one(agreed: tuple[Path, Any]) -> None:
    _, result = agreed
    assert "[1/2] furnace-sphere × reference: pass" in result.output
    assert "[2/2] furnace-sphere × mitsuba: known" in result.output


@pytest.mark.browser
@one_run
def test_a_real_report_opens_in_a_browser(agreed: tuple[Path, Any], open_report: Any) -> None:
    page = open_report(agreed[0] / "report.html")
    text = page.inner_text("body")
    assert "furnace-sphere" in text
    assert "mitsuba" in text
    assert "known" in text
    assert page.locator(".plot canvas").count() > 0


def test_a_fail_ends_with_1(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same deviation of Mitsuba, which is real: undeclared it fails."""
    monkeypatch.setattr(inquiry, "CASES", 0)  # what is asked about it has tests of its own
    arguments = ("furnace-sphere", "--renderer", "mitsuba", "--bounces", "1", "--no-total")
    assert validate(tmp_path, *arguments, "--known", "none").exit_code == 1


def test_an_inconclusive_run_ends_with_4(tmp_path: Path) -> None:
    result = validate(tmp_path, "furnace-box", "--renderer", "reference", "--budget", "0.01")
    assert result.exit_code == 4
    assert "could have been detected from" in result.output


def test_a_renderer_that_can_t_be_loaded_ends_with_3(tmp_path: Path) -> None:
    """A real process of the command, in which Mitsuba's package is one that raises."""
    broken = tmp_path / "broken" / "mitsuba"
    broken.mkdir(parents=True)
    (broken / "__init__.py").write_text("raise ImportError('libmitsuba.so: cannot open shared object file')")
    result = subprocess.run(
        # bounce 0 alone is soon decided
        [*RUN, "validate", "furnace-sphere", *QUICK, "--size", "8x8", "--out", tmp_path / "out"],
        env={**os.environ, "PYTHONPATH": str(broken.parent)},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert result.returncode == 3, result.stdout + result.stderr
    assert "furnace-sphere × reference: pass" in result.stdout
    assert "furnace-sphere × mitsuba: error" in result.stdout
    [_, comparison] = json.loads((tmp_path / "out" / "results.json").read_bytes())["comparisons"]
    assert "libmitsuba.so" in comparison["message"]
    assert "libmitsuba.so" in comparison["log"][-1]


def test_a_package_that_is_not_installed_is_no_reason_to_lose_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing(package: str) -> str:
        if package in ("mitsuba", "pyrender"):
            raise PackageNotFoundError(package)
        return version(package)

    for module in ("lightproof.validate", "comparisons.renderers.mitsuba", "comparisons.renderers.registry"):
        monkeypatch.setattr(f"{module}.version", missing)
    assert validate(tmp_path, "furnace-sphere", "--renderer", "reference", *QUICK).exit_code == 0
    document = json.loads((tmp_path / "out" / "results.json").read_bytes())
    assert document["provenance"]["versions"]["mitsuba"] is None
    assert "pip install mitsuba" in invoke("list", "renderers").output
    assert "lightproof[opengl]" in invoke("list", "renderers").output


def test_a_new_run_leaves_nothing_of_the_old_one(tmp_path: Path) -> None:
    validate(tmp_path, "furnace-sphere", "--renderer", "reference", *QUICK)
    validate(tmp_path, "furnace-box", "--renderer", "reference", *QUICK)
    assert [path.name for path in (tmp_path / "out" / "images").iterdir()] == ["furnace-box"]


def test_ctrl_c_ends_the_run_and_its_renderers(tmp_path: Path, processes: Any) -> None:
    def below(run: int) -> set[int]:
        """The run, and its renderers, each of which leads a group of its own."""
        return {p.pid for p in processes() if run in (p.pid, p.parent) and p.state != "Z"}

    run = subprocess.Popen(
        [
            *RUN,
            "validate",
            "furnace-box",
            "--tolerance",
            "0.00001%",
            "--budget",
            "300",
            "--out",
            tmp_path / "out",
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    deadline = time.monotonic() + 60
    while not below(run.pid) - {run.pid} and time.monotonic() < deadline:
        time.sleep(0.1)
    started = below(run.pid)
    assert started - {run.pid}, "no renderer was started"
    os.killpg(run.pid, signal.SIGINT)
    _, errors = run.communicate(timeout=30)
    assert run.returncode == 130
    assert "interrupted" in errors
    assert "Traceback" not in errors
    assert not started & {p.pid for p in processes() if p.state != "Z"}


def test_the_total_can_be_left_out(tmp_path: Path) -> None:
    """With it: ``test_a_pass_ends_with_0_and_writes_everything``."""
    found = validate(tmp_path, "furnace-box", "--renderer", "reference", *QUICK)
    assert found.exit_code == 0, found.output
    [comparison] = json.loads((tmp_path / "out" / "results.json").read_text())["comparisons"]
    assert comparison["totals"] == []
    assert "total: the sum of all bounces" not in found.output


# ---- relations


def test_relations_need_no_answer(tmp_path: Path) -> None:
    scene = tmp_path / "mine.json"
    scene.write_bytes(library.case("furnace-channels").scene.to_json())
    only = ("--relation", "first-hits", "--relation", "channels")
    shared = ("--renderer", "reference", "--bounces", "1", "--tolerance", "10%", "--tile-tolerance", "50%")
    result = validate(tmp_path, "--scene", str(scene), *only, *shared)
    assert result.exit_code == 0, result.output
    assert "[2/2] channels (mine) × reference: pass" in result.output
    document = json.loads((tmp_path / "out" / "results.json").read_bytes())
    assert document["comparisons"] == []
    assert [(r["relation"], r["scene"]) for r in document["relations"]] == [
        ("first-hits", "mine"),
        ("channels", "mine"),
    ]
    page = (tmp_path / "out" / "report.html").read_text()
    assert "All 2 checks passed." in page
    assert "relation channels" in (tmp_path / "out" / "junit.xml").read_text()


def test_relations_on_the_scene_of_a_case(tmp_path: Path) -> None:
    """Of a case with one channel, permuting channels says nothing: nothing was compared."""
    only = ("blend-lamp", "--relation", "superposition", "--renderer", "reference")
    result = validate(tmp_path, *only)
    assert result.exit_code == 5, result.output
    assert "superposition (blend-lamp) × reference: unsupported" in result.output
    assert "not applicable: nothing emits but" in result.output


def test_a_relation_that_fails_ends_with_1(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def far(claim: Any) -> Any:
        return Told("fail", "7 of 9 pixels have another distance")

    relation = dataclasses.replace(RELATIONS["first-hits"], claims=lambda *_: [Exact(far)])
    monkeypatch.setattr("comparisons.relations.RELATIONS", {**RELATIONS, "first-hits": relation})
    result = validate(tmp_path, "furnace-box", "--relation", "first-hits", "--renderer", "reference")
    assert result.exit_code == 1, result.output
    assert "7 of 9 pixels" in (tmp_path / "out" / "junit.xml").read_text()
