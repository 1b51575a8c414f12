"""The folder of results in, the page out: what it says, what it must not do, and what it survives."""

from __future__ import annotations

import base64
import html.parser
import io
import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import OpenImageIO
import pytest
from PIL import Image

import reports
from comparisons.results import Metrics, Results, ResultsError, read, write
from reports.html import FEW, web_link
from scenes.formats import exr

pytestmark = pytest.mark.xdist_group(
    "report"
)  # reports that are rendered once, a browser that is started once


class Page(html.parser.HTMLParser):
    """The tags, links and visible text of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self._raw = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self._raw = tag in {"script", "style"}

    def handle_endtag(self, tag: str) -> None:
        self._raw = False

    def handle_data(self, data: str) -> None:
        if not self._raw:
            self.words.append(data)

    @property
    def text(self) -> str:
        return re.sub(r"\s+", " ", " ".join(self.words))

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.tags if name == tag]


def rendered(folder: Path) -> Page:
    path, _ = reports.render(folder)
    return Page(path.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def page(run: Path) -> Page:
    return rendered(run)


def alone(results: Results, folder: Path, *indices: int) -> None:
    """Leave but these of the comparisons."""
    write(msgspec.structs.replace(results, comparisons=[results.comparisons[i] for i in indices]), folder)


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


@pytest.mark.parametrize("damage", ["missing", "cut short", "no image", "another size"])
def test_a_damaged_image_is_said_at_its_place(results: Results, tmp_path: Path, damage: str) -> None:
    alone(results, tmp_path, 0, 2)  # what is said of one, and another one that goes on
    file = tmp_path / "pass.renderer.exr"
    if damage == "missing":
        file.unlink()
    elif damage == "cut short":
        file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    elif damage == "no image":
        file.write_text("no image")
    else:
        exr.write_bounces(file, np.ones((2, 8, 16, 3)))
    page = rendered(tmp_path)
    assert page.text.count("The images can't be shown.") == 1
    assert len(page.all("img")) == 2 * 7
    if damage == "another size":
        assert "the renderer's file 2 bounces of 16 × 8 pixels in 3 channels" in page.text


def test_an_image_of_other_layers_is_said_too(results: Results, tmp_path: Path) -> None:
    alone(results, tmp_path, 0)
    spec = OpenImageIO.ImageSpec(4, 4, 1, OpenImageIO.FLOAT)
    spec.channelnames = ["bounce0.Z"]
    out = OpenImageIO.ImageOutput.create(str(tmp_path / "pass.truth.exr"))
    out.open(str(tmp_path / "pass.truth.exr"), spec)
    out.write_image(np.zeros((4, 4, 1), np.float32))
    out.close()
    assert rendered(tmp_path).text.count("The images can't be shown.") == 1


def test_pixels_that_are_not_finite_do_not_stop_the_report(results: Results, tmp_path: Path) -> None:
    alone(results, tmp_path, 0)
    file = tmp_path / "pass.renderer.exr"
    mean, error = exr.read_bounces(file)
    mean[1, 3, 4], mean[2, 5, 6] = np.nan, np.inf
    exr.write_bounces(file, mean, error)
    assert len(rendered(tmp_path).all("img")) == 7 * 7


def test_large_images_are_averaged(results: Results, tmp_path: Path) -> None:
    alone(results, tmp_path, 2)
    for side in ("truth", "renderer"):
        exr.write_bounces(tmp_path / f"grey.{side}.exr", np.ones((2, 300, 600, 1)))
    page = rendered(tmp_path)
    assert "Each pixel shown is the average of 3 × 3 pixels." in page.text
    assert [image["width"] for image in page.all("img")].count("200") == 2 * 6


VISIBLE = tuple(range(380, 781, 10))


def equal_energy(folder: Path, wavelengths: tuple[int, ...] | None = VISIBLE) -> None:
    """Give the spectral comparison images of the same radiance at every wavelength: 1, then none."""
    mean = np.stack([np.ones((8, 8, 41)), np.zeros((8, 8, 41))])
    exr.write_bounces(folder / "five.truth.exr", mean, wavelengths=VISIBLE)
    exr.write_bounces(folder / "five.renderer.exr", 1.1 * mean, wavelengths=wavelengths)


def test_spectra_are_shown_in_colour(results: Results, tmp_path: Path) -> None:
    alone(results, tmp_path, 3)
    equal_energy(tmp_path)
    page = rendered(tmp_path)
    assert "Truth and renderer show 41 wavelengths" in page.text
    assert "grey mean" not in page.text
    # of E on both sides, E in the first sum and E + TE in the second; TE has no light, and so no chromaticity
    assert page.text.count("x 0.333, y 0.333") == 6
    [source] = {str(image["src"]) for image in page.all("img") if image["alt"] == "E, truth, exposure ×0.66"}
    picture = Image.open(io.BytesIO(base64.b64decode(source.partition(",")[2])))
    # equal energy is XYZ = (1, 1, 1), so linear sRGB is what the rows of IEC 61966-2-1's matrix add up to
    linear = 0.66 * np.array([1.2048, 0.9483, 0.9087])
    np.testing.assert_allclose(
        picture.convert("RGB").getpixel((3, 3)), 255 * (1.055 * linear ** (1 / 2.4) - 0.055), atol=1
    )


@pytest.mark.parametrize("wavelengths", [None, tuple(range(385, 786, 10))], ids=["none", "others"])
def test_two_sides_of_different_wavelengths_are_not_compared(
    results: Results, tmp_path: Path, wavelengths: tuple[int, ...] | None
) -> None:
    alone(results, tmp_path, 3)
    equal_energy(tmp_path, wavelengths)
    assert "The channels of the two files are different wavelengths." in rendered(tmp_path).text


@pytest.fixture(scope="module")
def many(run_of_many: Path) -> Path:
    """The report of a run of each comparison twice."""
    path, _ = reports.render(run_of_many)
    return path


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


@pytest.mark.browser
@pytest.mark.parametrize(
    "options", [{}, {"color_scheme": "dark"}, {"viewport": {"width": 390, "height": 800}}], ids=str
)
def test_in_a_browser(page: Page, run: Path, open_report: Any, options: dict[str, Any]) -> None:
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


# ---- relations


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


@pytest.mark.browser
def test_relations_in_a_browser(with_relations: Results, tmp_path: Path, open_report: Any) -> None:
    # a look at one comparison's plots will do: those of all six have been drawn above
    write(msgspec.structs.replace(with_relations, comparisons=with_relations.comparisons[1:2]), tmp_path)
    reports.render(tmp_path)
    page = open_report(tmp_path / "report.html")
    assert "superposition" in page.inner_text("body")
