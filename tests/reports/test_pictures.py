"""Radiance and differences as pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from bokeh.models import ColumnDataSource

from reports import difference, exposure, plots


def test_both_sides_are_exposed_for_the_truth() -> None:
    truth, renderer = np.full((4, 4, 3), 0.4), np.full((4, 4, 3), 9.0)
    assert exposure.automatic(truth, renderer) == 2.0
    assert exposure.automatic(0 * truth, truth) == 2.0
    assert exposure.automatic(0 * truth) == 1.0


def test_a_lamp_does_not_darken_the_picture() -> None:
    image = np.full((10, 10, 3), 0.4)
    image[0, :8] = 100
    assert exposure.automatic(image) == 2.0


def test_the_encoding_is_srgb() -> None:
    image = np.array([[[0.0, 0.0031308, 0.2140411], [1.0, 2.0, -1.0]]])
    assert exposure.encode(image, 1.0).tolist() == [[[0, 10, 127], [255, 255, 0]]]
    assert exposure.encode(image / 2, 2.0).tolist() == exposure.encode(image, 1.0).tolist()


@pytest.mark.parametrize("channels", [1, 2, 5])
def test_other_numbers_of_channels_are_grey(channels: int) -> None:
    image = np.linspace(0, 1, channels).reshape(1, 1, channels)
    [[pixel]] = exposure.encode(image, 1.0)
    assert len(set(pixel.tolist())) == 1


def test_what_is_not_finite_is_magenta() -> None:
    image = np.array([[[np.nan, 0, 0], [np.inf, 0, 0]]])
    assert exposure.encode(image, 1.0).tolist() == [[[255, 0, 255]] * 2]
    assert difference.colours(image[..., 0], 1.0).tolist() == [[[255, 0, 255]] * 2]


def test_blue_is_darker_white_is_equal_red_is_brighter() -> None:
    [[low, middle, high]] = difference.colours(np.array([[-2.0, 0.0, 2.0]]), 1.0).astype(int)
    assert low[2] > low[0]
    assert middle.tolist() == [247] * 3
    assert high[0] > high[2]


def test_a_difference_is_relative_to_the_mean_of_the_truth_or_else_of_the_sum() -> None:
    truth = np.full((2, 2, 3), 0.5)
    field, relative = difference.relative(truth, truth * 1.02)
    assert relative
    np.testing.assert_allclose(field, 0.02)
    field, relative = difference.relative(0 * truth, truth, fallback=2.0)
    assert relative
    np.testing.assert_allclose(field, 0.25)
    assert not difference.relative(0 * truth, truth)[1]


def test_rounding_is_no_effect() -> None:
    truth = np.full((2, 2, 3), 0.1)
    stored = truth.astype(np.float32).astype(float)
    zero = np.zeros_like(truth)
    assert difference.automatic_scale(difference.relative(truth, stored)[0]) == 1e-4
    assert np.abs(difference.in_standard_errors(truth, stored, zero, zero)).max() < 1
    np.testing.assert_allclose(
        difference.in_standard_errors(truth, truth + 0.3, zero, zero + 0.1), 3, rtol=1e-6
    )


def test_a_log_axis_survives_bounces_without_energy(make_bounce: Any, make_comparison: Any) -> None:
    dark = make_bounce(1, "pass", truth=0.0)
    leak = make_bounce(2, "fail", 0.02, truth=0.0, mean=0.01, denominator=0.5)
    lit = make_bounce(0, "pass", truth=0.5)
    plot, left_out = plots.energy(make_comparison("c", "r", "fail", [lit, dark, leak]))
    assert left_out == [1, 2]
    assert plot.y_range.start > 0
    [low, high] = [
        model.data[end]
        for end in ("low", "high")
        for model in plot.select(ColumnDataSource)
        if end in model.data
    ]
    # the interval of the leak, 2 % ± 0.3 % of something, becomes radiance in the same proportion
    np.testing.assert_allclose([low[1], high[1]], [0.0085, 0.0115])
    assert plots.energy(make_comparison("c", "r", "pass", [dark])) == (None, [1])
    assert plots.bias(make_comparison("c", "r", "error", [])) is None
