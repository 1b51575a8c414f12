"""Finite elements against exact answers, against the walk, and against themselves in another basis."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from reference_tracer.elements.form_factors import DenseBlock, point_to_polygon
from reference_tracer.elements.meshing import Sight, UnsupportedSceneError, meshed
from reference_tracer.finite_elements import FormFactors, SingularTransportError, Solution, solve
from reference_tracer.precomputed_transfer import precompute
from reference_tracer.random_walk import render
from scenes import AreaLight, Lambertian, Pinhole, Quad, Scene, Surface, box
from scenes.library import case
from scenes.library.cornell_box import empty_box

CAMERA = Pinhole((0.1, 0.2, 0.1), (0.3, 0.9, 0.2), (0.0, 0.0, 1.0), 70.0, 8, 8)
GRAY = Lambertian((0.5,))
CUBE = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
TURN = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]


@pytest.fixture(scope="module")
def solved() -> Solution:
    return solve(empty_box(), 6)


def furnace(axes: object, material: Lambertian = GRAY) -> Scene:
    walls = box("box", (0.0, 0.0, 0.0), axes, material, inward=True, emission=AreaLight((1.0,)))
    return Scene(walls, CAMERA)


def turned(scene: Scene, R: np.ndarray) -> Scene:
    def move(v: tuple[float, ...]) -> tuple[float, ...]:
        return tuple((R @ v).tolist())

    surfaces = []
    for s in scene.surfaces:
        quad = Quad(move(s.shape.corner), move(s.shape.edge_u), move(s.shape.edge_v))
        surfaces.append(msgspec.structs.replace(s, shape=quad))
    sensor = msgspec.structs.replace(
        scene.sensor, **{f: move(getattr(scene.sensor, f)) for f in ("origin", "target", "up")}
    )
    return Scene(tuple(surfaces), sensor)


# ---- exact answers


def test_furnace() -> None:
    """TᵏE = e ρᵏ, and (I − T)⁻¹E = e / (1 − ρ)."""
    found = solve(case("furnace-box").scene.resized(16, 16), 5, order=5, levels=4)
    expected = 0.5 ** np.arange(6)
    np.testing.assert_allclose(
        found.terms, np.broadcast_to(expected[:, None, None], found.terms.shape), rtol=2e-10
    )
    image = found.image()
    np.testing.assert_allclose(image, np.broadcast_to(expected[:, None, None, None], image.shape), rtol=2e-10)
    np.testing.assert_allclose(found.inverse, 2, rtol=2e-10)


def test_energy_and_reciprocity() -> None:
    """Form factors of a closed room sum to 1 at every node, and A_i F_ij = A_j F_ji for each pair of walls."""
    scene = furnace(((1.0, 0.0, 0.0), (0.0, 0.7, 0.0), (0.0, 0.0, 1.6)))
    surfaces = meshed(scene, 5, 4)
    F = FormFactors(scene, surfaces)
    np.testing.assert_allclose(F(np.ones((1, F.size))), 1, atol=2e-10)
    assert len(F.blocks) == 30
    for (i, j), block in F.blocks.items():
        there = surfaces[i].weights @ block(np.ones((1, len(surfaces[j]))))[0]
        back = surfaces[j].weights @ F.blocks[j, i](np.ones((1, len(surfaces[i]))))[0]
        assert there == pytest.approx(back, rel=1e-6)  # 3e-7: of the polynomials


def test_direct_light_is_lamberts_formula(solved: Solution) -> None:
    scene = solved.scene
    lamp = solved.surfaces[0]
    for i, surface in enumerate(scene.surfaces):
        if not surface.name.startswith(("floor", "back", "red", "green")):
            continue
        s, t = np.random.default_rng(i).random((2, 40))
        x = solved.surfaces[i].points(s, t)
        factor = point_to_polygon(x, np.tile(solved.surfaces[i].normal[:, None], 40), lamp.corners)
        le_rho = np.array(scene.surfaces[0].emission.radiance) * np.array(surface.material.albedo)
        expected = le_rho[:, None] * factor
        np.testing.assert_allclose(
            solved.radiance(surface.name, s, t)[1], expected, rtol=0, atol=2e-7 * expected.max()
        )


def test_the_inverse_is_the_sum_of_the_series() -> None:
    found = solve(empty_box(), 80, order=4, levels=2)
    total = found.terms.sum(axis=0)
    np.testing.assert_allclose(found.inverse, total, atol=1e-10 * total.max())


# ---- the number


def test_the_error_of_the_empty_box_is_below_1e_5(solved: Solution) -> None:
    """Against twice refined; the estimate from one refinement agrees."""
    error = solved.compared(solved.refined(2))
    assert error.surfaces.shape == (7, 9, 3)
    assert error.image.shape == (7, 3)
    assert error.largest < 1e-5
    assert error.surfaces[0].max() < 1e-14
    assert error.image[0].max() < 1e-11
    assert error.largest / 3 < solved.error.largest < 3 * error.largest


def test_finer_is_better(solved: Solution) -> None:
    errors = [solve(empty_box(), 6, order=n, levels=n // 2).compared(solved) for n in (4, 6, 8)]
    surfaces, images = ([getattr(e, field)[1:].max() for e in errors] for field in ("surfaces", "image"))
    for found in (surfaces, images):
        assert found[0] > 5 * found[1] > 25 * found[2]


# ---- the walk


RESOLUTION = (0.012, 0.04, 0.05, 0.075, 0.075, 0.12)
"""Of bounces 1 to 6: the light that is left after six, in blue, has been carried by few walks."""


def test_the_walk_finds_the_same(
    solved: Solution, expect_means: Callable[..., None], off: type[Exception]
) -> None:
    """Quarters of the image, every bounce and channel."""
    scene = empty_box().resized(8, 8)
    image = quarters(seen_through(solved, scene))
    found = np.array([quarters(render(scene, 6, 1024, seed, sampler="sobol")) for seed in range(24)])
    for k, channel in np.ndindex(6, 3):
        expect_means(found[:, k + 1, ..., channel], image[k + 1, ..., channel], RESOLUTION[k])
    with pytest.raises(off):  # the fault that this resolves
        expect_means(found[:, 2, ..., 0], 1.1 * image[2, ..., 0], resolution=0.05)


def quarters(image: np.ndarray) -> np.ndarray:
    return image.reshape(-1, 2, 4, 2, 4, 3).mean(axis=(2, 4))


def seen_through(solved: Solution, scene: Scene) -> np.ndarray:
    """The image of the same solution with fewer pixels."""
    return dataclasses.replace(solved, scene=scene).image()


def test_a_room_with_a_corner_in_the_light(expect_means: Callable[..., None]) -> None:
    """An L: half of the pairs need visibility. The furnace tells its error, the walk that nothing is misplaced."""
    uniform = solve(l_room(emission=AreaLight((1.0,))), 2, order=2, levels=0)
    assert not uniform.F.structured
    np.testing.assert_allclose(
        uniform.terms[1:], [[[0.5]] * 1, [[0.25]] * 1] * np.ones(uniform.F.size), rtol=2e-3
    )
    scene = l_room(lamp=AreaLight((1.0,)))
    found = solve(scene, 2, order=3, levels=0, splits={"wall-5": ((), (0.5,))})
    walked = np.array([render(scene, 2, 32, seed).mean(axis=(1, 2)) for seed in range(24)])
    mean, error = walked.mean(axis=0), walked.std(axis=0, ddof=1) / np.sqrt(24)
    image = found.image().mean(axis=(1, 2))
    assert (error[1:] < 0.01 * mean[1:]).all()
    np.testing.assert_allclose(image[1:], mean[1:], atol=float((5.5 * error[1:]).max()))


def l_room(emission: AreaLight | None = None, lamp: AreaLight | None = None) -> Scene:
    """Three unit cubes in an L; its walls counterclockwise, the second one the lamp."""
    outline = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]
    surfaces = []
    for i, (p, q) in enumerate(zip(outline, [*outline[1:], outline[0]], strict=True)):
        quad = Quad((*p, 0.0), (0.0, 0.0, 1.0), (q[0] - p[0], q[1] - p[1], 0.0))
        surfaces.append(Surface(f"wall-{i}", quad, GRAY, lamp if lamp and i == 1 else emission))
    for k, (x, y) in enumerate(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))):
        floor = Quad((x, y, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
        ceiling = Quad((x, y, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
        surfaces += [
            Surface(f"floor-{k}", floor, GRAY, emission),
            Surface(f"ceiling-{k}", ceiling, GRAY, emission),
        ]
    return Scene(tuple(surfaces), Pinhole((0.3, 0.3, 0.5), (0.6, 1.9, 0.4), (0.0, 0.0, 1.0), 80.0, 8, 8))


# ---- bases, frames, shapes


def test_radiosity_converges_to_the_same(solved: Solution) -> None:
    """The L² error of constants halves with their size, as that of the best approximation does."""
    s, t = np.random.default_rng(7).random((2, 4000))
    expected = solved.radiance("floor", s, t)[1:4]
    off = []
    for levels in (2, 3, 4, 5):
        found = solve(empty_box(), 3, "constant", levels=levels).radiance("floor", s, t)[1:]
        off.append(np.sqrt(((found - expected) ** 2).mean() / (expected**2).mean()))
    ratios = np.array(off[:-1]) / off[1:]
    assert ratios == pytest.approx(2, rel=0.1)


def test_turning_the_scene_changes_nothing() -> None:
    R = TURN * np.linalg.det(TURN)
    scene = empty_box().resized(8, 8)
    straight, askew = (solve(s, 2, order=4, levels=2) for s in (scene, turned(scene, R)))
    assert askew.F.structured
    np.testing.assert_allclose(askew.terms, straight.terms, atol=1e-8 * straight.terms[0].max())
    # polygons may start at another corner: another rule, with another error
    np.testing.assert_allclose(askew.image(), straight.image(), atol=1e-7 * straight.terms[0].max())


def test_a_sheared_room_goes_by_quadrature() -> None:
    scene = furnace(((1.0, 0.0, 0.0), (0.3, 1.0, 0.0), (0.1, 0.2, 1.0)))
    found = solve(scene, 2, order=3, levels=1)
    assert not found.F.structured
    np.testing.assert_allclose(found.terms[1], 0.5, rtol=1e-4)
    exact = solve(scene, 2, "constant", levels=2)  # Lambert's formula for each patch
    np.testing.assert_allclose(exact.terms[2], 0.25, rtol=1e-9)


def test_pairs_are_proved_to_see_each_other() -> None:
    scene = l_room(emission=AreaLight((1.0,)))
    sight = Sight(meshed(scene, 1, 0))
    names = {s.name: i for i, s in enumerate(scene.surfaces)}
    pair = {
        ("wall-0", "wall-4"): (True, True, True),  # across the inner corner
        ("wall-1", "wall-4"): (True, True, True),
        ("wall-2", "wall-4"): (False, False, False),  # turned away from each other
        ("wall-2", "wall-3"): (False, False, False),  # the inner corner itself
        ("floor-0", "ceiling-1"): (True, True, False),
        ("floor-1", "floor-2"): (False, False, False),
        ("floor-1", "ceiling-2"): (True, True, True),
    }
    for (a, b), (see, face, hidden) in pair.items():
        i, j = names[a], names[b]
        if see:
            assert (sight.see(i, j), sight.face(i, j), sight.hidden(i, j)) == (see, face, hidden), (a, b)
        assert sight.see(i, j) == see, (a, b)
    convex = Sight(meshed(empty_box(), 1, 0))
    assert not any(convex.hidden(i, j) for i in range(9) for j in range(9) if i != j)


def test_plates_at_a_hair_s_breadth() -> None:
    """Closer than any node is to an edge: in the middle each plate sees the other one alone."""
    low = Quad((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    high = Quad((0.0, 0.0, 1e-4), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    scene = Scene((Surface("low", low, GRAY), Surface("high", high, GRAY, AreaLight((1.0,)))), CAMERA)
    found = solve(scene, 1, order=3, levels=0)
    x = found.surfaces[0].nodes
    expected = 0.5 * point_to_polygon(
        x, np.tile([[0.0], [0.0], [1.0]], x.shape[1]), found.surfaces[1].corners
    )
    np.testing.assert_allclose(found.terms[1, 0, found.F.slices[0]], expected, rtol=1e-9)


def test_patches_shrink_where_surfaces_meet_and_only_there() -> None:
    scene = empty_box()
    cells = {
        s.name: [len(m.orders) for m in p.meshes]
        for s, p in zip(scene.surfaces, meshed(scene, 3, 4), strict=True)
    }
    inner, end = 3, 4
    assert cells["lamp"] == [inner, inner]
    # open at the front, but the edges to the sides end there
    assert cells["floor"] == cells["back"] == cells["red-wall"] == [inner + 2 * end] * 2
    assert cells["ceiling-left"] == [inner + end, inner + 2 * end]
    assert cells["ceiling-back"] == [inner, inner + end]


# ---- what can't be


def test_other_shapes_are_refused() -> None:
    with pytest.raises(
        UnsupportedSceneError, match="surface 'sphere': its shape is a Sphere, expected a Quad"
    ):
        solve(case("furnace-sphere").scene, 1)


def test_angular_profiles_are_refused() -> None:
    light = AreaLight((1.0,), angular_profile=((1.0,), (2.0,)))
    walls = box("room", (0.0, 0.0, 0.0), CUBE, GRAY, inward=True, emission=light)
    with pytest.raises(UnsupportedSceneError, match=r"surface 'room\.left' has an angular profile"):
        solve(Scene(walls, CAMERA), 1)
    with pytest.raises(UnsupportedSceneError, match="angular profile"):
        precompute(Scene(walls, CAMERA), 1, 2)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"bounces": -1}, "bounces = -1: expected 0 or more"),
        ({"bounces": 1, "basis": "fourier"}, "basis = 'fourier': expected one of legendre, constant, haar"),
        ({"bounces": 1, "order": 0}, "order = 0, levels = 6: expected order ≥ 1 and levels ≥ 0"),
        ({"bounces": 1, "splits": {"moon": ((), ())}}, r"splits name \['moon'\]"),
        (
            {"bounces": 1, "basis": "haar", "splits": {"floor": ((), (0.5,))}},
            "has no other lines; use constant",
        ),
        ({"bounces": 1, "basis": "haar", "levels": 7}, "expected at most 2e"),
    ],
)
def test_arguments_that_cannot_be(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        solve(empty_box(), **arguments)


def test_more_than_fits_is_refused_before_it_is_computed() -> None:
    with pytest.raises(ValueError, match="that need quadrature; expected at most 2e"):
        solve(furnace(((1.0, 0.0, 0.0), (0.3, 1.0, 0.0), (0.1, 0.2, 1.0))), 1, order=10, levels=6)


def test_light_that_is_never_absorbed_has_no_sum() -> None:
    found = solve(furnace(CUBE, Lambertian((1.0,))), 3, order=3, levels=1)
    np.testing.assert_allclose(found.terms, 1, rtol=1e-9)
    with pytest.raises(
        SingularTransportError, match="expected a scene that is open or has an albedo below 1"
    ):
        _ = found.inverse


def test_no_surface_of_that_name(solved: Solution) -> None:
    with pytest.raises(ValueError, match="no surface is called 'roof'; there are lamp, "):
        solved.radiance("roof", np.array([0.5]), np.array([0.5]))


def test_a_planted_fault_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three parts in 10⁴ too much from adaptive quadrature: the furnace of the sheared room shows it."""
    scene = furnace(((1.0, 0.0, 0.0), (0.3, 1.0, 0.0), (0.1, 0.2, 1.0)))
    monkeypatch.setattr(DenseBlock, "__call__", lambda self, values: 1.0003 * values @ self.matrix.T)
    with pytest.raises(AssertionError):
        np.testing.assert_allclose(solve(scene, 1, order=3, levels=1).terms[1], 0.5, rtol=1e-4)
