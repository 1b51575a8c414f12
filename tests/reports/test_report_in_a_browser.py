"""The page in a real browser, which loads nothing from elsewhere and complains of nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import pytest

import reports
from comparisons.results import Results, write

pytestmark = pytest.mark.xdist_group("report")  # one browser, and the reports of test_report.py


@pytest.mark.browser
@pytest.mark.parametrize(
    "options", [{}, {"color_scheme": "dark"}, {"viewport": {"width": 390, "height": 800}}], ids=str
)
def test_in_a_browser(page: Any, run: Path, open_report: Any, options: dict[str, Any]) -> None:
    shown = open_report(run / "report.html", **options)
    assert shown.locator("h1").inner_text().startswith("1 of 6 comparisons failed")
    assert shown.locator(".plot").count() == 8
    # wide tables and galleries scroll inside their boxes, the page itself never sideways
    assert shown.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    shown.locator(".verdicts td a.fail").first.click()
    assert shown.url.endswith("#comparison-2")


@pytest.mark.browser
def test_a_link_opens_its_section_and_draws_its_plots(many: Path, open_report: Any) -> None:
    page = open_report(many)
    plots = page.locator("#comparison-7 .plot canvas")
    assert not page.locator("#comparison-7 .finding").is_visible()
    assert plots.count() == 0
    page.locator("nav a[href='#comparison-7']").click()
    assert page.locator("#comparison-7 .finding").is_visible()
    plots.first.wait_for(state="attached")
    page.goto(f"{many.resolve().as_uri()}#comparison-1")
    page.reload()
    assert page.locator("#comparison-1 .finding").is_visible()


@pytest.mark.browser
def test_a_report_without_plots_in_a_browser(results: Results, tmp_path: Path, open_report: Any) -> None:
    write(msgspec.structs.replace(results, comparisons=results.comparisons[-2:]), tmp_path)
    path, _ = reports.render(tmp_path)
    assert open_report(path, plots=False).locator(".plot").count() == 0


@pytest.mark.browser
def test_relations_in_a_browser(with_relations: Results, tmp_path: Path, open_report: Any) -> None:
    # a look at one comparison's plots will do: those of all six have been drawn above
    write(msgspec.structs.replace(with_relations, comparisons=with_relations.comparisons[1:2]), tmp_path)
    reports.render(tmp_path)
    page = open_report(tmp_path / "report.html")
    assert "superposition" in page.inner_text("body")


@pytest.mark.browser
def test_the_browser_check_notices_what_it_is_there_for(tmp_path: Path, open_report: Any) -> None:
    bad = {
        "console": "<script>console.warn('x')</script>",
        "page": "<script>throw new Error('x')</script>",
        "request": "<img src='file:///nowhere.png' alt='far'>",
        "image": "<img src='data:image/png;base64,AAAA' alt='broken'>",
    }
    for name, body in bad.items():
        path = tmp_path / f"{name}.html"
        path.write_text(f"<!doctype html><link rel=icon href='data:,'>{body}", encoding="utf-8")
        with pytest.raises(AssertionError):
            open_report(path, plots=False)
