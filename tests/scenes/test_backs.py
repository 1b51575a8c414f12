"""What is said to be unseen is unseen: by random walks of rays that know nothing of the two arguments."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from scenes import (
    Affine,
    AreaLight,
    Blend,
    Dielectric,
    DirectionalLight,
    Disk,
    Ellipsoid,
    Lambertian,
    Mesh,
    Orthographic,
    Pinhole,
    PointLight,
    Quad,
    Scene,
    Sphere,
    Surface,
    ThinLens,
    box,
    library,
    transformed,
)
from scenes.backs import visible_backs
from scenes.library.cornell_box import empty_box

GREY = Lambertian((0.5, 0.5, 0.5))
LIGHT = PointLight((0.0, 5.0, 0.0), (1.0, 1.0, 1.0))
AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def camera(*origin: float) -> Pinhole:
    return Pinhole(origin, (0.1, 0.2, 0.3), (0.1, 1.0, 0.0), 40.0, 8, 8)  # type: ignore[arg-type]


OUTSIDE, INSIDE = camera(0.4, 0.3, 4.0), camera(0.2, 0.1, 0.4)
BLOCK, ROOM = box("box", (0, 0, 0), AXES, GREY), box("box", (0, 0, 0), AXES, GREY, inward=True)
FLOOR = Surface("floor", Quad((-4, -1, 4), (8, 0, 0), (0, 0, -8)), GREY)
HIGH_FLOOR = Surface("floor", Quad((-4, -0.9, 4), (8, 0, 0), (0, 0, -8)), GREY)
CORNERS = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def tetrahedron(faces: Any = FACES, scale: float = 1.0) -> Surface:
    return Surface("it", Mesh(scale * CORNERS, faces), GREY)  # type: ignore[arg-type]


def scene(*surfaces: Surface, sensor: Any = OUTSIDE, light: Any = LIGHT) -> Scene:
    return Scene(surfaces, sensor, (light,))


def ball(**options: Any) -> Surface:
    return Surface("it", Sphere((0, 0, 0), 1, inward=options.pop("inward", False)), GREY, **options)


EGG = Ellipsoid((0, 0, 0), (2, 0, 0), (0, 1, 0), (0, 0, 0.5))
LENS = {"target": (0, 0, 0), "up": (0, 1, 0), "width": 8, "height": 8}

UNSEEN = {
    "block from outside": scene(*BLOCK),
    "room from inside": scene(*ROOM, sensor=INSIDE),
    "turned block": scene(*(transformed(s, Affine.rotation((1, 2, 3), 33)) for s in BLOCK)),
    "block on a floor": scene(*BLOCK, FLOOR),
    "sphere from outside": scene(ball()),
    "sphere from inside": scene(ball(inward=True), sensor=INSIDE),
    "two-sided sphere from inside": scene(ball(two_sided=True), sensor=INSIDE),
    "egg from outside": scene(Surface("it", EGG, GREY), sensor=camera(0, 0, 0.6)),
    "tetrahedron from outside": scene(tetrahedron()),
    "tetrahedron as a room": scene(
        tetrahedron([(a, c, b) for a, b, c in FACES], 4.0), sensor=camera(0.5, 0.5, 0.6)
    ),
    "glass from anywhere": scene(Surface("it", Sphere((0, 0, 0), 1), Dielectric(1.5)), sensor=INSIDE),
    "disk with nothing behind": scene(Surface("it", Disk((0, 0, 0), (1, 0, 0), (0, 1, 0)), GREY)),
    "small lens": scene(
        ball(), sensor=ThinLens((0, 0, 2), fov=40, aperture_radius=0.9, focus_distance=1, **LENS)
    ),
    "empty Cornell box": empty_box(),
    "furnace": library.case("furnace-box").scene,
}

SEEN = {
    "block from inside": (scene(*BLOCK, sensor=INSIDE), {s.name for s in BLOCK}),
    "room from outside": (scene(*ROOM), {"box.front"}),  # the only wall that the sensor is behind of
    "open block": (scene(*BLOCK[:5]), {"box.right", "box.bottom", "box.left", "box.top", "box.back"}),
    "sphere from inside": (scene(ball(), sensor=INSIDE), {"it"}),
    "sphere from outside": (scene(ball(inward=True)), {"it"}),
    "egg from inside": (scene(Surface("it", EGG, GREY), sensor=camera(0, 0, 0.4)), {"it"}),
    "tetrahedron from inside": (scene(tetrahedron(scale=4.0), sensor=camera(0.5, 0.5, 0.6)), {"it"}),
    "tetrahedron with a face turned over": (scene(tetrahedron([(0, 1, 2), *FACES[1:]])), {"it"}),
    "floor below a block": (scene(*BLOCK, HIGH_FLOOR), {"floor"}),
    "half glass": (scene(Surface("it", Sphere((0, 0, 0), 1), Blend(GREY, Dielectric(1.5), 0.5))), {"it"}),
    "wide lens": (
        scene(ball(), sensor=ThinLens((0, 0, 2), fov=40, aperture_radius=1.1, focus_distance=1, **LENS)),
        {"it"},
    ),
    "camera plane through a block": (
        scene(*BLOCK, sensor=Orthographic((0, 0, 1.1), extent=4, **LENS)),
        {s.name for s in BLOCK},
    ),
    "lamp under the ceiling": (library.case("cornell-box").scene, {"lamp", "floor"}),
}


@pytest.mark.parametrize("name", UNSEEN)
def test_unseen(name: str) -> None:
    assert visible_backs(UNSEEN[name]) == []


@pytest.mark.parametrize("name", SEEN)
def test_what_may_be_seen_is_named(name: str) -> None:
    found, expected = SEEN[name]
    assert set(visible_backs(found)) == expected


def test_order_is_that_of_the_scene() -> None:
    assert visible_backs(scene(*BLOCK, sensor=INSIDE)) == [s.name for s in BLOCK]


def test_a_light_inside_sees_backs() -> None:
    """For formats in which a back casts no shadow."""
    inside, above = PointLight((0.1, 0.2, 0.3), (1, 1, 1)), DirectionalLight((0.1, -1, 0.2), (1, 1, 1))
    below = DirectionalLight((0.1, 1, 0.2), (1, 1, 1))
    assert visible_backs(scene(ball(), light=inside)) == []
    assert visible_backs(scene(ball(), light=inside), to_lights=True) == ["it"]
    assert visible_backs(scene(ball(), light=above), to_lights=True) == []
    assert visible_backs(scene(FLOOR, light=above), to_lights=True) == []
    assert visible_backs(scene(FLOOR, light=below), to_lights=True) == ["floor"]
    walls = ["box.left", "box.top", "box.back"]  # where the light comes from
    assert visible_backs(scene(*ROOM, light=above, sensor=INSIDE), to_lights=True) == walls


# ---- rays that bounce about


def hits(corner: Any, u: Any, v: Any, origin: Any, direction: Any) -> Any:
    """Distances along the rays to a parallelogram, infinity where they miss, by Cramer's rule."""
    matrix = np.stack(np.broadcast_arrays(u, v, -direction), axis=-1)
    with np.errstate(all="ignore"):
        volume = np.linalg.det(matrix)
        offset = origin - corner

        def solved(column: int) -> Any:
            replaced = matrix.copy()
            replaced[..., column] = offset
            return np.linalg.det(replaced) / volume

        s, t, distance = solved(0), solved(1), solved(2)
    inside = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1) & (distance > 1e-9)
    return np.where(inside, distance, np.inf)


def backs_met(world: Scene, rays: int = 3000, bounces: int = 6) -> set[str]:
    """Names of the quads that random paths from the sensor meet from behind; they go on at random."""
    rng = np.random.default_rng(7)
    quads = [
        (s.name, *map(np.asarray, (s.shape.corner, s.shape.edge_u, s.shape.edge_v))) for s in world.surfaces
    ]  # type: ignore[union-attr]
    origin = np.tile(world.sensor.origin, (rays, 1))
    direction, met = rng.normal(size=(rays, 3)), set[str]()
    for _ in range(bounces):
        distances = np.array([hits(c, u, v, origin, direction) for _, c, u, v in quads])
        which = distances.argmin(axis=0)
        found = np.isfinite(distances.min(axis=0))
        origin, direction, which = origin[found], direction[found], which[found]
        origin = origin + distances.min(axis=0)[found, None] * direction
        normals = np.array([np.cross(u, v) for _, _, u, v in quads])[which]
        behind = np.einsum("ri,ri->r", normals, direction) > 0
        met |= {quads[i][0] for i in which[behind]}
        side = np.where(behind, -1, 1)[:, None] * normals
        direction = rng.normal(size=direction.shape)
        direction *= np.sign(np.einsum("ri,ri->r", side, direction))[:, None]
    return met


@pytest.mark.parametrize(
    "name", ["block from outside", "room from inside", "block on a floor", "empty Cornell box"]
)
def test_no_path_meets_what_is_unseen(name: str) -> None:
    assert backs_met(UNSEEN[name]) == set()


@pytest.mark.parametrize("name", ["block from inside", "room from outside", "open block"])
def test_paths_do_meet_what_may_be_seen(name: str) -> None:
    found, expected = SEEN[name]
    assert backs_met(found) == expected


def test_scenes_without_quads_at_all() -> None:
    lamp = Surface("it", Sphere((0, 0, 0), 1), GREY, AreaLight((1, 1, 1)))
    assert visible_backs(Scene((lamp,), OUTSIDE)) == []
    assert visible_backs(Scene((), OUTSIDE, (LIGHT,)), to_lights=True) == []
