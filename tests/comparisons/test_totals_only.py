"""A renderer that makes nothing but totals: sums of the scene with darker albedos take the place of bounces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import numpy as np

from comparisons.renderers import Images, RendererError, Unsupported
from comparisons.renderers.reference import ReferenceRenderer
from comparisons.results import Comparison
from comparisons.whole_sum import Series
from scenes import Scene, Tolerance

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("oracle.py"))))
Oracle, small = shared.Oracle, shared.small


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
