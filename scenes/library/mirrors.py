"""Mirrors that reflect the same share at any angle: images stand where the mirrored things would be."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from scenes.case import Case, Formula, Images, Tolerance
from scenes.coverage import cone_coverage, half_space_coverage
from scenes.lights import AreaLight
from scenes.materials import Lambertian, Mirror
from scenes.scene import Scene
from scenes.sensor import Pinhole
from scenes.shapes import Quad, Sphere
from scenes.surfaces import Surface

Array = NDArray[np.float64]

_BLACK = Lambertian((0.0, 0.0, 0.0))
_UP = (0.0, 1.0, 0.0)
_TOLERANCE = Tolerance(image=(0.005,), tile=(0.02,))


def _mirrored(point: Array, mirror: Quad) -> Array:
    n = mirror.normal
    mirrored: Array = point - 2 * ((point - mirror.corner) @ n) * n
    return mirrored


def _images(scene: Scene, bounces: int) -> Images:
    """Lamps seen directly, and mirrored in the first surface."""
    assert isinstance(scene.sensor, Pinhole)
    mirror, *lamps = scene.surfaces
    assert isinstance(mirror.shape, Quad)
    assert isinstance(mirror.material, Mirror)
    images, origin = np.zeros((bounces + 1, *scene.shape)), np.array(scene.sensor.origin)
    spots: list[tuple[Array, float]] = []  # directions and angular radii
    for lamp in lamps:
        assert isinstance(lamp.shape, Sphere)
        assert lamp.emission is not None
        center, e = np.array(lamp.shape.center), np.array(lamp.emission.diffuse_radiance)
        seen = (center, e), (_mirrored(center, mirror.shape), e * mirror.material.reflectance)
        for k, (place, radiance) in enumerate(seen[: bounces + 1]):
            c = place - origin
            # a ray meets the sphere if (d·c)² > (c² − r²) d²
            cone = np.outer(c, c) - (c @ c - lamp.shape.radius**2) * np.eye(3)
            images[k] += cone_coverage(cone, c, scene.sensor)[..., None] * radiance
            spots.append((c / np.linalg.norm(c), math.asin(lamp.shape.radius / np.linalg.norm(c))))
    if any(math.acos(c @ d) < r + s for (c, r), (d, s) in combinations(spots, 2)):
        raise ValueError("one lamp or image hides another: expected them side by side")
    return images


def mirror_lamps() -> Case:
    """Two lamps and their images in a tilted mirror, all in one view."""
    # u and v are orthogonal, and u × v is along (0.2, 0.3, 1)
    mirror = Quad((-4.7, -5.2, 2.5), (10.0, 0.0, -2.0), (-0.6, 10.4, -3.0))
    surfaces = (
        Surface("mirror", mirror, Mirror((0.9, 0.6, 0.3))),
        Surface("left-lamp", Sphere((-0.3, 0.6, 1.4), 0.52), _BLACK, AreaLight((4.0, 1.0, 2.0))),
        Surface("right-lamp", Sphere((1.1, 1.1, 0.8), 0.53), _BLACK, AreaLight((1.0, 5.0, 3.0))),
    )
    return Case(
        name="mirror-lamps",
        family="mirrors",
        title="Two lamps and their images in a tilted mirror: TE = ρ e inside the images, then nothing",
        scene=Scene(surfaces, Pinhole((0.4, -0.3, 5.0), (0.2, 0.1, 0.0), _UP, 42.0, 64, 64)),
        answer=Formula(_images, "law of reflection; a sphere seen through a pinhole is a cone of rays"),
        bounces=2,
        tolerance=_TOLERANCE,
        derivation="""\
A mirror reflects every ray as if it came from the mirrored scene. A lamp at c therefore shows a second time, ρ
times as bright, where the sphere around its image c − 2 ((c − p)·n) n is seen; p is a point of the mirror and n
its normal. Directly seen lamps are E, those in the mirror TE. The lamps are black: T²E = 0. A sphere is seen
under the cone (d·c)² > (c² − r²) d², c from the pinhole, and covers the share of a pixel that lies in an ellipse.""",
        blind_to="reflectance that depends on the angle; orders of reflection beyond the first",
    )


def _strips(scene: Scene, bounces: int) -> Images:
    """The images of a luminous wall between two mirrors, side by side.

    In units of the mirrors' distance w from the near one, along its normal n, the eye is at height h, and the wall,
    with normal −a, at the distance s. A ray d reaches the wall s / (d·a) away and there has met k mirrors at most if
    the height h + s d·n / d·a is above −k: s n·d + (h + k) a·d > 0, one side of a straight line in the image.
    """
    assert isinstance(scene.sensor, Pinhole)
    near, far, wall = scene.surfaces
    assert isinstance(near.shape, Quad)
    assert isinstance(near.material, Mirror)
    assert isinstance(far.shape, Quad)
    assert isinstance(far.material, Mirror)
    assert isinstance(wall.shape, Quad)
    assert wall.emission is not None
    n, a, eye = near.shape.normal, -wall.shape.normal, np.array(scene.sensor.origin)
    w = n @ np.subtract(far.shape.corner, near.shape.corner)
    h, s = n @ (eye - near.shape.corner) / w, a @ (np.array(wall.shape.corner) - eye) / w
    if (n @ scene.sensor.pixel_to_direction @ _corners(scene.sensor)).max() >= 0:
        raise ValueError(
            "a ray looks away from the near mirror: all must meet it first, in a less wide image"
        )
    images, e = np.empty((bounces + 1, *scene.shape)), np.array(wall.emission.diffuse_radiance)
    before = np.zeros((scene.sensor.height, scene.sensor.width))
    for k in range(bounces + 1):
        up_to_k = half_space_coverage(s * n + (h + k) * a, scene.sensor)
        images[k] = (up_to_k - before)[..., None] * e
        before = up_to_k
        e = e * (near.material.reflectance if k % 2 == 0 else far.material.reflectance)
    return images


def _corners(sensor: Pinhole) -> Array:
    """Of the image, in pixels, ``(3, 4)``."""
    w, h = sensor.width, sensor.height
    return np.array([[0, w, 0, w], [0, 0, h, h], [1, 1, 1, 1]], dtype=float)


def two_mirrors() -> Case:
    """A luminous wall between two parallel mirrors, and its row of images."""
    surfaces = (
        Surface("near", Quad((-5.0, -9.0, 0.0), (7.0, 0.0, 0.0), (0.0, 18.0, 0.0)), Mirror((0.9, 0.8, 0.6))),
        Surface("far", Quad((-5.0, -9.0, 1.0), (0.0, 18.0, 0.0), (7.0, 0.0, 0.0)), Mirror((0.7, 0.9, 0.8))),
        Surface(
            "wall",
            Quad((2.0, -9.0, 0.0), (0.0, 0.0, 1.0), (0.0, 18.0, 0.0)),
            _BLACK,
            AreaLight((3.0, 4.0, 5.0)),
        ),
    )
    return Case(
        name="two-mirrors",
        family="mirrors",
        title="A luminous wall between two parallel mirrors: TᵏE is its k-th image, ρ₁ρ₂ρ₁… times as bright",
        scene=Scene(surfaces, Pinhole((0.0, 0.3, 0.8), (1.0, 0.1, -0.2), (0.1, 1.0, 0.0), 60.0, 64, 64)),
        answer=Formula(_strips, "law of reflection; a wall's edge is a straight line in the image"),
        bounces=5,
        tolerance=_TOLERANCE,
        derivation="""\
A ray that has met k mirrors goes on as if straight into the k times mirrored space: the room between the mirrors
follows upon itself again and again, and so does the wall at its end. A ray therefore sees one image of the wall and
no other, k is how many mirrors lie before it, and the radiance is e times their reflectances in turn. The images
stand side by side, with straight edges; a pixel has the share of its square that lies between two of them.""",
        blind_to="reflectance that depends on the angle; anything that scatters",
    )


CASES: Mapping[str, Callable[[], Case]] = {"mirror-lamps": mirror_lamps, "two-mirrors": two_mirrors}
