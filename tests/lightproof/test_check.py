"""``lightproof check`` as people meet it: what it says, what it writes, how it ends."""

from __future__ import annotations

import json
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import OpenImageIO as oiio
import pytest
from PIL import Image

from comparisons import results
from comparisons.results import Comparison
from scenes import library
from scenes.formats import exr

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("command.py"))))
flat, unbroken = shared.flat, shared.unbroken


def invoke(*arguments: str | Path) -> Any:
    return shared.invoke("check", *arguments)


def truth_of(name: str, bounces: int, size: int = 64) -> np.ndarray:
    case = library.case(name)
    truth = case.answer.truth(case.scene.resized(size, size), bounces)
    assert truth is not None
    return truth.mean


def write(path: Path, image: np.ndarray, names: str = "RGB") -> Path:
    height, width, channels = image.shape
    spec = oiio.ImageSpec(width, height, channels, oiio.FLOAT)
    spec.channelnames = list(names)
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec)
    assert out.write_image(np.ascontiguousarray(image, dtype=np.float32))
    out.close()
    return path


@pytest.fixture
def image() -> np.ndarray:
    """The sum of bounces 0 to 3 of a case, with 2 % of noise, but for the lamp that is seen itself."""
    image = truth_of("sphere-zones", 3).sum(axis=0)
    return image + 0.02 * np.minimum(image, 1) * np.random.default_rng(1).standard_normal(image.shape)


def test_a_right_image_passes(tmp_path: Path, image: np.ndarray) -> None:
    result = invoke(write(tmp_path / "a.exr", image), "--case", "sphere-zones", "--bounces", "3")
    assert result.exit_code == 0, result.output
    assert "a.exr × sphere-zones, 64x64: pass" in result.output
    assert "E + … + T³E" in result.output
    assert "HDR-FLIP" in result.output
    assert "Which bounce is wrong does not show in a sum" in result.output
    assert not list(tmp_path.glob("lightproof-report"))


def test_a_wrong_image_fails_with_a_hint_and_a_report(tmp_path: Path, image: np.ndarray) -> None:
    out = tmp_path / "out"
    result = invoke(
        *(write(tmp_path / "a.exr", image[::-1]), "--case", "sphere-zones", "--bounces", "3"),
        *("--independent", "--out", out),
    )
    assert result.exit_code == 1, result.output
    assert "independent is taken on your word though its residuals contradict it" in result.output
    assert "Hint: It fits the truth far better turned upside down" in result.output
    assert f"Report: {(out / 'report.html').resolve()}" in result.output
    [comparison] = results.read(out).comparisons
    assert comparison.renderer == "a.exr"
    assert (comparison.spp, comparison.replicates, comparison.looks) == (0, 0, [])
    assert comparison.images is not None
    truth, _ = exr.read_bounces(out / comparison.images.truth)
    assert truth == pytest.approx(truth_of("sphere-zones", 3).sum(axis=0, keepdims=True), rel=1e-6)
    page = (out / "report.html").read_text()
    assert "The sum of bounces 0 to 3 " in page
    assert "turned upside down" in page
    assert 'name="sum of bounces 0 to 3"' in (out / "junit.xml").read_text()


def test_without_that_word_what_is_smooth_may_be_a_denoisers_noise(tmp_path: Path, image: np.ndarray) -> None:
    result = invoke(write(tmp_path / "a.exr", image[::-1]), "--case", "sphere-zones", "--bounces", "3")
    assert result.exit_code == 4
    assert "noise or bias, the two look alike" in result.output
    assert "turned upside down" in result.output
    assert "say --independent" in result.output


def test_layers_are_judged_one_by_one(tmp_path: Path) -> None:
    layers = truth_of("furnace-box", 2)
    layers[2] *= 1.05
    exr.write_bounces(tmp_path / "a.exr", layers)
    result = invoke(tmp_path / "a.exr", "--case", "furnace-box", "--layers", "--json")
    assert result.exit_code == 1
    comparison = msgspec.json.decode(result.stdout, type=Comparison)
    assert [b.verdict for b in comparison.bounces] == ["pass", "pass", "fail"]
    assert len(comparison.term_metrics) == 3


def test_json_is_all_there_is_on_the_standard_output(tmp_path: Path, image: np.ndarray) -> None:
    path = write(tmp_path / "a.exr", image)
    result = invoke(path, "--case", "sphere-zones", "--bounces", "3", "--json", "--tolerance", "0.1%")
    found = json.loads(result.stdout)
    assert found["single_image"]["summed"] is True
    assert found["single_image"]["noise"][0]["reach"] == 0
    assert found["bounces"][0]["tolerance"] == 0.001


def test_noise_is_inconclusive(tmp_path: Path, image: np.ndarray) -> None:
    noisy = image * (1 + np.random.default_rng(2).standard_normal(image.shape))
    result = invoke(write(tmp_path / "a.exr", noisy), "--case", "sphere-zones", "--bounces", "3")
    assert result.exit_code == 4
    assert "too much noise: a bias could have been detected from" in result.output


def test_a_nan_is_an_error(tmp_path: Path, image: np.ndarray) -> None:
    image[5, 6] = np.nan
    out = tmp_path / "out"
    result = invoke(write(tmp_path / "a.exr", image), "--case", "sphere-zones", "--out", out)
    assert result.exit_code == 3
    assert "1 of 4096 pixels are NaN or infinite, the first one at x = 6, y = 5" in result.output
    assert results.read(out).comparisons[0].verdict == "error"
    assert (out / "report.html").exists()


def test_a_case_takes_the_size_of_the_image(tmp_path: Path) -> None:
    image = truth_of("furnace-box", 5, 48).sum(axis=0)
    result = invoke(write(tmp_path / "a.exr", image[:40]), "--case", "furnace-box")
    assert result.exit_code == 0, result.output
    assert "48x40: pass" in result.output


def test_luminance_will_do(tmp_path: Path) -> None:
    image = truth_of("furnace-box", 5).sum(axis=0)[..., :1]
    assert invoke(write(tmp_path / "a.exr", image, "Y"), "--case", "furnace-box").exit_code == 0


def test_a_case_of_ones_own(tmp_path: Path, image: np.ndarray) -> None:
    file = tmp_path / "own.py"
    file.write_text("from scenes import library\n\ndef zones():\n    return library.case('sphere-zones')\n")
    result = invoke(write(tmp_path / "a.exr", image), "--case", f"{file}:zones", "--bounces", "3")
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--case", "sphere-zone"], "no case is called 'sphere-zone': did you mean sphere-zones"),
        (["--case", "sphere-zones", "--layers", "--bounces", "3"], "says itself how many bounces it has"),
        (
            ["--case", "sphere-zones", "--layers"],
            "expected layers bounce0, bounce1, …; found channels R, G, B",
        ),
        (["--case", "cornell-box-spectral"], "expected channels C0, C1, C2, …, or Y; found R, G, B"),
        (["--case", "sphere-zones", "--tolerance", "no"], "'no': expected a share above 0"),
        ([], "Missing option '--case'"),
    ],
)
def test_wrong_usage_is_explained_and_ends_with_2(
    tmp_path: Path, image: np.ndarray, options: list[str], complaint: str
) -> None:
    result = invoke(write(tmp_path / "a.exr", image), *options)
    assert result.exit_code == 2
    assert complaint in flat(result.output)


def test_what_is_no_linear_image_is_refused(tmp_path: Path) -> None:
    Image.fromarray(np.zeros((64, 64, 3), np.uint8)).save(tmp_path / "a.png")
    result = invoke(tmp_path / "a.png", "--case", "furnace-box")
    assert result.exit_code == 2
    assert "expected EXR, found a png file of 8-bit integers" in flat(result.output)
    result = invoke(tmp_path / "b.exr", "--case", "furnace-box")
    assert result.exit_code == 2
    assert unbroken("b.exr: there is no such file") in unbroken(result.output)


def test_an_image_too_small_is_refused(tmp_path: Path) -> None:
    image = truth_of("furnace-box", 5, 8).sum(axis=0)
    result = invoke(write(tmp_path / "a.exr", image), "--case", "furnace-box")
    assert result.exit_code == 2
    assert "a.exr has 8x8 pixels; their scatter tells the noise from 16x16 up" in flat(result.output)
