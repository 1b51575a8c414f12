"""Each held-out fault changes the bounces it says, and those with a closed form by as much as that."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from comparisons.faults import FAULTS, Fault, held_out
from comparisons.faults.held_out import microfacets, propagation
from comparisons.renderers import create
from reference_tracer.bsdfs import microfacet
from scenes import Disk, Mesh, library

Array = NDArray[np.float64]

CASES = {
    "harmonics-with-condon-shortley": ("harmonics-on-sphere", [1]),
    "environment-first-column-on-the-last": ("snells-window", [1]),
    "environment-without-ground": ("furnace-convex", [0, 1]),
    "point-lights-softened": ("point-in-sphere", [1, 2, 3]),
    "spot-beam-for-its-margin": ("spot-falloff", [1]),
    "lamp-profile-by-the-angle": ("constant-radiance-mirror", [0, 1, 2, 3]),
    "spheres-open-from-inside": ("furnace-sphere", [0, 1, 2, 3]),
    "disks-of-24-facets": ("moved-disk", [1]),
    "hierarchy-boxes-rounded": ("hundred-tiles", [1]),
    "lamps-cast-no-shadow": ("furnace-cornell", [1, 2, 3]),
    "shadow-rays-pass-fronts": ("screened-lamp", [1]),
    "own-surface-skipped": ("integrating-sphere", [1, 2, 3]),
    "rays-end-at-1000": ("furnace-huge", [0, 1, 2, 3]),
    "shading-normals-not-normalised": ("shading-normals-from-behind", [1]),
    "diffuse-of-disney": ("furnace-sphere", [1, 2, 3]),
    "diffuse-into-the-ball": ("integrating-sphere", [1, 2, 3]),
    "metal-as-at-normal-incidence": ("metal-angles", [1]),
    "glass-weighed-twice": ("lamp-under-water", [1]),
    "glass-always-from-outside": ("glass-ball", [2, 3]),
    "blend-weighed-twice": ("blend-sky", [1]),
    "texture-pixel-rounded": ("printed-board", [1]),
    "facets-of-beckmann": ("rough-metal-sky", [1]),
    "shadowing-of-an-engine": ("rough-metal-sun", [1]),
    "fresnel-by-the-tilt": ("rough-metal-sky", [1]),
    "refracting-facet-by-the-inverse": ("rough-glass-tank", [1]),
    "mirrors-not-counted": ("constant-radiance-mirror", [0, 1, 2, 3]),
    "roulette-reweighted-twice": ("furnace-sphere", [3]),
    "faint-walks-ended": ("furnace-sphere", [5]),
    "two-specular-bounces": ("constant-radiance-mirror", [3]),
    "throughput-in-sixteen-bits": ("constant-radiance-mirror", [1, 2, 3]),
    "weight-by-the-reverse-density": ("quad-over-plane", [1]),
    "last-emitter-never-chosen": ("four-points", [1]),
    "environment-directions-by-the-angle": ("furnace-convex", [1]),
    "cone-of-the-tangent": ("sphere-over-plane", [1]),
    "triangle-without-root": ("triangle-over-plane", [1]),
    "disk-without-root": ("moved-disk", [1]),
    "extent-for-half-of-it": ("cie-171-panel", [1]),
    "camera-never-rolled": ("bright-texel", [1]),
    "filter-dark-at-borders": ("furnace-sphere", [0, 1, 2, 3]),
    "tile-seams-added-twice": ("furnace-sphere", [0, 1, 2, 3]),
    "columns-for-rows": ("quad-over-plane", [1]),
    "primaries-of-acescg": ("quad-over-plane", [1]),
    "numbers-run-out": ("furnace-sphere", [4, 5]),
    "choice-and-place-by-one-number": ("furnace-channels", [1, 2, 3]),
}
"""A case that shows the fault, and the bounces that it changes there, up to the last one that is looked at."""

LAST = {"faint-walks-ended": 5, "numbers-run-out": 5}
"""Where it is not the third."""

SIZE = {"tile-seams-added-twice": 40}
"""Pixels along each side of the image, where 8 do not show it."""


def image_of(name: str, case: str, last: int, spp: int = 4, size: tuple[int, int] = (8, 8)) -> Array:
    """By chance alone: no next event."""
    planted = FAULTS[name].plant(create("reference:bsdf"))
    return planted.render(library.case(case).scene.resized(*size), range(last + 1), spp, 1)


@pytest.mark.parametrize("fault", held_out.FAULTS, ids=lambda fault: fault.name)
def test_changes_what_it_says(fault: Fault, changed: Callable[..., list[int]]) -> None:
    name, bounces = CASES[fault.name]
    case, size = library.case(name), SIZE.get(fault.name, 8)
    last = min(case.bounces, LAST.get(fault.name, 3))
    assert changed(fault, case.scene.resized(size, size), last) == bounces


def test_they_are_of_the_catalogue_and_of_every_operator() -> None:
    assert len({fault.name for fault in held_out.FAULTS}) == len(held_out.FAULTS)
    assert all(FAULTS[fault.name] is fault for fault in held_out.FAULTS)
    of = Counter(fault.operator for fault in held_out.FAULTS)
    assert set(of) == {fault.operator for fault in FAULTS.values()}
    assert min(of.values()) >= 2


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("faint-walks-ended", [1, 1 / 2, 1 / 4, 1 / 8, 1 / 16, 0]),
        (
            "throughput-in-sixteen-bits",
            [1, 1 / 2, 1 / 4, 1 / 8, 1 / 16, 1 / 32],
        ),  # powers of two have no digits
    ],
)
def test_what_becomes_of_a_furnace(name: str, expected: list[float]) -> None:
    """Emission 1 and albedo 1/2: found by chance, every walk is worth exactly TᵏE = 1/2ᵏ."""
    images = image_of(name, "furnace-box", last=5, spp=1)
    np.testing.assert_allclose(images, np.reshape(expected, (-1, 1, 1, 1)) * np.ones_like(images), rtol=1e-12)


def test_albedos_of_sixteen_bits() -> None:
    """0.9 is 230.4 / 256, and 0.2 is 204.8 / 256 of 1/4; 0.5 is itself."""
    _, found = image_of("throughput-in-sixteen-bits", "furnace-channels", last=1, spp=1)
    expected = np.array([230 / 256, 1 / 2, 204 / 1024]) * [1, 2, 0.5]
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), rtol=1e-12)


def test_roulette_that_reweights_twice_doubles_every_late_bounce() -> None:
    """Walks go on with the probability 1/2, for 4 times as much: of 16384, bounce 5 has 2048, ± 11 % at most."""
    found = image_of("roulette-reweighted-twice", "furnace-box", last=5, spp=256).mean(axis=(1, 2, 3))
    np.testing.assert_allclose(found * 2.0 ** np.arange(6), [1, 1, 1, 2, 4, 8], rtol=0.15)


def test_mirrors_that_do_not_count_show_everything_at_once() -> None:
    """Six bounces more than the one that was asked for are walked, and all of them are E."""
    right = create("reference:bsdf").render(
        library.case("constant-radiance-mirror").scene.resized(8, 8), range(8), 4, 1
    )
    found = image_of("mirrors-not-counted", "constant-radiance-mirror", last=1)
    np.testing.assert_allclose(found[0], right.sum(axis=0), rtol=1e-9)
    assert not found[1].any()


def test_no_more_than_two_specular_bounces() -> None:
    found = image_of("two-specular-bounces", "constant-radiance-mirror", last=4)
    assert [bool(image.any()) for image in found] == [True, True, True, False, False]


def test_a_filter_that_takes_what_is_beyond_the_border_for_black() -> None:
    [image] = image_of("filter-dark-at-borders", "furnace-box", last=0, size=(7, 5))
    across, down = ([3 / 4, *(n - 2) * [1], 3 / 4] for n in (image.shape[1], image.shape[0]))
    np.testing.assert_allclose(image[..., 0], np.outer(down, across))


def test_seams_of_tiles() -> None:
    """Row and column 31 alone are the last of a tile that has a neighbour."""
    [image] = image_of("tile-seams-added-twice", "furnace-box", last=0, spp=1, size=(40, 64))
    down, across = np.ones(64), np.ones(40)
    down[31] = across[31] = 2
    np.testing.assert_allclose(image[..., 0], np.outer(down, across))


def test_columns_for_rows() -> None:
    scene = library.case("cornell-box").scene.resized(4, 6)
    request = (scene, [0], 16, 1)
    right, plain = create("reference"), create("reference").render(*request)
    found = FAULTS["columns-for-rows"].plant(right).render(*request)
    assert found.shape == plain.shape
    for channel in range(3):
        np.testing.assert_array_equal(found[0, ..., channel].ravel(), plain[0, ..., channel].ravel(order="F"))


def test_grey_stays_grey_in_other_primaries() -> None:
    np.testing.assert_allclose(image_of("primaries-of-acescg", "furnace-box", last=0), 1, rtol=1e-5)


def test_the_area_of_a_disk_of_24_facets() -> None:
    """24 triangles with the angle 15° at the centre: 12 sin 15° for π."""
    surface = next(s for s in library.case("moved-disk").scene.surfaces if isinstance(s.shape, Disk))
    polygon = propagation._polygon(surface).shape
    assert isinstance(polygon, Mesh)
    assert polygon.area == pytest.approx(surface.shape.area * 12 * np.sin(np.radians(15)) / np.pi)
    assert np.cross(*np.diff(polygon.corners[0], axis=0)) @ surface.shape.normal > 0


def test_facets_of_beckmann_have_the_projected_area_one() -> None:
    """2π ∫ D cos θ d(cos θ) = 1, by quadrature."""
    z, weights = np.polynomial.legendre.leggauss(400)
    cosine = (z + 1) / 2
    density = microfacets._beckmann(microfacet.D)(cosine, np.full_like(cosine, 0.4))
    area = np.pi * weights @ (density * cosine)
    assert area == pytest.approx(1, rel=1e-9)
