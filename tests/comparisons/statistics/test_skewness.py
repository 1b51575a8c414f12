from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from comparisons.statistics import skewness
from comparisons.statistics.moments import Moments


def test_skewness_of_the_mean_is_that_of_a_replicate_over_root_n() -> None:
    replicates = np.random.default_rng(1).exponential(1.0, (50, 2, 3))
    found = skewness.of_the_mean(Moments.of_all(replicates))
    np.testing.assert_allclose(found, stats.skew(replicates, axis=0) / np.sqrt(50))
    assert (skewness.of_the_mean(Moments.of_all(np.ones((4, 1, 1)))) == 0).all()


def test_the_stretch_is_hall_s_transformation_inverted() -> None:
    """g(T) = T + γT²/3 + γ²T³/27 + γ/6n = −q/√n, solved for T numerically; the series ends after two terms."""
    n = 400
    for gamma, q in ((0.5, 3.0), (1.0, 4.0), (2.0, 3.0)):
        t = np.roots([gamma**2 / 27, gamma / 3, 1.0, gamma / (6 * n) + q / np.sqrt(n)])
        exact = -float(t[np.abs(t.imag) < 1e-9].real.max()) * np.sqrt(n)
        tail = gamma / np.sqrt(n)
        u = np.array(tail * (q + tail / 6))
        third = 10 * u**3 / 81  # the first term that is left out
        assert exact / (q + tail / 6) - float(skewness.stretch(u)) == pytest.approx(third, rel=0.5)


def test_what_one_tile_has_not_seen_the_others_tell() -> None:
    rng = np.random.default_rng(2)
    replicates = rng.normal(1.0, 0.1, (64, 17, 1)) + (rng.random((64, 17, 1)) < 0.05) * 2.0
    replicates[:, 3] = rng.normal(1.0, 0.1, (64, 1))
    replicates[:, 0] = replicates[:, 1:].mean(axis=1)
    moments = Moments.of_all(replicates)
    below, above = skewness.both_ways(moments)
    common = above[1:].min()  # what all tiles have at least
    assert above[3, 0] == pytest.approx(common)
    assert skewness.of_the_mean(moments)[3, 0] < common / 2
    assert above[0, 0] >= common / 4  # of 16 tiles together a quarter
    assert (below <= np.maximum(0, -skewness.of_the_mean(moments))).all()


def test_a_tail_below_is_a_tail_above_turned_round() -> None:
    replicates = np.random.default_rng(3).exponential(1.0, (40, 5, 2))
    below, above = skewness.both_ways(Moments.of_all(replicates))
    turned = skewness.both_ways(Moments.of_all(-replicates))
    np.testing.assert_allclose(below, turned[1])
    np.testing.assert_allclose(above, turned[0])


def test_one_region_alone_has_its_own() -> None:
    moments = Moments.of_all(np.random.default_rng(3).exponential(1.0, (40, 1, 1)))
    np.testing.assert_allclose(skewness.both_ways(moments)[1], skewness.of_the_mean(moments))
