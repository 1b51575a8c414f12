"""What is shipped, and that the parts know only what lies below them."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = {"scenes", "reference_tracer", "comparisons", "reports", "lightproof"}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", folder, ROOT]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    [wheel] = folder.glob("*.whl")
    return wheel


def test_the_top_level_of_the_wheel(wheel: Path) -> None:
    names = {name.split("/")[0] for name in zipfile.ZipFile(wheel).namelist()}
    assert {name for name in names if not name.endswith(".dist-info")} == PACKAGES


@pytest.mark.parametrize(
    "name",
    [
        "scenes/library/data/cornell-box.exr",
        "comparisons/known.toml",
        "comparisons/results.schema.json",
        "scenes/scene.schema.json",
        "reports/templates/report.html.j2",
    ],
)
def test_data_is_shipped(wheel: Path, name: str) -> None:
    assert name in zipfile.ZipFile(wheel).namelist()


def test_imports_point_one_way() -> None:
    found = subprocess.run(
        [sys.executable, "-c", "from importlinter.cli import lint_imports_command as main; main()"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert found.returncode == 0, found.stdout


def test_the_tracer_needs_numpy_alone() -> None:
    """Beside NumPy it imports scenes, and what scenes need; no renderer, no SciPy, no report."""
    code = "import sys, reference_tracer.operators, reference_tracer.random_walk; print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True, timeout=60
    )
    modules = {name.split(".")[0] for name in loaded.stdout.split()}
    assert {"numpy", "scenes"} <= modules
    assert not modules & {"mitsuba", "scipy", "comparisons", "reports", "lightproof", "skimage", "bokeh"}


def test_pytest_finds_the_plugin_in_the_wheel(wheel: Path) -> None:
    [name] = [name for name in zipfile.ZipFile(wheel).namelist() if name.endswith("/entry_points.txt")]
    text = zipfile.ZipFile(wheel).read(name).decode()
    assert "[pytest11]\nlightproof = lightproof.pytest_plugin\n" in text
