"""Objects of this process as renderers: right ones pass, wrong ones fail, and whatever they do is a result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from comparisons import campaign
from comparisons.in_process import InProcess
from comparisons.renderers import Images, RendererFailed, Unsupported
from comparisons.results import Comparison
from comparisons.settings import Settings
from scenes import Scene, library

CASE = library.case("furnace-box")


@dataclass
class Noise:
    """The truth, with normal noise of 5 % a sample and pixel, times a factor per bounce."""

    factors: Sequence[float] = (1.0,) * 6

    def version(self) -> str:
        return "0.1 of my own"  # which no version number of a package looks like

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        rows = list(bounces)
        noise = np.random.default_rng(seed).normal(1.0, 0.05 / np.sqrt(spp), (len(rows), *scene.shape))
        if scene.surfaces != CASE.scene.surfaces:
            return noise  # asked whether it heeds its seed
        truth = CASE.answer.truth(scene, max(bounces))
        assert truth is not None
        return truth.mean[rows] * noise * np.take(self.factors, rows)[:, None, None, None]


class Wrong(Noise):
    def __init__(self, returned: Any) -> None:
        super().__init__()
        self._returned = returned

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Any:
        return self._returned(super().render(scene, bounces, spp, seed))


class Raising(Noise):
    def __init__(self, error: BaseException) -> None:
        super().__init__()
        self._error = error

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        raise self._error


class OnePicture(Noise):
    """Draws every image over the last one."""

    picture: Images | None = None

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        image = super().render(scene, bounces, spp, seed)
        if self.picture is None or self.picture.shape != image.shape:
            self.picture = np.empty_like(image)
        self.picture[...] = image
        return self.picture


def compare(renderer: Any, tmp_path: Path, observer: Any) -> Comparison:
    settings = Settings(size=(8, 8), budget=20.0)
    [comparison] = list(campaign.run([CASE], [renderer], settings, tmp_path, observer))
    return comparison


def test_what_is_right_passes_under_the_name_of_its_class(tmp_path: Path, observer: Any) -> None:
    comparison = compare(Noise(), tmp_path, observer)
    assert (comparison.verdict, comparison.renderer) == ("pass", "Noise")
    assert comparison.renderer_version == "0.1 of my own"
    assert observer.events == [("furnace-box", "Noise"), ("furnace-box", "pass")]
    assert (tmp_path / "images" / "furnace-box" / "Noise.exr").is_file()


def test_what_is_wrong_fails_at_its_bounce_and_its_size_is_measured(tmp_path: Path, observer: Any) -> None:
    """32 replicates of 64 pixels: an error of 0.1 % at the most, against tolerances of 0.5 %."""
    comparison = compare(Noise((1, 1, 1.03, 1, 1, 1)), tmp_path, observer)
    assert [b.verdict for b in comparison.bounces] == ["pass", "pass", "fail", "pass", "pass", "pass"]
    low, high = comparison.bounces[2].interval
    assert low < 0.03 < high


def test_an_image_that_is_drawn_over_is_not_lost() -> None:
    scene, crews = CASE.scene.resized(8, 8), [InProcess(OnePicture()), InProcess(Noise())]
    futures = [[crew.render("", scene, [0, 1], 1, seed, 60.0) for seed in range(3)] for crew in crews]
    drawn_over, new = ([future.result() for future in of_crew] for of_crew in futures)
    np.testing.assert_array_equal(drawn_over, new)


@pytest.mark.parametrize(
    ("returned", "message"),
    [
        (lambda image: None, "returned values of type object, expected an array of real numbers"),
        (lambda image: image.astype(complex), "returned values of type complex128"),
        (lambda image: image[:, :-1], "returned an image of shape (2, 7, 8, 3), expected (2, 8, 8, 3)"),
        (lambda image: np.where(image > 0, np.nan, image), "not finite"),
        (lambda image: [[1.0], [2.0, 3.0]], "ValueError"),
    ],
)
def test_what_is_no_image_is_an_error(tmp_path: Path, observer: Any, returned: Any, message: str) -> None:
    comparison = compare(Wrong(returned), tmp_path, observer)
    assert comparison.verdict == "error"
    assert message in comparison.message


def test_single_precision_will_do(tmp_path: Path, observer: Any) -> None:
    assert compare(Wrong(lambda image: image.astype(np.float32)), tmp_path, observer).verdict == "pass"


def test_an_exception_is_an_error_with_the_end_of_its_traceback(tmp_path: Path, observer: Any) -> None:
    comparison = compare(Raising(RuntimeError("out of texture memory")), tmp_path, observer)
    assert comparison.verdict == "error"
    assert comparison.message.startswith("RuntimeError: out of texture memory (asked for the Cornell box, ")
    assert comparison.log[-1] == "RuntimeError: out of texture memory"
    assert "raise self._error" in comparison.log[-2]
    assert not any("in_process.py" in line for line in comparison.log if "test_in_process" not in line)


def test_a_missing_feature_is_unsupported(tmp_path: Path, observer: Any) -> None:
    comparison = compare(Raising(Unsupported("spheres")), tmp_path, observer)
    assert (comparison.verdict, comparison.message) == ("unsupported", "spheres")


class WithoutSeed(Noise):
    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        return super().render(scene, bounces, spp, 7)


class Deterministic(WithoutSeed):
    deterministic = True


def test_whoever_ignores_the_seed_is_told_unless_it_declares_to_have_no_noise(
    tmp_path: Path, observer: Any
) -> None:
    comparison = compare(WithoutSeed(), tmp_path, observer)
    assert comparison.verdict == "error"
    assert "takes no notice of its seed" in comparison.message
    assert compare(Deterministic((1, 1, 1.5, 1, 1, 1)), tmp_path, observer).verdict == "fail"


def test_a_bounce_that_is_lost_is_a_fail_and_says_nothing_of_seeds(tmp_path: Path, observer: Any) -> None:
    class WithoutDirectLight(Noise):
        def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
            images = super().render(scene, bounces, spp, seed)
            images[[k == 1 for k in bounces]] = 0
            return images

    comparison = compare(WithoutDirectLight(), tmp_path, observer)
    assert comparison.verdict == "fail"
    assert [b.bounce for b in comparison.bounces if b.verdict == "fail"] == [1]


def test_the_seed_is_asked_for_once_and_a_scene_too_many_may_be_refused(
    tmp_path: Path, observer: Any
) -> None:
    asked = []

    class WithoutLamps(Noise):
        def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
            if scene.surfaces != CASE.scene.surfaces:
                asked.append(seed)
                raise Unsupported("lamps")
            return super().render(scene, bounces, spp, seed)

    settings = Settings(size=(8, 8), budget=20.0, bounces=0)
    found = campaign.run([CASE, replace(CASE, name="again")], [WithoutLamps()], settings, tmp_path, observer)
    assert [comparison.verdict for comparison in found] == ["pass", "pass"]
    assert len(asked) == 1


def test_ctrl_c_goes_through(tmp_path: Path, observer: Any) -> None:
    with pytest.raises(KeyboardInterrupt):
        compare(Raising(KeyboardInterrupt()), tmp_path, observer)


def test_a_version_must_be_a_text() -> None:
    class Numbered(Noise):
        def version(self) -> Any:
            return 3

    with pytest.raises(RendererFailed, match=r"version\(\) returned 3: expected a text"):
        InProcess(Numbered()).version("")


def test_an_object_is_never_taken_for_a_registered_renderer(tmp_path: Path, observer: Any) -> None:
    """Even if it is called like the one that estimated the truth, in whose place another one is judged."""

    class reference(Noise):  # noqa: N801
        def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
            return np.random.default_rng(seed).normal(1.0, 0.05, (len(bounces), *scene.shape))

    case, settings = replace(library.case("cornell-box"), bounces=0), Settings(size=(8, 8), budget=20.0)
    [comparison] = campaign.run([case], [reference()], settings, tmp_path, observer)
    assert (comparison.renderer, comparison.verdict) == ("reference", "fail")  # a grey wall is no Cornell box
    assert comparison.notes == []
