"""Each fault of the sensor changes the image as it says, and leaves the tracer as it was."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from comparisons.faults import sensor
from comparisons.faults.fault import Fault
from comparisons.renderers import Renderer, create
from comparisons.renderers.protocol import SeesFirstHits
from scenes import Pinhole, Scene, ThinLens, library

Array = NDArray[np.float64]

BY_NAME = {fault.name: fault for fault in sensor.FAULTS}
BOUNCES = range(4)
OTHER_CASES = {
    "angle-of-the-other-axis": "cie-171-panel",
    "clamped-at-10": "cie-171-sphere",
    "fireflies-clamped": "cie-171-sphere",
    "aperture-by-diameter": "a thin lens",
}
FIRST_CHANGED = {"angle-of-the-other-axis": 1, "clamped-at-10": 1, "fireflies-clamped": 1}
"""Bounce 0 is black there."""
ONLY_THE_LAMP = ("clamped-at-1",)
BESIDE_THE_LAMP = ("hot-pixel", "black-column")


def with_a_lens(scene: Scene, radius: float) -> Scene:
    camera = scene.sensor
    assert isinstance(camera, Pinhole)
    distance = float(np.linalg.norm(np.subtract(camera.target, camera.origin)))
    fields = {field: getattr(camera, field) for field in camera.__struct_fields__}
    return msgspec.structs.replace(
        scene, sensor=ThinLens(**fields, aperture_radius=radius, focus_distance=distance / 2)
    )


def scene_of(name: str) -> Scene:
    case = OTHER_CASES.get(name, "cornell-box")
    if case == "a thin lens":
        return with_a_lens(library.case("cornell-box").scene.resized(8, 8), 0.2)
    return library.case(case).scene.resized(8, 12 if case == "cie-171-panel" else 8)


def image_of(renderer: Renderer, scene: Scene, spp: int = 16) -> Array:
    return renderer.render(scene, BOUNCES, spp, 1)


def both(name: str) -> tuple[Array, Array]:
    """The right image and the wrong one."""
    plain, scene = create("reference"), scene_of(name)
    return image_of(plain, scene), image_of(BY_NAME[name].plant(plain), scene)


@pytest.mark.parametrize("fault", sensor.FAULTS, ids=lambda fault: fault.name)
def test_it_changes_the_image_in_every_bounce_that_shows_it(fault: Fault) -> None:
    right, wrong = both(fault.name)
    claimed = list(BOUNCES)[FIRST_CHANGED.get(fault.name, 0) :]
    if fault.name in ONLY_THE_LAMP:
        claimed = [0]
    if fault.name in BESIDE_THE_LAMP:
        claimed = [1, 2, 3]
    assert [k for k in BOUNCES if not np.array_equal(right[k], wrong[k])] == claimed


@pytest.mark.parametrize("fault", sensor.FAULTS, ids=lambda fault: fault.name)
def test_the_tracer_is_left_as_it_was(fault: Fault) -> None:
    plain, scene = create("reference"), scene_of(fault.name)
    before, planted = image_of(plain, scene), fault.plant(plain)
    image_of(planted, scene)
    np.testing.assert_array_equal(image_of(plain, scene), before)
    with pytest.raises(ValueError, match="spp"):
        image_of(planted, scene, spp=0)
    np.testing.assert_array_equal(image_of(plain, scene), before)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("image-one-row-low", lambda right: right[:, [0, 0, 1, 2, 3, 4, 5, 6]]),
        ("image-upside-down", lambda right: right[:, [7, 6, 5, 4, 3, 2, 1, 0]]),
        ("image-mirrored", lambda right: right[:, :, [7, 6, 5, 4, 3, 2, 1, 0]]),
        ("channels-swapped", lambda right: right[..., [2, 1, 0]]),
        ("clamped-at-1", lambda right: right.clip(max=1)),
        ("clamped-at-10", lambda right: right.clip(max=10)),
        ("exposure-too-high", lambda right: right * 1.007),
        ("one-sample-too-many", lambda right: right * 16 / 17),
    ],
)
def test_what_becomes_of_the_image(name: str, expected: Callable[[Array], Array]) -> None:
    right, wrong = both(name)
    np.testing.assert_allclose(wrong, expected(right), rtol=1e-12)


def test_srgb_by_its_inverse() -> None:
    right, wrong = both("srgb-applied")
    linear = np.where(wrong <= 0.04045, wrong / 12.92, ((wrong + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(linear, right, rtol=1e-4, atol=1e-6)


def test_a_filter_and_a_median_leave_an_even_image_as_it_is() -> None:
    scene = library.case("furnace-box").scene.resized(8, 8)
    for name in ("wide-filter", "denoised"):
        image = image_of(BY_NAME[name].plant(create("reference:bsdf")), scene)
        np.testing.assert_allclose(
            image, np.reshape([1, 1 / 2, 1 / 4, 1 / 8], (4, 1, 1, 1)) * np.ones((8, 8, 3))
        )


def test_vignetting_by_the_angle_of_view() -> None:
    """A furnace shows the cos⁴ itself: 1 in the middle, (1 + 2 tan² of half the angle)⁻² towards a corner."""
    scene = library.case("furnace-box").scene.resized(63, 63)
    image = BY_NAME["vignetting"].plant(create("reference:bsdf")).render(scene, [0], 1, 1)[0, ..., 0]
    tangent = np.tan(np.radians(scene.sensor.fov / 2)) * 62 / 63
    assert image[31, 31] == pytest.approx(1)
    assert image[0, 0] == pytest.approx((1 + 2 * tangent**2) ** -2)


@pytest.mark.parametrize(
    ("case", "size", "factor"), [("quad-over-plane", (8, 8), 1), ("cie-171-panel", (8, 12), 2 / 3)]
)
def test_the_extent_of_the_other_axis(case: str, size: tuple[int, int], factor: float) -> None:
    scene = library.case(case).scene.resized(*size)
    narrower = scene
    if factor != 1:
        narrower = msgspec.structs.replace(
            scene, sensor=msgspec.structs.replace(scene.sensor, extent=factor * scene.sensor.extent)
        )
    planted = BY_NAME["angle-of-the-other-axis"].plant(create("reference"))
    np.testing.assert_allclose(image_of(planted, scene), image_of(create("reference"), narrower), rtol=1e-9)


def test_a_view_that_is_too_wide() -> None:
    """The centres of the outermost of 9 pixels lie where the edges should be: 9/8 of the tangent."""
    scene = library.case("furnace-sphere").scene.resized(9, 9)
    half = np.degrees(np.arctan(9 / 8 * np.tan(np.radians(scene.sensor.fov) / 2)))
    wider = msgspec.structs.replace(scene, sensor=msgspec.structs.replace(scene.sensor, fov=2 * half))
    planted = BY_NAME["view-too-wide"].plant(create("reference"))
    np.testing.assert_allclose(image_of(planted, scene), image_of(create("reference"), wider), rtol=1e-9)


def test_half_a_pixel_is_seen_in_what_rays_hit_first() -> None:
    """Half a pixel up and to the left: pixel (0, 0) of 8 looks through the corner, pixel (4, 4) along the view."""
    scene = library.case("furnace-sphere").scene
    planted, plain = BY_NAME["half-a-pixel-off"].plant(create("reference")), create("reference")
    assert isinstance(planted, SeesFirstHits)
    assert isinstance(plain, SeesFirstHits)
    moved = planted.first_hits(scene.resized(8, 8)).reshape(5, 8, 8)
    middle = plain.first_hits(scene.resized(9, 9)).reshape(5, 9, 9)[:, 4, 4]
    np.testing.assert_allclose(moved[:, 4, 4], middle, atol=1e-12)


def test_a_thin_lens_of_twice_the_radius() -> None:
    scene = library.case("cornell-box").scene.resized(8, 8)
    planted = BY_NAME["aperture-by-diameter"].plant(create("reference"))
    np.testing.assert_array_equal(
        image_of(planted, with_a_lens(scene, 0.2)), image_of(create("reference"), with_a_lens(scene, 0.4))
    )


def test_one_pixel_and_one_column() -> None:
    right, hot = both("hot-pixel")
    _, black = both("black-column")
    hot[:, 2, 2] /= 10
    np.testing.assert_allclose(hot, right)
    assert not black[:, :, 2].any()
    np.testing.assert_array_equal(np.delete(black, 2, axis=2), np.delete(right, 2, axis=2))
