"""The row ``total``: what only production settings get wrong must fail there, and nowhere else."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from comparisons import campaign
from comparisons.diagnosis import diagnoses
from comparisons.faults.planting import of_request
from comparisons.known import Deviation
from comparisons.renderers import Images, Renderer, RendererError, Unsupported
from comparisons.renderers.reference import ReferenceRenderer
from comparisons.results import Comparison, TotalResult, Verdict
from comparisons.settings import Settings, Silent
from comparisons.statistics.intervals import Biases, Range
from comparisons.total import said_of, up_to
from comparisons.whole_sum import Series
from reference_tracer import random_walk
from reference_tracer.roulette import roulette
from scenes import Case, Scene, Tolerance, library

NOISE = 0.01  # of a pixel, relative, one sample per pixel


class Oracle:
    """Knows the answer, and adds noise: what it gets wrong is what a test plants, and nothing else."""

    name = "oracle"

    def __init__(
        self,
        case: Case,
        of_total: Callable[[Images], Images] = lambda image: image,
        factors: Callable[[int], float] = lambda k: 1.0,
    ) -> None:
        truth = case.answer.truth(case.scene, case.bounces)
        assert truth is not None
        self._terms, self._sum = truth.mean, Series.of(case, truth).total().mean
        self._of_total, self._factors = of_total, factors

    def version(self) -> str:
        return "1"

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        if scene.shape != self._sum.shape:  # the probe
            return np.random.default_rng(seed).random((len(bounces), *scene.shape))
        return np.stack([self._noisy(self._factors(k) * self._terms[k], spp, seed + 7 * k) for k in bounces])

    def total(self, scene: Scene, spp: int, seed: int) -> Images:
        return self._noisy(self._of_total(self._sum), spp, seed)

    def _noisy(self, image: Images, spp: int, seed: int) -> Images:
        noise = np.random.default_rng(seed).normal(size=image.shape) * NOISE / np.sqrt(spp)
        return np.asarray(image * (1 + noise))


def small(name: str, size: int = 8, **changes: Any) -> Case:
    case = library.case(name)
    return replace(case, scene=case.scene.resized(size, size), **changes)


@pytest.fixture
def against(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Comparison]:
    """``against(case, renderer, **settings)``."""
    monkeypatch.setattr("comparisons.total.LEAST_PATHS", 256)  # images are small, and need few

    def run(case: Case, renderer: Renderer, **settings: Any) -> Comparison:
        chosen = Settings(**({"budget": 20.0, "first_look": 0.1} | settings))
        [comparison] = campaign.run([case], [renderer], chosen, tmp_path, Silent())
        return comparison

    return run


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


# ---- a renderer that makes nothing but totals


class Total:
    """A program without depth control."""

    name = "total-only"

    def __init__(self, seeded: bool = True) -> None:
        self._inner, self._seeded = ReferenceRenderer("mis"), seeded

    def version(self) -> str:
        return "1"

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        raise Unsupported("per-bounce images: the program has no option for its depth")

    def total(self, scene: Scene, spp: int, seed: int) -> Images:
        return self._inner.total(scene, spp, seed if self._seeded else 1)


LOOSE = Tolerance(image=(0.04,), tile=(0.3,))


def test_without_depth_control_darker_scenes_are_compared(against: Callable[..., Comparison]) -> None:
    case = small("furnace-box", size=4, tolerance=Tolerance(image=(0.06,), tile=(0.3,)), tiles=(2, 2))
    found = against(case, Total(), budget=200.0)
    assert found.verdict == "pass"
    assert [b.bounce for b in found.bounces] == [0]
    assert [(t.scale, t.verdict) for t in found.totals] == [(s, "pass") for s in (0.25, 0.5, 0.75, 1.0)]
    assert any("no bounce from 1 on can be seen by itself" in note for note in found.notes)
    assert found.images is not None


def test_what_every_surface_reflects_too_much_shows_more_and_more(against: Callable[..., Comparison]) -> None:
    """Albedos 6 % too high: E is right, and each further scale is further off."""

    class Brighter(Oracle):
        def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
            raise Unsupported("per-bounce images: the program has no option for its depth")

        def total(self, scene: Scene, spp: int, seed: int) -> Images:
            scale = scene.surfaces[0].material.albedo[0] / case.scene.surfaces[0].material.albedo[0]  # type: ignore
            probed = scene.shape != case.scene.shape
            return self._noisy(np.ones(scene.shape) if probed else whole.total(1.06 * scale).mean, spp, seed)

    case = small("furnace-box", tolerance=LOOSE)
    truth = case.answer.truth(case.scene, case.bounces)
    assert truth is not None
    whole = Series.of(case, truth)
    found = against(case, Brighter(case))
    assert found.verdict == "fail"
    assert [b.verdict for b in found.bounces] == ["pass"]
    biases = [t.result.bias for t in found.totals if t.result]
    assert biases == sorted(biases)
    # Σ (s ρ)ᵏ with ρ = 0.53 in place of 0.5
    expected = [(1 - 0.5 * s) / (1 - 0.53 * s) - 1 for s in (0.25, 0.5, 0.75, 1.0)]
    np.testing.assert_allclose(biases, expected, atol=0.002)
    assert found.totals[-1].verdict == "fail"


def test_where_albedos_can_not_be_scaled_only_the_sum_is_compared(against: Callable[..., Comparison]) -> None:
    case = small("glass-ball", tolerance=LOOSE)
    found = against(case, Total(), budget=200.0)
    assert found.verdict == "pass"
    assert found.bounces == []
    assert [t.verdict for t in found.totals] == ["unsupported"] * 3 + ["pass"]
    assert "dielectric" in found.totals[0].message.lower()


def test_what_totals_have_in_common_is_said_once() -> None:
    def total(scale: float, message: str, verdict: Verdict = "inconclusive") -> TotalResult:
        return TotalResult(verdict=verdict, scale=scale, message=message)

    assert said_of([total(scale, "total: why") for scale in (0.0, 0.5, 1.0)]) == "total: why"
    others = [total(0.25, "", "pass"), total(0.5, "total: why"), total(0.75, "total: why")]
    assert said_of(others) == "albedo × 0.5, 0.75: total: why"
    assert said_of([*others, total(1.0, "total: else")]) == "albedo × 0.5, 0.75: total: why; total: else"
    assert said_of([total(1.0, "total: else", "unsupported")]) == ""


def test_its_seed_is_probed_by_totals(against: Callable[..., Comparison]) -> None:
    case = small("furnace-box", tolerance=LOOSE)
    found = against(case, Total(seeded=False))
    assert found.verdict == "error"
    assert "takes no notice of its seed" in found.message
    assert "the total of the Cornell box" in found.message


def test_what_crashes_once_is_not_asked_again(against: Callable[..., Comparison]) -> None:
    asked: list[int] = []

    class Crashing(Total):
        def total(self, scene: Scene, spp: int, seed: int) -> Images:
            if scene.shape != case.scene.shape:
                return super().total(scene, spp, seed)
            asked.append(seed)
            raise RendererError("out of memory")

    case = small("furnace-box", size=9, tolerance=LOOSE)
    found = against(case, Crashing())
    assert (found.verdict, found.bounces, len(asked)) == ("error", [], 1)
    assert "out of memory" in found.message


def test_a_wrapped_renderer_keeps_its_total() -> None:
    """Faults are planted around renderers; one that changes requests for bounces leaves the total as it is."""
    scene = library.case("furnace-box").scene.resized(4, 4)
    plain = ReferenceRenderer("mis")
    planted = of_request(lambda inner, *request: inner.render(*request))(plain)
    np.testing.assert_array_equal(planted.total(scene, 2, 1), plain.total(scene, 2, 1))  # type: ignore[attr-defined]
