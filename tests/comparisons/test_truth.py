from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from comparisons import truth
from comparisons.truth import truth_of
from reference_tracer.random_walk import render
from scenes import Estimate, library
from scenes.formats import exr

CORNELL = library.case("cornell-box")


def test_the_committed_truth_is_there_and_says_how_it_was_made() -> None:
    found = truth_of(CORNELL, CORNELL.scene, truth.COMMITTED_BOUNCES)
    assert found.mean.shape == (7, 64, 64, 3)
    assert "reference tracer" in CORNELL.answer.source
    assert "strategy mis" in CORNELL.answer.source
    assert (found.stderr[1:].mean(axis=(1, 2)) > 0).all()


def test_the_committed_truth_is_that_of_its_scene() -> None:
    """Another seed and another strategy agree with it, over the image within five standard errors."""
    scene = CORNELL.scene.resized(16, 16)
    found = truth_of(CORNELL, scene, 5)
    images = np.array([render(scene, 5, 64, 100 + i, "nee").mean(axis=(1, 2)) for i in range(16)])
    error = images.std(axis=0, ddof=1) / 4
    assert (np.abs(images.mean(axis=0) - found.mean.mean(axis=(1, 2))) < 5 * error).all()
    assert (error < 0.03 * images.mean(axis=0)).all(), "too noisy to tell anything"


def test_its_error_is_that_of_repeated_work() -> None:
    """64 committed batches against 16 fresh renders: the errors per sample agree within a factor of 1.5."""
    stderr = truth_of(CORNELL, CORNELL.scene, 3).stderr
    assert isinstance(CORNELL.answer, Estimate)
    spp = 64 * int(CORNELL.answer.source.split("batches of ")[1].split()[0])
    images = np.array([render(CORNELL.scene, 3, 4, 200 + i) for i in range(16)])
    fresh = images.std(axis=0, ddof=1) * np.sqrt(4 / spp)
    ratio = np.sqrt((stderr[1:] ** 2).mean() / (fresh[1:] ** 2).mean())
    assert 1 / 1.5 < ratio < 1.5


def test_an_odd_resolution_is_estimated_once_and_cached(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(truth, "CACHED_SAMPLES", 12 * 10 * 640)
    scene, shares = CORNELL.scene.resized(12, 10), list[float]()
    first = truth_of(CORNELL, scene, 2, jobs=2, progress=shares.append)
    assert shares[-1] == 1
    assert len(shares) == truth.BATCHES
    again = truth_of(CORNELL, scene, 2, progress=shares.append)
    assert len(shares) == truth.BATCHES
    np.testing.assert_array_equal(first.mean, again.mean)
    [file] = tmp_path.rglob("*.exr")
    assert "strategy mis" in exr.read_attribute(file, "lightproof:source")
    reference = render(scene, 2, 2000, 1)
    error = np.sqrt((first.stderr**2).sum(axis=(1, 2))) / 120
    assert (np.abs((first.mean - reference).mean(axis=(1, 2))) < 6 * error)[1:].all()


def test_no_answer_for_that_many_bounces() -> None:
    from dataclasses import replace

    limited = replace(library.case("furnace-box"), max_bounces=3)
    with pytest.raises(ValueError, match="answer for bounces 0 to 3, not for 4"):
        truth_of(limited, limited.scene, 4)
