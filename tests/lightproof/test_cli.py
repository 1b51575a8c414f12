"""The command as people meet it: what it refuses, what it writes, how it ends. For runs see test_cli_validate.py."""

from __future__ import annotations

import sys
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace
from typing import Any

import pytest

from lightproof.cli import main
from scenes.formats import exr

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("command.py"))))
flat, invoke = shared.flat, shared.invoke


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
