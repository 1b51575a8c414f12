"""Open scenes: light that is not uniform, shadows, backs, and rays that leave."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from reference_tracer import sampling
from reference_tracer.bsdfs.bsdf import BSDFSample
from reference_tracer.points import Points
from reference_tracer.random_walk import STRATEGIES, RandomWalk, Strategy, render
from reference_tracer.reflection import LambertianBSDF
from scenes import AreaLight, Lambertian, Pinhole, Quad, Scene, Sphere, Surface
from scenes.library import case

BLACK, RED = Lambertian((0.0, 0.0)), Lambertian((0.8, 0.2))
FLOOR = Surface("floor", Quad((-2.0, -2.0, 0.0), (4.0, 0.0, 0.0), (0.0, 4.0, 0.0)), RED)
# off the middle and tilted, so that no symmetry hides a cosine or an axis
LAMP = Surface("lamp", Quad((0.2, -0.3, 1.0), (0.1, 0.9, 0.2), (0.7, 0.0, 0.1)), BLACK, AreaLight((3.0, 5.0)))
CAMERA = Pinhole((0.0, -4.0, 3.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 14.0, 8, 8)  # sees the floor alone

strategies = pytest.mark.parametrize("strategy", STRATEGIES)


def direct_light(width: int, height: int) -> np.ndarray:
    """TE on the floor by quadrature over lamp and pixels, written out: the mean over each quarter, per channel."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    nodes, weights = (nodes + 1) / 2, weights / 2
    s, t = (grid.ravel() for grid in np.meshgrid(nodes, nodes))
    share = np.outer(weights, weights).ravel()
    quad = LAMP.shape
    y = np.array(quad.corner) + np.outer(s, quad.edge_u) + np.outer(t, quad.edge_v)
    columns, rows = np.meshgrid(width * nodes, height * nodes)
    # each quarter has its own quadrature over the image plane
    image = np.zeros((2, 2, 2))
    for i, j in np.ndindex(2, 2):
        x_image, y_image = (columns + j * width) / 2, (rows + i * height) / 2
        d = np.stack([x_image, y_image, np.ones_like(x_image)], axis=-1) @ CAMERA.pixel_to_direction.T
        x = np.array(CAMERA.origin) - d * (CAMERA.origin[2] / d[..., 2:])
        segment = y - x[..., None, :]
        squared = (segment**2).sum(axis=-1)
        cosines = segment[..., 2] * np.maximum(-(segment @ quad.normal), 0)
        irradiance = (cosines / squared**2) @ share * quad.area
        mean = (irradiance * np.outer(weights, weights)).sum()
        image[i, j] = mean / np.pi * np.array(RED.albedo) * np.array(LAMP.emission.radiance)
    return image


def quarters(image: np.ndarray) -> np.ndarray:
    height, width, channels = image.shape
    return image.reshape(2, height // 2, 2, width // 2, channels).mean(axis=(1, 3))


def replicates(strategy: Strategy, spp: int) -> np.ndarray:
    scene = Scene((FLOOR, LAMP), CAMERA)
    return np.array([quarters(render(scene, 1, spp, seed, strategy)[1]) for seed in range(24)])


SAMPLES = {"bsdf": (512, 0.15), "nee": (256, 0.03), "mis": (256, 0.03)}


@strategies
def test_direct_light(strategy: Strategy, expect_means: Callable[..., None]) -> None:
    spp, resolution = SAMPLES[strategy]
    expect_means(replicates(strategy, spp), direct_light(8, 8), resolution)


@pytest.mark.parametrize(
    "fault", ["cosine at the floor left out", "lobe uniform, density that of the cosine"]
)
def test_planted_faults_are_found(
    fault: str, expect_means: Callable[..., None], off: type[Exception], monkeypatch: pytest.MonkeyPatch
) -> None:
    def sample(self: LambertianBSDF, points: Points, wo: np.ndarray, u: np.ndarray) -> BSDFSample:
        right = lambertian(self, points, wo, u)
        uniform = sampling.to_world(sampling.square_to_cone(u, 1.0), points.n)
        pdf = np.einsum("in,in->n", uniform, points.n) / np.pi
        return BSDFSample(uniform, right.weight, pdf)

    def without_cosine(self: RandomWalk, vertex: Points, wo: np.ndarray, u: np.ndarray) -> np.ndarray:
        flat = Points(vertex.x, np.tile([[0.6], [0.0], [0.8]], len(vertex)), vertex.surface)
        return next_event(self, flat, wo, u)

    lambertian = LambertianBSDF.sample
    next_event = RandomWalk._next_event
    if fault.startswith("lobe"):
        strategy: Strategy = "mis"
        monkeypatch.setattr(LambertianBSDF, "sample", sample)
    else:
        strategy = "nee"
        monkeypatch.setattr(RandomWalk, "_next_event", without_cosine)
    with pytest.raises(off):
        expect_means(replicates(strategy, 128), direct_light(8, 8), resolution=0.05)


# ---- what must be dark is exactly dark


@strategies
def test_a_shadow_is_dark_also_behind_a_back(strategy: Strategy) -> None:
    """A blocker just under the lamp, larger than it: floor and lamp don't see each other, on either side up."""
    for turned in (False, True):
        edges = ((6.0, 0.0, 0.0), (0.0, 6.0, 0.0))
        shape = Quad((-3.0, -3.0, 0.5), *(edges[::-1] if turned else edges))
        camera = msgspec.structs.replace(CAMERA, origin=(0.0, -1.0, 0.4), target=(0.0, 0.0, 0.0), fov=20.0)
        image = render(Scene((FLOOR, LAMP, Surface("blocker", shape, BLACK)), camera), 2, 32, 0, strategy)
        assert not image.any()


@strategies
def test_from_behind_everything_is_black(strategy: Strategy) -> None:
    behind = msgspec.structs.replace(
        CAMERA, origin=(0.1, 0.2, -2.0), target=(0.0, 0.0, 0.0), up=(0.0, 1.0, 0.0)
    )
    assert not render(Scene((FLOOR, LAMP), behind), 2, 16, 0, strategy).any()


@strategies
def test_the_inside_of_a_sphere_gives_no_light_through_its_back(strategy: Strategy) -> None:
    cavity = Surface("cavity", Sphere((0.0, 0.0, 1.0), 0.5, inward=True), RED, AreaLight((1.0, 1.0)))
    assert not render(Scene((FLOOR, cavity), CAMERA), 2, 64, 0, strategy).any()


@strategies
def test_a_ball_lights_the_floor_below_it(strategy: Strategy, expect_means: Callable[..., None]) -> None:
    """Under a ball of radius r at height h the irradiance is πe (r/h)² (all of it above the horizon)."""
    ball = Surface("ball", Sphere((0.0, 0.0, 1.0), 0.5), BLACK, AreaLight((1.0, 4.0)))
    # a camera low and near enough to see the point below the ball and nothing else: 0.004 wide
    camera = Pinhole((0.0, -0.4, 0.3), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.4, 8, 8)
    scene = Scene((FLOOR, ball), camera)
    found = np.array([render(scene, 1, 192, seed, strategy)[1].mean(axis=(0, 1)) for seed in range(24)])
    expected = np.array(RED.albedo) * np.array(ball.emission.radiance) * 0.25
    expect_means(found, expected, resolution=0.04)


@strategies
def test_a_camera_that_sees_nothing(strategy: Strategy) -> None:
    away = msgspec.structs.replace(CAMERA, target=(0.0, -9.0, 3.5))
    shares: list[float] = []
    image = render(Scene((FLOOR, LAMP), away), 3, 4, 0, strategy, on_block=shares.append)
    assert image.shape == (4, 8, 8, 2)
    assert not image.any()
    assert shares[-1] == 1


@strategies
def test_the_open_front_of_the_cornell_box(strategy: Strategy) -> None:
    """Rays that pass beside the box, or leave by its front, add nothing and break nothing."""
    scene = case("cornell-box").scene
    wide = Scene(scene.surfaces, msgspec.structs.replace(scene.sensor, fov=100.0, width=12, height=12))
    image = render(wide, 3, 16, 0, strategy)
    assert np.isfinite(image).all()
    assert (image >= 0).all()
    assert not image[:, 0].any()  # the top row looks past it
    if strategy != "bsdf":  # which finds the lamp too rarely to promise anything
        assert image[1:, 6, 6].min() > 0


@strategies
def test_an_albedo_of_zero_ends_the_series(strategy: Strategy) -> None:
    black = [
        msgspec.structs.replace(s, material=Lambertian((0.0,) * 3))
        for s in case("furnace-box").scene.surfaces
    ]
    image = render(Scene(tuple(black), case("furnace-box").scene.sensor).resized(4, 4), 3, 4, 0, strategy)
    np.testing.assert_array_equal(image[0], 1)
    assert not image[1:].any()
