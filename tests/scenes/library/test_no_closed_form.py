"""Committed solutions against quadrature written out here: Gauss nodes, the kernel, camera rays, nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from scenes import Case, Computed, Pinhole, Quad, Scene
from scenes.library import CASES, case


def truth(found: Case, bounces: int) -> np.ndarray:
    answer = found.answer.truth(found.scene, bounces)
    assert answer is not None
    return answer.mean


def gauss(n: int) -> tuple[np.ndarray, np.ndarray]:
    nodes, weights = np.polynomial.legendre.leggauss(n)
    return (nodes + 1) / 2, weights / 2


def nodes_of(quad: Quad, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss nodes of a quad ``(n², 3)`` and the areas they stand for."""
    u, w = gauss(n)
    s, t = (a.ravel() for a in np.meshgrid(u, u))
    edges = np.array(quad.edge_u), np.array(quad.edge_v)
    points = np.array(quad.corner) + s[:, None] * edges[0] + t[:, None] * edges[1]
    return points, np.outer(w, w).ravel() * np.linalg.norm(np.cross(*edges))


def exchange(x: np.ndarray, nx: np.ndarray, y: np.ndarray, ny: np.ndarray) -> np.ndarray:
    """cos θ cos θ′ / π|x − y|², ``(len(x), len(y))``; both ends in front of each other."""
    d = y[None] - x[:, None]
    cosines = np.maximum(d @ nx, 0) * np.maximum(-(d @ ny), 0)
    return cosines / (np.pi * (d**2).sum(axis=-1) ** 2)


def seen_points(camera: Pinhole, rows: np.ndarray, columns: np.ndarray, quad: Quad) -> np.ndarray:
    """Where rays through 3 × 3 Gauss nodes of pixels meet a quad's plane, ``(pixels, 9, 3)``; each must be on it."""
    u, _ = gauss(3)
    y, x = (a.ravel() for a in np.meshgrid(u, u, indexing="ij"))
    forward = np.subtract(camera.target, camera.origin)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, camera.up)
    right /= np.linalg.norm(right)
    scale = 2 * np.tan(np.radians(camera.fov / 2)) / min(camera.width, camera.height)
    across = scale * (columns[:, None] + x - camera.width / 2)
    down = scale * (rows[:, None] + y - camera.height / 2)
    d = forward + across[..., None] * right - down[..., None] * np.cross(right, forward)
    n = np.cross(quad.edge_u, quad.edge_v)
    t = (n @ np.subtract(quad.corner, camera.origin)) / (d @ n)
    points = np.array(camera.origin) + t[..., None] * d
    for edge in (np.array(quad.edge_u), np.array(quad.edge_v)):
        share = (points - quad.corner) @ edge / (edge @ edge)
        assert ((share > 0) & (share < 1)).all(), "a pixel that does not see this quad alone"
    return points


def averaged(values: np.ndarray) -> np.ndarray:
    """The mean over pixels from values at their 3 × 3 Gauss nodes, ``(pixels, 9, channels)``."""
    _, w = gauss(3)
    return np.einsum("pqc,q->pc", values, np.outer(w, w).ravel())


def quads(scene: Scene) -> dict[str, tuple[Quad, np.ndarray, np.ndarray]]:
    return {s.name: (s.shape, np.array(s.shape.normal), np.array(s.material.albedo)) for s in scene.surfaces}


def test_facing_squares_by_nyström() -> None:
    """Every bounce: the kernel is smooth at this distance, so that 20 Gauss nodes per axis leave no error."""
    found = case("facing-squares")
    parts, expected = quads(found.scene), truth(found, 5)
    pixels = {
        "lamp": (np.array([46, 48, 52, 58]), np.array([20, 40, 30, 35])),
        "square": (np.array([6, 10, 15, 18]), np.array([30, 20, 45, 35])),
    }
    nodes = {name: nodes_of(quad, 20) for name, (quad, _, _) in parts.items()}

    def lit_by_other(name: str, x: np.ndarray, fields: dict[str, np.ndarray]) -> np.ndarray:
        """T of the other square's radiance at points of this one."""
        other = "square" if name == "lamp" else "lamp"
        y, areas = nodes[other]
        (_, n, rho), (_, n_other, _) = parts[name], parts[other]
        return rho * ((exchange(x, n, y, n_other) * areas) @ fields[other])

    E = np.array(found.scene.surfaces[0].emission.radiance)
    fields = {"lamp": np.tile(E, (400, 1)), "square": np.zeros((400, 3))}
    for k in range(1, 6):
        for name, (rows, columns) in pixels.items():
            x = seen_points(found.scene.sensor, rows, columns, parts[name][0])
            seen = averaged(lit_by_other(name, x.reshape(-1, 3), fields).reshape(4, 9, 3))
            np.testing.assert_allclose(expected[k, rows, columns], seen, rtol=2e-6)
            assert seen.any() == ((name == "square") == bool(k % 2))
        fields = {name: lit_by_other(name, nodes[name][0], fields) for name in parts}


def test_each_bounce_is_on_one_square_only() -> None:
    expected = truth(case("facing-squares"), 6)
    lit = (expected > 0).all(axis=-1)
    for k in range(7):
        np.testing.assert_array_equal(lit[k], lit[k % 2])
    assert not (lit[0] & lit[1]).any()
    assert lit[0].sum() > 500
    assert lit[1].sum() > 500


FLOOR = np.array([52, 54, 57, 60]), np.array([20, 34, 30, 45])
BACK = np.array([25, 30, 36, 40]), np.array([22, 40, 30, 35])


@pytest.mark.parametrize(("wall", "pixels"), [("floor", FLOOR), ("back", BACK)])
def test_the_empty_box_by_quadrature(wall: str, pixels: tuple[np.ndarray, np.ndarray]) -> None:
    """TE and T²E of pixels that see the middle of a wall, by quadrature over the lamp and over all walls."""
    found = case("cornell-box-empty")
    parts, expected = quads(found.scene), truth(found, 2)
    lamp, n_lamp, _ = parts["lamp"]
    on_lamp, areas = nodes_of(lamp, 24)
    E = np.array(found.scene.surfaces[0].emission.radiance)

    def direct(x: np.ndarray, n: np.ndarray, rho: np.ndarray) -> np.ndarray:
        return np.outer(exchange(x, n, on_lamp, n_lamp) @ areas, E) * rho

    quad, n, rho = parts[wall]
    x = seen_points(found.scene.sensor, *pixels, quad).reshape(-1, 3)
    TE = direct(x, n, rho).reshape(len(pixels[0]), 9, 3)
    np.testing.assert_allclose(expected[1][pixels], averaged(TE), rtol=2e-6)
    TTE = np.zeros((len(x), 3))
    for name, (other, n_other, rho_other) in parts.items():
        if name != wall:
            y, there = nodes_of(other, 32)
            TTE += (exchange(x, n, y, n_other) * there) @ direct(y, n_other, rho_other)
    values = (rho * TTE).reshape(len(pixels[0]), 9, 3)
    np.testing.assert_allclose(expected[2][pixels], averaged(values), rtol=1e-5)


COMPUTED = [name for name in CASES if case(name).answer.kind == "computed"]


@pytest.mark.parametrize("name", COMPUTED)
def test_the_tolerance_is_ten_times_the_error(name: str) -> None:
    found = case(name)
    assert isinstance(found.answer, Computed)
    assert len(found.answer.error) == 7
    for k, error in enumerate(found.answer.error):
        assert found.tolerance.of_image(k) >= 10 * error
        assert found.tolerance.of_tile(k) >= 40 * error  # 16 tiles: √16 × the root mean square of all pixels
    assert found.answer.source.startswith("finite elements of lightproof")
    assert found.answer.path.stat().st_size < 300_000
