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


@given(_replicates, st.data())
def test_any_split_gives_the_moments_of_the_whole(replicates: np.ndarray, data: st.DataObject) -> None:
    cut = data.draw(st.integers(1, len(replicates) - 1))
    parts = [reduce(add, map(Moments.of, part)) for part in (replicates[:cut], replicates[cut:])]
    whole = parts[0] + parts[1]
    assert whole.count == len(replicates)
    scale = max(1.0, float(np.abs(replicates).max()))
    np.testing.assert_allclose(whole.mean, replicates.mean(axis=0), atol=1e-12 * scale)
    np.testing.assert_allclose(whole.variance, replicates.var(axis=0, ddof=1), atol=1e-11 * scale**2)


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
