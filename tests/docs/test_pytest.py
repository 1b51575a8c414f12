"""pytest.md: its files, put into an empty folder, are a test suite that passes for a right renderer only."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "pytest.md").read_text()
FILES = dict(re.findall(r"^<!-- runs: (\S+) -->\n```python\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL))

# the latter: an installation in place that is older than the entry point
PLUGIN = "lightproof" if entry_points(group="pytest11", name="lightproof") else "lightproof.pytest_plugin"

NOT_NEEDED = ["-p", "no:cacheprovider", "-p", "no:hypothesispytest"]

TRACE = """
from functools import cache

import numpy as np
from scenes import library

CASES = [library.case(name) for name in ("furnace-box", "integrating-sphere", "quad-over-plane", "cornell-box")]

@cache
def truth(name, width, height, last):
    case = library.case(name)
    return case.answer.truth(case.scene.resized(width, height), last).mean

def trace(scene, bounces, spp, seed):
    case = next(case for case in CASES if case.scene.surfaces == scene.surfaces)
    means = truth(case.name, scene.sensor.width, scene.sensor.height, max(bounces))[bounces,]
    return {factor} * means * np.random.default_rng(seed).normal(1, 0.05 / spp**0.5, means.shape)
"""
"""The truth with noise, 5 % for a sample of a pixel."""


@pytest.mark.parametrize(("factor", "outcome"), [("1.00", "3 passed"), ("1.04", "3 failed")])
def test_the_files_of_the_page_are_a_test_suite(tmp_path: Path, factor: str, outcome: str) -> None:
    assert list(FILES) == ["my_renderer.py", "test_light_transport.py"]
    assert PAGE.count("```python") == len(FILES)
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "trace.py").write_text(TRACE.format(factor=factor))
    (tmp_path / "my_renderer.py").write_text(f"from trace import trace\n\n\n{FILES['my_renderer.py']}")
    found = subprocess.run(
        # without hypothesis, which takes half a second to import
        [sys.executable, "-m", "pytest", "-p", PLUGIN, *NOT_NEEDED, "-W", "error"],
        cwd=tmp_path,
        env={name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert re.search(rf"=+ {outcome} in ", found.stdout), found.stdout
