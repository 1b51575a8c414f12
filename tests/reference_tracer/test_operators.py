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
    delta_emission,
    emission,
    measure,
    neumann,
    propagation,
    reflection,
    reflection_by_quadrature,
    transport,
)
from reference_tracer.points import NOWHERE, Points
from reference_tracer.propagation import RayCaster
from reference_tracer.random_walk import render
from scenes import (
    Blend,
    ConstantEnvironment,
    DirectionalLight,
    Lambertian,
    Material,
    PointLight,
    Quad,
    RoughConductor,
    Scene,
    SpotLight,
    Surface,
)
from scenes.library import DEFAULT, case

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


@pytest.mark.parametrize("name", DEFAULT)
@pytest.mark.parametrize("power", [1, 3])
def test_transport_is_linear(name: str, power: int) -> None:
    scene = scene_of(name)
    here, (a, b) = surface_points(scene), (2.5, -0.75)

    def T() -> Operator:
        return transport(scene, sampling.stream(7), samples=2) ** power  # each with the same random numbers

    same(T()(a * X + b * Y), a * T()(X) + b * T()(Y), here)


@pytest.mark.parametrize("name", DEFAULT)
def test_transport_is_reflection_after_propagation(name: str) -> None:
    scene = scene_of(name)
    G, R = propagation(scene), reflection(scene, sampling.stream(3))
    same((R @ G)(X), transport(scene, sampling.stream(3))(X), surface_points(scene))


@pytest.mark.parametrize("name", DEFAULT)
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


@pytest.mark.parametrize("name", DEFAULT)
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


# ---- R by quadrature, the lowest rung of the ladder


def test_quadrature_is_exact_for_polynomials() -> None:
    """R of 1 is the albedo; R of cos² θ is half of it, ∫ cos³ θ dl / π = ½."""
    scene = scene_of("furnace-box")
    here = surface_points(scene)
    R = reflection_by_quadrature(scene, order=4)
    one = Field(lambda x, w: np.ones((3, len(x))))
    cosine = Field(lambda x, w: np.tile(np.einsum("in,in->n", x.n, w) ** 2, (3, 1)))
    np.testing.assert_allclose(R(one)(*here), 0.5, rtol=1e-13)
    np.testing.assert_allclose(R(cosine)(*here), 0.25, rtol=1e-13)


@pytest.mark.parametrize("name", ["integrating-sphere", "cornell-box"])
def test_quadrature_and_samples_agree(name: str, expect_means: Callable[..., None]) -> None:
    """Of a smooth field, so that a coarse rule is all but exact."""
    scene = scene_of(name)
    here, (low, high) = surface_points(scene), (reflection_by_quadrature(scene, n)(X) for n in (6, 12))
    exact = high(*here)
    np.testing.assert_allclose(low(*here), exact, atol=1e-12 * np.abs(exact).max())
    estimates = np.array([reflection(scene, sampling.stream(s), 256)(X)(*here) for s in range(24)])
    expect_means(estimates.mean(axis=2), exact.mean(axis=1), resolution=0.07, scale=np.abs(exact).mean())


def test_two_bounces_by_quadrature_alone() -> None:
    """T² E of the furnace, without a random number: ρ² e."""
    scene = scene_of("furnace-sphere")
    T = reflection_by_quadrature(scene, order=3) @ propagation(scene)
    points, directions = surface_points(scene)
    TTE = (T**2)(emission(scene))(points[np.arange(5)], directions[:, :5])
    np.testing.assert_allclose(TTE, 0.25, rtol=1e-12)


# ---- reciprocity: source and meter may be exchanged

ROUGH = RoughConductor((0.2, 1.0, 1.5), (3.9, 6.0, 2.0), 0.5)


@pytest.mark.parametrize(
    "material", [Lambertian((0.8, 0.3, 0.5)), ROUGH, Blend(ROUGH, Lambertian((0.5,) * 3), 0.4)]
)
def test_reflection_is_reciprocal(material: Material) -> None:
    """⟨X, R Y⟩ = ⟨R X, Y⟩ at every point, with the inner product ∫ · · cos θ dω and the directions of X turned."""
    floor = Surface("floor", Quad((-1.0, -1.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0)), material)
    scene = Scene((floor,), case("cornell-box").scene.sensor, (ConstantEnvironment((1.0,) * 3),))
    R, order = reflection_by_quadrature(scene, 16), 16
    z, w = np.polynomial.legendre.leggauss(order)
    cosines, phi = np.meshgrid((z + 1) / 2, np.pi * (np.arange(2 * order) + 0.25) / order, indexing="ij")
    sine = np.sqrt(1 - cosines**2)
    d = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosines]).reshape(3, -1)
    weight = (np.repeat(w / 2, 2 * order) * np.pi / order) * d[2]
    n = d.shape[1]
    up = Points(np.zeros((3, n)), np.tile([[0.0], [0.0], [1.0]], n), np.zeros(n, dtype=int))
    f, g = (
        Field(lambda x, w, a=a: np.tile((1 + np.array(a) @ w) ** 2, (3, 1)))
        for a in ((0.5, 0.2, 0.1), (-0.3, 0.6, 0.3))
    )
    left, right = (f(up, d) * R(g)(up, d)) @ weight, (R(f)(up, d) * g(up, d)) @ weight
    np.testing.assert_allclose(left, right, rtol=2e-4)  # 4e-5: of the quadrature
    assert not np.allclose((f(up, d) * g(up, d)) @ weight, left, rtol=0.02)


# ---- point, spot and directional lights beside E


def test_delta_emission_is_bounce_one_and_starts_the_series() -> None:
    """Against closed form, and number for number against the walk where next event has one light to choose."""
    base = case("cornell-box").scene
    light = PointLight((0.0, 0.5, 0.3), (2.0, 1.0, 3.0))
    dark = tuple(msgspec.structs.replace(s, emission=None) for s in base.surfaces)
    scene = Scene(dark, base.sensor, (light,)).resized(8, 8)
    TE = delta_emission(scene)
    x = np.array([[0.2], [-1.0], [0.5]])
    at = Points(x, np.array([[0.0], [1.0], [0.0]]), np.array([1]))
    segment = np.array(light.position) - x[:, 0]
    expected = np.array(base.surfaces[1].material.albedo) / np.pi * np.array(light.intensity)
    expected = expected * segment[1] / np.linalg.norm(segment) ** 3
    seen = TE(at, np.array([[0.0], [0.6], [0.8]]))[:, 0]
    blocked = RayCaster(scene).distance(at, segment[:, None] / np.linalg.norm(segment)) < np.linalg.norm(
        segment
    )
    np.testing.assert_allclose(seen, expected * ~blocked, rtol=1e-12)
    for k in (1, 2, 3):
        means = []
        for seed in range(6):
            rng = sampling.stream(seed, 1)
            series = (transport(scene, rng) ** (k - 1))(TE)
            means.append(measure(series, scene, rng, 40).mean())
        walk = [render(scene, k, 40, 50 + seed)[k].mean() for seed in range(6)]
        error = np.hypot(np.std(means, ddof=1), np.std(walk, ddof=1)) / np.sqrt(6)
        assert error < 0.05 * np.mean(walk)
        assert abs(np.mean(means) - np.mean(walk)) < 5 * error


def test_delta_emission_of_several_lights_is_their_sum() -> None:
    base = case("furnace-box").scene
    lights = (
        PointLight((0.1, 0.2, 0.3), (1.0, 2.0, 3.0)),
        SpotLight((0.0, 0.0, 0.5), (1.0, 0.5, 0.0), (2.0, 2.0, 1.0), 60.0, 20.0),
        DirectionalLight((1.0, -1.0, 0.2), (1.0, 1.0, 1.0)),
    )
    here = surface_points(base)
    alone = [delta_emission(Scene(base.surfaces, base.sensor, (light,)))(*here) for light in lights]
    together = delta_emission(Scene(base.surfaces, base.sensor, lights))(*here)
    np.testing.assert_allclose(together, sum(alone), rtol=1e-12)
    assert alone[0].min() > 0  # the box is convex
    assert 0 < np.mean(alone[1] > 0) < 1
    assert not alone[2].any()  # no light from outside gets in
