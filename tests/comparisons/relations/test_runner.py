"""How claims are tried: seeds, statistics, verdicts, and what can't be claimed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from scipy import stats

from comparisons.known import Deviation
from comparisons.relations import RELATIONS, STAGES, Subject, Task, all_tasks, cheap_tasks, run
from comparisons.relations.relation import Equal, Part, Relation
from comparisons.relations.replicates import Pairs, split
from comparisons.renderers import Images, RendererFailed, Unsupported, create
from comparisons.results import RelationResult
from comparisons.sequential import Sampler
from comparisons.settings import Settings
from comparisons.statistics.moments import Moments
from scenes import (
    ConstantEnvironment,
    Dielectric,
    IrradianceMeter,
    Lambertian,
    Mesh,
    Mirror,
    Pinhole,
    PointLight,
    Quad,
    Scene,
    Sphere,
    Surface,
    Tolerance,
    box,
)

Try = Callable[..., list[RelationResult]]

GREY = Lambertian((0.5,))
FLOOR = Surface("floor", Quad((-1, 0, 1), (2, 0, 0), (0, 0, -2)), GREY)
VIEW = Pinhole((0, 1, 2), (0, 0, 0), (0, 1, 0), 45, 4, 4)
LAMP = PointLight((0, 1, 0), (1.0,))
SKY = ConstantEnvironment((1.0,))
SHADED = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)], [(0, 0.1, 1)] * 3)


def grey(*surfaces: Surface, **changes: Any) -> Scene:
    return Scene((FLOOR, *surfaces), **({"sensor": VIEW, "lights": (LAMP,)} | changes))


# ---- what can't be claimed


@pytest.mark.parametrize(
    ("relation", "scene", "why"),
    [
        ("superposition", grey(), r"nothing emits but lights[0]; superposition takes two emitters"),
        ("homogeneity", grey(Surface("ball", Sphere((0, 1, 0), 0.3), Dielectric())), "'Dielectric'"),
        ("channels", grey(), "one channel"),
        ("roll", grey(sensor=IrradianceMeter((0, 1, 0), (0, -1, 0))), "IrradianceMeter"),
        ("first-hits", grey(sensor=IrradianceMeter((0, 1, 0), (0, -1, 0))), "IrradianceMeter"),
        (
            "reciprocity",
            grey(Surface("mirror", Sphere((0, 1, 0), 0.3), Mirror((0.5,)))),
            "surface mirror is a Mirror",
        ),
        ("reciprocity", grey(Surface("shaded", SHADED, GREY)), "surface shaded has shading normals"),
        ("reciprocity", Scene((), VIEW, (SKY,)), "there is no surface"),
        (
            "reciprocity",
            Scene(
                box("wall", (0, 0, 0), ((3, 0, 0), (0, 3, 0), (0, 0, 3)), GREY, inward=True),
                VIEW,
                (LAMP,),
            ),
            "closed",
        ),
    ],
)
def test_what_does_not_apply_says_why(attempt: Try, relation: str, scene: Scene, why: str) -> None:
    [result] = attempt(relation, scene=scene)
    assert result.verdict == "unsupported"
    assert result.message.startswith("not applicable: ")
    assert why in result.message


def test_errors_and_missing_features_are_results(attempt: Try) -> None:
    def refuse(*_: Any) -> Images:
        raise Unsupported("floors")

    def fail(*_: Any) -> Images:
        raise RendererFailed("out of memory", ["the last line"])

    [refused], [failed] = attempt("channels", refuse), attempt("channels", fail)
    assert (refused.verdict, refused.message) == ("unsupported", "floors")
    assert (failed.verdict, failed.log) == ("error", ["the last line"])
    assert failed.message.startswith("out of memory")


def test_negative_radiance_is_reported(attempt: Try, wrong: Any) -> None:
    def with_a_hole(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        images = wrong.right(scene, bounces, spp, seed)
        images[:, 3, 2] = -100.0
        return images

    [result] = attempt("linearity", with_a_hole, last=0)
    [note] = result.notes
    assert note.startswith("Bounce 0: radiance is negative in 1 pixels, down to -")
    assert "in row 3, column 2" in note


def test_without_noise_there_are_no_intervals(attempt: Try, wrong: Any) -> None:
    """A renderer that ignores its seed would have failed ``rotation``, with an interval of no width."""
    [result] = attempt("rotation", wrong.deaf_to_its_seed)
    assert result.verdict == "error"
    assert "takes no notice of its seed" in result.message


def test_black_on_both_sides_is_no_pass(attempt: Try, wrong: Any) -> None:
    [result] = attempt("linearity", wrong.black)
    assert result.verdict == "inconclusive"
    assert "says nothing" in result.message


def test_a_renderer_that_can_t_tell_first_hits(attempt: Try) -> None:
    def cannot(scene: Scene) -> Any:
        raise Unsupported("first hits: its adapter has no first_hits(scene)")

    [result] = attempt("first-hits", hits=cannot)
    assert result.verdict == "unsupported"


def test_a_noiseless_scene_says_nothing_of_seeds_and_a_noisy_one_is_asked(attempt: Try, wrong: Any) -> None:
    def image(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        return (
            np.ones((len(bounces), *scene.shape))
            if scene.channels == 1
            else wrong.right(scene, bounces, spp, seed)
        )

    result, _ = attempt("seeds", image, scene=grey())
    assert result.verdict == "pass"
    assert "no noise" in result.message


# ---- seeds, budgets, settings


def test_no_two_renders_of_a_claim_share_a_seed(attempt: Try, here: Any) -> None:
    crew = here({})
    [result] = attempt("superposition", crew=crew, last=0)
    drawn = [seed for _, _, seed in crew.asked]
    asked_whether_it_heeds_them = 2
    assert len(drawn) == len(set(drawn)) == 3 * result.replicates + asked_whether_it_heeds_them


def test_an_exhausted_budget_is_inconclusive_and_says_what_could_have_been_seen(attempt: Try) -> None:
    [result] = attempt("homogeneity", budget=0.001)
    assert result.verdict == "inconclusive"
    assert result.replicates == 2
    assert "the budget of 0.001 s was used up after 2 replicates, and a verdict needs 32" in result.message


def test_settings_have_the_last_word(attempt: Try) -> None:
    [result] = attempt("linearity", tolerance=(0.11,), tile_tolerance=(0.7,), bounces=1, size=(8, 6))
    assert {(b.tolerance, b.tile_tolerance) for b in result.bounces} == {(0.11, 0.7)}
    assert [b.bounce for b in result.bounces] == [0, 1]
    assert result.bounces[0].worst_tile.place.y1 <= 6


def test_a_run_can_be_repeated(attempt: Try) -> None:
    first, second, other = (attempt("homogeneity", seed=seed, last=1)[0] for seed in (1, 1, 2))
    assert first.bounces == second.bounces
    assert first.bounces != other.bounces


def test_a_strategy_of_another_renderer_is_never_taken(attempt: Try) -> None:
    [result] = attempt("strategies", renderer="mitsuba:scalar_rgb")
    assert result.verdict == "unsupported"
    assert "offers one strategy" in result.message


# ---- statistics


def made_up(deviation: float, shape: str) -> Any:
    """A claim whose first side is higher by this share, and a crew that renders it: white noise of one shape."""

    class Noise:
        jobs = 1

        def render(self, name: str, scene: Scene, bounces: Any, spp: int, seed: int, timeout: float) -> Any:
            from concurrent.futures import Future

            rng = np.random.default_rng(seed)
            noise = {
                "normal": lambda: rng.normal(1.0, 0.2, (1, 1, 1, 1)),
                "skewed": lambda: rng.exponential(1.0, (1, 1, 1, 1)),
            }[shape]()
            future: Future[Images] = Future()
            future.set_result(noise)
            return future

        def version(self, name: str) -> str:
            return "0"

        def dismiss(self, name: str) -> None:
            pass

    scene = grey(sensor=Pinhole((0, 1, 2), (0, 0, 0), (0, 1, 0), 45, 1, 1))
    claim = Equal((Part(scene, weight=lambda k: 1 + deviation),), (Part(scene),), bounces=(0,))
    relation = Relation("made-up", "E", "", "", lambda *_: [claim], (), tiles=(1, 1))
    return relation, scene, Noise()


@pytest.mark.parametrize("shape", ["normal", "skewed"])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_deviation_of_exactly_the_tolerance_is_seldom_decided(
    monkeypatch: pytest.MonkeyPatch, shape: str, sign: int
) -> None:
    """Both verdicts are wrong there: each may come in a share α of the runs, here 10 %; three looks in each run."""
    runs, alpha = 100, 0.10
    found = _repeated(monkeypatch, sign * TOLERANCE, shape, runs, alpha)
    most = stats.binom.ppf(0.99, runs, alpha)
    assert found.count("fail") <= most
    assert found.count("pass") <= most


@pytest.mark.parametrize(("deviation", "verdict"), [(0.0, "pass"), (0.15, "fail"), (-0.15, "fail")])
def test_what_is_far_from_the_tolerance_is_decided(
    monkeypatch: pytest.MonkeyPatch, deviation: float, verdict: str
) -> None:
    """After 512 replicates the difference has a standard error of 0.2 √(2 / 512) = 1.25 %; tolerance ± 5 %."""
    found = _repeated(monkeypatch, deviation, "normal", 20, 0.10, replicates=512)
    assert found.count(verdict) >= 10
    assert set(found) <= {verdict, "inconclusive"}


TOLERANCE = 0.05


@pytest.mark.parametrize(
    ("deviation", "of", "verdict", "state"),
    [
        (0.15, "made-up", "known", "confirmed"),
        (0.30, "made-up", "fail", "changed"),
        (0.0, "made-up", "pass", "vanished"),
        (0.15, None, "fail", None),  # declared of the comparison, not of the relation
    ],
)
def test_a_deviation_can_be_declared(
    monkeypatch: pytest.MonkeyPatch, deviation: float, of: str | None, verdict: str, state: str | None
) -> None:
    """± 4 % around the 15 % that are declared; the difference has a standard error of 0.6 %."""
    monkeypatch.setattr(Sampler, "exhausted", property(lambda s: bool(s.regions) and s.replicates >= 2048))
    relation, scene, crew = made_up(deviation, "normal")
    entry = Deviation("dot", "reference", "", 0.04, 0.04, "why", "where", [0], [0.15], relation=of)
    task = Task(relation, Subject("dot", scene), tolerance=Tolerance((TOLERANCE,), (TOLERANCE,)), walks=1)
    [result] = run([task], ["reference"], Settings(alpha=0.01, known=(entry,)), _Silent(), crew)
    assert result.verdict == verdict
    known = result.bounces[0].known
    assert (known and known.state) == state
    assert any("the declared deviation has vanished" in note for note in result.notes) == (
        state == "vanished"
    )


def _repeated(
    monkeypatch: pytest.MonkeyPatch,
    deviation: float,
    shape: str,
    runs: int,
    alpha: float,
    replicates: int = 128,
) -> list[str]:
    """Verdicts of many runs, each of which ends after so many replicates."""
    monkeypatch.setattr(
        Sampler, "exhausted", property(lambda s: bool(s.regions) and s.replicates >= replicates)
    )
    relation, scene, crew = made_up(deviation, shape)
    task = Task(relation, Subject("dot", scene), tolerance=Tolerance((TOLERANCE,), (TOLERANCE,)), walks=1)
    found = []
    for seed in range(runs):
        [result] = run([task], ["reference"], Settings(alpha=alpha, seed=seed), _Silent(), crew)
        found.append(result.verdict)
    return found


class _Silent:
    def started(self, case: str, renderer: str) -> None: ...
    def progressed(self, share: float, message: str) -> None: ...
    def finished(self, comparison: Any) -> None: ...
    def related(self, results: list[RelationResult]) -> None: ...


def test_pairs_carry_both_sides_with_seeds_of_their_own() -> None:
    relation, scene, crew = made_up(0.5, "normal")
    [claim] = relation.claims(scene, 0, "")
    pairs = Pairs(claim, crew, 0)
    drawn = [pairs.render("", scene, [0], 1, seed, 1.0).result() for seed in range(2000)]
    first, second = split(Moments.of_all(np.array(drawn)))
    assert first.mean.shape == second.mean.shape == (1, 1, 1, 1)
    assert first.mean.item() == pytest.approx(1.5, abs=4 * 0.3 / np.sqrt(2000))
    assert second.mean.item() == pytest.approx(1.0, abs=4 * 0.2 / np.sqrt(2000))
    assert np.sqrt(second.variance.item()) == pytest.approx(0.2, rel=0.1)
    correlation = np.corrcoef(np.reshape(drawn, (-1, 2)).T)[0, 1]
    assert abs(correlation) < 4 / np.sqrt(2000)


# ---- lists


def test_tasks_of_a_run() -> None:
    own = [Subject("mine", grey())]
    assert [t.subject.name for t in all_tasks(list(RELATIONS.values()), own)] == ["mine"] * len(RELATIONS)
    usual = all_tasks(list(RELATIONS.values()))
    assert len(usual) == sum(len(relation.scenes) for relation in RELATIONS.values())
    assert {t.subject.name for t in usual} == set(STAGES)
    assert {t.relation.name for t in cheap_tasks()} == {"first-hits", "superposition", "homogeneity"}


@pytest.mark.parametrize("name", RELATIONS)
def test_each_says_what_it_tests_and_what_it_can_t_see(name: str) -> None:
    relation = RELATIONS[name]
    assert relation.name == name
    assert relation.statement
    assert relation.blind_to
    assert set(relation.scenes) <= set(STAGES)


def test_every_operator_has_a_relation() -> None:
    assert {r.operator for r in RELATIONS.values()} == {"E", "G", "R", "T", "sensor", "estimator"}


@dataclass  # which has no hash
class Named:
    """An object of this process; ``seed``: whether it ignores its own."""

    name: str = "mine"
    seed: int | None = None
    deterministic: bool = False

    def version(self) -> str:
        return "7"

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        return create("reference").render(scene, bounces, spp, seed if self.seed is None else self.seed)


def test_an_object_that_ignores_its_seed_is_told_unless_it_declares_to_have_no_noise(attempt: Try) -> None:
    [deaf] = attempt("linearity", renderer=Named(seed=7), last=1)
    assert deaf.verdict == "error"
    [linear] = attempt("linearity", renderer=Named(seed=7, deterministic=True), last=1)
    assert linear.verdict == "pass"  # the same paths on both sides
    [seeds] = attempt("seeds", renderer=Named(seed=7, deterministic=True))
    assert (seeds.verdict, seeds.message) == (
        "unsupported",
        "not applicable: mine declares that it has no noise",
    )


def test_an_object_of_this_process_is_tried_like_any_renderer(attempt: Try) -> None:
    found = attempt("homogeneity", renderer=Named(), bounces=1, budget=5)
    assert [(one.renderer, one.renderer_version, one.verdict) for one in found] == [("mine", "7", "pass")]
    [hits] = attempt("first-hits", renderer=Named())
    assert hits.verdict == "unsupported"
