"""A folder of results with every verdict, and a browser that complains."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from comparisons.results import (
    BounceResult,
    ChannelResult,
    Comparison,
    Images,
    KnownDeviation,
    Look,
    Metrics,
    Place,
    Provenance,
    Results,
    TileResult,
    write,
)
from scenes.formats import exr

SCRIPT = "<script>alert(1)</script>"
CONTROL = "\x1b[31mred\x1b[0m\x00\x08 bell\x07 \ufffe"


def bounce(k: int, verdict: Any, bias: float = 0.0, *, truth: float = 0.5, **changes: Any) -> BounceResult:
    """A bounce whose interval is ± 0.3 %, held against 1 %; its worst tile is in row 1, column 2 of 4 × 4."""
    interval = bias - 0.003, bias + 0.003
    fields = {
        "bounce": k,
        "verdict": verdict,
        "decided_by": "image",
        "channel": "G",
        "truth_mean": truth,
        "denominator": truth or 0.25,
        "mean": truth * (1 + bias),
        "bias": bias,
        "interval": interval,
        "standard_error": 0.001,
        "tolerance": 0.01,
        "tile_tolerance": 0.05,
        "detectable_bias": 0.0142,
        "resolution": 0.0042,
        "channels": [
            ChannelResult(
                channel=name,
                truth_mean=truth,
                denominator=truth or 0.25,
                mean=truth * (1 + bias),
                bias=bias,
                interval=interval,
                standard_error=0.001,
                detectable_bias=0.0142,
                resolution=0.0042,
            )
            for name in "RGB"
        ],
        "worst_tile": tile(bias + 0.005, 0.01),
    }
    return BounceResult(**(fields | changes))


def tile(bias: float, half: float) -> TileResult:
    place = Place(row=1, column=2, x0=32, y0=16, x1=48, y1=32)
    interval = bias - half, bias + half
    return TileResult(place=place, channel="R", bias=bias, interval=interval, detectable_bias=0.071)


def comparison(
    case: str, renderer: str, verdict: Any, bounces: list[BounceResult], **changes: Any
) -> Comparison:
    fields = {
        "case": case,
        "renderer": renderer,
        "verdict": verdict,
        "truth": "exact",
        "seconds": 12.5,
        "spp": 1024,
        "replicates": 64,
        "bounces": bounces,
        "title": f"The {case} case",
        "blind_to": "the direction of reflection",
        "renderer_version": "3.7.1",
        "truth_source": "a geometric series, see its derivation",
        "width": 64,
        "height": 64,
        "channels": ["R", "G", "B"],
        "tiles": (4, 4),
        "alpha": 0.05,
        "looks": [Look(replicates=32, seconds=4.0, alpha=0.025, open_bounces=[1, 2])],
        "metrics": [
            Metrics(bounces=k, nrmse=0.01 * k, psnr=None if k == 0 else 40.0, ssim=0.99) for k in range(2)
        ],
    }
    return Comparison(**(fields | changes))


def pictures(
    folder: Path, name: str, bounces: int, channels: int = 3, *, factor: float = 1.0, dark: int = -1
) -> Images:
    """Write a truth and a noisy renderer, wrong by a factor in bounce 1; one bounce may hold no light."""
    rng = np.random.default_rng(7)
    y, x = np.mgrid[0:64, 0:64] / 64
    base = (1.2 + np.sin(7 * x) * np.cos(5 * y))[..., None] * np.linspace(1, 0.4, channels)
    truth = np.stack([base * 0.5**k for k in range(bounces)])
    truth[0] *= ((x > 0.4) & (x < 0.6) & (y < 0.2))[..., None] * 12
    if dark >= 0:
        truth[dark] = 0
    error = 0.03 * truth
    renderer = truth + error * rng.standard_normal(truth.shape)
    if bounces > 1:
        renderer[1] *= factor
    names = Images(truth=f"{name}.truth.exr", renderer=f"{name}.renderer.exr")
    exr.write_bounces(folder / names.truth, truth)
    exr.write_bounces(folder / names.renderer, renderer, error)
    return names


def every_verdict(folder: Path) -> Results:
    """Write a run with all six verdicts, hostile texts, a bounce without energy and odd channels."""
    known = KnownDeviation(
        declared_bias=-0.04,
        state="confirmed",
        reason=f"rounding {SCRIPT}",
        link="https://example.org/issues/1",
    )
    bad_link = KnownDeviation(declared_bias=0.02, state="vanished", reason="old", link="javascript:alert(1)")
    in_tile = bounce(2, "fail", 0.001, truth=0.12, decided_by="tile", worst_tile=tile(0.12, 0.03))
    passing = [bounce(k, "pass", 0.001 * (-1) ** k, truth=0.5**k) for k in range(7)]
    comparisons = [
        comparison("cornell_box", "mitsuba", "pass", passing, images=pictures(folder, "pass", 7)),
        comparison(
            "furnace",
            "mitsuba",
            "fail",
            [bounce(0, "pass"), bounce(1, "fail", 0.031, truth=0.25), in_tile, bounce(3, "pass", truth=0.0)],
            images=pictures(folder, "fail", 4, factor=1.031, dark=3),
            message=f"budget {SCRIPT}",
            notes=["depends on a convention", "a second note"],
        ),
        comparison(
            f"sphere {SCRIPT}",
            "reference",
            "inconclusive",
            [bounce(0, "pass"), bounce(1, "inconclusive", 0.009, truth=1e-7)],
            images=pictures(folder, "grey", 2, channels=1),
            message="The budget of 10 s is used up.",
            title=f"{SCRIPT}{CONTROL}",
            channels=["Y"],
        ),
        comparison(
            "spectral",
            "pyrender",
            "known",
            [bounce(0, "pass", known=bad_link), bounce(1, "known", -0.04, truth=0.2, known=known)],
            images=pictures(folder, "five", 2, channels=5, factor=0.96),
            channels=[f"{w} nm" for w in range(400, 900, 100)],
        ),
        comparison("glass", "pyrender", "unsupported", [], message="no dielectric materials"),
        comparison(
            "furnace",
            "broken",
            "error",
            [],
            message=f"exit code 139 {SCRIPT}{CONTROL}",
            log=["starting", f"{CONTROL}", f"]]> {SCRIPT} & more"],
        ),
    ]
    provenance = Provenance(
        date="2025-11-03T09:30:00Z",
        command_line=["lightproof", "validate", "--only", "a case"],
        versions={"lightproof": "0.1.0", "numpy": "2.4.6"},
        platform="Linux x86_64",
        processors=8,
        seed=1,
        seeds="SeedSequence(seed).spawn",
        budget=60.0,
        alpha=0.05,
        jobs=4,
        seconds=187.0,
    )
    results = Results(provenance=provenance, comparisons=comparisons)
    write(results, folder)
    return results


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of results for tests that change nothing in it."""
    folder = tmp_path_factory.mktemp("run")
    every_verdict(folder)
    return folder


@pytest.fixture
def results(tmp_path: Path) -> Results:
    return every_verdict(tmp_path)


@pytest.fixture
def make_bounce() -> Callable[..., BounceResult]:
    return bounce


@pytest.fixture
def make_comparison() -> Callable[..., Comparison]:
    return comparison


class Watched:
    """A page and everything on it that a report must not do."""

    def __init__(self, page: Any, file: Path) -> None:
        self.page, self.complaints = page, list[str]()
        own = file.resolve().as_uri()
        page.on("console", self._on_console)
        page.on("pageerror", lambda error: self.complaints.append(f"page error: {error}"))
        page.on("request", lambda request: self._on_request(request.url, own))

    def _on_console(self, message: Any) -> None:
        if message.type in {"error", "warning"}:
            self.complaints.append(f"console {message.type}: {message.text}")

    def _on_request(self, url: str, own: str) -> None:
        if url.partition("#")[0] != own and not url.startswith(("data:", "blob:")):
            self.complaints.append(f"request: {url[:200]}")


OpenReport = Callable[..., Any]


@pytest.fixture
def open_report() -> Iterator[OpenReport]:
    """``open_report(path)`` opens a report in Chromium, checks it, and returns the page for further checks.

    It fails on any error or warning in the console, any request but the file itself, any image that does not
    load and, unless ``plots=False``, any plot that is not drawn. Options go to Playwright's ``new_page``.
    """
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        if os.environ.get("CI") == "true":
            pytest.fail("chromium is not installed, and CI has to test the report in a browser")
        pytest.skip("chromium is not installed")
    with _browser(chromium) as browser:
        yield lambda path, *, plots=True, **options: _checked(browser, path, plots, options)


@contextmanager
def _browser(executable: str) -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    quiet = [
        "--disable-background-networking",
        "--disable-component-update",
        "--disable-sync",
        "--no-first-run",
    ]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=executable, args=["--no-sandbox", "--disable-gpu", *quiet]
        )
        try:
            yield browser
        finally:
            browser.close()


def _checked(browser: Any, path: Path, plots: bool, options: dict[str, Any]) -> Any:
    watched = Watched(browser.new_page(**({"viewport": {"width": 1280, "height": 900}} | options)), path)
    page = watched.page
    page.goto(path.resolve().as_uri())
    page.wait_for_load_state("load")
    if plots:
        # Playwright's selectors look into the shadow roots that Bokeh draws in
        page.wait_for_selector(".plot canvas", state="attached")
        page.wait_for_function("() => Bokeh.documents.length && Bokeh.documents.every(d => d.is_idle)")
        for plot in page.query_selector_all(".plot"):
            canvas = plot.query_selector("canvas")
            assert canvas is not None, "a plot has no canvas"
            assert canvas.evaluate(_HAS_INK), "a plot is empty"
    unseen = page.evaluate("() => [...document.images].filter(i => !i.naturalWidth).map(i => i.alt)")
    assert not unseen, f"images that don't load: {unseen}"
    page.wait_for_timeout(200)
    assert not watched.complaints
    return page


_HAS_INK = """canvas => {
  const {width, height} = canvas;
  return width > 0 && canvas.getContext("2d").getImageData(0, 0, width, height).data.some(v => v);
}"""
