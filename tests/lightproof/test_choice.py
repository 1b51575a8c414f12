"""Which cases and relations a run has, from what the command line names."""

from __future__ import annotations

from pathlib import Path
from runpy import run_path
from types import SimpleNamespace
from typing import Any

import pytest

from comparisons.relations import RELATIONS
from scenes import library

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("command.py"))))
invoke, validate = shared.invoke, shared.validate


def test_families_and_all(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    asked: list[list[str]] = []

    def run(chosen: Any, *rest: Any) -> Any:
        asked.append([case.name for case in chosen])
        raise KeyboardInterrupt

    monkeypatch.setattr("lightproof.cli.run_validation", run)
    for arguments in (
        (),
        ("--family", "furnace"),
        ("--family", "furnace", "cornell-box"),
        ("--all", "furnace-box"),
    ):
        assert invoke("validate", *arguments, "--out", tmp_path / "out").exit_code == 130
    default, family, both, everything = asked
    assert tuple(default) == library.DEFAULT
    assert family == [n for n in library.CASES if library.case(n).family == "furnace"]
    assert both == ["cornell-box", *family]
    assert sorted(everything) == sorted(library.CASES)


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
