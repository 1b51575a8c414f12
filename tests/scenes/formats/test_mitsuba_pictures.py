"""What becomes a picture for Mitsuba is the same radiance."""

from __future__ import annotations

import numpy as np
import pytest

from reference_tracer.emitters.environments import LatitudeLongitudeMap
from scenes import EnvironmentMap, Image, PolarRange
from scenes.formats.mitsuba_pictures import environment_rows, zone_rows


@pytest.mark.parametrize("count", [1, 3, 8])
def test_rows_of_an_environment_map_are_the_same_map(count: int) -> None:
    """Linear from one row to the next, at equal steps of the polar angle from pole to pole."""
    pixels = np.random.default_rng(count).uniform(0.1, 1, (count, 4, 3))
    ours = LatitudeLongitudeMap(EnvironmentMap(Image(pixels)), 1.0)  # type: ignore[arg-type]
    rows = environment_rows(pixels)
    assert rows.shape == (2 * count + 1, 4, 3)
    theta = np.linspace(1e-9, np.pi - 1e-9, 61)
    phi = 2 * np.pi * 2.5 / 4
    d = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    steps = np.linspace(0, np.pi, len(rows))
    expected = [np.interp(theta, steps, rows[:, 2, c]) for c in range(3)]
    np.testing.assert_allclose(ours.radiance(d), expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("low", "high", "steps", "lit"), [(0, 45, 4, [0]), (60, 120, 3, [1]), (20, 60, 9, [1, 2])]
)
def test_a_zone_is_whole_steps(low: float, high: float, steps: int, lit: list[int]) -> None:
    rows = zone_rows(PolarRange(low, high), (1.0, 2.0, 4.0))
    assert rows is not None
    assert rows.shape == (steps, 1, 3)
    assert [i for i in range(steps) if rows[i].any()] == lit
    assert rows[lit[0]].tolist() == [[1.0, 2.0, 4.0]]


def test_borders_that_no_steps_have() -> None:
    assert zone_rows(PolarRange(0.0, 33.3333), (1.0,)) is None
