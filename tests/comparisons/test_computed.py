"""Committed solutions are those of their scenes: fresh ones agree, within the error that is stated."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from comparisons import truth
from comparisons.computed import relative_error
from comparisons.crew import Crew
from reference_tracer.finite_elements import solve
from scenes import Case, Computed
from scenes.formats import exr
from scenes.library import CASES, case

COMPUTED = [name for name in CASES if case(name).answer.kind == "computed"]
SECONDS = ["cornell-box-empty", "facing-squares", "cornell-box-spectral"]


def committed(found: Case) -> np.ndarray:
    answer = found.answer.truth(found.scene, truth.COMMITTED_BOUNCES)
    assert answer is not None
    assert not answer.stderr.any()
    return answer.mean


@pytest.mark.parametrize("name", COMPUTED)
def test_the_data_is_that_of_the_scene(name: str) -> None:
    """If this fails, the scene or its JSON has changed: python -m comparisons.truth NAME."""
    found = case(name)
    assert isinstance(found.answer, Computed)
    assert exr.read_attribute(found.answer.path, "lightproof:scene") == truth.scene_hash(found.scene)
    assert committed(found).shape == (7, *found.scene.shape)


@pytest.mark.parametrize("name", SECONDS)
def test_the_coarser_mesh_is_off_by_the_stated_error(name: str) -> None:
    found = case(name)
    fresh = solve(found.scene, 6).image()
    assert isinstance(found.answer, Computed)
    np.testing.assert_allclose(
        relative_error(fresh, committed(found)), found.answer.error, rtol=0.1, atol=3e-8
    )


def test_around_the_corner_on_a_coarse_mesh() -> None:
    """That of the data takes minutes; this one takes seconds."""
    found = case("around-the-corner")
    assert isinstance(found.answer, Computed)
    fresh = solve(found.scene, 6, order=3, levels=0, splits=found.answer.splits).image()
    error = relative_error(fresh, committed(found))
    assert not error[:3].any()
    assert error.max() < 0.003


def test_another_resolution_is_computed_once_and_cached(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    found = case("facing-squares")
    odd = replace(found, scene=found.scene.resized(12, 20), bounces=2)
    with Crew(1) as crew:
        first = truth.truth_of(odd, crew)
        [file] = tmp_path.rglob("*.exr")
        made = file.stat().st_mtime_ns
        again = truth.truth_of(odd, crew)
    assert file.stat().st_mtime_ns == made
    np.testing.assert_array_equal(first.mean, again.mean)
    assert first.mean.shape == (3, 20, 12, 3)
    assert not first.stderr.any()
    expected = solve(odd.scene, 2).image()
    np.testing.assert_allclose(first.mean, expected, atol=1e-6 * expected.max())


def test_the_error_is_relative_to_the_image_and_to_the_brightest_one_where_there_is_no_light() -> None:
    expected = np.zeros((3, 2, 2, 1))
    expected[1], expected[2] = 4.0, 2.0
    off = expected + 0.4
    np.testing.assert_allclose(relative_error(off, expected), [0.1, 0.1, 0.2], rtol=1e-6)
    assert relative_error(expected, expected)[0] == 0
