"""What callers may mistake: refused before any work, with a message that says what is expected."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from reference_tracer import sampling
from reference_tracer.finite_elements import solve
from reference_tracer.operators import I, emission, measure, neumann, reflection, reflection_by_quadrature
from reference_tracer.random_walk import render
from reference_tracer.samplers import MOST_DIMENSIONS, MOST_POINTS, sobol
from scenes.library import case

SCENE = case("furnace-box").scene.resized(4, 4)
GOOD: dict[str, Any] = {"scene": SCENE, "bounces": 1, "spp": 2, "seed": 0}


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("spp", 0, "spp = 0: expected a whole number, at least 1"),
        ("spp", -1, "spp = -1: expected a whole number, at least 1"),
        ("spp", 4.0, "spp = 4.0: expected a whole number, at least 1"),
        ("spp", True, "spp = True: expected a whole number, at least 1"),
        ("bounces", -1, "bounces = -1: expected a whole number, at least 0"),
        ("bounces", "2", "bounces = '2': expected a whole number, at least 0"),
        ("seed", -1, "seed = -1: expected a whole number, at least 0"),
        ("strategy", "MIS", "strategy = 'MIS': expected one of bsdf, nee, mis"),
        ("sampler", "halton", "sampler = 'halton': expected one of independent, sobol"),
    ],
)
def test_the_walk_refuses(name: str, value: object, expected: str) -> None:
    with pytest.raises(ValueError, match="expected") as refused:
        render(**(GOOD | {name: value}))
    assert str(refused.value) == expected


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (case("furnace-box"), "scene is a Case, expected a Scene: take its .scene"),
        ("furnace-box", "scene is a str, expected a Scene"),
        (None, "scene is a NoneType, expected a Scene"),
    ],
)
def test_scenes_only(value: object, message: str) -> None:
    with pytest.raises(TypeError, match="expected") as refused:
        render(**(GOOD | {"scene": value}))
    assert str(refused.value) == message
    with pytest.raises(TypeError, match="expected") as refused:
        solve(value, bounces=1)  # type: ignore[arg-type]
    assert str(refused.value) == message


def test_numbers_of_numpy_are_numbers() -> None:
    numpy = {name: np.int64(GOOD[name]) for name in ("bounces", "spp", "seed")}
    np.testing.assert_array_equal(render(**(GOOD | numpy)), render(**GOOD))


def test_operators_refuse() -> None:
    rng = sampling.stream(1)
    for attempt in (
        lambda: reflection(SCENE, rng, samples=0),
        lambda: reflection_by_quadrature(SCENE, order=0),
        lambda: neumann(I, -1),
        lambda: measure(emission(SCENE), SCENE, rng, spp=0),
    ):
        with pytest.raises(ValueError, match="expected a whole number, at least"):
            attempt()


def test_as_many_sobol_points_as_there_are() -> None:
    next(sobol(4, 4, MOST_POINTS // 16, 0, 2))
    with pytest.raises(ValueError, match=r"4 × 4 pixels, .* spp take .* points, expected at most 1073741824"):
        next(sobol(4, 4, MOST_POINTS // 16 + 1, 0, 2))
    with pytest.raises(ValueError, match=r"take 21202 dimensions, expected at most 21201"):
        next(sobol(4, 4, 1, 0, MOST_DIMENSIONS - 1))
