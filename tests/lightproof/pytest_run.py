"""The plugin as a test suite meets it: pytest in a process of its own, in a folder that knows nothing of ours."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path
from typing import NamedTuple

from junitparser import JUnitXml, TestCase

# the latter: an installation in place that is older than the entry point
PLUGIN = "lightproof" if entry_points(group="pytest11", name="lightproof") else "lightproof.pytest_plugin"
# without hypothesis, which none of these suites uses, and which takes half a second of each to import
PYTEST = [sys.executable, "-m", "pytest", "-p", PLUGIN, "-p", "no:hypothesispytest"]
ENVIRONMENT = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}


class Run(NamedTuple):
    """What became of it."""

    folder: Path
    status: int
    text: str

    @property
    def tests(self) -> dict[str, TestCase]:
        """From the JUnit file."""
        return {
            test.name: test for suite in JUnitXml.fromfile(str(self.folder / "junit.xml")) for test in suite
        }


def run(folder: Path, *arguments: str, files: dict[str, str] | None = None) -> Run:
    for name, text in (files or {}).items():
        (folder / name).write_text(text)
    done = subprocess.run(
        [*PYTEST, *arguments], cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=300
    )
    return Run(folder, done.returncode, done.stdout + done.stderr)


def message(test: TestCase) -> str:
    [result] = test.result
    return str(result.text or result.message)
