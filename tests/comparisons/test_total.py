"""The row ``total``: what only production settings get wrong must fail there, and nowhere else."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest

from comparisons.diagnosis import diagnoses
from comparisons.faults.planting import of_request
from comparisons.known import Deviation
from comparisons.renderers import Images
from comparisons.renderers.reference import ReferenceRenderer
from comparisons.results import Comparison, TotalResult, Verdict
from comparisons.statistics.intervals import Biases, Range
from comparisons.total import said_of, up_to
from comparisons.whole_sum import Series
from reference_tracer import random_walk
from reference_tracer.roulette import roulette
from scenes import Case, Scene, Tolerance, library

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("oracle.py"))))
Oracle, small = shared.Oracle, shared.small


def test_who_is_right_passes(against: Callable[..., Comparison]) -> None:
    case = small("furnace-cornell")
    found = against(case, Oracle(case))
    assert found.verdict == "pass"
    [total] = found.totals
    assert total.verdict == "pass"
    assert total.result is not None
    assert total.result.truth_mean == pytest.approx(total.result.mean, rel=0.005)
    assert total.result.tolerance == pytest.approx(0.005)
    assert 0 < total.tail < 1e-3


@pytest.mark.parametrize("factor", [0.97, 1.03])
def test_a_wrong_total_fails_and_leaves_the_bounces_alone(
    against: Callable[..., Comparison], factor: float
) -> None:
    """3 % against ± 0.5 %, with a standard error below 0.05 % at the first look: power 1 for all that matters."""
    case = small("furnace-cornell")
    found = against(case, Oracle(case, of_total=lambda image: factor * image))
    assert found.verdict == "fail"
    assert {b.verdict for b in found.bounces} == {"pass"}
    [total] = found.totals
    assert total.verdict == "fail"
    assert total.result is not None
    assert total.result.bias == pytest.approx(factor - 1, abs=0.003)
    [diagnosis] = diagnoses([found])
    assert diagnosis.suspect == "series"
    assert "each bounce is right by itself" in diagnosis.sentence


def test_wrong_in_a_tile_alone(against: Callable[..., Comparison]) -> None:
    """A bright corner is cut off, as a clamp does."""
    case = small("furnace-cornell")

    def clamped(image: Images) -> Images:
        image = image.copy()
        image[:2, :2] *= 0.9
        image[2:4, :2] *= 1.1
        return image

    [total] = against(case, Oracle(case, of_total=clamped)).totals
    assert total.result is not None
    assert (total.verdict, total.result.decided_by) == ("fail", "tile")


def test_without_it_nothing_is_asked(against: Callable[..., Comparison]) -> None:
    case = small("furnace-cornell")
    found = against(case, Oracle(case, of_total=lambda image: 2 * image), total=False)
    assert (found.verdict, found.totals) == ("pass", [])


def test_who_makes_no_total_is_told_so_and_judged_by_bounces(against: Callable[..., Comparison]) -> None:
    class ByBounce:
        name = "by-bounce"

        def __init__(self, inner: Oracle) -> None:
            self.version, self.render = inner.version, inner.render

    case = small("furnace-cornell")
    found = against(case, ByBounce(Oracle(case)))
    assert found.verdict == "pass"
    [total] = found.totals
    assert (total.verdict, total.result) == ("unsupported", None)
    assert "has no total(scene, spp, seed)" in total.message


@pytest.mark.parametrize(
    ("broken", "message"),
    [
        (lambda image: image * np.nan, "the total, row 0, column 0"),
        (lambda image: image[:-1], "returned a total of shape"),
    ],
)
def test_a_total_that_is_no_image_is_an_error(
    against: Callable[..., Comparison], broken: Callable[[Images], Images], message: str
) -> None:
    case = small("furnace-cornell")
    found = against(case, Oracle(case, of_total=broken))
    assert found.verdict == "error"
    assert {b.verdict for b in found.bounces} == {"pass"}
    assert message in found.totals[0].message
    assert message in found.message


def test_where_the_rest_of_the_sum_is_not_known_nobody_is_judged(against: Callable[..., Comparison]) -> None:
    case = small("wall-by-reflection")
    found = against(case, Oracle(case, of_total=lambda image: 9 * image))
    assert found.verdict == "pass"
    [total] = found.totals
    assert total.verdict == "unsupported"
    assert "bounces 0 to 3, all that its answer has" in total.message


# ---- the tail: a verdict holds for every truth in between


def test_biases_that_hold_for_every_truth() -> None:
    one = np.array([[1.0]])
    found = Biases(
        bias=0.0 * one,
        error=0.01 * one,
        own=Range(-0.02 * one, 0.02 * one),
        simultaneous=Range(-0.03 * one, 0.03 * one),
        resolution=0.04 * one,
        p_value=one,
    )
    wider = up_to(found, 0.06 * one)
    assert wider.bias == pytest.approx(-0.03)
    assert (wider.own.low, wider.own.high) == (pytest.approx(-0.08), pytest.approx(0.02))
    assert (wider.simultaneous.low, wider.simultaneous.high) == (pytest.approx(-0.09), pytest.approx(0.03))
    assert wider.resolution == pytest.approx(0.07)
    # inside ± 0.08 whatever the truth is; inside ± 0.07 only if the truth is low
    assert wider.own.inside(0.08 * one).all()
    assert not wider.own.inside(0.07 * one).any()


@pytest.mark.parametrize(
    ("factor", "verdict"),
    [
        (1.0, "pass"),  # 1.5 % too dark at most
        (1.015, "pass"),  # 1.5 % too bright at most
        (0.99, "inconclusive"),  # right enough, if nothing follows
        (1.03, "inconclusive"),
        (0.97, "fail"),  # too dark for any truth
        (1.05, "fail"),
    ],
)
def test_a_tail_is_an_interval_of_truths(
    against: Callable[..., Comparison], monkeypatch: pytest.MonkeyPatch, factor: float, verdict: str
) -> None:
    """The rest may be up to 1.5 % of the sum, which is held against ± 2 %."""
    case = small("furnace-cornell", tolerance=Tolerance(image=(0.02,), tile=(0.04,)))
    plain = Series.of.__func__  # type: ignore[attr-defined]

    def with_a_tail(cls: type[Series], case: Case, truth: Any) -> Series:
        found = plain(cls, case, truth)
        # denominators are those of the sum: the same in all pixels
        return replace(found, bound=0.015 * found.terms.sum(axis=0).mean(axis=(0, 1)))

    oracle = Oracle(case, of_total=lambda image: factor * image)
    monkeypatch.setattr(Series, "of", classmethod(with_a_tail))
    found = against(case, oracle, budget=1.5)
    [total] = found.totals
    assert total.verdict == verdict, total.message
    if verdict == "inconclusive":
        assert "the tail is not known well enough" in total.message
        assert found.verdict == "inconclusive"


def test_a_tail_wider_than_the_tolerance_is_told_beforehand(
    against: Callable[..., Comparison], monkeypatch: pytest.MonkeyPatch
) -> None:
    case = small("furnace-cornell")
    oracle = Oracle(case)
    monkeypatch.setattr("comparisons.whole_sum.MOST", 4)  # so that the bound of its albedos is all there is
    [total] = against(case, oracle).totals
    assert (total.verdict, total.result) == ("unsupported", None)
    assert "bounces 0 to 4" in total.message


# ---- planted in the tracer, at its production settings


class Unfair(ReferenceRenderer):
    """Ends walks by roulette, and does not make brighter what goes on."""

    name = "unfair-roulette"

    def total(self, scene: Scene, spp: int, seed: int) -> Images:
        def unfair(throughput: Images, bounce: int, u: Images) -> Images:
            return np.asarray(throughput * (roulette(throughput, bounce, u) > 0))

        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(random_walk, "roulette", unfair)
            return super().total(scene, spp, seed)


class Clamped(ReferenceRenderer):
    """Clamps what a pixel holds of light that something has reflected, against fireflies."""

    name = "clamped"

    def total(self, scene: Scene, spp: int, seed: int) -> Images:
        image = self.render(scene, range(13), spp, seed)
        return np.asarray(image[0] + np.minimum(image[1:].sum(axis=0), 1.0))


@pytest.mark.parametrize(
    ("renderer", "name", "verdict"),
    [
        (ReferenceRenderer("mis"), "furnace-cornell", "pass"),
        (Unfair("mis"), "furnace-channels", "fail"),
        (Clamped("mis"), "integrating-sphere", "fail"),
        (ReferenceRenderer("nee"), "integrating-sphere", "pass"),
    ],
)
def test_production_settings_of_the_tracer(
    against: Callable[..., Comparison], renderer: ReferenceRenderer, name: str, verdict: str
) -> None:
    """An unfair roulette loses a third of the light of furnace-channels: it fails at the first look."""
    case = small(name, tolerance=Tolerance(image=(0.03,), tile=(0.15,)), bounces=3)
    found = against(case, renderer, budget=120.0)
    assert {b.verdict for b in found.bounces} == {"pass"}
    assert [t.verdict for t in found.totals] == [verdict], found.totals


def test_sound_roulette_seldom_fails(against: Callable[..., Comparison]) -> None:
    """Eight seeds of a right renderer at α = 1 %: one fails with a probability below 8 %, these do not."""
    case = small("furnace-cornell")
    verdicts = [against(case, Oracle(case), seed=seed, alpha=0.01).totals[0].verdict for seed in range(8)]
    assert verdicts == ["pass"] * 8


# ---- known deviations


def declared(bounces: list[int], bias: list[float], within: float = 0.004) -> Deviation:
    return Deviation(
        case="furnace-cornell",
        renderer="reference",
        versions="==1",
        bounces=bounces,
        bias=list(bias),
        within=within,
        tile_within=0.05,
        reason="a lamp too weak",
        link="docs/findings/made-up.md",
        onwards=True,
    )


@pytest.mark.parametrize(
    ("factor_of_total", "verdict"), [(None, "known"), (0.90, "fail")], ids=["explained", "more than that"]
)
def test_what_is_declared_of_bounces_explains_the_total(
    against: Callable[..., Comparison],
    monkeypatch: pytest.MonkeyPatch,
    factor_of_total: float | None,
    verdict: str,
) -> None:
    """Every bounce from 1 on is 3 % low. Of the sums E + TE + …, that is 3 % of what is not E."""
    case = small("furnace-cornell")
    truth = case.answer.truth(case.scene, case.bounces)
    assert truth is not None
    whole, E = Series.of(case, truth).total().mean, truth.mean[0]
    wrong = (lambda image: E + 0.97 * (whole - E)) if factor_of_total is None else lambda image: 0.9 * image
    oracle = Oracle(case, of_total=wrong, factors=lambda k: 1.0 if k == 0 else 0.97)
    monkeypatch.setattr("comparisons.comparison.declared", lambda *_: [declared([1], [-0.03])])
    found = against(case, oracle)
    [total] = found.totals
    assert total.verdict == verdict
    assert [b.verdict for b in found.bounces] == ["pass"] + ["known"] * 5
    assert total.result is not None
    assert total.result.known is not None
    assert "What is declared of bounces 1, 2, 3, 4, 5, 6 … explains it" in total.result.known.reason


@pytest.mark.parametrize(
    ("bias", "verdict", "state"),
    [(-0.05, "known", "confirmed"), (-0.09, "fail", "changed"), (0.0, "pass", "vanished")],
)
def test_of_the_total_alone_a_deviation_can_be_declared(
    against: Callable[..., Comparison], monkeypatch: pytest.MonkeyPatch, bias: float, verdict: str, state: str
) -> None:
    """Every bounce is right, and their sum, as users have it, is not: Russian roulette, say."""
    case = small("furnace-cornell")
    entry = msgspec.structs.replace(declared([1], [-0.05]), bounces=[], bias=[], onwards=False, total=-0.05)
    monkeypatch.setattr("comparisons.comparison.declared", lambda *_: [entry])
    found = against(case, Oracle(case, of_total=lambda image: (1 + bias) * image))
    [total] = found.totals
    assert [b.verdict for b in found.bounces] == ["pass"] * 6
    assert found.verdict == total.verdict == verdict
    assert total.result is not None
    assert total.result.known is not None
    assert (total.result.known.declared_bias, total.result.known.state) == (-0.05, state)
    assert any("The total: the declared deviation has vanished" in note for note in found.notes) == (not bias)


# ---- what is said of several, and a renderer that is wrapped


def test_what_totals_have_in_common_is_said_once() -> None:
    def total(scale: float, message: str, verdict: Verdict = "inconclusive") -> TotalResult:
        return TotalResult(verdict=verdict, scale=scale, message=message)

    assert said_of([total(scale, "total: why") for scale in (0.0, 0.5, 1.0)]) == "total: why"
    others = [total(0.25, "", "pass"), total(0.5, "total: why"), total(0.75, "total: why")]
    assert said_of(others) == "albedo × 0.5, 0.75: total: why"
    assert said_of([*others, total(1.0, "total: else")]) == "albedo × 0.5, 0.75: total: why; total: else"
    assert said_of([total(1.0, "total: else", "unsupported")]) == ""


def test_a_wrapped_renderer_keeps_its_total() -> None:
    """Faults are planted around renderers; one that changes requests for bounces leaves the total as it is."""
    scene = library.case("furnace-box").scene.resized(4, 4)
    plain = ReferenceRenderer("mis")
    planted = of_request(lambda inner, *request: inner.render(*request))(plain)
    np.testing.assert_array_equal(planted.total(scene, 2, 1), plain.total(scene, 2, 1))  # type: ignore[attr-defined]
