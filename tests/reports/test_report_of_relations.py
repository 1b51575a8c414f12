"""What the page says of relations, and where there are none."""

from __future__ import annotations

import re
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import msgspec
import pytest

from comparisons.results import Results, write

pytestmark = pytest.mark.xdist_group("report")  # rendered once, on the worker of test_report.py

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("page.py"))))
Page, rendered = shared.Page, shared.rendered


@pytest.fixture(scope="module")
def related(run_with_relations: Path) -> Page:
    return rendered(run_with_relations)


@pytest.mark.parametrize(
    "said",
    [
        "3 of 13 checks failed, 2 ended in an error, 2 stayed inconclusive.",
        "Both sides agree: pass. A deviation of 1.4 % of the whole image would have failed with 90 % power.",
        "In bounce 1 the first side is 4.0 % above the second (interval +3.70 to +4.30 %, tolerance ±1.0 %): fail.",
        "it takes no notice of its seed: fail.",
        "In bounce 1 the first side is 1.3 % above the second",
        "as declared: known.",
        "one replicate dominates",
        "Declared: 1.3 % in bounce 1, confirmed. the ray offset",
        "what is wrong on both sides",
        "25° and 50°",
        "exit code 139: error.",
        "64 samples per pixel and side in 32 replicates",
    ],
)
def test_the_page_says_of_relations(related: Page, said: str) -> None:
    assert said in related.text


def test_texts_of_relations_are_escaped(related: Page, run_with_relations: Path) -> None:
    text = (run_with_relations / "report.html").read_text(encoding="utf-8")
    assert "<script>alert" not in text
    assert not re.search("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe]", text.replace("\r", ""))
    anchors = {a["id"] for _, a in related.tags if a.get("id")}
    assert {str(a["href"])[1:] for a in related.all("a") if str(a["href"]).startswith("#")} <= anchors


def test_a_run_of_relations_alone(with_relations: Results, tmp_path: Path) -> None:
    write(msgspec.structs.replace(with_relations, comparisons=[]), tmp_path)
    page = rendered(tmp_path)
    assert "This run tried relations only." in page.text
    assert "2 of 7 checks failed, 1 ended in an error, 1 stayed inconclusive." in page.text


def test_a_page_without_relations_says_nothing_of_them(page: Page) -> None:
    assert "Relations" not in page.words
