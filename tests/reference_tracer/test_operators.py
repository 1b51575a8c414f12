"""The algebra: linear, composable, and the same series that the random walk sums."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from reference_tracer import sampling
from reference_tracer.operators import (
    Field,
    I,
    Operator,
    emission,
    measure,
    neumann,
    propagation,
    reflection,
    transport,
)
from reference_tracer.points import NOWHERE, Points
from reference_tracer.propagation import RayCaster
from reference_tracer.random_walk import render
from scenes import Scene
from scenes.library import CASES, case

COUNT = 300


def scene_of(name: str) -> Scene:
    return case(name).scene.resized(8, 8)


def unit(rng: np.random.Generator, count: int) -> np.ndarray:
    d = rng.standard_normal((3, count))
    return d / np.linalg.norm(d, axis=0)


def surface_points(scene: Scene, seed: int = 1) -> tuple[Points, np.ndarray]:
    """Points of surfaces, as rays from the camera's origin find them, and directions away from their fronts."""
    rng = np.random.default_rng(seed)
    x = np.tile(np.array(scene.sensor.origin)[:, None], COUNT)
    points = RayCaster(scene)(Points.nowhere(x), unit(rng, COUNT))
    d = unit(rng, COUNT)
    return points, d * np.where(np.einsum("in,in->n", points.n, d) < 0, -1, 1)


# ---- fields that are written by hand

X = Field(lambda x, w: np.stack([x.x[0] + 2 * w[1], x.x[1] * w[2], np.cos(x.x[2])]))
Y = Field(lambda x, w: np.stack([w[0] ** 2, x.x[2] - w[2], x.n[0] + x.x[0]]))
SCALE = Operator(lambda field: Field(lambda x, w: 3 * field(x, w)))
REVERSE = Operator(lambda field: Field(lambda x, w: field(x, -w)))


@pytest.fixture
def here() -> tuple[Points, np.ndarray]:
    return surface_points(scene_of("furnace-box"))


def same(a: Field, b: Field, here: tuple[Points, np.ndarray]) -> None:
    np.testing.assert_allclose(a(*here), b(*here), rtol=1e-13, atol=1e-13)


def test_fields_add_and_scale(here: tuple[Points, np.ndarray]) -> None:
    np.testing.assert_array_equal((X + Y)(*here), X(*here) + Y(*here))
    np.testing.assert_array_equal((X - Y)(*here), X(*here) - Y(*here))
    np.testing.assert_array_equal((2.5 * X)(*here), 2.5 * X(*here))
    np.testing.assert_array_equal((np.float64(2.5) * X)(*here), 2.5 * X(*here))


def test_operators_add_scale_and_compose(here: tuple[Points, np.ndarray]) -> None:
    same(I(X), X, here)
    same((SCALE @ REVERSE)(X), SCALE(REVERSE(X)), here)
    same((SCALE + REVERSE)(X), SCALE(X) + REVERSE(X), here)
    same((SCALE - REVERSE)(X), SCALE(X) - REVERSE(X), here)
    same((0.5 * SCALE)(X), 1.5 * X, here)
    same((I - SCALE)(X), -2.0 * X, here)


def test_the_right_operator_is_applied_first(here: tuple[Points, np.ndarray]) -> None:
    add_y = Operator(lambda field: field + Y)  # not linear, so that the order shows
    same((SCALE @ add_y)(X), 3.0 * X + 3.0 * Y, here)
    same((add_y @ SCALE)(X), 3.0 * X + Y, here)


@pytest.mark.parametrize("exponent", range(5))
def test_powers(exponent: int, here: tuple[Points, np.ndarray]) -> None:
    same((SCALE**exponent)(X), 3.0**exponent * X, here)
    same((REVERSE**exponent)(X), REVERSE(X) if exponent % 2 else X, here)


def test_no_negative_powers() -> None:
    with pytest.raises(ValueError, match="exponent = -1"):
        SCALE**-1


def test_a_geometric_series(here: tuple[Points, np.ndarray]) -> None:
    same(neumann(0.5 * I, bounces=4)(X), (1 + 0.5 + 0.25 + 0.125 + 0.0625) * X, here)
    same(neumann(SCALE, bounces=0)(X), X, here)


# ---- G


def test_propagation_carries_what_the_other_end_sends_back() -> None:
    """Along the axes of the cube it is known where a ray arrives, and it sends its light along −l."""
    start = np.array([0.3, -0.2, 0.7])
    l = np.concatenate([np.eye(3), -np.eye(3)], axis=1)  # noqa: E741
    origin = Points.nowhere(np.tile(start[:, None], 6))
    ends = np.where(l == 0, start[:, None], l)
    found = propagation(scene_of("furnace-box"))(Field(lambda x, w: np.concatenate([x.x, w, x.n])))(origin, l)
    np.testing.assert_allclose(found, np.concatenate([ends, -l, -l]), atol=1e-15)


def test_propagation_finds_no_emission_nowhere() -> None:
    scene = scene_of("cornell-box")
    outside = Points.nowhere(np.array([[0.0], [0.0], [3.9]]))
    away = np.array([[0.0], [0.0], [1.0]])
    assert RayCaster(scene)(outside, away).surface.tolist() == [NOWHERE]
    assert not propagation(scene)(emission(scene))(outside, away).any()


# ---- T


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("power", [1, 3])
def test_transport_is_linear(name: str, power: int) -> None:
    scene = scene_of(name)
    here, (a, b) = surface_points(scene), (2.5, -0.75)

    def T() -> Operator:
        return transport(scene, sampling.stream(7), samples=2) ** power  # each with the same random numbers

    same(T()(a * X + b * Y), a * T()(X) + b * T()(Y), here)


@pytest.mark.parametrize("name", CASES)
def test_transport_is_reflection_after_propagation(name: str) -> None:
    scene = scene_of(name)
    G, R = propagation(scene), reflection(scene, sampling.stream(3))
    same((R @ G)(X), transport(scene, sampling.stream(3))(X), surface_points(scene))


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("power", [1, 2, 4])
def test_no_bounce_is_brighter_than_the_albedo_allows(name: str, power: int) -> None:
    scene = scene_of(name)
    albedo = np.max([surface.material.albedo for surface in scene.surfaces], axis=0)
    brightest = np.max([surface.emission.radiance for surface in scene.surfaces if surface.emission], axis=0)
    for samples in (1, 3):
        T = transport(scene, sampling.stream(5), samples)
        TE = (T**power)(emission(scene))(*surface_points(scene))
        assert (TE.max(axis=1) <= albedo**power * brightest * (1 + 1e-12)).all()
        assert TE.min() >= 0
        assert TE.shape == (3, COUNT)


def test_light_is_additive() -> None:
    """Each wall of the furnace emits alone; the sum over walls is the furnace."""
    scene = scene_of("furnace-box")
    here = surface_points(scene)

    def alone(lit: int) -> Scene:
        walls = [
            msgspec.structs.replace(s, emission=s.emission if i == lit else None)
            for i, s in enumerate(scene.surfaces)
        ]
        return Scene(tuple(walls), scene.sensor)

    def bounces(of: Scene) -> np.ndarray:
        T = transport(scene, sampling.stream(11))
        return np.array([(T**k)(emission(of))(*here) for k in range(4)])

    parts = np.array([bounces(alone(i)) for i in range(6)])
    np.testing.assert_allclose(parts.sum(axis=0), bounces(scene), rtol=1e-13)
    assert (parts.mean(axis=(2, 3)) > 0).all()
    assert not np.allclose(parts[0], parts[1])


@pytest.mark.parametrize("name", CASES)
def test_the_neumann_series_is_the_sum_of_powers(name: str) -> None:
    scene = scene_of(name)
    E, here = emission(scene), surface_points(scene)
    rng = sampling.stream(13)
    T = transport(scene, rng)
    powers = sum((T**k)(E)(*here) for k in range(5))
    np.testing.assert_allclose(
        neumann(transport(scene, sampling.stream(13)), 4)(E)(*here), powers, rtol=1e-13
    )


# ---- the same series as the random walk's


@pytest.mark.parametrize("name", ["furnace-box", "furnace-sphere", "integrating-sphere"])
@pytest.mark.parametrize("bounce", range(5))
def test_with_the_same_numbers_a_power_is_a_walk(name: str, bounce: int) -> None:
    """Where no walk ends early, T with one sample and the strategy bsdf draw the same numbers in the same order."""
    scene = scene_of(name)
    rng = sampling.stream(17, 0)
    image = measure((transport(scene, rng) ** bounce)(emission(scene)), scene, rng)
    walk = render(scene, bounce, spp=1, seed=17, strategy="bsdf")[bounce]
    np.testing.assert_allclose(image, walk, rtol=1e-12, atol=1e-12)


REPLICATES = 24


def measured(name: str, bounce: int, spp: int) -> np.ndarray:
    """Replicates of the image's mean of TᵏE; each path branches in 4 at its first vertex."""
    scene, means = case(name).scene.resized(32, 32), []
    for seed in range(REPLICATES):
        rng = sampling.stream(seed, 1)
        T, branching = transport(scene, rng), transport(scene, rng, samples=4)
        field = (branching @ T ** (bounce - 1))(emission(scene)) if bounce else emission(scene)
        means.append(measure(field, scene, rng, spp).mean(axis=(0, 1)))
    return np.array(means)


@pytest.mark.parametrize(("name", "resolution"), [("furnace-box", 1e-9), ("integrating-sphere", 0.07)])
@pytest.mark.parametrize("bounce", range(4))
def test_exact_answers(
    name: str, resolution: float, bounce: int, expect_means: Callable[..., None], off: type[Exception]
) -> None:
    truth = case(name).answer.truth(scene_of(name), bounce)
    assert truth is not None
    found, expected = measured(name, bounce, spp=8), truth.mean[bounce].mean(axis=(0, 1))
    expect_means(found, expected, resolution)
    with pytest.raises(off):
        expect_means(found * (1 + 2 * resolution), expected, 2 * resolution)


@pytest.mark.parametrize("bounce", range(3))
def test_the_walk_in_the_cornell_box(bounce: int, expect_means: Callable[..., None]) -> None:
    """Against the strategy mis, which shares neither numbers nor the way that light is found."""
    scene = scene_of("cornell-box")
    walk = [render(scene, bounce, 256, 1000 + seed)[bounce].mean(axis=(0, 1)) for seed in range(REPLICATES)]
    difference = measured("cornell-box", bounce, spp=16) - np.array(walk)
    expect_means(difference, 0, resolution=0.3, scale=float(np.mean(walk)))
