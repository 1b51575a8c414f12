from __future__ import annotations

from functools import reduce
from operator import add

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from comparisons.statistics.moments import Moments

_replicates = arrays(
    np.float64, st.tuples(st.integers(2, 12), st.just(3)), elements=st.floats(-1e6, 1e6, width=32)
)


def one_by_one(replicates: np.ndarray) -> Moments:
    first, *others = replicates
    return reduce(Moments.including, others, Moments.of(first))


@given(_replicates, st.data())
def test_any_split_gives_the_moments_of_the_whole(replicates: np.ndarray, data: st.DataObject) -> None:
    cut = data.draw(st.integers(1, len(replicates) - 1))
    parts = [reduce(add, map(Moments.of, part)) for part in (replicates[:cut], replicates[cut:])]
    whole = parts[0] + parts[1]
    assert whole.count == len(replicates)
    scale = max(1.0, float(np.abs(replicates).max()))
    np.testing.assert_allclose(whole.mean, replicates.mean(axis=0), atol=1e-12 * scale)
    np.testing.assert_allclose(whole.variance, replicates.var(axis=0, ddof=1), atol=1e-11 * scale**2)
    for at_once in (Moments.of_all(replicates), one_by_one(replicates)):
        np.testing.assert_allclose(at_once.m2, whole.m2, atol=1e-11 * scale**2)
        np.testing.assert_allclose(at_once.m3, whole.m3, atol=1e-10 * scale**3)
        np.testing.assert_allclose(at_once.m4, whole.m4, atol=1e-9 * scale**4)
        np.testing.assert_array_equal(at_once.lowest, replicates.min(axis=0))
        np.testing.assert_array_equal(at_once.highest, replicates.max(axis=0))
    np.testing.assert_array_equal(whole.lowest, replicates.min(axis=0))
    np.testing.assert_array_equal(whole.highest, replicates.max(axis=0))


def test_a_large_offset_does_not_cancel() -> None:
    values = 1e8 + np.array([0.1, 0.2, 0.3, 0.4])
    total = reduce(add, (Moments.of(np.array([v])) for v in values))
    np.testing.assert_allclose(total.variance, values.var(ddof=1), rtol=1e-6)
    np.testing.assert_allclose(total.standard_error, values.std(ddof=1) / 2, rtol=1e-6)


def test_one_replicate_has_no_spread() -> None:
    assert np.isnan(Moments.of(np.ones(2)).variance).all()


def test_replicates_of_different_shapes_are_refused() -> None:
    with pytest.raises(ValueError, match=r"shape \(2,\) can't take some of shape \(3,\)"):
        Moments.of(np.ones(2)) + Moments.of(np.ones(3))
    with pytest.raises(ValueError, match=r"shape \(2,\) can't take one of shape \(3,\)"):
        Moments.of(np.ones(2)).including(np.ones(3))


def test_rounding_is_no_spread() -> None:
    """Of a constant that 32-bit numbers hold in one of two ways, none dominates; of twice the constant, one does."""
    replicates = np.full((32, 1), 0.4)
    replicates[7] *= 1 + 2.0**-25
    assert Moments.of_all(replicates).dominance == 0
    replicates[7] = 0.8
    assert Moments.of_all(replicates).dominance > 0.9


def test_dominance_is_the_share_of_the_one_furthest_off() -> None:
    replicates = np.array([[0.0, 1.0, 5.0], [0.0, 1.0, 5.0], [9.0, 2.0, 5.0], [0.0, 0.0, 5.0]])
    # deviations: −2.25 thrice and 6.75; 0 twice, 1, −1; none
    expected = [6.75**2 / (6.75**2 + 3 * 2.25**2), 0.5, 0.0]
    np.testing.assert_allclose(Moments.of_all(replicates).dominance, expected)
