"""Answers: written by the command, estimated for scenes of one's own, and what an image must be to be one."""

from __future__ import annotations

import json
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import numpy as np
import pytest

from comparisons.diagnosis import inquiry
from lightproof import cases
from scenes import library
from scenes.formats import exr

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("command.py"))))
flat, invoke, small = shared.flat, shared.invoke, shared.small


# ---- the command


def test_the_answer_is_the_truth(tmp_path: Path) -> None:
    out = tmp_path / "truth.exr"
    result = invoke("answer", "integrating-sphere", "--bounces", "3", "--size", "16x8", "--out", out)
    assert result.exit_code == 0, result.output
    case = library.case("integrating-sphere")
    truth = case.answer.truth(case.scene.resized(16, 8), 3)
    assert truth is not None
    np.testing.assert_allclose(exr.read_bounces(out)[0], truth.mean, rtol=1e-6)
    assert exr.read_attribute(out, "lightproof:source") == truth.source
    assert exr.read_attribute(out, "lightproof:scene") == "integrating-sphere, 16x8 pixels"
    assert exr.read_attribute(out, "lightproof:sha256") == case.scene.resized(16, 8).sha256
    assert invoke("answer", "cornell-box", "--bounces", "2", "--out", out).exit_code == 0
    assert (exr.read_bounces(out)[1] > 0).any(), "an estimate comes with its standard error"


def test_spectra_are_written_with_their_wavelengths(tmp_path: Path) -> None:
    """And read again: as the answer of a scene of one's own they bring their wavelengths along."""
    name, answer = "furnace-equal-energy", tmp_path / "answer.exr"
    size = ("--size", "4x4", "--bounces", "1")
    result = invoke("answer", name, *size, "--out", answer)
    assert "each of 41 wavelengths from 380 to 780 nm and a picture in linear sRGB, exact" in flat(
        result.output
    )
    found = library.case(name)
    assert exr.read_wavelengths(answer) == found.wavelengths
    image = tmp_path / "image.exr"
    result = invoke("render", name, *size, "--spp", "1", "--out", image)
    assert "each of 41 wavelengths" in flat(result.output)
    assert exr.read_wavelengths(image) == found.wavelengths
    assert (exr.read_bounces(image)[0][0] == 1).all()
    (tmp_path / "own.json").write_bytes(found.scene.resized(4, 4).to_json())
    assert cases.from_answer(tmp_path / "own.json", answer).wavelengths == found.wavelengths


def test_the_answer_of_a_scene_is_estimated_with_its_error(tmp_path: Path) -> None:
    """In a furnace, whose answer is known: within the stated error, which is that of its pixels."""
    scene, answer = tmp_path / "room.json", tmp_path / "room.exr"
    scene.write_bytes(small(library.case("furnace-box").scene).to_json())
    options = ("--bounces", "2", "--spp", "64", "--jobs", "1", "--out", answer)
    result = invoke("answer", scene, *options)
    assert result.exit_code == 0, result.output
    assert "layers bounce0 to bounce2, estimated, with its standard error" in flat(result.output)
    mean, stderr = exr.read_bounces(answer)
    off = mean - np.array([1, 0.5, 0.25])[:, None, None, None]
    np.testing.assert_allclose(off[0], 0, atol=1e-6)
    for k in (1, 2):
        assert (stderr[k] > 0).all()
        assert 0.6 < np.sqrt((off[k] ** 2).mean() / (stderr[k] ** 2).mean()) < 1.6
    assert exr.read_attribute(answer, "lightproof:scene") == "room, 8x8 pixels"
    assert "64 batches of 1 spp" in exr.read_attribute(answer, "lightproof:source")
    assert cases.from_answer(scene, answer).answer.kind == "estimated"


# ---- a scene with an answer image


def test_a_scene_with_an_answer_image_is_a_case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files as the command itself writes them; a wrong answer fails."""
    monkeypatch.setattr(inquiry, "CASES", 0)  # what is asked about a fail has tests of its own
    scene, answer = tmp_path / "room.json", tmp_path / "room.exr"
    assert invoke("export", "furnace-box", "--size", "8x8", "--out", scene).exit_code == 0
    assert invoke("answer", "furnace-box", "--size", "8x8", "--bounces", "2", "--out", answer).exit_code == 0
    files = ("--scene", scene, "--answer", answer)
    options = ("--renderer", "reference", "--jobs", "1", "--no-total", "--out", tmp_path / "out")
    result = invoke("validate", *files, *options)
    assert result.exit_code == 0, result.output
    assert "room × reference: pass" in result.output
    [comparison] = json.loads((tmp_path / "out" / "results.json").read_bytes())["comparisons"]
    assert comparison["truth"] == "computed"
    assert [b["bounce"] for b in comparison["bounces"]] == [0, 1, 2]
    mean, _ = exr.read_bounces(answer)
    exr.write_bounces(answer, mean * [[[[1.0]]], [[[1.0]]], [[[1.1]]]])
    assert invoke("validate", *files, *options).exit_code == 1


def test_the_noise_of_an_answer_image_is_warned_of(tmp_path: Path) -> None:
    """And whether it comes from the tracer that is judged: only then another strategy takes its place."""
    scene, answer = tmp_path / "room.json", tmp_path / "room.exr"
    scene.write_bytes(small(library.case("furnace-box").scene).to_json())
    files = ("--scene", scene, "--answer", answer)
    options = ("--renderer", "reference", "--jobs", "1", "--budget", "0.1", "--out", tmp_path / "out")

    def notes() -> str:
        invoke("validate", *files, *options)
        [comparison] = json.loads((tmp_path / "out" / "results.json").read_bytes())["comparisons"]
        return " ".join(comparison["notes"])

    assert invoke("render", scene, "--spp", "4", "--bounces", "1", "--out", answer).exit_code == 0
    found = notes()
    assert "The truth is an image of 4 spp without standard errors" in found
    assert "estimated by the reference tracer, which can't judge itself; reference:nee" in found
    mean, _ = exr.read_bounces(answer)
    exr.write_bounces(answer, mean, np.full_like(mean, 0.1), {"lightproof:source": "elsewhere, 4 spp"})
    found = notes()
    assert "without standard errors" not in found
    assert "judge itself" not in found


def test_an_answer_image_says_nothing_of_other_sizes_and_bounces(tmp_path: Path) -> None:
    scene, answer = tmp_path / "room.json", tmp_path / "room.exr"
    scene.write_bytes(small(library.case("furnace-box").scene).to_json())
    exr.write_bounces(answer, np.ones((2, 8, 8, 3)))
    files = ("--scene", scene, "--answer", answer)
    finer = invoke("validate", *files, "--size", "16x16")
    assert finer.exit_code == 2
    assert "room.exr has 8x8 pixels and bounces 0 to 1; it says nothing of 16x16" in flat(finer.output)
    more = invoke("validate", *files, "--bounces", "2")
    assert more.exit_code == 2
    assert "holds for bounces 0 to 1" in flat(more.output)


def test_a_scene_and_an_answer_that_don_t_fit(tmp_path: Path) -> None:
    scene, answer = tmp_path / "room.json", tmp_path / "room.exr"
    scene.write_bytes(small(library.case("furnace-box").scene).to_json())
    exr.write_bounces(answer, np.ones((2, 4, 8, 3)))
    with pytest.raises(cases.CaseError, match=r"\(4, 8, 3\), the scene's sensor has \(8, 8, 3\)"):
        cases.from_answer(scene, answer)
    with pytest.raises(cases.CaseError, match="can't be read"):
        cases.from_answer(scene, tmp_path / "none.exr")
    scene.write_text('{"surfaces": [], "sensor": 3}')
    with pytest.raises(cases.CaseError, match=r"room.json: sensor = 3"):
        cases.from_answer(scene, answer)


def test_an_answer_image_is_radiance(tmp_path: Path) -> None:
    """Below 0 only by rounding, or as far as its own standard error reaches."""
    scene, answer = tmp_path / "room.json", tmp_path / "room.exr"
    scene.write_bytes(small(library.case("furnace-box").scene).to_json())
    mean = np.ones((2, 8, 8, 3))
    mean[1, 2, 3, 0] = -0.25
    exr.write_bounces(answer, mean)
    with pytest.raises(
        cases.CaseError, match=r"-0\.25 in bounce 1, row 2, column 3, channel 0: expected finite"
    ):
        cases.from_answer(scene, answer)
    exr.write_bounces(answer, mean, np.full_like(mean, 0.02))
    with pytest.raises(cases.CaseError, match=r"-0\.25 with a standard error of 0\.02 in bounce 1"):
        cases.from_answer(scene, answer)
    exr.write_bounces(answer, mean, np.full_like(mean, 0.1))
    assert cases.from_answer(scene, answer).bounces == 1
    mean[1, 2, 3, 0] = -1e-7
    exr.write_bounces(answer, mean)
    assert cases.from_answer(scene, answer).bounces == 1
    for place in (0, 1):
        pair = [np.ones_like(mean), np.ones_like(mean)]
        pair[place][0, 0, 0, 1] = np.nan
        exr.write_bounces(answer, *pair)
        with pytest.raises(cases.CaseError, match="in bounce 0, row 0, column 0, channel 1"):
            cases.from_answer(scene, answer)
