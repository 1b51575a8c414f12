"""foreign-renderer.md: its commands are run, in order, and print what the page says, numbers aside.

So this is also where the program in examples/tiny is held against cases through the command adapter.
"""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
VERDICTS = "pass|fail|inconclusive|known|unsupported|error"

pytestmark = pytest.mark.xdist_group("tiny")


def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("foreign_renderer", ROOT / "docs" / "foreign_renderer.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


SCRIPT = script()
TEXT = SCRIPT.PAGE.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def rewritten() -> str:
    compiler = all(map(shutil.which, ("make", "g++", "pkg-config")))
    if not compiler or subprocess.run(["pkg-config", "--exists", "OpenEXR", "nlohmann_json"]).returncode:
        if os.environ.get("CI") == "true":
            pytest.fail("the C++ compiler or its libraries are missing, and CI has to build the example")
        pytest.skip("no C++ compiler with OpenEXR and nlohmann-json")
    return str(SCRIPT.rewritten(TEXT))


def without_progress(text: str) -> str:
    """Numbers, and what depends on how fast the machine is, left out; of validations the verdicts stay."""
    kept = [line for line in text.splitlines() if not re.match(r"\[\d+/\d+\]|      Bounce \d|Report: ", line)]
    # relation, scene, renderer: how far a question of two seconds comes depends on the machine
    kept = [re.sub(rf"^(  \S+ +\S+ +tiny\S* +)({VERDICTS})\b.*", r"\1", line) for line in kept]
    kept = [re.sub(r"(checks failed), \d+ stayed inconclusive\.", r"\1.", line) for line in kept]
    return re.sub(r"[ ─]+", " ", re.sub(r"[+−]?\d[\d.]*[!?t]*", "#", "\n".join(kept)))


def verdicts(text: str) -> list[tuple[str, str, str]]:
    return re.findall(rf"^  (\S+) +(tiny\S*) +({VERDICTS})\b", text, re.MULTILINE)


def test_the_commands_print_what_the_page_says(rewritten: str) -> None:
    assert without_progress(rewritten) == without_progress(TEXT), "it is old: python docs/foreign_renderer.py"


def test_the_verdicts_through_the_adapter(rewritten: str) -> None:
    assert verdicts(rewritten) == [
        ("furnace-box", "tiny", "pass"),
        ("integrating-sphere", "tiny", "pass"),
        ("cie-171-glass", "tiny", "pass"),
        ("metal-angles", "tiny", "unsupported"),
        ("furnace-box", "tiny-sums", "pass"),
        ("furnace-box", "tiny", "fail"),  # without the cosine
        ("furnace-box", "tiny-sums", "fail"),  # one bounce too many
    ]


def test_the_planted_mistake_is_where_the_page_looks_for_it() -> None:
    """A ``sed`` that finds nothing changes nothing."""
    source = (SCRIPT.EXAMPLE / "path_tracer.cpp").read_text()
    assert source.count(" dot(vertex.n, light.wi) / pdf") == 1
    assert source.count(" 1 / pdf") == 0


def test_the_links_lead_somewhere() -> None:
    for target in re.findall(r"\]\(([^)#]+)", TEXT):
        assert (SCRIPT.PAGE.parent / target).exists(), target


def test_no_path_of_a_machine_is_printed() -> None:
    assert not re.search(r"/(tmp|home|work)/", TEXT)
