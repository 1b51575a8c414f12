"""The folder of results in, the page out: what it says, what it must not do, and what it survives."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import msgspec
import pytest

import reports
from comparisons.results import Metrics, Results, ResultsError, read, write
from reports.html import FEW, web_link

pytestmark = pytest.mark.xdist_group("report")  # rendered once, for test_report_in_a_browser.py too

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("page.py"))))
Page, alone, rendered = shared.Page, shared.alone, shared.rendered


def test_render_writes_two_files_into_the_folder(results: Results, tmp_path: Path) -> None:
    alone(results, tmp_path, 4)
    assert reports.render(tmp_path) == [tmp_path / "report.html", tmp_path / "junit.xml"]


def test_a_folder_without_results_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(ResultsError, match=r"results\.json"):
        reports.render(tmp_path)


@pytest.mark.parametrize(
    "said",
    [
        "1 of 6 comparisons failed, 1 ended in an error, 1 stayed inconclusive.",
        "2025-11-03 09:30 UTC",
        "Bounce 1 is 3.1 % high (interval +2.80 to +3.40 %, tolerance ±1.0 %): fail. Bounce 2 ended the same",
        "a tile: +12.0 ± 3.0 %",
        "All 7 bounces agree with the exact truth within tolerance: pass.",
        "Bounce 1 is undecided (interval +0.60 to +1.20 %, tolerance ±1.0 %): inconclusive, which is",
        "Bounce 1 is 4.0 % low (interval −4.30 to −3.70 %, tolerance ±1.0 %), as declared: known.",
        "no dielectric materials",
        "vanished (remove the entry)",
        "the direction of reflection",
        "since the walls are equal",
        "a geometric series, see its derivation",
        "so what is not positive is left out: bounce 3.",
        "The pictures show the grey mean of 5 channels.",
        "lightproof validate --only 'a case'",
        "This comparison has no images.",
    ],
)
def test_the_page_says(page: Page, said: str) -> None:
    assert said in page.text


def test_every_verdict_is_written_out_and_not_only_coloured(page: Page) -> None:
    for verdict in ("pass", "fail", "inconclusive", "known", "unsupported", "error"):
        assert f"1 {verdict}" in page.text


def test_texts_are_escaped_and_free_of_control_characters(page: Page, run: Path) -> None:
    text = (run / "report.html").read_text(encoding="utf-8")
    assert "<script>alert" not in text
    assert "sphere <script>alert(1)</script>" in page.text
    assert not re.search("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe]", text.replace("\r", ""))
    assert "[31m" not in page.text


def test_only_web_links_become_links(page: Page) -> None:
    targets = {a["href"] for a in page.all("a") if not str(a["href"]).startswith("#")}
    assert targets == {"https://example.org/issues/1"}
    assert "javascript:alert(1)" in page.text


@pytest.mark.parametrize(
    ("link", "kept"),
    [
        ("https://a.org/x?y=1#z", True),
        ("http://a.org", True),
        ("JavaScript:alert(1)", False),
        ("java\nscript:alert(1)", False),
        ("data:text/html,x", False),
        ("//a.org/x", False),
        ("https:///x", False),
        ("http://[", False),
        ("", False),
    ],
)
def test_web_links(link: str, kept: bool) -> None:
    assert bool(web_link(link)) is kept


def test_nothing_is_loaded_from_elsewhere(page: Page) -> None:
    sources = [a.get("src") or "" for tag in ("img", "script", "iframe", "source") for a in page.all(tag)]
    assert all(source.startswith("data:") for source in sources if source)
    assert [str(link["href"])[:5] for link in page.all("link")] == ["data:"]


def test_pictures_have_alternatives_and_anchors_have_targets(page: Page) -> None:
    images = page.all("img")
    # per bounce four rows, per partial sum three
    assert len(images) == (7 + 4 + 2 + 2) * 7
    assert all(image["alt"] for image in images)
    names = {attributes["id"] for _, attributes in page.tags if attributes.get("id")}
    assert {str(a["href"])[1:] for a in page.all("a") if str(a["href"]).startswith("#")} <= names


def test_only_the_bounces_that_did_not_pass_carry_a_marker(page: Page) -> None:
    assert len([a for a in page.all("span") if a.get("class") == "marker"]) == 4


def test_metrics_of_terms_and_sums(results: Results, tmp_path: Path) -> None:
    first = results.comparisons[0]
    of_term = Metrics(
        bounces=1, nrmse=0.1, psnr=None, ssim=0.5, rmse=0.2, rel_mse=0.03, flip=0.0625, delta_e=1.75
    )
    write(
        msgspec.structs.replace(
            results, comparisons=[msgspec.structs.replace(first, term_metrics=[of_term])]
        ),
        tmp_path,
    )
    text = rendered(tmp_path).text
    assert "Partial sum RMSE NRMSE relMSE PSNR, dB SSIM HDR-FLIP ΔE₀₀" in text
    assert "TE 0.2 0.1 0.03 not defined 0.5 0.0625 1.75" in text


def sections(page: Page) -> dict[str, bool]:
    """Their names, and whether they are open."""
    return {
        str(section["id"]): "open" in details
        for (name, section), (_, details) in pairwise(page.tags)
        if name == "section"
    }


def test_few_sections_are_open_and_of_many_those_that_did_not_pass(page: Page, many: Path) -> None:
    assert len(sections(page)) == FEW
    assert all(sections(page).values())
    assert page.all("nav") == []
    long = Page(many.read_text(encoding="utf-8"))
    found = read(many.parent).comparisons
    passes = [f"comparison-{i}" for i, c in enumerate(found, start=1) if c.verdict == "pass"]
    assert len(passes) == 2
    assert sections(long) == {f"comparison-{i}": f"comparison-{i}" not in passes for i in range(1, 13)}
    assert len(long.all("nav")) == 1


def test_the_index_has_every_comparison_once_and_fails_first(many: Path) -> None:
    text = many.read_text(encoding="utf-8")
    index = Page(text[text.index("<nav") : text.index("</nav>")])
    links = [str(a["href"]) for a in index.all("a")]
    assert sorted(links) == sorted(f"#comparison-{i}" for i in range(1, 13))
    assert links[:2] == ["#comparison-2", "#comparison-8"]
    assert links[-2:] == ["#comparison-1", "#comparison-7"]
    assert "furnace mitsuba" in index.text, "renderers are named where there are several"


def test_an_empty_run_is_no_pass(results: Results, tmp_path: Path) -> None:
    write(msgspec.structs.replace(results, comparisons=[]), tmp_path)
    page = rendered(tmp_path)
    assert "Nothing was compared." in page.text
    assert page.all("img") == []
