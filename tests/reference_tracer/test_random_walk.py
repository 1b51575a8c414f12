"""The walk against exact answers, its strategies against each other, and its bookkeeping."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from reference_tracer import random_walk, samplers
from reference_tracer.bsdfs.bsdf import BSDFSample
from reference_tracer.emission import Emitters
from reference_tracer.points import Points
from reference_tracer.propagation import RayCaster
from reference_tracer.random_walk import STRATEGIES, NonFiniteRadianceError, Strategy, render
from reference_tracer.reflection import LambertianBSDF
from reference_tracer.samplers import SAMPLERS, Block, SamplerName
from scenes import ConstantEnvironment, Lambertian, Pinhole, Scene, Sphere, Surface
from scenes.library import case

BOUNCES, REPLICATES = 4, 24

# samples per pixel, and the relative error that they resolve (see expect_means); some make no noise at all. Next
# event alone is left out in the furnace box: near an edge its terms grow like 1/d², so that their variance has no
# bound, and no standard error means anything
EXACT: dict[tuple[str, Strategy], tuple[int, float]] = {
    ("furnace-box", "bsdf"): (4, 1e-9),
    ("furnace-box", "mis"): (128, 0.015),
    ("furnace-sphere", "bsdf"): (4, 1e-9),
    ("furnace-sphere", "nee"): (4, 1e-9),
    ("furnace-sphere", "mis"): (4, 1e-9),
    ("integrating-sphere", "bsdf"): (1280, 0.07),
    ("integrating-sphere", "nee"): (4, 1e-9),
    ("integrating-sphere", "mis"): (256, 0.02),
}


def quadrants(images: np.ndarray) -> np.ndarray:
    """Means over the four quarters of images, ``(…, 2, 2, channels)``: a flip shows, and noise is averaged."""
    *rest, height, width, channels = images.shape
    return images.reshape(*rest, 2, height // 2, 2, width // 2, channels).mean(axis=(-4, -2))


def replicates(
    scene: Scene,
    strategy: Strategy,
    spp: int,
    bounces: int = BOUNCES,
    count: int = REPLICATES,
    sampler: SamplerName = "independent",
) -> np.ndarray:
    return np.array(
        [quadrants(render(scene, bounces, spp, seed, strategy, sampler)) for seed in range(count)]
    )


def hold_against_the_answer(
    name: str, strategy: Strategy, expect_means: Callable[..., None], sampler: SamplerName = "independent"
) -> None:
    found = case(name)
    scene = found.scene.resized(12, 8)
    truth = found.answer.truth(scene, BOUNCES)
    assert truth is not None
    spp, resolution = EXACT[name, strategy]
    images, expected = replicates(scene, strategy, spp, sampler=sampler), quadrants(truth.mean)
    # whether a ray meets the lamp is chance in E, whatever the strategy
    expect_means(images[:, 0], expected[0], resolution=0.4 / np.sqrt(spp))
    for k in range(1, BOUNCES + 1):
        expect_means(images[:, k], expected[k], resolution)


@pytest.mark.parametrize(("name", "strategy"), EXACT)
@pytest.mark.parametrize("sampler", SAMPLERS)
def test_exact_answers(
    name: str, strategy: Strategy, sampler: SamplerName, expect_means: Callable[..., None]
) -> None:
    hold_against_the_answer(name, strategy, expect_means, sampler)


# ---- planted faults: the checks above find them


def scaled(function: Callable[..., Any], factor: float) -> Callable[..., Any]:
    return lambda *args: factor * function(*args)


def reflecting(factor: float) -> Callable[..., BSDFSample]:
    sample = LambertianBSDF.sample

    def more(self: LambertianBSDF, points: Points, wo: np.ndarray, u: np.ndarray) -> BSDFSample:
        found = sample(self, points, wo, u)
        return BSDFSample(found.wi, factor * found.weight, found.pdf)

    return more


def denser(self: Emitters, reference: Points, u: np.ndarray) -> Any:
    found = straight_sample(self, reference, u)
    found.pdf = found.pdf * 1.01
    return found


def mirrored(sensor: Any, block: Block) -> Any:
    return straight_camera_rays(
        sensor, Block([[sensor.width], [0]] - block.position * [[1], [-1]], block.numbers)
    )


straight_camera_rays, straight_sample = random_walk.camera_rays, Emitters.sample

FAULTS: dict[str, tuple[str, Strategy, object, str, Callable[..., Any]]] = {
    "1 % too much reflected": ("furnace-sphere", "bsdf", LambertianBSDF, "sample", reflecting(1.01)),
    "1 % too much reflected, with noise": (
        "integrating-sphere",
        "nee",
        LambertianBSDF,
        "sample",
        reflecting(1.01),
    ),
    "4 % too much reflected, by mis": ("furnace-box", "mis", LambertianBSDF, "sample", reflecting(1.04)),
    "density of the lamp 1 % too large": ("integrating-sphere", "nee", Emitters, "sample", denser),
    "weights of mis that don't sum to one": (
        "integrating-sphere",
        "mis",
        random_walk.RandomWalk,
        "_found",
        scaled(random_walk.RandomWalk._found, 0.9),
    ),
    "image mirrored": ("integrating-sphere", "nee", random_walk, "camera_rays", mirrored),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_planted_faults_are_found(
    fault: str, expect_means: Callable[..., None], off: type[Exception], monkeypatch: pytest.MonkeyPatch
) -> None:
    name, strategy, owner, attribute, wrong = FAULTS[fault]
    monkeypatch.setattr(owner, attribute, wrong)
    with pytest.raises(off):
        hold_against_the_answer(name, strategy, expect_means)


# ---- strategies against each other


@pytest.fixture(scope="module")
def by_strategy() -> dict[Strategy, np.ndarray]:
    """Replicates of the Cornell box; bsdf finds the lamp by chance only and needs more samples."""
    scene = case("cornell-box").scene.resized(16, 16)
    return {s: replicates(scene, s, spp=256 if s == "bsdf" else 192, bounces=3) for s in STRATEGIES}


@pytest.mark.parametrize(("one", "other", "resolution"), [("nee", "mis", 0.08), ("bsdf", "mis", 0.25)])
def test_strategies_agree_in_the_cornell_box(
    by_strategy: dict[Strategy, np.ndarray],
    one: Strategy,
    other: Strategy,
    resolution: float,
    expect_means: Callable[..., None],
) -> None:
    a, b = by_strategy[one].mean(axis=(2, 3)), by_strategy[other].mean(axis=(2, 3))
    # E comes from the same camera rays whatever the strategy; the seeds of the rest are set apart
    difference = a - np.roll(b, 1, axis=0)
    for k in range(1, 4):
        expect_means(difference[:, k], 0, resolution, scale=b[:, k].mean())
    if one == "nee":
        np.testing.assert_array_equal(by_strategy[one][:, 0], by_strategy[other][:, 0])


# ---- seeds, blocks, pixels


def test_the_image_is_a_function_of_the_seed() -> None:
    scene = case("cornell-box").scene.resized(8, 6)
    images = {seed: render(scene, 3, 4, seed) for seed in (0, 1, 2**31)}
    for seed, image in images.items():
        np.testing.assert_array_equal(image, render(scene, 3, 4, seed))
    assert len({image.tobytes() for image in images.values()}) == 3
    for k in range(1, 4):  # E is the same where no pixel lies on the lamp's edge
        assert (images[0][k] != images[1][k]).any()


@pytest.mark.parametrize(
    ("width", "height", "block"),
    [(1, 1, 7), (7, 3, 7), (3, 7, 64), (20, 15, 64), (20, 15, 299), (70, 60, 4096), (5, 5, 4096)],
)
@pytest.mark.parametrize("spp", [1, 3, 50])
def test_every_pixel_gets_its_samples(
    width: int, height: int, spp: int, block: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the furnace each sample is exact, so one too many or too few, or one in a wrong pixel, would show."""
    monkeypatch.setattr(samplers, "BLOCK", block)
    shares: list[float] = []
    image = render(
        case("furnace-sphere").scene.resized(width, height), 2, spp, 1, "bsdf", on_block=shares.append
    )
    assert image.shape == (3, height, width, 3)
    np.testing.assert_allclose(
        image, np.broadcast_to([[[[1.0]]], [[[0.5]]], [[[0.25]]]], image.shape), rtol=1e-12
    )
    assert shares == sorted(shares)
    assert len(set(shares)) == len(shares)
    assert shares[-1] == pytest.approx(1)


@pytest.mark.parametrize("block", [40, 200])
def test_the_size_of_blocks_leaves_the_means(
    block: int, expect_means: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(samplers, "BLOCK", block)
    hold_against_the_answer("integrating-sphere", "nee", expect_means)


def test_blocks_are_independent(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pixels that lie in different blocks don't repeat each other's numbers."""
    monkeypatch.setattr(samplers, "BLOCK", 8)
    seen: list[np.ndarray] = []
    cast = RayCaster.__call__

    def watch(self: RayCaster, origin: Points, d: np.ndarray) -> Points:
        seen.append(d)
        return cast(self, origin, d)

    monkeypatch.setattr(RayCaster, "__call__", watch)
    render(case("furnace-sphere").scene.resized(4, 2), 1, 3, 1, "bsdf")
    camera = np.concatenate(seen[::2], axis=1)
    assert camera.shape == (3, 24)
    assert len(np.unique(camera.round(12), axis=1).T) == 24


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_bounce_0_alone(strategy: Strategy) -> None:
    scene = case("integrating-sphere").scene.resized(6, 4)
    image = render(scene, 0, 5, 3, strategy)
    assert image.shape == (1, 4, 6, 3)
    np.testing.assert_array_equal(image[0], render(scene, 3, 5, 3, strategy)[0])
    levels = image[0] / np.array([4.0, 3.0, 5.0]) * 5
    np.testing.assert_allclose(levels, levels.round(), atol=1e-12)  # E is on or off in each of the 5 samples
    assert 0 < levels.mean() < 5


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_radiance_up_to_the_largest_floats(strategy: Strategy) -> None:
    """Sums over a block overflow before any pixel does; where a pixel does, it is an error and no image."""
    camera = Pinhole((0, 0, 3), (0, 0, 0), (0, 1, 0), 60.0, 40, 40)

    def glowing(radiance: float) -> Scene:
        ball = Surface("ball", Sphere((0, 0, 0), 1.0), Lambertian((0.5,)))
        return Scene((ball,), camera, (ConstantEnvironment((radiance,)),))

    image = render(glowing(1e306), 2, 4, 0, strategy)
    np.testing.assert_allclose(image, 1e306 * render(glowing(1.0), 2, 4, 0, strategy), rtol=1e-12)
    with pytest.raises(NonFiniteRadianceError, match=r"^bounce 0, row 0, column 0: the sum of its walks"):
        render(glowing(4e307), 2, 8, 0, strategy)


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_what_is_not_finite_is_an_error_with_its_place(
    strategy: Strategy, wrong: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    sample = LambertianBSDF.sample

    def broken(self: LambertianBSDF, points: Points, wo: np.ndarray, u: np.ndarray) -> BSDFSample:
        found = sample(self, points, wo, u)
        found.weight[1, 5] = wrong  # one channel of the walk through pixel 5: row 1, column 1 of four
        return found

    monkeypatch.setattr(LambertianBSDF, "sample", broken)
    with pytest.raises(NonFiniteRadianceError, match=r"^bounce [12], row 1, column 1, at sphere: found \["):
        render(case("furnace-sphere").scene.resized(4, 3), 3, 1, 0, strategy)
