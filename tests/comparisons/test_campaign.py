"""Whole comparisons with real processes: what is right passes, what is wrong fails, and at the right bounce."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from comparisons import campaign, known
from comparisons.comparison import _as_far_as_it_goes
from comparisons.results import Comparison
from comparisons.sequential import MIN_REPLICATES
from comparisons.settings import Settings
from scenes import UnknownNameError, library
from scenes.formats import exr

Compare = Callable[..., Comparison]


def failed(comparison: Comparison) -> list[int]:
    return [b.bounce for b in comparison.bounces if b.verdict == "fail"]


def passed(comparison: Comparison) -> list[int]:
    return [b.bounce for b in comparison.bounces if b.verdict == "pass"]


@pytest.mark.parametrize("case", ["furnace-box", "furnace-sphere", "integrating-sphere"])
def test_the_way_faults_are_planted_is_sound(compare: Compare, wrong: Any, case: str) -> None:
    assert compare(case, "wrong:right").verdict == "pass"


@pytest.mark.parametrize("case", ["furnace-box", "integrating-sphere"])
def test_the_reference_tracer_passes_at_a_fifth_of_a_percent(compare: Compare, case: str) -> None:
    comparison = compare(case, "reference", tolerance=0.002)
    assert passed(comparison) == [0, 1, 2, 3, 4, 5]


@pytest.mark.parametrize(
    ("fault", "case", "at"),
    [
        ("wrong:brighter", "furnace-box", [1, 2, 3, 4, 5]),
        ("wrong:brighter", "furnace-sphere", [1, 2, 3, 4, 5]),
        ("wrong:brighter", "integrating-sphere", [1, 2, 3, 4, 5]),
        ("wrong:one-bounce-too-many", "furnace-box", [5]),
        ("wrong:one-bounce-too-many", "integrating-sphere", [5]),
        ("wrong:flipped", "integrating-sphere", [0]),
        ("wrong:mirrored", "integrating-sphere", [0]),
        ("wrong:third-bounce-brighter", "furnace-box", [3]),
    ],
)
def test_a_planted_fault_fails_at_its_bounce(
    compare: Compare, wrong: Any, fault: str, case: str, at: list[int]
) -> None:
    comparison = compare(case, fault)
    assert comparison.verdict == "fail"
    assert failed(comparison) == at
    assert passed(comparison) == [k for k in range(6) if k not in at]


def test_the_size_of_a_fault_is_measured(compare: Compare, wrong: Any) -> None:
    """Albedo × 1.01 makes bounce k too bright by 1.01ᵏ − 1; each interval, at 99.9 %, holds that."""
    for bounce in compare("furnace-box", "wrong:brighter").bounces:
        low, high = bounce.interval
        assert low - 1e-9 <= 1.01**bounce.bounce - 1 <= high + 1e-9


def test_a_furnace_can_t_see_a_flipped_image_and_says_so(compare: Compare, wrong: Any) -> None:
    comparison = compare("furnace-box", "wrong:flipped")
    assert comparison.verdict == "pass"
    assert "flipped" in comparison.blind_to


@pytest.mark.parametrize(
    ("fault", "verdict", "message"),
    [
        ("wrong:crash", "error", "killed by signal 11"),
        ("wrong:missing", "error", "No module named 'missing'"),
        ("wrong:nan", "error", "not finite"),
        ("wrong:refuse", "unsupported", "spheres"),
    ],
)
def test_what_goes_wrong_is_a_result_and_the_others_go_on(
    wrong: Any, tmp_path: Path, observer: Any, fault: str, verdict: str, message: str
) -> None:
    settings = Settings(size=(16, 16), budget=10.0, jobs=2)
    first, second = campaign.run(
        [library.case("furnace-sphere")], [fault, "wrong:right"], settings, tmp_path, observer
    )
    assert (first.verdict, second.verdict) == (verdict, "pass")
    assert message in first.message
    assert first.bounces == []
    assert bool(first.log) == (verdict == "error" and fault != "wrong:nan")


def test_a_renderer_that_hangs_is_stopped_and_the_others_go_on(
    wrong: Any, tmp_path: Path, observer: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("comparisons.sequential.GRACE", 1.0)
    settings = Settings(size=(8, 8), budget=2.0)
    first, second = campaign.run(
        [library.case("furnace-sphere")], ["wrong:hang", "wrong:right"], settings, tmp_path, observer
    )
    assert (first.verdict, second.verdict) == ("error", "pass")
    assert "no answer within 3 s" in first.message
    assert first.seconds >= 3.0  # of the question that it was stopped at


@pytest.mark.parametrize("budget", [0.001, 0.2])
def test_a_budget_too_small_is_inconclusive_and_says_what_it_could_have_seen(
    compare: Compare, budget: float
) -> None:
    comparison = compare("furnace-box", "reference", budget=budget, tolerance=1e-6)
    assert comparison.verdict == "inconclusive"
    assert comparison.replicates >= 2
    assert "could have been detected" in comparison.message
    if comparison.replicates < MIN_REPLICATES:
        needed = comparison.looks[-1].seconds * MIN_REPLICATES / comparison.replicates
        told = re.search(r"a verdict needs 32: try --budget ([0-9.]+);", comparison.message)
        assert told
        assert max(needed, 1) <= float(told[1]) <= max(3 * needed, 1)
    assert all(np.isfinite(b.detectable_bias) and b.detectable_bias > 0 for b in comparison.bounces)


def test_looks_come_later_and_later_until_all_is_clear(compare: Compare) -> None:
    """When the noise can decide, and never sooner than after a quarter more of the time."""
    comparison = compare("furnace-box", "reference", tolerance=0.002, tile_tolerance=0.01)
    assert comparison.verdict == "pass"
    looks = comparison.looks
    assert looks[0].replicates == 32
    assert len(looks) > 1, "all was clear at the first look: tighten the tolerance"
    for before, after in itertools.pairwise(looks):
        assert after.seconds >= 1.25 * before.seconds
    assert looks[-1].open_bounces == []
    assert looks[-1].replicates > looks[0].replicates
    assert sum(look.alpha for look in looks) < comparison.alpha


def test_samples_go_to_the_bounces_that_are_open(compare: Compare) -> None:
    comparison = compare("furnace-box", "reference", tolerance=0.002, tile_tolerance=0.01)
    assert len({b.look for b in comparison.bounces}) > 1, "all was decided at once: tighten the tolerance"
    for i, look in enumerate(comparison.looks, start=1):
        decided = [b.bounce for b in comparison.bounces if b.look <= i]
        assert sorted(decided + look.open_bounces) == list(range(6))
    first = [b for b in comparison.bounces if b.look == 1]
    assert all(b.replicates == 32 for b in first)
    assert all(b.replicates > 32 for b in comparison.bounces if b not in first)


def test_samples_go_where_the_noise_is_largest(compare: Compare) -> None:
    """In Mitsuba bounces cost extra, and E of a closed furnace has no noise at all."""
    comparison = compare("furnace-box", "mitsuba", bounces=2, budget=3.0, early_stop=False)
    assert len(comparison.looks) == 1
    assert comparison.seconds >= 3.0
    emission, direct, indirect = comparison.bounces
    assert emission.replicates == 32
    assert direct.replicates > 32
    assert indirect.replicates > 32


def test_the_images_are_written(compare: Compare, tmp_path: Path) -> None:
    comparison = compare("integrating-sphere", "reference", bounces=2)
    assert comparison.images is not None
    truth, _ = exr.read_bounces(tmp_path / comparison.images.truth)
    mean, stderr = exr.read_bounces(tmp_path / comparison.images.renderer)
    assert truth.shape == mean.shape == stderr.shape == (3, 16, 16, 3)
    np.testing.assert_allclose(
        mean.mean(axis=(1, 2))[:, 0], [b.channels[0].mean for b in comparison.bounces], rtol=1e-5
    )
    assert (stderr[0].max(axis=(0, 1)) > 0).all()


def test_channels_of_a_spectral_case_are_its_wavelengths(compare: Compare, tmp_path: Path) -> None:
    comparison = compare("furnace-equal-energy", "reference", bounces=1, size=(4, 4), tolerance=0.5)
    assert comparison.channels == [f"{nm} nm" for nm in range(380, 781, 10)]
    assert {b.channel for b in comparison.bounces} <= set(comparison.channels)
    assert {b.worst_tile.channel for b in comparison.bounces} <= set(comparison.channels)
    assert comparison.images is not None
    for file in (comparison.images.truth, comparison.images.renderer):
        assert exr.read_wavelengths(tmp_path / file) == tuple(range(380, 781, 10))


def test_a_renderer_that_ignores_its_seed_is_told_so(wrong: Any, compare: Compare) -> None:
    comparison = compare("furnace-box", "wrong:ignore-the-seed")
    assert comparison.verdict == "error"
    assert "takes no notice of its seed" in comparison.message


def test_identical_replicates_that_are_the_truth_pass(compare: Compare) -> None:
    """In the furnace, walks that find emission by chance carry no noise at all."""
    assert compare("furnace-sphere", "reference:bsdf").verdict == "pass"


def test_no_truth_no_verdict_and_the_others_go_on(
    wrong: Any, tmp_path: Path, observer: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("comparisons.truth.ESTIMATOR", "wrong:crash")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    settings = Settings(size=(7, 5), budget=10.0)
    cases = [library.case("cornell-box"), library.case("furnace-sphere")]
    first, second = campaign.run(cases, ["wrong:right"], settings, tmp_path, observer)
    assert (first.verdict, second.verdict) == ("error", "pass")
    assert "there is no truth: its process was killed by signal 11" in first.message


def test_a_declared_deviation_is_known_and_a_vanished_one_is_reported(
    wrong: Any, compare: Compare, tmp_path: Path
) -> None:
    file = tmp_path / "known.toml"
    file.write_text(
        '[[deviation]]\ncase = "furnace-box"\nrenderer = "wrong:third-bounce-brighter"\nversions = "==1.*"\n'
        'bounces = [2, 3]\nbias = [0.02, 0.02]\nwithin = 0.005\ntile_within = 0.02\nreason = "r"\nlink = "l"\n'
    )
    comparison = compare("furnace-box", "wrong:third-bounce-brighter", known=tuple(known.load(file)))
    assert comparison.verdict == "known"
    second, third = comparison.bounces[2], comparison.bounces[3]
    assert (second.verdict, third.verdict) == ("pass", "known")
    assert second.known is not None
    assert second.known.state == "vanished"
    assert comparison.notes == ["Bounce 2: the declared deviation has vanished; remove its entry."]


def test_the_estimator_of_a_truth_does_not_judge_itself(compare: Compare) -> None:
    comparison = compare("cornell-box", "reference", bounces=1, budget=0.1)
    assert comparison.truth == "estimated"
    assert "reference:nee is held against it" in comparison.notes[0]
    assert (
        "reference:bsdf is held against it" in compare("cornell-box", "reference:bsdf", budget=0.1).notes[0]
    )


def test_an_unknown_renderer_stops_the_run_before_it_begins(tmp_path: Path, observer: Any) -> None:
    with pytest.raises(UnknownNameError):
        next(
            campaign.run(
                [library.case("furnace-box")], ["reference", "mitsubi"], Settings(), tmp_path, observer
            )
        )
    assert observer.events == []


def test_the_observer_sees_it_all(compare: Compare, observer: Any) -> None:
    compare("furnace-sphere", "reference")
    assert observer.events == [("furnace-sphere", "reference"), ("furnace-sphere", "pass")]
    assert observer.shares == sorted(observer.shares)
    assert observer.messages[:2] == ["1 of 32 replicates", "2 of 32 replicates"]
    assert observer.messages[-1] == "open bounces: 0, 1, 2, 3, 4, 5"
    assert 0 <= observer.shares[0] <= observer.shares[-1] <= 1


def test_a_renderer_may_stop_at_a_bounce(compare: Compare, tmp_path: Path) -> None:
    """What it has is judged; what it has not is said to be unsupported."""
    comparison = compare(
        "furnace-box",
        "mitsuba:scalar_rgb:direct",
        size=(8, 8),
        tolerance=0.02,
        tile_tolerance=0.2,
        total=True,
    )
    assert comparison.verdict == "pass"
    assert [bounce.bounce for bounce in comparison.bounces] == [0, 1]
    assert "Bounces 2 to 5 are unsupported: the renderer stops at bounce 1" in comparison.notes
    [total] = comparison.totals
    assert (total.verdict, total.message) == ("unsupported", "total: the renderer stops at bounce 1")
    assert comparison.images is not None
    assert exr.read_bounces(tmp_path / comparison.images.renderer)[0].shape == (2, 8, 8, 3)


def test_one_bounce_that_is_missing_is_no_several() -> None:
    case = replace(library.case("furnace-box"), bounces=2)
    truth = case.answer.truth(case.scene.resized(2, 2), 2)
    cut, shorter, notes = _as_far_as_it_goes(case, truth, 1)
    assert (cut.bounces, shorter.bounces) == (1, 1)
    assert notes == ["Bounce 2 is unsupported: the renderer stops at bounce 1"]
    assert _as_far_as_it_goes(case, truth, 2)[2] == _as_far_as_it_goes(case, truth, None)[2] == []


def test_samples_that_belong_together_are_counted_together(compare: Compare) -> None:
    comparison = compare(
        "furnace-box", "mitsuba:scalar_rgb:path:ldsampler", size=(4, 4), tolerance=0.05, tile_tolerance=0.5
    )
    assert comparison.verdict == "pass"
    for bounce in comparison.bounces:
        assert bounce.spp % (16 * bounce.replicates) == 0
