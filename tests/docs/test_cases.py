"""The pages of the cases are those that their script writes; the pictures show the answers."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "cases"


def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("docs_cases", ROOT / "docs" / "cases.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


CASES = script()


def test_the_pages_are_up_to_date() -> None:
    expected = dict(CASES.pages())
    found = {file.name: file.read_text() for file in FOLDER.glob("*.md")}
    assert set(found) == set(expected)
    for name, text in expected.items():
        assert found[name] == text, f"docs/cases/{name} is old: python docs/cases.py"


def test_every_picture_is_the_answer() -> None:
    expected = dict(CASES.pictures())
    assert {file.name for file in FOLDER.glob("*.webp")} == set(expected)
    for name, pixels in expected.items():
        found = np.asarray(Image.open(FOLDER / name).convert("RGB"))
        assert found.shape == pixels.shape
        # a byte may round the other way on another machine
        assert np.abs(found.astype(int) - pixels.astype(int)).max() <= 1, f"docs/cases/{name} is old"


def test_a_meter_has_a_table() -> None:
    lines = CASES._table(np.array([[[[0.0, 1.5]]], [[[0.25, 2.0]]]]))
    assert lines == ["| E | TE |", "|---|---|", "| 0, 1.5 | 0.25, 2 |\n"]


@pytest.mark.parametrize("file", sorted(FOLDER.glob("*.md")), ids=lambda file: file.name)
def test_pictures_that_pages_name_are_there(file: Path) -> None:
    for picture in re.findall(r"\]\(([\w.-]+\.webp)\)", file.read_text()):
        assert (FOLDER / picture).exists()
