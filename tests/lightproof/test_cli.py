"""The command as people meet it: what it says, what it writes, how it ends."""

from __future__ import annotations

import dataclasses
import io
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from rich.console import Console
from typer.testing import CliRunner

from comparisons.diagnosis import inquiry
from comparisons.relations import RELATIONS
from comparisons.relations.relation import Exact, Told
from lightproof.cli import app, main
from lightproof.terminal import show_rows, show_verdicts
from scenes import library
from scenes.formats import exr

RUN = [sys.executable, "-P", "-m", "lightproof"]
QUICK = ("--bounces", "0", "--no-total")
"""Of a run whose verdict is not what is looked at."""


def invoke(*arguments: str | Path) -> Any:
    return CliRunner().invoke(app, [str(a) for a in arguments])


def flat(text: str) -> str:
    """Without the frames and line breaks that depend on the width of the terminal."""
    return " ".join(text.translate(str.maketrans("│╭╮╰╯─", "      ")).split())


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["validate", "furnace-bax"], "no case is called 'furnace-bax': did you mean furnace-box"),
        (
            ["validate", "--renderer", "mitsubishi"],
            "no renderer is called 'mitsubishi': did you mean mitsuba",
        ),
        (["validate", "--tolerance", "-1%"], "'-1%': expected a share above 0, such as 0.5% or 0.005"),
        (["validate", "--tile-tolerance", "big"], "'big': expected a share above 0"),
        (["validate", "--size", "64"], "'64': expected WIDTHxHEIGHT in pixels, such as 64x48"),
        (["validate", "--bounces", "-1"], "Invalid value for '--bounces'"),
        (["validate", "--budget", "0"], "Invalid value for '--budget'"),
        (["validate", "--known", "no/such.toml"], "no/such.toml: No such file"),
        (["render", "nothing"], "no case is called 'nothing': there are "),
        (["list", "everything"], "'everything' is not one of"),
        (["explode"], "No such command 'explode'"),
        (["render", "furnace-box", "--out", "box.jpg"], "box.jpg: expected a name that ends in .exr"),
        (["validate", "--budget", "inf"], "Invalid value for '--budget'"),
        (
            ["validate", "--relation", "superstition"],
            "no relation is called 'superstition': did you mean superposition",
        ),
        (["validate", "--relations", "--scene", "no/such.json"], "no/such.json: No such file"),
        (["faults", "cosine-mising"], "no fault is called 'cosine-mising': did you mean cosine-missing"),
    ],
)
def test_wrong_usage_is_explained_and_ends_with_2(arguments: list[str], complaint: str) -> None:
    result = invoke(*arguments)
    assert result.exit_code == 2
    assert complaint in flat(result.output)


@pytest.mark.parametrize("arguments", [["validate", "furnace-box"], ["faults", "cosine-missing"]])
def test_out_must_be_a_folder(tmp_path: Path, arguments: list[str]) -> None:
    file = tmp_path / "file"
    file.touch()
    result = invoke(*arguments, "--out", file)
    assert result.exit_code == 2
    assert "expected a folder that can be written" in flat(result.output)


@pytest.mark.parametrize("command", ["validate", "faults", "render", "answer", "export", "list", "report"])
def test_help_teaches(command: str) -> None:
    result = invoke(command, "--help")
    assert result.exit_code == 0
    assert "Usage" in result.output


def test_lists_for_people_and_programs() -> None:
    for what, name in (
        ("cases", "furnace-box"),
        ("renderers", "mitsuba:scalar_rgb"),
        ("relations", "superposition"),
    ):
        rows = json.loads(invoke("list", what, "--json").output)
        assert name in [row["name"] for row in rows]
        assert name in invoke("list", what).output


def test_renderers_of_ones_own_are_listed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where they are, whether they are there, how to get them, and what they support."""
    command = """["./mine", "{scene}", "{spp}", "{seed}", "{output}"]"""
    keys = f"command = {command}\nscene = 'gltf'\nimages = 'total'\ninstall = 'make mine'"
    (tmp_path / "lightproof.toml").write_text(f"[renderers.mine]\n{keys}\nversion = '2.0'")
    monkeypatch.chdir(tmp_path)
    rows = {row["name"]: row for row in json.loads(invoke("list", "renderers", "--json").output)}
    mine = rows["mine"]
    assert (mine["version"], mine["installed"], mine["install"]) == (None, False, "make mine")
    assert re.search("mine .*not installed: make mine", invoke("list", "renderers").output)
    assert mine["supports"]["images"] == ["bounce 0", "total"]
    assert rows["reference:mis"]["installed"]
    assert rows["reference:mis"]["supports"]["sensors"][0] == "pinhole"
    (tmp_path / "mine").write_text("#!/bin/sh")
    (tmp_path / "mine").chmod(0o755)
    rows = {row["name"]: row for row in json.loads(invoke("list", "renderers", "--json").output)}
    assert (rows["mine"]["version"], rows["mine"]["installed"]) == ("2.0", True)
    shown = invoke("list", "renderers").output
    assert re.search("mine .*2.0", shown)
    assert re.search(r"^mine\n +shapes: quad, mesh", shown, re.MULTILINE)


@pytest.mark.parametrize("command", [["list", "renderers"], ["render", "furnace-box", "--renderer", "mine"]])
def test_a_wrong_configuration_is_wrong_usage(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: list[str]
) -> None:
    (tmp_path / "lightproof.toml").write_text("[renderers.mine]\ncomand = ['./mine']")
    monkeypatch.chdir(tmp_path)
    result = invoke(*command)
    assert result.exit_code == 2
    assert "renderers.mine: expected one of the keys command" in flat(result.output)


def test_render_writes_a_layer_per_bounce(tmp_path: Path) -> None:
    out = tmp_path / "box.exr"
    arguments = ("furnace-box", "--renderer", "mitsuba", "--bounces", "2", "--spp", "2", "--size", "8x6")
    result = invoke("render", *arguments, "--out", out)
    assert result.exit_code == 0
    mean, _ = exr.read_bounces(out)
    assert mean.shape == (3, 6, 8, 3)
    assert (mean[0] == 1).all()


def test_render_into_no_folder_is_wrong_usage(tmp_path: Path) -> None:
    result = invoke(
        "render", "furnace-box", "--spp", "1", "--size", "4x4", "--out", tmp_path / "no" / "box.exr"
    )
    assert result.exit_code == 2


def test_report_of_no_results_is_wrong_usage(tmp_path: Path) -> None:
    result = invoke("report", tmp_path)
    assert result.exit_code == 2
    assert "lightproof validate" in result.output


def validate(tmp_path: Path, *arguments: str, jobs: int = 1) -> Any:
    return invoke("validate", *arguments, "--size", "16x16", "--jobs", str(jobs), "--out", tmp_path / "out")


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


def test_a_bug_is_no_verdict(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def broken(*arguments: Any) -> Any:
        raise ZeroDivisionError

    monkeypatch.setattr("lightproof.cli.run_validation", broken)
    monkeypatch.setattr(
        sys, "argv", ["lightproof", "validate", "furnace-box", "--out", str(tmp_path / "out")]
    )
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 70


def test_too_little_memory_is_no_bug(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def greedy() -> None:
        raise MemoryError("Unable to allocate 1 TiB")

    monkeypatch.setattr("lightproof.cli.app", greedy)
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 2
    assert "out of memory: Unable to allocate 1 TiB; a smaller --size" in capsys.readouterr().err


def test_a_new_run_leaves_nothing_of_the_old_one(tmp_path: Path) -> None:
    validate(tmp_path, "furnace-sphere", "--renderer", "reference", *QUICK)
    validate(tmp_path, "furnace-box", "--renderer", "reference", *QUICK)
    assert [path.name for path in (tmp_path / "out" / "images").iterdir()] == ["furnace-box"]


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


def test_in_a_pipe_no_line_is_longer_than_what_it_says() -> None:
    for what in ("renderers", "relations"):
        assert max(map(len, invoke("list", what).output.splitlines())) < 1000


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


def test_cheap_relations_belong_to_the_default_run_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[list[str]] = []

    def run(cases: Any, renderers: Any, settings: Any, folder: Any, observer: Any, tasks: Any) -> Any:
        asked.append([task.relation.name for task in tasks])
        raise KeyboardInterrupt

    monkeypatch.setattr("lightproof.cli.run_validation", run)
    for arguments in ((), ("--no-relations",), ("furnace-box",), ("--family", "furnace"), ("--relations",)):
        assert validate(tmp_path, *arguments).exit_code == 130
    assert asked == [["first-hits", "superposition", "homogeneity"], [], [], [], asked[-1]]
    assert set(asked[-1]) == set(RELATIONS)


@pytest.mark.browser
@one_run
def test_a_real_report_opens_in_a_browser(agreed: tuple[Path, Any], open_report: Any) -> None:
    page = open_report(agreed[0] / "report.html")
    text = page.inner_text("body")
    assert "furnace-sphere" in text
    assert "mitsuba" in text
    assert "known" in text
    assert page.locator(".plot canvas").count() > 0


def test_the_total_can_be_left_out(tmp_path: Path) -> None:
    """With it: ``test_a_pass_ends_with_0_and_writes_everything``."""
    found = validate(tmp_path, "furnace-box", "--renderer", "reference", *QUICK)
    assert found.exit_code == 0, found.output
    [comparison] = json.loads((tmp_path / "out" / "results.json").read_text())["comparisons"]
    assert comparison["totals"] == []
    assert "total: the sum of all bounces" not in found.output
