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

pytestmark = pytest.mark.xdist_group("docs-cases")  # all answers are evaluated once

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


def test_a_bounce_without_light_has_no_picture_and_is_named() -> None:
    images = np.zeros((4, 8, 8, 3))
    images[1], images[3] = np.linspace(0.1, 0.8, 8)[:, None], np.linspace(0.01, 0.08, 8)[:, None]
    made = CASES.case("quad-over-plane")
    assert CASES.strip(images).shape == (128, 2 * 128 + 4, 3)
    [picture, caption] = CASES._picture(made, images)
    assert picture.startswith("![TE, T³E](")
    assert caption == "*Exposures: TE ×1, T³E ×10. No light: E, T²E.*\n"


def test_uniform_bounces_share_an_exposure_and_have_a_table() -> None:
    images = np.broadcast_to(np.array([1.0, 0.5, 0.25])[:, None, None, None], (3, 8, 8, 3))
    assert CASES.exposures(images) == {0: 0.8, 1: 0.8, 2: 0.8}
    assert CASES._picture(CASES.case("furnace-box"), images)[1] == "*Exposure: ×0.8 for all.*\n"
    assert "| 1, 1, 1 | 0.5, 0.5, 0.5 |" in CASES.page(CASES.FAMILIES[0])


def test_spectral_cases_are_in_colour() -> None:
    """The left wall is red, the right one green."""
    made = CASES.case("cornell-box-spectral")
    images = CASES.truth(made)
    direct = CASES.strip(CASES.shown(made, images))[:, 132:260].astype(int)
    left, right = direct[64, 4], direct[64, -4]
    assert left[0] > 2 * left[1]
    assert right[1] > right[0]
    [line] = CASES._spectrum(made, images)
    assert "38, from 404 to 700 nm" in line
    assert CASES._spectrum(CASES.case("furnace-box"), images) == []
    furnace = CASES.case("furnace-equal-energy")
    [line] = CASES._spectrum(furnace, CASES.truth(furnace))
    assert line.count("(0.333, 0.333)") == 6


def test_an_answer_that_is_no_formula_states_its_error() -> None:
    """Of each committed bounce; the standard error in the channel in which it is largest."""
    computed, estimated = CASES.case("facing-squares"), CASES.case("cornell-box")
    [line] = CASES._error(computed)
    assert line.startswith("- **Error, relative**: E 9.8e-09, TE 4.9e-08, ")
    assert line.count("T") == 6
    [line] = CASES._error(estimated)
    data = estimated.answer.truth(estimated.scene, 6)
    blue = np.linalg.norm(data.stderr[6, ..., 2]) / data.mean[6, ..., 2].sum()
    assert line.endswith(f", T⁶E {blue:.1e}.")
    assert CASES._error(CASES.case("furnace-box")) == []
    assert "0 to 6 as data" in CASES._last(computed)
    assert (CASES._last(CASES.case("furnace-box")), CASES._last(CASES.case("glass-slab"))) == (
        "any",
        "up to 12",
    )


def test_a_meter_has_a_table() -> None:
    lines = CASES._table(np.array([[[[0.0, 1.5]]], [[[0.25, 2.0]]]]))
    assert lines == ["| E | TE |", "|---|---|", "| 0, 1.5 | 0.25, 2 |\n"]


@pytest.mark.parametrize("file", sorted(FOLDER.glob("*.md")), ids=lambda file: file.name)
def test_pictures_that_pages_name_are_there(file: Path) -> None:
    for picture in re.findall(r"\]\(([\w.-]+\.webp)\)", file.read_text()):
        assert (FOLDER / picture).exists()
