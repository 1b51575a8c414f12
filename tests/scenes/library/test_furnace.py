"""TE = ρe in a closed scene, by quadrature over its walls or over the hemisphere with rays; the rest by induction."""

from __future__ import annotations

import numpy as np
import pytest

from scenes import Blend, Case, Lambertian, Mesh, Mirror, Quad, Scene, Sphere, Surface
from scenes.library import case
from scenes.library.furnace import CASES, reflected_share

CLOSED = [*sorted(set(CASES) - {"furnace-convex"}), "furnace-equal-energy", "furnace-d65"]

NODES, WEIGHTS = np.polynomial.legendre.leggauss(64)
NODES, WEIGHTS = (NODES + 1) / 2, WEIGHTS / 2  # on [0, 1]
INSIDE = [(0.5, 0.5), (0.21, 0.66), (0.8, 0.3)]


def place(quad: Quad, s: np.ndarray, t: np.ndarray) -> np.ndarray:
    return np.array(quad.corner) + np.multiply.outer(s, quad.edge_u) + np.multiply.outer(t, quad.edge_v)


def kernel(x: np.ndarray, n: np.ndarray, y: np.ndarray, m: np.ndarray) -> np.ndarray:
    """cos θ cos θ′ / π|x − y|² between x with normal n and the points y with normals m; 0 from behind."""
    d = y - x
    squared = (d**2).sum(axis=-1)
    return np.maximum(d @ n, 0) * np.maximum(-(d * m).sum(axis=-1), 0) / (np.pi * squared**2)


def form_factor(x: np.ndarray, n: np.ndarray, wall: Quad) -> float:
    y = place(wall, *np.meshgrid(NODES, NODES))
    return float((kernel(x, n, y, wall.normal) * np.outer(WEIGHTS, WEIGHTS)).sum() * wall.area)


def uniform(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    assert surface.emission is not None
    return np.array(surface.emission.radiance), np.array(surface.material.albedo)


def check_series(found: Case, irradiance_per_radiance: float) -> None:
    """TE = (ρ/π) · irradiance must be the case's bounce 1, and T the same multiple of every uniform field."""
    e, rho = uniform(found.scene.surfaces[0])
    assert all(uniform(surface)[0].tolist() == e.tolist() for surface in found.scene.surfaces)
    assert all(uniform(surface)[1].tolist() == rho.tolist() for surface in found.scene.surfaces)
    T = rho / np.pi * irradiance_per_radiance
    truth = found.answer.truth(found.scene, 6)
    assert truth is not None
    np.testing.assert_allclose(truth.mean[0], np.broadcast_to(e, found.scene.shape))
    for previous, image in zip(truth.mean, truth.mean[1:], strict=False):
        np.testing.assert_allclose(image, T * previous, rtol=1e-6)


@pytest.mark.parametrize("at", range(6))
@pytest.mark.parametrize("point", INSIDE)
def test_the_box_sees_itself_everywhere(at: int, point: tuple[float, float]) -> None:
    found = case("furnace-box")
    walls = [surface.shape for surface in found.scene.surfaces]
    x = place(walls[at], *point)
    factors = [form_factor(x, walls[at].normal, wall) for wall in walls]
    assert factors[at] == 0
    assert sum(factors) == pytest.approx(1, abs=1e-6)
    check_series(found, np.pi * sum(factors))


def test_the_wall_opposite_the_middle_has_its_known_form_factor() -> None:
    """The quadrature itself: four quarters, each (1/π)(a/√(1+a²)) atan(a/√(1+a²)), a = ½ (Howell, B-4)."""
    walls = [surface.shape for surface in case("furnace-box").scene.surfaces]
    a = 0.5 / np.sqrt(1.25)
    expected = 4 / np.pi * a * np.arctan(a)
    found = form_factor(place(walls[0], 0.5, 0.5), walls[0].normal, walls[1])
    assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("x", [(0, 0, 1), (0.6, 0.0, -0.8), (1, 0, 0)])
def test_the_sphere_sees_itself_everywhere(x: tuple[float, float, float]) -> None:
    found = case("furnace-sphere")
    sphere = found.scene.surfaces[0].shape
    z, phi = np.meshgrid(2 * NODES - 1, 2 * np.pi * (np.arange(96) + 0.25) / 96)
    outward = np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z], axis=-1)
    area = 4 * np.pi * sphere.radius**2 * WEIGHTS / 96
    point = np.array(sphere.center) + sphere.radius * np.array(x)
    F = kernel(point, -np.array(x, float), np.array(sphere.center) + sphere.radius * outward, -outward) * area
    assert F.sum() == pytest.approx(1, abs=1e-9)
    check_series(found, np.pi * F.sum())


@pytest.mark.parametrize("name", ["furnace-box", "furnace-sphere"])
def test_the_camera_is_inside(name: str) -> None:
    scene = case(name).scene
    origin = np.array(scene.sensor.origin)
    for surface in scene.surfaces:
        if isinstance(surface.shape, Quad):
            assert (origin - surface.shape.corner) @ surface.shape.normal > 0.1
        else:
            assert surface.shape.inward
            assert np.linalg.norm(origin - surface.shape.center) < surface.shape.radius


# ---- rays written out: what a point of any furnace sees, all round


def nearest_hits(scene: Scene, o: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Distance, front normal ``(n, 3)`` and index of the nearest surface; infinity where there is none."""
    best, normal, index = np.full(len(o), np.inf), np.zeros_like(o), np.full(len(o), -1)
    tiny = 1e-7 * np.abs(o).max()

    def keep(t: np.ndarray, n: np.ndarray, i: int) -> None:
        nearer = (t > tiny) & (t < best)
        best[nearer], index[nearer] = t[nearer], i
        normal[nearer] = np.broadcast_to(n, o.shape)[nearer]

    for i, shape in enumerate(surface.shape for surface in scene.surfaces):
        if isinstance(shape, Sphere):
            w = o - shape.center
            b, c = (w * d).sum(axis=1), (w * w).sum(axis=1) - shape.radius**2
            root = np.sqrt(np.where(b * b > c, b * b - c, np.nan))
            for t in (-b - root, -b + root):
                outward = (w + t[:, None] * d) / shape.radius
                keep(t, -outward if shape.inward else outward, i)
            continue
        if isinstance(shape, Quad):
            flats, limit = [(np.array(shape.corner), np.array(shape.edge_u), np.array(shape.edge_v))], 2.0
        else:
            assert isinstance(shape, Mesh)
            flats, limit = [(a, b - a, c - a) for a, b, c in shape.corners], 1.0
        for corner, u, v in flats:
            n = np.cross(u, v)
            t = -((o - corner) @ n) / (d @ n)
            p = o + t[:, None] * d - corner
            s, r = np.cross(p, v) @ n / (n @ n), np.cross(u, p) @ n / (n @ n)
            inside = (s > -1e-9) & (r > -1e-9) & (s < 1 + 1e-9) & (r < 1 + 1e-9) & (s + r < limit + 1e-9)
            keep(np.where(inside, t, np.nan), n / np.linalg.norm(n), i)
    return best, normal, index


def hemisphere(n: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions about n and weights of ∫ cos θ dl / π: Gauss in sin²θ, equal steps in azimuth."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    sin2, phi = np.meshgrid((nodes + 1) / 2, 2 * np.pi * (np.arange(2 * order) + 0.37) / (2 * order))
    across = np.cross(n, [0.36, 0.48, 0.8])
    across /= np.linalg.norm(across)
    sin2, phi = sin2.ravel()[:, None], phi.ravel()[:, None]
    d = np.sqrt(1 - sin2) * n + np.sqrt(sin2) * (np.cos(phi) * across + np.sin(phi) * np.cross(n, across))
    return d, np.tile(weights / 2, 2 * order) / (2 * order)


def emitted(scene: Scene, normal: np.ndarray, index: np.ndarray, d: np.ndarray) -> np.ndarray:
    """E where rays arrive: that of a front, 0 from behind, the environment where there is nothing."""
    out = np.zeros((len(d), scene.channels))
    for i, surface in enumerate(scene.surfaces):
        if surface.emission is not None:
            seen = (index == i) & ((normal * d).sum(axis=1) < 0)
            out[seen] = surface.emission.radiance
    if scene.environment is not None:
        out[index < 0] = scene.environment.radiance
    return out


def reflect(scene: Scene, material: object, x: np.ndarray, n: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """TE at one point, into one direction, by tracing E over the hemisphere or along the mirrored ray."""
    if isinstance(material, Blend):
        first, second = (reflect(scene, m, x, n, wo) for m in (material.first, material.second))
        return (1 - material.weight) * first + material.weight * second
    if isinstance(material, Mirror):
        d, weights, share = 2 * (wo @ n) * n[None] - wo, np.ones(1), material.reflectance
    else:
        assert isinstance(material, Lambertian)
        (d, weights), share = hemisphere(n, 12), material.albedo
    _, normal, index = nearest_hits(scene, np.broadcast_to(x, d.shape), d)
    return np.array(share) * (weights @ emitted(scene, normal, index, d))


@pytest.mark.parametrize("name", [*CLOSED, "furnace-convex"])
def test_every_point_that_is_seen_finds_the_same_radiance_all_round(name: str) -> None:
    """E and TE along camera rays, and TE along rays that leave where those arrive: two rounds of points."""
    found = case(name)
    camera, rng = found.scene.sensor, np.random.default_rng(5)
    place = rng.uniform(0, [camera.width, camera.height], (12, 2))
    d = np.concatenate([place, np.ones((12, 1))], axis=1) @ camera.pixel_to_direction.T
    d /= np.linalg.norm(d, axis=1)[:, None]
    o = np.tile(camera.origin, (12, 1))
    truth = found.answer.truth(found.scene, 2)
    assert truth is not None
    for _ in range(2):
        t, normal, index = nearest_hits(found.scene, o, d)
        E, next_o, next_d = emitted(found.scene, normal, index, d), [], []
        for x, n, i, wi, Le in zip(o + t[:, None] * d, normal, index, d, E, strict=True):
            if i < 0:  # beside the convex body
                assert Le.tolist() == list(found.scene.environment.radiance)
                continue
            TE = reflect(found.scene, found.scene.surfaces[i].material, x, n, -wi)
            if name == "furnace-convex":
                assert not Le.any()
                np.testing.assert_allclose(TE, truth.mean[:, 31, 31][1], rtol=1e-12)  # a pixel of the ball
            else:
                np.testing.assert_allclose(Le, truth.mean[0, 0, 0], rtol=1e-12)
                np.testing.assert_allclose(TE, truth.mean[1, 0, 0], rtol=1e-12)
            next_o.append(x)
            next_d.append(hemisphere(n, 5)[0][rng.integers(50)])
        assert next_o or name == "furnace-convex"  # from which every ray leaves for good
        o, d = np.array(next_o).reshape(-1, 3), np.array(next_d).reshape(-1, 3)


@pytest.mark.parametrize("name", CLOSED)
def test_the_series_is_that_of_its_first_step(name: str) -> None:
    found = case(name)
    truth = found.answer.truth(found.scene.resized(3, 2), 7)
    assert truth is not None
    assert truth.mean.shape == (8, 2, 3, found.scene.channels)
    step = truth.mean[1] / truth.mean[0]
    for previous, image in zip(truth.mean, truth.mean[1:], strict=False):
        np.testing.assert_allclose(image, step * previous, rtol=1e-12)


def test_a_hole_would_be_seen() -> None:
    """The check itself: without its ceiling the room is no furnace any more."""
    found = case("furnace-channels").scene
    scene = Scene(tuple(s for s in found.surfaces if s.name != "room.top"), found.sensor)
    floor = next(surface for surface in scene.surfaces if surface.name == "room.bottom")
    up = np.array([0.0, 1.0, 0.0])
    TE = reflect(scene, floor.material, np.array([0.1, -0.8, 0.5]), up, up)
    assert (TE / [0.9, 1.0, 0.1]).max() < 0.9


def test_a_convex_body_and_its_outline() -> None:
    """Shares of pixels by 64² rays each; what is reflected comes back from nowhere."""
    found = case("furnace-convex")
    scene, fine = found.scene.resized(9, 7), 64
    [ball] = scene.surfaces
    x, y = (np.arange(9 * fine) + 0.5) / fine, (np.arange(7 * fine) + 0.5) / fine
    image = np.stack([*np.meshgrid(x, y), np.ones((7 * fine, 9 * fine))], axis=-1)
    d = image @ scene.sensor.pixel_to_direction.T
    w = np.subtract(ball.shape.center, scene.sensor.origin)
    distance2 = w @ w - (d @ w) ** 2 / (d**2).sum(axis=-1)  # of the centre from the ray
    share = (distance2 < ball.shape.radius**2).reshape(7, fine, 9, fine).mean(axis=(1, 3))
    truth = found.answer.truth(scene, 4)
    assert truth is not None
    sky, rho = np.array(scene.lights[0].radiance), np.array(ball.material.albedo)
    np.testing.assert_allclose(truth.mean[0], np.multiply.outer(1 - share, sky), atol=4e-3)
    np.testing.assert_allclose(truth.mean[1], np.multiply.outer(share, rho * sky), atol=4e-3)
    assert truth.mean[0, ..., 0].mean() == pytest.approx(1 - share.mean(), abs=1e-4)
    assert ((share > 0.01) & (share < 0.99)).sum() > 10
    assert not truth.mean[2:].any()


def test_no_uniform_field_where_lobes_or_surfaces_differ() -> None:
    scene = case("furnace-channels").scene
    with pytest.raises(ValueError, match="every angle"):
        reflected_share(Blend(Mirror((0.5,)), Lambertian((0.4,)), 0.5))
    darker = (*scene.surfaces[:-1], case("furnace-mesh").scene.surfaces[0])
    with pytest.raises(ValueError, match="2 pairs"):
        case("furnace-channels").answer.truth(Scene(darker, scene.sensor), 1)
