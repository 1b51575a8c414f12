"""The page of verdicts, made of a run."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

from comparisons import results
from comparisons.settings import Settings, Silent
from lightproof.validate import compare
from scenes import library


def loaded(name: str) -> Any:
    """A script of docs/."""
    spec = importlib.util.spec_from_file_location(name, Path(__file__).parents[2] / "docs" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_signs_versions_and_reasons(tmp_path: Path) -> None:
    settings = Settings(budget=30.0, first_look=0.3, size=(16, 16), bounces=1, total=False)
    cases = [library.case("furnace-box")]
    compare(cases, ["reference:nee", "mitsuba:scalar_rgb:direct"], settings, tmp_path, Silent())
    page = loaded("verdicts").page([results.read(tmp_path)])
    assert "| 1 | `reference:nee` |\n| 2 | `mitsuba:scalar_rgb:direct` |" in page
    assert "mitsuba 3." in page
    assert "30 s per case and renderer" in page
    [furnace] = [line for line in page.splitlines() if line.startswith("| furnace-box |")]
    assert furnace.split("|")[2].split()[0] == "✓"
