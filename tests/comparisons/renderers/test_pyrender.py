"""OpenGL as a witness, drawn for real: against closed forms, in a worker process; and the adapter with faults."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from comparisons.regions import Regions
from comparisons.relations import RELATIONS
from comparisons.relations.relation import Exact, Told
from comparisons.relations.stages import STAGES
from comparisons.renderers import Hits, Images, Unsupported
from comparisons.renderers.opengl import _shifts
from comparisons.renderers.opengl_triangles import CORNERS_OF_DISK, sphere, triangles
from comparisons.renderers.opengl_view import View
from comparisons.renderers.process import RendererProcess
from comparisons.results import Comparison
from comparisons.statistics.intervals import denominators
from scenes import (
    AreaLight,
    ConstantEnvironment,
    Disk,
    Ellipsoid,
    IrradianceMeter,
    Lambertian,
    Mesh,
    Orthographic,
    Pinhole,
    PointLight,
    PolarRange,
    Quad,
    RadianceMeter,
    Scene,
    Sensor,
    Sphere,
    Surface,
    ThinLens,
    library,
)
from scenes.first_hit import first_hits

GREY = Lambertian((0.5, 0.5, 0.5))
PERSPECTIVE = Pinhole((0.3, 0.5, 4.0), (0.1, -0.2, 0.0), (0.3, 1.0, 0.1), 55, 14, 9)
PARALLEL = Orthographic((0.3, 0.5, 4.0), (0.1, -0.2, 0.0), (0.3, 1.0, 0.1), 3.6, 14, 9)


def everything(sensor: Sensor) -> Scene:
    """Every shape, from in front and from behind, near and far, nothing symmetric."""
    lamp = AreaLight((4.0, 2.0, 1.0))
    return Scene(
        (
            Surface("wall", Quad((-2.1, -1.6, -2), (6, 0, 0.3), (0, 3.6, 1.0)), GREY),
            Surface("ball", Sphere((-0.9, 0.5, 0.2), 0.5), GREY),
            Surface(
                "egg", Ellipsoid((0.9, -0.5, 0.1), (0.6, 0.1, 0), (0, 0.3, 0.1), (0, 0, 0.5)), GREY, lamp
            ),
            Surface("lamp", Disk((0.6, 1.1, -0.3), (0.5, 0, 0.1), (0.1, 0.4, 0)), GREY, lamp),
            Surface("turned away", Quad((-1.6, -1.3, 0.4), (0, 0.8, 0.1), (1.1, 0.1, 0)), GREY, lamp),
            Surface(
                "both",
                Mesh(
                    ((0.0, 0.0, 1.0), (0.2, 0.9, 0.9), (-0.5, 0.4, 1.1), (0.4, 0.5, 1.6)),
                    ((0, 1, 2), (0, 3, 1)),
                ),
                GREY,
                lamp,
                two_sided=True,
            ),
            Surface("dome", Sphere((0, 0, 0), 30.0, inward=True), GREY),
        ),
        sensor,
    )


class OpenGL:
    """A renderer's process as relations see it."""

    def __init__(self, process: RendererProcess) -> None:
        self.process = process

    def render(self, *_: object) -> Images:
        raise AssertionError

    def first_hits(self, scene: Scene) -> Hits:
        return self.process.first_hits(scene, timeout=60)

    def restart(self) -> None:
        raise AssertionError

    def E(self, scene: Scene) -> Images:
        return self.process.render(scene, [0], 1, 0, timeout=60)[0]


@pytest.fixture(scope="module")
def opengl() -> Iterator[OpenGL]:
    with RendererProcess("pyrender") as process:
        yield OpenGL(process)


@pytest.fixture
def planted(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], OpenGL]]:
    """``planted("Mirrored")`` is the witness with that fault of wrong_opengl.py."""
    monkeypatch.chdir(Path(__file__).parent)
    started: list[RendererProcess] = []

    def start(fault: str) -> OpenGL:
        started.append(RendererProcess(f"wrong_opengl:{fault}"))
        return OpenGL(started[-1])

    yield start
    for process in started:
        process.close()


def told(scene: Scene, witness: OpenGL) -> Told:
    [claim] = RELATIONS["first-hits"].claims(scene, 0, "")
    assert isinstance(claim, Exact)
    return claim.look(witness)


# ---- first hits


@pytest.mark.parametrize("sensor", [PERSPECTIVE, PARALLEL], ids=["perspective", "parallel"])
def test_every_shape_from_both_sides(opengl: OpenGL, sensor: Sensor) -> None:
    scene = everything(sensor)
    exact = first_hits(scene)
    assert set(exact.surface) == set(range(7))
    found = told(scene, opengl)
    assert found.verdict == "pass"
    assert "normals were not told" in found.message


def test_distances_by_hand(opengl: OpenGL) -> None:
    """A wall at 3: in the middle that is the distance, 10 pixels aside at 45° it is 3 √2; above it is nothing."""
    wall = Surface("wall", Quad((-9, -9, -2), (18, 0, 0), (0, 9, 0)), GREY, AreaLight((1.0, 1.0, 1.0)))
    camera = Pinhole((0, 0, 1), (0, 0, 0), (0, 1, 0), 90, 21, 21)
    found = opengl.first_hits(Scene((wall,), camera)).reshape(5, 21, 21)
    np.testing.assert_allclose(found[0, 11, 10], math.hypot(3, 3 * 1 / 10.5), rtol=1e-5)
    np.testing.assert_allclose(found[0, 20, 0], 3 * math.sqrt(1 + 2 * (10 / 10.5) ** 2), rtol=1e-5)
    assert np.isinf(found[0, :10]).all()
    assert (found[4, :10] == -1).all()
    assert (found[4, 11:] == 0).all()
    assert not found[1:4].any()


@pytest.mark.parametrize("stage", ["room", "lights", "metal"])
def test_the_scenes_of_relations(opengl: OpenGL, stage: str) -> None:
    assert told(STAGES[stage](), opengl).verdict == "pass"


@pytest.mark.parametrize("name", library.CASES)
def test_every_scene_of_the_library(opengl: OpenGL, name: str) -> None:
    scene = library.case(name).scene
    if scene.shape[:2] != (1, 1):
        scene = scene.resized(12, 12)
    assert told(scene, opengl).verdict == "pass"


@pytest.mark.parametrize(
    "sensor",
    [
        ThinLens((0.3, 0.5, 4.0), (0.1, -0.2, 0.0), (0.3, 1.0, 0.1), 55, 9, 14, 0.4, 3.0),
        Pinhole((0.3, 0.5, 4.0), (0.1, -0.2, 0.0), (0.3, 1.0, 0.1), 140, 9, 14),
        RadianceMeter((0.3, 0.5, 4.0), (-0.3, 0.1, -1.0)),
    ],
    ids=["thin lens", "wide angle", "one ray"],
)
def test_other_sensors(opengl: OpenGL, sensor: Sensor) -> None:
    assert told(everything(sensor), opengl).verdict == "pass"


def test_near_and_far_in_one_image(opengl: OpenGL) -> None:
    """A pin at a thousandth of the distance of the wall, and more beside it: no one depth buffer holds both."""
    surfaces = [
        Surface("wall", Quad((-90, -90, -40), (180, 0, 9), (0, 180, 0)), GREY, AreaLight((1.0, 1.0, 1.0)))
    ]
    for k, depth in enumerate((0.01, 0.1, 1.0, 10.0)):
        tall = 0.15 * depth
        edge, up = (tall, 0.0, 0.02 * depth), (0.0, tall, 0.0)
        surfaces.append(Surface(f"at {depth}", Quad(((k - 2) * 0.2 * depth, 0, -depth), edge, up), GREY))
    scene = Scene(tuple(surfaces), Pinhole((0, 0, 0), (0, 0, -1), (0, 1, 0), 60, 48, 48))
    assert set(first_hits(scene).surface) == set(range(5))
    assert told(scene, opengl).verdict == "pass"


FAULTS = {
    "LargerAxis": "another",
    "WorldsUp": "another",
    "UpsideDown": "another",
    "Mirrored": "another",
    "TenthOfAPixel": "another",
    "ScaledUnits": "another distance",
    "NoBacks": "another surface",
    "AlongTheView": "another distance",
    "PerspectiveDepth": "another distance",
}


@pytest.mark.parametrize("fault", ["Right", *FAULTS])
def test_a_planted_fault_is_caught(planted: Callable[[str], OpenGL], fault: str) -> None:
    found = told(everything(PARALLEL if fault == "PerspectiveDepth" else PERSPECTIVE), planted(fault))
    assert found.verdict == ("fail" if fault in FAULTS else "pass"), found.message
    assert FAULTS.get(fault, "agree") in found.message


# ---- bounce 0

SEEN = (
    "cornell-box",
    "concentric-spheres",
    "two-mirrors",
    "furnace-convex",
    "facing-squares",
    "cornell-box-spectral",
)
"""Cases of which the sensor sees a lamp: rectangles, disks, spheres, a sky; in three channels and in many."""


@pytest.mark.parametrize("name", SEEN)
def test_what_is_emitted(opengl: OpenGL, name: str) -> None:
    """Within a third of the case's tolerance, of the image and of each tile, where nothing is random."""
    case = library.case(name)
    exact, E = case.answer.truth(case.scene, 0).mean[0], opengl.E(case.scene)
    regions = Regions.of(*case.scene.shape[:2], case.tiles)
    right, found = regions.means(exact[None]), regions.means(E[None])
    assert right[0].any()
    bias = (np.abs(found - right) / denominators(right))[:, 0]
    assert bias[0].max() <= case.tolerance.of_image(0) / 3
    assert bias[1:].max() <= case.tolerance.of_tile(0) / 3


def test_sides_rows_columns_and_channels(opengl: OpenGL) -> None:
    """Lamps that cover whole pixels, by hand; one is turned away, and hides half of another."""

    def lamp(
        name: str, radiance: tuple[float, ...], x: tuple[float, float], y: tuple[float, float], z: float
    ) -> Surface:
        # pixels are 0.25 wide at z = 0, and as much smaller as they are nearer to the camera at z = 1
        shape = Quad((x[0], y[0], z), (x[1] - x[0], 0, 0), (0, y[1] - y[0], 0))
        return Surface(name, shape, GREY, AreaLight(radiance))

    scene = Scene(
        (
            lamp("above right", (1.0, 2.0, 4.0), (0.25, 1.0), (0.5, 1.0), 0.0),
            lamp("below left", (16.0, 8.0, 0.5), (-1.25, -1.0), (-1.0, -0.75), 0.0),
            lamp("turned away", (64.0, 64.0, 64.0), (0.0, -0.5), (0.0, 0.25), 0.0),
            lamp("half behind that", (32.0, 16.0, 64.0), (-0.75, 0.0), (0.0, 0.75), -0.5),
        ),
        Pinhole((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 90.0, 10, 8),
    )
    known = np.zeros((8, 10, 3))
    known[0:2, 6:9] = 1.0, 2.0, 4.0
    known[7, 0] = 16.0, 8.0, 0.5
    known[2, 3:5] = 32.0, 16.0, 64.0  # and row 3 is black: the back of a lamp covers it
    np.testing.assert_allclose(opengl.E(scene), known, rtol=1e-12)


def test_one_pixel_is_a_mean_and_one_ray_is_not(opengl: OpenGL) -> None:
    """A lamp right of x = 0.1, at distance 1 from a pixel that is 1 wide there: 40 %, all or nothing."""
    lamp = Surface("lamp", Quad((0.1, -5, 0), (9, 0, 0), (0, 9, 0)), GREY, AreaLight((1.0, 2.0, 4.0)))
    pixel = Pinhole((0, 0, 1), (0, 0, 0), (0, 1, 0), 2 * math.degrees(math.atan(0.5)), 1, 1)
    np.testing.assert_allclose(opengl.E(Scene((lamp,), pixel)), [[(0.4, 0.8, 1.6)]], rtol=1 / 400)
    for x, seen in ((0.11, 1), (0.09, 0)):
        ray = RadianceMeter((x, 0, 1), (0, 0, -1))
        np.testing.assert_allclose(opengl.E(Scene((lamp,), ray)), [[(seen, 2 * seen, 4 * seen)]], rtol=1e-12)


def test_a_back_emits_where_it_is_said_to(opengl: OpenGL, planted: Callable[[str], OpenGL]) -> None:
    scene = everything(PERSPECTIVE)
    hits = first_hits(scene).surface.reshape(9, 14)
    E, wrong = opengl.E(scene), planted("BothSidesEmit").E(scene)
    row, column = np.argwhere(hits == 4)[len(np.argwhere(hits == 4)) // 2]  # turned away
    assert not E[row, column].any()
    assert wrong[row, column].any()
    assert (E[hits == 5, 0] > 1).all()  # emits on both sides; no pixel has nothing else in it


@pytest.mark.parametrize("angle", np.radians([0.0, 90.0, 17.0, 45.0, 70.0]))
@pytest.mark.parametrize(("count", "along", "across"), [(64, 1 / 1024, 0.008), (16, 1 / 256, 0.016)])
def test_how_well_an_edge_is_averaged(angle: float, count: int, along: float, across: float) -> None:
    """Half a plane over a pixel, in many places: the share of points in it, and its area by many more points."""
    cells = (np.mgrid[:8, :8].reshape(2, 1, -1) + 0.5) / 8
    points = cells + np.array(list(_shifts(count))).T[:, :, None] / 8
    many = (np.mgrid[:1000, :1000].reshape(2, -1) + 0.5) / 1000
    normal, offsets = np.array([math.cos(angle), math.sin(angle)]), np.linspace(-0.1, 1.5, 97)
    share, area = (
        np.searchsorted(np.sort(normal @ p), offsets) / p.shape[1] for p in (points.reshape(2, -1), many)
    )
    limit = along if angle in (0.0, math.pi / 2) else across
    assert np.abs(share - area).max() <= limit + 1e-3  # of the many points


def test_the_verdict_is_about_bounce_0_alone(compare: Callable[..., Comparison]) -> None:
    found = compare("cornell-box", "pyrender", budget=2.0)
    assert [b.bounce for b in found.bounces] == [0]
    assert found.bounces[0].verdict == "pass"
    assert found.totals == []
    assert any("unsupported: the renderer stops at bounce 0" in note for note in found.notes)


def test_what_it_can_t_witness(opengl: OpenGL) -> None:
    wall = Surface("wall", Quad((-2, -2, -2), (4, 0, 0), (0, 4, 0)), GREY)
    camera = Pinhole((0, 0, 1), (0, 0, 0), (0, 1, 0), 60, 4, 4)
    light = PointLight((0, 3, 3), (1.0, 1.0, 1.0))
    zone = AreaLight((1.0, 1.0, 1.0), polar_range=PolarRange(0, 40))
    profile = AreaLight((1.0, 1.0, 1.0), angular_profile=((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))
    lens = ThinLens((0, 0, 1), (0, 0, 0), (0, 1, 0), 60, 4, 4, 0.1, 2.0)
    refused = {
        "polar_range": Scene((Surface("cap", Sphere((0, 0, -3), 1.0), GREY, zone),), camera),
        "angular_profile": Scene((Surface("lamp", wall.shape, GREY, profile),), camera),
        "thin_lens": Scene((wall,), lens, (light,)),
        "irradiance_meter": Scene((wall,), IrradianceMeter((0, 0, 0), (0, 0, -1)), (light,)),
        "environment_map": library.case("bright-texel").scene.resized(4, 4),
        "spherical_harmonics": library.case("harmonics-on-sphere").scene.resized(4, 4),
    }
    for feature, scene in refused.items():
        with pytest.raises(Unsupported, match=feature):
            opengl.E(scene)
    with pytest.raises(Unsupported, match="bounce 1: "):
        opengl.process.render(Scene((wall,), camera, (light,)), [0, 1], 1, 0, timeout=60)
    with pytest.raises(Unsupported, match="sphere ball so near the sensor"):
        opengl.first_hits(Scene((Surface("ball", Sphere((0, 0, 0), 1 - 1e-6), GREY),), camera, (light,)))


def test_nothing_but_a_sky(opengl: OpenGL) -> None:
    camera = Pinhole((0, 0, 1), (0, 0, 0), (0, 1, 0), 60, 3, 2)
    scene = Scene((), camera, (ConstantEnvironment((1.0, 0.5, 0.25)),))
    np.testing.assert_allclose(opengl.E(scene), np.tile((1.0, 0.5, 0.25), (2, 3, 1)), rtol=1e-12)
    assert (opengl.first_hits(scene)[4] == -1).all()


# ---- shapes as triangles


@pytest.mark.parametrize("cells", [1, 2, 5, 32])
def test_how_far_a_sphere_of_triangles_is_off(cells: int) -> None:
    """The least and the largest distance of its points; closed, and its fronts are outside."""
    points, indices = sphere(cells)
    weights = np.random.default_rng(3).dirichlet((1, 1, 1), size=200)
    inside = np.linalg.norm(np.einsum("wk,tki->wti", weights, points[indices]), axis=-1)
    bound = math.pi**2 / 32 / cells**2
    assert np.abs(np.linalg.norm(points, axis=1) - 1).max() <= bound * (1 + 1e-9)
    if cells >= 32:  # the bound is that of fine ones
        assert (1 - inside).max() <= bound
    a, b, c = points[indices].transpose(1, 0, 2)
    assert (np.einsum("ti,ti->t", np.cross(b - a, c - a), a + b + c) > 0).all()
    edges = np.concatenate([indices[:, [0, 1]], indices[:, [1, 2]], indices[:, [2, 0]]])
    assert {tuple(e) for e in edges.tolist()} == {tuple(e[::-1]) for e in edges.tolist()}
    assert len(np.unique(edges, axis=0)) == len(edges)


def test_a_disk_keeps_its_area() -> None:
    surface = Surface("disk", Disk((1, 2, 3), (2, 0, 0.5), (0.3, 1, 0)), GREY)
    corners, indices = triangles(surface, View.of(PERSPECTIVE))
    a, b, c = corners[indices].transpose(1, 0, 2)
    across = np.cross(b - a, c - a)
    assert len(indices) == CORNERS_OF_DISK
    np.testing.assert_allclose(np.linalg.norm(across, axis=1).sum() / 2, surface.shape.area, rtol=1e-9)  # type: ignore[union-attr]
    assert (across @ surface.shape.normal > 0).all()  # type: ignore[union-attr]
