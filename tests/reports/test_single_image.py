"""The report of one finished image, which is a sum of bounces, or has a layer for each."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest
from junitparser import JUnitXml

import reports
from comparisons.results import (
    BounceResult,
    Comparison,
    Images,
    Metrics,
    Outlier,
    ResidualNoise,
    Results,
    SingleImage,
    read,
    write,
)
from scenes.formats import exr

SCRIPT = "<script>alert(1)</script>"


@pytest.fixture
def finished(
    results: Results,
    tmp_path: Path,
    make_comparison: Callable[..., Comparison],
    make_bounce: Callable[..., BounceResult],
) -> Callable[[bool], str]:
    """Writes a folder of one finished image, a sum or two layers, and gives its page."""

    def make(summed: bool) -> str:
        layers = [5] if summed else [0, 1]
        noise = ResidualNoise(
            correlation=0.4,
            correlation_error=0.01,
            reach=2,
            inflation=3.0,
            outliers=1,
            brightest_outliers=[Outlier(x=7, y=9, channel="G", value=50.0, truth=0.5)],
        )
        verdicts = ["fail", "pass"]
        images = Images(truth="truth.exr", renderer="image.exr")
        truth, _ = exr.read_bounces(tmp_path / "pass.truth.exr")
        exr.write_bounces(tmp_path / "truth.exr", truth[: len(layers)])
        exr.write_bounces(tmp_path / "image.exr", 1.03 * truth[: len(layers)])
        comparison = make_comparison(
            "cornell_box",
            f"{SCRIPT}.exr",
            "fail",
            [
                make_bounce(k, verdict, 0.031 if verdict == "fail" else 0.0, spp=0, replicates=0)
                for k, verdict in zip(layers, verdicts, strict=False)
            ],
            replicates=0,
            looks=[],
            images=images,
            renderer_version="",
            metrics=[Metrics(bounces=k, nrmse=0.03, psnr=30.0, ssim=0.9, rmse=0.01) for k in layers],
            single_image=SingleImage(
                file="box.exr",
                summed=summed,
                independent=False,
                noise=[noise] * len(layers),
                limits=["Which bounce is wrong does not show."],
                hints=[f"It seems to be {SCRIPT}."],
            ),
        )
        provenance = msgspec.structs.replace(results.provenance, budget=0.0)
        write(Results(provenance=provenance, comparisons=[comparison]), tmp_path)
        assert read(tmp_path).comparisons == [comparison]
        path, _ = reports.render(tmp_path)
        return path.read_text(encoding="utf-8")

    return make


def test_a_sum_is_called_a_sum_everywhere(finished: Callable[[bool], str], tmp_path: Path) -> None:
    page = finished(True)
    assert "The sum of bounces 0 to 5 is 3.1 % high" in page
    assert "Sum<small>E + … + T⁵E</small>" in page
    for absent in (
        "Bounce 0<small>",
        "Energy per bounce",
        "Partial sums</h3>",
        ">T⁵E<",
        "Bounce by bounce</h3>",
    ):
        assert absent not in page
    assert page.count("<img ") == 3
    [suite] = JUnitXml.fromfile(str(tmp_path / "junit.xml"))
    assert [test.name for test in suite] == ["sum of bounces 0 to 5"]


def test_layers_are_called_bounces(finished: Callable[[bool], str], tmp_path: Path) -> None:
    page = finished(False)
    assert "Bounce 0 is 3.1 % high" in page
    assert "Bounce 1<small>TE</small>" in page
    assert "Energy per bounce" in page
    assert page.count("<img ") == 3 * 2 * 2
    [suite] = JUnitXml.fromfile(str(tmp_path / "junit.xml"))
    assert [test.name for test in suite] == ["bounce 0", "bounce 1"]


def test_what_was_learned_of_the_image_is_said(finished: Callable[[bool], str]) -> None:
    page = finished(True)
    assert "Which bounce is wrong does not show." in page
    assert "1 outlier at (x, y) = (7, 9) G 50 for 0.5" in page
    assert "It seems to be &lt;script&gt;alert(1)&lt;/script&gt;." in page
    assert SCRIPT not in page
    assert "<dt>Seed</dt>" not in page
    assert "replicates," not in page


@pytest.mark.browser
def test_in_a_browser(finished: Callable[[bool], str], tmp_path: Path, open_report: Any) -> None:
    finished(True)
    page = open_report(tmp_path / reports.REPORT_FILE)
    assert page.locator(".plot").count() == 1
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
