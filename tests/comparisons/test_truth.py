from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from comparisons import truth
from comparisons.crew import Crew
from comparisons.truth import truth_of
from reference_tracer.random_walk import render
from scenes import Estimate, Truth, library
from scenes.formats import exr

CORNELL = library.case("cornell-box")


def known_truth(**changes: Any) -> Truth:
    with Crew(1) as crew:
        return truth_of(replace(CORNELL, **changes), crew)


def test_the_committed_truth_is_that_of_the_scene() -> None:
    """If this fails, the scene or its JSON has changed: make truth."""
    assert isinstance(CORNELL.answer, Estimate)
    assert exr.read_attribute(CORNELL.answer.path, "lightproof:scene") == truth.scene_hash(CORNELL.scene)


def test_the_committed_truth_is_there_and_says_how_it_was_made() -> None:
    found = known_truth(bounces=truth.COMMITTED_BOUNCES)
    assert found.mean.shape == (7, 64, 64, 3)
    assert CORNELL.answer.source.startswith("reference:mis:sobol of lightproof")
    assert (found.stderr[1:].mean(axis=(1, 2)) > 0).all()


def test_another_strategy_agrees_with_the_committed_truth() -> None:
    """With other seeds, over the image, within five standard errors; each below 3 % of the mean."""
    scene = CORNELL.scene.resized(16, 16)
    found = known_truth(scene=scene)
    images = np.array([render(scene, 5, 64, 100 + i, "nee").mean(axis=(1, 2)) for i in range(16)])
    error = images.std(axis=0, ddof=1) / 4
    assert (np.abs(images.mean(axis=0) - found.mean.mean(axis=(1, 2))) < 5 * error).all()
    assert (error < 0.03 * images.mean(axis=0)).all(), "too noisy to tell anything"


def test_its_error_is_that_of_repeated_work() -> None:
    """64 committed batches against 16 fresh renders with independent numbers, which scale with 1/√n.

    Sobol' points do better in the first bounces, and all but as these in the last ones.
    """
    stderr = known_truth(bounces=6).stderr
    assert isinstance(CORNELL.answer, Estimate)
    spp = 64 * int(CORNELL.answer.source.split("batches of ")[1].split()[0])
    images = np.array([render(CORNELL.scene, 6, 4, 200 + i) for i in range(16)])
    fresh = images.std(axis=0, ddof=1) * np.sqrt(4 / spp)
    ratio = np.sqrt((stderr**2).mean(axis=(1, 2, 3)) / (fresh**2).mean(axis=(1, 2, 3)))
    assert (ratio < 1.1).all()
    assert ratio[5:].min() > 1 / 1.5
    # nor is any too good to be true: Sobol' points at 32 spp, and from there on an error that falls with 1/n
    images = np.array([render(CORNELL.scene, 6, 32, 300 + i, sampler="sobol") for i in range(12)])
    best = images.std(axis=0, ddof=1) * (32 / (spp / 64)) / np.sqrt(64)
    assert (np.sqrt((stderr**2).mean(axis=(1, 2, 3)) / (best**2).mean(axis=(1, 2, 3))) > 1).all()


def test_an_odd_resolution_is_estimated_once_and_cached(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(truth, "CACHED_SAMPLES", 12 * 10 * 640)
    case, shares = replace(CORNELL, scene=CORNELL.scene.resized(12, 10), bounces=2), list[float]()
    with Crew(2) as crew:
        first = truth_of(case, crew, shares.append)
        assert shares[-1] == 1
        assert len(shares) == truth.BATCHES
        again = truth_of(case, crew, shares.append)
        assert len(shares) == truth.BATCHES
        np.testing.assert_array_equal(first.mean, again.mean)
        [file] = tmp_path.rglob("*.exr")
        file.write_bytes(file.read_bytes()[:1000])
        mended = truth_of(case, crew, shares.append)
        assert len(shares) == 2 * truth.BATCHES
    np.testing.assert_allclose(mended.mean, first.mean, rtol=1e-6)
    reference = render(case.scene, 2, 2000, 1)
    error = np.sqrt((first.stderr**2).sum(axis=(1, 2))) / 120
    assert (np.abs((first.mean - reference).mean(axis=(1, 2))) < 6 * error)[1:].all()


def test_no_answer_for_that_many_bounces() -> None:
    limited = replace(library.case("furnace-box"), max_bounces=3)
    with Crew(1) as crew, pytest.raises(ValueError, match="answer for bounces 0 to 3, not for 5"):
        truth_of(limited, crew)
