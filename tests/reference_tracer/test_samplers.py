"""Where walks start and what numbers they get: each pixel its share, each number uniform, replicates independent."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy import stats

from reference_tracer import samplers
from reference_tracer.samplers import BLOCKS, SAMPLERS, SamplerName

SIZES = [(1, 1, 5), (7, 3, 1), (3, 7, 4), (20, 15, 3), (64, 64, 2), (70, 33, 2), (64, 1, 100)]


@pytest.mark.parametrize("sampler", SAMPLERS)
@pytest.mark.parametrize(("width", "height", "spp"), SIZES)
def test_every_pixel_gets_its_samples(sampler: SamplerName, width: int, height: int, spp: int) -> None:
    counts = np.zeros((height, width), dtype=int)
    for block in BLOCKS[sampler](width, height, spp, 3, 6):
        assert 0 < block.position.shape[1] <= samplers.BLOCK
        column, row = block.position.astype(int)
        np.add.at(counts, (row, column), 1)
    assert (counts == spp).all()


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_all_numbers_are_uniform(sampler: SamplerName, follows: Callable[..., bool]) -> None:
    """Each dimension by itself, over seeds too; those of one walk don't depend on one another."""
    drawn = []
    for seed in range(64):
        for block in BLOCKS[sampler](8, 8, 8, seed, 6):
            n = block.position.shape[1]
            inside = block.position / 8
            drawn.append(np.concatenate([inside, *(block.numbers(2, np.arange(n)) for _ in range(3))]))
    u = np.concatenate(drawn, axis=1)
    assert u.shape == (8, 64 * 512)
    assert 0 <= u.min() <= u.max() < 1
    for i in range(8):
        assert follows(np.histogram(u[i], 16, (0, 1))[0], np.full(16, 1 / 16))
        for j in range(i):
            counts = np.histogram2d(u[i], u[j], 8, ((0, 1), (0, 1)))[0]
            assert follows(counts, np.full((8, 8), 1 / 64))


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_numbers_follow_their_lanes(sampler: SamplerName) -> None:
    """Walks that have ended take none; the others keep theirs (Sobol') or just get new ones."""
    block = next(iter(BLOCKS[sampler](8, 8, 1, 1, 6)))
    some = np.array([3, 9, 60])
    first, second = block.numbers(2, np.arange(64)), block.numbers(3, some)
    assert (first.shape, second.shape) == ((2, 64), (3, 3))
    if sampler == "sobol":
        again = next(iter(BLOCKS[sampler](8, 8, 1, 1, 6)))
        again.numbers(2, np.arange(64))
        np.testing.assert_array_equal(second, again.numbers(3, np.arange(64))[:, some])


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_replicates_differ_and_repeat(sampler: SamplerName) -> None:
    def walks(seed: int) -> np.ndarray:
        blocks = BLOCKS[sampler](8, 8, 128, seed, 2)
        return np.concatenate(
            [np.concatenate([b.position, b.numbers(2, np.arange(b.position.shape[1]))]) for b in blocks]
        )

    np.testing.assert_array_equal(walks(5), walks(5))
    assert not np.isin(walks(5).round(12), walks(6).round(12)).any()


def test_sobol_points_cover_evenly() -> None:
    """4,096 walks of 64 × 64 pixels: one per pixel, and one in each of 4,096 equal intervals of every dimension."""
    block = next(iter(BLOCKS["sobol"](64, 64, 1, 7, 12)))
    u = np.concatenate([block.position / 64, block.numbers(12, np.arange(4096))])
    for row in u:
        assert len(np.unique((row * 4096).astype(int))) == 4096
    assert len(np.unique((u[:2] * 64).astype(int), axis=1).T) == 4096


def test_the_mean_of_sobol_points_converges_faster() -> None:
    """∏ (1 + (u_i − ½) / 2) over six dimensions, mean 1: the variance over 64 seeds is a fiftieth at most."""
    variance = {}
    for sampler in SAMPLERS:
        means = []
        for seed in range(64):
            total = 0.0
            for block in BLOCKS[sampler](32, 32, 4, seed, 4):
                u = np.concatenate(
                    [block.position / 32, block.numbers(4, np.arange(block.position.shape[1]))]
                )
                total += np.prod(1 + (u - 0.5) / 2, axis=0).sum()
            means.append(total / 4096)
        variance[sampler] = np.var(means, ddof=1)
        assert abs(np.mean(means) - 1) < 5 * np.sqrt(variance[sampler] / 64)
    exact = ((1 + 1 / 48) ** 6 - 1) / 4096
    low, high = stats.chi2.ppf([1e-6, 1 - 1e-6], 63) / 63
    assert low < variance["independent"] / exact < high
    assert variance["sobol"] < exact / 50
