"""Rays of every sensor, and the film."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from reference_tracer.points import NOWHERE
from reference_tracer.samplers import Block
from reference_tracer.sensing import Film, camera_rays, sensor_dimensions
from scenes import IrradianceMeter, Orthographic, Pinhole, RadianceMeter, Sensor, ThinLens

EYE = {"origin": (1.0, 2.0, 3.0), "target": (0.0, 0.5, -1.0), "up": (0.0, 1.0, 0.2), "width": 9, "height": 6}
PINHOLE = Pinhole(fov=50.0, **EYE)  # type: ignore[arg-type]
LENS = ThinLens(fov=50.0, aperture_radius=0.3, focus_distance=4.0, **EYE)  # type: ignore[arg-type]
ORTHOGRAPHIC = Orthographic(extent=3.0, **EYE)  # type: ignore[arg-type]
N = 2000


def block(seed: int = 1, count: int = N, width: int = 9, height: int = 6) -> Block:
    rng = np.random.default_rng(seed)
    position = rng.random((2, count)) * [[width], [height]]
    return Block(position, lambda d, lanes: rng.random((d, len(lanes))))


@pytest.mark.parametrize(
    ("sensor", "dimensions"),
    [
        (PINHOLE, 0),
        (LENS, 2),
        (ORTHOGRAPHIC, 0),
        (RadianceMeter((0.0, 1.0, 2.0), (0.0, 3.0, 4.0)), 0),
        (IrradianceMeter((0.0, 1.0, 2.0), (0.0, 3.0, 4.0)), 2),
    ],
)
def test_rays_start_in_space_with_unit_directions(sensor: Sensor, dimensions: int) -> None:
    assert sensor_dimensions(sensor) == dimensions
    rays = camera_rays(sensor, block())
    assert (rays.origin.surface == NOWHERE).all()
    np.testing.assert_allclose(np.linalg.norm(rays.d, axis=0), 1, rtol=1e-14)


def projected(sensor: Pinhole | ThinLens, x: np.ndarray) -> np.ndarray:
    """Pixel coordinates of world points through a pinhole, from the definition of ``fov``."""
    right, up, forward = sensor.frame.T @ (x - np.array(sensor.origin)[:, None])
    pixels = min(sensor.width, sensor.height) / 2 / np.tan(np.radians(sensor.fov / 2))
    return np.stack([sensor.width / 2 + pixels * right / forward, sensor.height / 2 - pixels * up / forward])


def test_a_pinhole() -> None:
    a = block()
    rays = camera_rays(PINHOLE, a)
    np.testing.assert_array_equal(rays.origin.x, np.tile([[1.0], [2.0], [3.0]], N))
    np.testing.assert_allclose(projected(PINHOLE, rays.origin.x + 2.5 * rays.d), a.position, atol=1e-12)


def test_a_lens_is_sharp_in_its_plane_of_focus_only() -> None:
    a = block()
    rays = camera_rays(LENS, a)
    forward = LENS.frame[:, 2]
    lens = LENS.frame.T @ (rays.origin.x - np.array(LENS.origin)[:, None])
    np.testing.assert_allclose(lens[2], 0, atol=1e-14)
    radius = np.hypot(lens[0], lens[1]) / 0.3
    assert radius.max() <= 1
    # uniform on the disk: the squared radius is uniform, the angle too
    for value, (low, high) in ((radius**2, (0, 1)), (np.arctan2(lens[1], lens[0]), (-np.pi, np.pi))):
        counts = np.histogram(value, 10, (low, high))[0]
        assert ((counts - N / 10) ** 2 / (N / 10)).sum() < 40  # χ² of 9 degrees of freedom: chance 1e-5
    for distance, sharp in ((4.0, True), (2.0, False)):
        x = rays.origin.x + rays.d * (distance / (forward @ rays.d))
        blur = np.abs(projected(LENS, x) - a.position).max()
        assert blur < 1e-12 if sharp else blur > 0.1


def test_an_orthographic_camera() -> None:
    a = block()
    rays = camera_rays(ORTHOGRAPHIC, a)
    right, up, forward = ORTHOGRAPHIC.frame.T
    np.testing.assert_allclose(rays.d, np.tile(forward[:, None], N), atol=1e-15)
    offset = rays.origin.x - np.array(ORTHOGRAPHIC.origin)[:, None]
    np.testing.assert_allclose(forward @ offset, 0, atol=1e-14)
    # 3 units over the 6 rows
    np.testing.assert_allclose(right @ offset, (a.position[0] - 4.5) / 2, atol=1e-14)
    np.testing.assert_allclose(up @ offset, (3 - a.position[1]) / 2, atol=1e-14)


def test_meters() -> None:
    radiance = camera_rays(RadianceMeter((0.0, 1.0, 2.0), (0.0, 3.0, 4.0)), block(width=1, height=1))
    np.testing.assert_allclose(radiance.d, np.tile([[0.0], [0.6], [0.8]], N), atol=1e-15)
    assert radiance.weight == 1
    irradiance = camera_rays(IrradianceMeter((0.0, 1.0, 2.0), (0.0, 3.0, 4.0)), block(width=1, height=1))
    cosine = np.array([0.0, 0.6, 0.8]) @ irradiance.d
    assert cosine.min() > 0
    # density cos θ / π: cos² θ is uniform, and ∫ cos θ = π
    counts = np.histogram(cosine**2, 10, (0, 1))[0]
    assert ((counts - N / 10) ** 2 / (N / 10)).sum() < 40
    assert irradiance.weight == np.pi
    assert irradiance.origin.x[:, 0].tolist() == [0, 1, 2]


def test_the_film_sums_by_pixel() -> None:
    film, position = Film(1, (2, 3, 2)), np.array([[0.5, 2.9, 0.1, 1.0], [0.0, 1.5, 0.99, 1.0]])
    film.begin(Block(position, lambda d, lanes: np.zeros((d, len(lanes)))))
    assert [film.pixel(lane) for lane in range(4)] == [(0, 0), (1, 2), (0, 0), (1, 1)]
    film.add(0, np.arange(4), np.array([[1.0, 2.0, 3.0, 4.0], [10.0, 20.0, 30.0, 40.0]]))
    film.add(1, np.array([1, 3]), np.array([[5.0, 6.0], [0.0, 7.0]]))
    film.add(1, np.array([3]), np.array([[1.0], [1.0]]))
    image = film.mean(2)
    assert image.shape == (2, 2, 3, 2)
    expected = np.zeros((2, 2, 3, 2))
    expected[0, 0, 0], expected[0, 1, 2], expected[0, 1, 1] = (2, 20), (1, 10), (2, 20)
    expected[1, 1, 2], expected[1, 1, 1] = (2.5, 0), (3.5, 4)
    np.testing.assert_array_equal(image, expected)


def test_meters_have_one_pixel() -> None:
    meter = RadianceMeter((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    assert (meter.width, meter.height) == (1, 1)
    with pytest.raises(ValueError, match="a meter has one pixel"):
        msgspec.structs.replace(meter, width=2)
