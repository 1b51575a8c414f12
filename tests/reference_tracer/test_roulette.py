"""Walks that end by chance: their expectation, and their end."""

from __future__ import annotations

import numpy as np
import pytest

from reference_tracer import random_walk
from reference_tracer.random_walk import NonFiniteRadianceError, total
from reference_tracer.roulette import FIRST, MOST, roulette
from scenes import AreaLight, Lambertian, Pinhole, Scene, Sphere, Surface, library


@pytest.mark.parametrize("beta", [(0.3, 0.2, 0.1), (0.97, 0.01, 0.0), (2.5, 0.1, 0.2), (2e-3, 0.0, 0.0)])
def test_what_goes_on_is_worth_as_much_more_as_fewer_walks_go_on(beta: tuple[float, ...]) -> None:
    u = (np.arange(100_000) + 0.5) / 100_000
    worth = roulette(np.tile(np.array(beta)[:, None], len(u)), FIRST, u)
    q = min(max(beta), MOST)
    # of evenly spread numbers, the share below q is off by one of them at most
    np.testing.assert_allclose(worth.mean(axis=1), beta, rtol=2e-5 / q)
    assert np.unique(worth[0]).size == 2  # an end, or the same for all


def test_no_walk_ends_before_the_first_bounce_that_may() -> None:
    throughput = np.full((3, 4), 0.1)
    np.testing.assert_array_equal(roulette(throughput, FIRST - 1, np.full(4, 0.99)), throughput)
    assert not roulette(throughput, FIRST, np.full(4, 0.99)).any()


def test_black_walks_end_without_a_warning() -> None:
    assert not roulette(np.zeros((3, 4)), FIRST, np.zeros(4)).any()


@pytest.mark.parametrize("strategy", random_walk.STRATEGIES)
@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("furnace-box", (2.0, 2.0, 2.0)),
        ("furnace-channels", (10.0, 4.0, 0.625)),
        ("glass-ball", (3.0, 1.0, 2.0)),  # the sky, whatever glass does to it
    ],
)
def test_the_total_is_the_closed_form_of_the_sum(
    name: str, expected: tuple[float, ...], strategy: random_walk.Strategy
) -> None:
    scene = library.case(name).scene.resized(12, 12)
    images = total(scene, 288, 0, strategy).mean(
        axis=1
    )  # every row is a replicate: all pixels have the same answer
    z = (images.mean(axis=0) - expected) / (images.std(axis=0, ddof=1) / np.sqrt(len(images)) + 1e-12)
    assert np.abs(z).max() < 4.5  # of Student's t with 11 degrees of freedom: once in a thousand
    # what this resolves: without the later bounces the sum would lack 0.4 % (box) to 43 % (channels)
    assert (images.std(axis=0) / images.mean(axis=0)).max() < 0.02


def test_without_reweighting_the_total_is_too_dark() -> None:
    scene = library.case("furnace-channels").scene.resized(12, 12)

    def unfair(throughput: np.ndarray, bounce: int, u: np.ndarray) -> np.ndarray:
        return throughput * (roulette(throughput, bounce, u) > 0)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(random_walk, "roulette", unfair)
        image = total(scene, 64, 1)
    # 10 in all, of which the bounces before the first end hold 10 (1 − 0.9^8) + 1 − …: far less than 10
    assert image[..., 0].mean() < 8


def test_where_all_is_reflected_walks_end_nevertheless() -> None:
    wall = Surface("wall", Sphere((0.0, 0.0, 0.0), 1.0, inward=True), Lambertian((1.0,)))
    lamp = replace_emission(wall, (1e-3,))
    scene = Scene((lamp,), Pinhole((0.3, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), 60.0, 4, 4))
    assert np.isfinite(total(scene, 4, 1)).all()  # the series has no sum; the walks have an end


def replace_emission(surface: Surface, radiance: tuple[float, ...]) -> Surface:
    return Surface(surface.name, surface.shape, surface.material, AreaLight(radiance))


def test_a_seed_is_an_image() -> None:
    scene = library.case("furnace-cornell").scene.resized(6, 6)
    np.testing.assert_array_equal(total(scene, 3, 7), total(scene, 3, 7))
    assert (total(scene, 3, 7) != total(scene, 3, 8)).any()


def test_what_can_not_be_is_refused() -> None:
    case = library.case("furnace-box")
    with pytest.raises(TypeError, match=r"take its \.scene"):
        total(case, 1, 1)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="spp = 0"):
        total(case.scene, 0, 1)
    bright = replace_all(case.scene, 1e308)
    with pytest.raises(NonFiniteRadianceError):
        total(bright.resized(2, 2), 64, 1)


def replace_all(scene: Scene, radiance: float) -> Scene:
    from msgspec.structs import replace as changed

    light = AreaLight((radiance,) * scene.channels)
    return changed(scene, surfaces=tuple(changed(s, emission=light) for s in scene.surfaces))
