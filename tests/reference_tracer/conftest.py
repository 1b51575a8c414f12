"""The two statistical judgements of these tests. Seeds are fixed; the thresholds are what chance alone exceeds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy import stats

CHANCE = 1e-6
"""How often a test would fail a tracer without fault, were its seed drawn anew."""

ROUNDING = 1e-11
"""What a mean without any noise may still be off by, relative to the scale."""


class OffError(AssertionError):
    """A mean that chance does not explain."""


@pytest.fixture(scope="session")
def expect_means() -> Callable[..., None]:
    """``expect_means(replicates, expected, resolution=0.002)`` holds means of replicates against exact values.

    Each of the n components (all axes but the first, which is that of the replicates) is held to Student's t
    at CHANCE / n. ``resolution`` states the power: t standard errors, relative to the mean of the expected
    values or to ``scale``, must be smaller, so that an error of twice that size is all but certain to be found.
    """

    def check(
        replicates: np.ndarray, expected: np.ndarray | float, resolution: float, scale: float | None = None
    ) -> None:
        replicates = np.asarray(replicates)
        count, components = len(replicates), replicates[0].size
        expected = np.broadcast_to(expected, replicates.shape[1:])
        unit = float(np.mean(expected)) if scale is None else scale
        error = replicates.std(axis=0, ddof=1) / np.sqrt(count)
        allowed = stats.t.isf(CHANCE / components / 2, count - 1) * error + ROUNDING * unit
        assert allowed.max() <= resolution * unit, f"no power: {allowed.max() / unit:.2g} is not resolved"
        off = np.abs(replicates.mean(axis=0) - expected)
        if not (off <= allowed).all():
            raise OffError(f"off by {(off / unit).max():.3g}, which is {(off / allowed).max():.3g} × allowed")

    return check


@pytest.fixture(scope="session")
def off() -> type[OffError]:
    """What ``expect_means`` raises where the means are wrong, as opposed to where they have no power."""
    return OffError


@pytest.fixture(scope="session")
def follows() -> Callable[[np.ndarray, np.ndarray], bool]:
    """``follows(counts, probabilities)``: whether a chi-square test accepts the counts at CHANCE."""

    def accept(counts: np.ndarray, probabilities: np.ndarray) -> bool:
        counts, probabilities = np.ravel(counts), np.ravel(probabilities)
        assert probabilities.sum() == pytest.approx(1, abs=1e-6), "the density is none"
        expected = counts.sum() * probabilities
        assert expected.min() > 20, "cells too small for the chi-square distribution"
        statistic = ((counts - expected) ** 2 / expected).sum()
        return bool(stats.chi2.sf(statistic, counts.size - 1) > CHANCE)

    return accept
