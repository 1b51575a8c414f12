"""Which side of a surface is lit, and which is seen: backs, and shading normals.

A surface is one-sided here: it reflects what comes to its front into directions of its front, and what comes from
behind or is seen from behind is black. Everything that reflects lies in one plane, so that nothing lights anything
else: E = 0, TE = (ρ/π) × irradiance where front meets front, T²E = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from scenes.case import Case, Formula, Images
from scenes.library.direct_light import BLACK, TOLERANCE
from scenes.library.rectangles import exchange_per_pixel
from scenes.lights import AreaLight, DirectionalLight
from scenes.materials import Lambertian
from scenes.pixels_on_rectangle import pixels_on
from scenes.scene import Scene
from scenes.sensor import Orthographic
from scenes.shapes import Mesh, Quad
from scenes.surfaces import Surface

Array = NDArray[np.float64]

# ---- boards, some of them face down


def _boards(scene: Scene, bounces: int) -> Images:
    """TE = ρ L times the form factor on boards whose front is seen, by the lamp before their front."""
    *boards, above, _below = scene.surfaces
    assert isinstance(scene.sensor, Orthographic)
    assert isinstance(above.shape, Quad)
    assert above.emission is not None
    images = np.zeros((bounces + 1, *scene.shape))
    for board in boards if bounces else ():
        assert isinstance(board.shape, Quad)
        assert isinstance(board.material, Lambertian)
        if board.shape.normal @ scene.sensor.frame[:, 2] < 0:
            factor = exchange_per_pixel(scene.sensor, board.shape, above.shape)
            images[1] += factor[..., None] * np.array(board.material.albedo) * above.emission.diffuse_radiance
    return images


def lit_from_behind() -> Case:
    """Five boards, lit from both sides; every other one shows its back."""
    boards = []
    for i in range(5):
        corner, edges = (0.5 * i - 1.22, 0.0, -1.2), ((0.0, 0.0, 2.4), (0.5, 0.0, 0.0))
        up = i % 2 == 0
        shape = Quad(corner, *(edges if up else edges[::-1]))
        boards.append(Surface(f"board-{i}", shape, Lambertian((0.7, 0.5, 0.9) if up else (0.9, 0.8, 0.6))))
    above = Quad((-0.9, 1.1, -0.3), (1.3, 0.0, 0.0), (0.0, 0.0, 0.8))
    below = Quad((-0.2, -0.7, -0.6), (0.0, 0.0, 0.9), (1.1, 0.0, 0.0))
    lamps = (
        Surface("lamp-above", above, BLACK, AreaLight((3.0, 5.0, 2.0))),
        Surface("lamp-below", below, BLACK, AreaLight((6.0, 2.0, 4.0))),
    )
    return Case(
        name="lit-from-behind",
        family="sides",
        title="Boards, every other one face down, lit from both sides: TE = ρ L F, backs are black",
        scene=Scene(
            (*boards, *lamps),
            Orthographic((0.0, 0.9, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), 2.0, 64, 64),
        ),
        answer=Formula(_boards, "Ehlert and Smith 1993, View factors for perpendicular and parallel plates"),
        bounces=2,
        tolerance=TOLERANCE,
        derivation="""\
The boards lie in one plane, with a lamp above and a lamp below, and are seen from above. There are four ways to be
lit and seen. A board that faces up reflects the upper lamp: a pixel is a rectangle on it, or a part of one, whose
mean irradiance by a lamp of radiance L is πL F, F the form factor between two parallel rectangles, so TE = ρ L F.
It lets nothing of the lower lamp through. A board that faces down shows its back, and a back is black, whether the
light comes from its own side or from the other. No board sees another, and the lamps are black and not in view:
E = 0, T²E = 0.""",
        blind_to="backs of what is not Lambertian, or emits; whether a back hides what is behind it",
    )


# ---- a sheet with shading normals


def _sheet(scene: Scene, bounces: int) -> Images:
    """TE: (ρ/π) E max(ns·wi, 0) by every light before the sheet, averaged from column to column."""
    sheet, sensor = scene.surfaces[0], scene.sensor
    assert isinstance(sheet.shape, Mesh)
    assert isinstance(sheet.material, Lambertian)
    assert isinstance(sensor, Orthographic)
    x, low, high, normals = _strips(sheet.shape)
    pixels = pixels_on(Quad((x[0], 0.0, high), (x[-1] - x[0], 0.0, 0.0), (0.0, 0.0, low - high)), sensor)
    images = np.zeros((bounces + 1, *scene.shape))
    for light in scene.lights if bounces else ():
        assert isinstance(light, DirectionalLight)
        wi = -np.array(light.direction)
        if wi[1] > 0:  # before the geometric normal, +y
            ends = pixels.columns + x[0]
            cosines = np.array([_integral_of_cosine(a, b, x, normals, wi) for a, b in pairwise(ends)])
            share = np.outer(np.abs(np.diff(pixels.rows)), cosines) / pixels.area
            images[1] += share[..., None] * np.array(sheet.material.albedo) / np.pi * light.irradiance
    return images


def _strips(mesh: Mesh) -> tuple[Array, float, float, Array]:
    """Where its strips begin and end along x, its extent along z, and the normals there, ``(n, 3)``."""
    assert mesh.normals is not None
    vertices, normals = np.array(mesh.vertices), np.array(mesh.normals)
    x, first = np.unique(vertices[:, 0], return_index=True)
    return x, float(vertices[:, 2].min()), float(vertices[:, 2].max()), normals[first]


def _integral_of_cosine(low: float, high: float, x: Array, normals: Array, wi: Array) -> float:
    """∫ max(ns·wi, 0) dx from low to high, normals at the ``x`` interpolated and normalised."""
    total = 0.0
    for (start, end), (m, n) in zip(pairwise(x), pairwise(normals), strict=True):
        slope = (n - m) / (end - start)
        ends = np.clip([low, high], start, end) - start
        zero = -(wi @ m) / (wi @ slope) if wi @ slope else np.inf
        for a, b in pairwise(np.sort([*ends, np.clip(zero, *ends)])):
            if wi @ (m + slope * (a + b) / 2) > 0:
                total += _antiderivative(b, m, slope, wi) - _antiderivative(a, m, slope, wi)
    return total


def _antiderivative(t: float, m: Array, slope: Array, wi: Array) -> float:
    """Of (m + t·slope)·wi / |m + t·slope|, for a slope that is not along m."""
    square, product = slope @ slope, slope @ m
    root = np.sqrt(square * (m @ m) - product**2)
    along = np.arcsinh((square * t + product) / root) / np.sqrt(square)
    return float((wi @ slope) / square * (np.linalg.norm(m + t * slope) - product * along) + (wi @ m) * along)


_X = (-1.7, -0.7, 0.1, 0.8, 1.8)
_NORMALS = ((-2.0, 1.0, 0.2), (-1.2, 1.0, -0.3), (0.1, 1.0, 0.4), (0.9, 1.0, 0.1), (1.6, 1.0, -0.3))
_SUN = DirectionalLight((-0.8, -0.7, -0.3), (3.0, 5.0, 7.0))
_SUN_BELOW = DirectionalLight((0.9, 0.35, -0.2), (6.0, 4.0, 2.0))

_CONVENTION = """\
The convention is that of the scenes: the cosine is that of the shading normal ns, which is interpolated between
the vertices and normalised. Which side light and viewer are on is said by the geometric normal, and where the two
normals disagree about it nothing is reflected."""

_LINEAR = """\
The sheet is flat, in strips. The normals are the same at both ends of a border between two strips, so that they
change along x alone, as n = m + t s. In parallel light of irradiance E from wi, TE = (ρ/π) E max(n·wi, 0) / |n|.
Along a pixel it has an antiderivative: with A = |s|², B = s·m, C = |m|², g(t) = asinh((At + B) / √(AC − B²)) / √A it
is (s·wi / A) (|n| − B g) + (m·wi) g, taken between the borders of strips, the sides of the pixel and the zero of
n·wi."""

_FLAT = "No part of a flat sheet sees another: E = 0, T²E = 0."


def _sheet_case(
    name: str, title: str, lights: tuple[DirectionalLight, ...], more: str, blind_to: str
) -> Case:
    vertices = tuple((x, 0.0, z) for x in _X for z in (-1.9, 1.9))
    triangles = tuple(
        triangle
        for k in range(0, 2 * len(_X) - 2, 2)
        for triangle in ((k, k + 1, k + 2), (k + 1, k + 3, k + 2))
    )
    normals = tuple(n for n in _NORMALS for _ in range(2))
    sheet = Surface("sheet", Mesh(vertices, triangles, normals), Lambertian((0.8, 0.5, 0.3)))
    return Case(
        name=name,
        family="sides",
        title=title,
        scene=Scene(
            (sheet,),
            Orthographic((0.1, 3.0, 1.0), (0.1, 0.0, 0.0), (0.0, 1.0, 0.0), 2.0, 64, 64),
            lights,
        ),
        answer=Formula(
            _sheet,
            "Phong 1975, Illumination for Computer Generated Pictures (the interpolation); Veach 1997, §5.3 (which "
            "normal says what)",
        ),
        bounces=2,
        tolerance=TOLERANCE,
        derivation=f"{_LINEAR} {more}\n\n{_CONVENTION} {_FLAT}",
        blind_to=blind_to,
    )


def shading_normals() -> Case:
    """Parallel light from before the sheet, whose normals in part turn away from it."""
    return _sheet_case(
        "shading-normals",
        "A flat sheet with shading normals in parallel light: (ρ/π) E max(ns·wi, 0)",
        (_SUN,),
        "On the left the shading normals turn away from the light, and the sheet is black.",
        "light from behind the sheet, which is shading-normals-from-behind; viewers that the normals disagree about",
    )


def shading_normals_from_behind() -> Case:
    """A second light from behind the sheet, which some of the normals lean to."""
    return _sheet_case(
        "shading-normals-from-behind",
        "A flat sheet with shading normals, also lit from behind, where some of them lean to: that gives nothing",
        (_SUN, _SUN_BELOW),
        """\
On the left the shading normals turn away from this light, and the sheet is black. A second light comes from behind
the sheet, and there they lean to it, n·wi > 0. It gives nothing, and all is as in shading-normals.""",
        "viewers that the two normals disagree about",
    )


CASES: Mapping[str, Callable[[], Case]] = {
    "lit-from-behind": lit_from_behind,
    "shading-normals": shading_normals,
    "shading-normals-from-behind": shading_normals_from_behind,
}
