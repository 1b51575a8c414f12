"""Verdicts on made-up replicates: the statistics, the looks and the rules, without renderer and images."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.calibration.noise import SHAPES, Noise
from benchmarks.calibration.rates import Rate
from comparisons.sequential import MIN_REPLICATES
from comparisons.statistics.intervals import Biases, Means, alpha_of_look, biases
from comparisons.statistics.moments import Moments

TILES, BOUNCES, CHANNELS = 16, 6, 3
LOOKS = 4
TOLERANCE = 0.02
RUNS = 2_000
POWER_ALPHA = 1e-3


@dataclass(frozen=True)
class Counts:
    """Of the runs, how many failed and how many passed."""

    failed: int
    passed: int


def rates(runs: int = RUNS) -> Iterator[Rate]:
    """Wrong verdicts at the limit, and power at the stated bias, for each shape of noise."""
    for name, noise in SHAPES.items():
        for alpha in (1e-2, 1e-3):
            for bias, tolerance in ((TOLERANCE, TOLERANCE), (-TOLERANCE, TOLERANCE), (0.0, 0.0)):
                counts = verdicts(noise, bias, tolerance, alpha, runs)
                where = f"{name}; bias {bias:+.0%}, tolerance {tolerance:.0%}, α = {alpha:.1%}"
                yield Rate(f"{where}: fail", counts.failed, runs, 0.0, alpha)
                if tolerance:
                    yield Rate(f"{where}: pass", counts.passed, runs, 0.0, alpha)
        for replicates in (32, 256):
            what = f"{name}; the stated detectable bias, {replicates} replicates: fail"
            yield Rate(what, caught(noise, replicates, runs), runs, 0.85, 0.95)


def verdicts(noise: Noise, bias: float, tolerance: float, alpha: float, runs: int, seed: int = 1) -> Counts:
    """Whole comparisons, every region and bounce off by ``bias``; looks at 32, 64, … replicates."""
    rng = np.random.default_rng(seed)
    failed = passed = 0
    for _ in range(runs):
        open_bounces, fail = set(range(BOUNCES)), False
        sampled = noise(rng, (MIN_REPLICATES << (LOOKS - 1), BOUNCES, TILES, 1)) + bias
        # channels share paths, and so their noise
        replicates = np.broadcast_to(sampled, (*sampled.shape[:-1], CHANNELS))
        for look in range(1, LOOKS + 1):
            for k in tuple(open_bounces):
                found = _judge(replicates[: MIN_REPLICATES << (look - 1), k], tolerance, alpha, look)
                fail |= found == "fail"
                if found != "inconclusive":
                    open_bounces.remove(k)
        failed += fail
        passed += not fail and not open_bounces
    return Counts(failed, passed)


def _judge(tiles: np.ndarray, tolerance: float, alpha: float, look: int) -> str:
    found = _biases(tiles, alpha_of_look(alpha, look))
    limit = np.full((TILES + 1, 1), tolerance)
    if found.simultaneous.outside(limit).any():
        return "fail"
    return "pass" if found.own.inside(limit).all() else "inconclusive"


def caught(noise: Noise, replicates: int, runs: int, seed: int = 2) -> int:
    """One run states its detectable bias in a tile, another one has it there: how often it fails.

    The bias points where it is harder to see, below the truth for a tail above.
    """
    rng = np.random.default_rng(seed)
    found = 0
    for _ in range(runs):
        stated, tested = (
            np.broadcast_to(noise(rng, (replicates, TILES, 1)), (replicates, TILES, CHANNELS))
            for _ in range(2)
        )
        detectable = TOLERANCE + _biases(stated, POWER_ALPHA).resolution[1, 0]
        limits = _biases(tested - detectable, POWER_ALPHA).simultaneous
        found += bool(limits.outside(np.full((TILES + 1, 1), TOLERANCE))[1, 0])
    return found


def _biases(tiles: np.ndarray, alpha: float) -> Biases:
    regions = np.concatenate([tiles.mean(axis=1, keepdims=True), tiles], axis=1)
    one = np.ones(regions.shape[1:])
    return biases(
        Means.of(Moments.of_all(regions)), Means.known(one, 0 * one), one, alpha, BOUNCES * CHANNELS
    )
