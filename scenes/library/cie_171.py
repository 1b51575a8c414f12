"""The analytical cases 5.2 to 5.5 of CIE 171:2006, in lumens, candelas and metres, bounce by bounce.

Radiance is luminance here, in cd/m², and π/ρ times the luminance of a Lambertian surface is its illuminance in lx.
The test cases 5.6 and 5.7 have counterparts in ``rectangles``, 5.8 has one in ``point_in_sphere``.

The report itself was not at hand. What it prescribes is taken from published validations and their transcriptions;
where they are silent the scene is our own, and each case says so. Answers are derived, not copied: the printed tables
are rounded, and in places wrong (Ashdown, CIE 171:2006 – Errata, Lighting Analysts).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenes.case import Case, Formula, Images, Tolerance
from scenes.form_factors import solid_angles
from scenes.library.cie_room import HEIGHT, SIDE, hole_of, room, square_of_ceiling, view, whole_view
from scenes.library.direct_light import BLACK, TOLERANCE, direct_case
from scenes.library.rectangles import exchange_per_pixel
from scenes.library.specular import slab
from scenes.lights import AreaLight, ConstantEnvironment, Light, PointLight
from scenes.materials import Dielectric, Lambertian
from scenes.pixels_on_rectangle import pixels_on
from scenes.scene import Scene
from scenes.sensor import Orthographic, Pinhole
from scenes.shapes import Disk, Quad
from scenes.surfaces import Surface, box

Array = NDArray[np.float64]
Illuminance = Callable[[Orthographic, Quad], Array]
"""Camera, receiver → mean over each pixel, 0 beside the receiver, ``(height, width, channels)``."""

_INTENSITY, _FLUX = 1000.0, 10_000.0
_TOLD = "CIE 171:2006, test case {}, as transcribed in J. Thompson's CyclesCIEtest on GitHub"
_RECTANGLES = "Ehlert and Smith 1993, View factors for perpendicular and parallel rectangular plates"


# ---- 5.2: point light sources


_FLOOR = Surface(
    "floor", Quad((-3.0, 0.0, 3.0), (6.0, 0.0, 0.0), (0.0, 0.0, -6.0)), Lambertian((0.8, 0.5, 0.2))
)
_PLAN = Orthographic((0.9, 2.9, 0.6), (0.9, 0.0, 0.6), (0.0, 0.0, -1.0), 2.0, 64, 64)
"""Straight down on the measuring points, which lie 0 to 1.5 m aside of the light, along x and along z."""


def point() -> Case:
    """1000 cd into every direction, 3 m above a floor."""
    light = PointLight((0.0, 3.0, 0.0), (_INTENSITY, _INTENSITY, _INTENSITY))
    return direct_case(
        "cie-171-point",
        "CIE 171:2006, 5.2, a point light over a floor: illuminances I h / d³",
        (_FLOOR,),
        """\
The test case has a point light 3 m above the middle of a square of 4 m, here a part of the floor. A point of
intensity I at height h and distance d gives I cos θ / d² = I h / d³. Here I is 1000 cd into every direction; the test
case has 1000 cd cos θ, which is cie-171-small-lamp, and a distribution from a table, which no light of ours has.""",
        f"{_TOLD.format('5.2')}, but for the distribution; Lambert 1760, Photometria",
        family="cie_171",
        sensor=_PLAN,
        lights=(light,),
        blind_to="lights of finite size, distributions of intensity, indirect light",
    )


def small_lamp() -> Case:
    """1000 cd cos θ from a disk of a centimetre, which from 3 m away is a point."""
    radius = 0.01
    luminance = _INTENSITY / (math.pi * radius**2)
    lamp = Disk((0.0, 3.0, 0.0), (radius, 0.0, 0.0), (0.0, 0.0, radius))
    return direct_case(
        "cie-171-small-lamp",
        "CIE 171:2006, 5.2, 1000 cd cos θ from a lamp that is almost a point: illuminances I h² / d⁴",
        (_FLOOR, Surface("lamp", lamp, BLACK, AreaLight((luminance, luminance, luminance)))),
        """\
The scene of cie-171-point with the intensity of the test case, I cos θ with I = 1000 cd. A flat diffuse lamp has it:
a disk of radius r = 1 cm and luminance L = I / πr², with an exact answer of its own,
(πL/2)(1 − (h² + x² − r²) / √((h² + x² + r²)² − 4r²x²)), x aside, which is the point's I h² / d⁴ to 2 · 10⁻⁵.
At the measuring points, 0, 0.5, 1 and 1.5 m aside, illuminances are 111.11, 105.19, 90.00 and 71.11 lx. Those of the
report, as transcribed, differ by up to 0.02 lx.""",
        f"{_TOLD.format('5.2')}; Foote 1915, Illumination from a radiating disk",
        family="cie_171",
        sensor=_PLAN,
        blind_to="the size of the lamp; indirect light",
    )


# ---- 5.3 and 5.4: a floor and a wall in one image


def _first_bounce(scene: Scene, bounces: int, illuminance: Illuminance) -> Images:
    """(ρ/π) × illuminance of floor and wall, the first two surfaces."""
    if bounces > 1:
        raise ValueError(f"bounces = {bounces}: expected at most 1, then floor and wall light each other")
    assert isinstance(scene.sensor, Orthographic)
    images = np.zeros((bounces + 1, *scene.shape))
    for receiver in scene.surfaces[:2] if bounces else ():
        assert isinstance(receiver.material, Lambertian)
        assert isinstance(receiver.shape, Quad)
        images[1] += np.asarray(receiver.material.albedo) / np.pi * illuminance(scene.sensor, receiver.shape)
    return images


def _by_lamp(lamp: Quad, luminance: tuple[float, ...]) -> Illuminance:
    """πL times the form factor from a pixel to the lamp."""
    return lambda sensor, receiver: (
        exchange_per_pixel(sensor, receiver, lamp)[..., None] * np.pi * np.array(luminance)
    )


def _panel(scene: Scene, bounces: int) -> Images:
    """By the lamp, the last surface."""
    *_, lamp = scene.surfaces
    assert isinstance(lamp.shape, Quad)
    assert lamp.emission is not None
    return _first_bounce(scene, bounces, _by_lamp(lamp.shape, lamp.emission.diffuse_radiance))


def _opening(scene: Scene, bounces: int) -> Images:
    """By the sky in the hole of the ceiling, as if it were a lamp there."""
    assert isinstance(scene.environment, ConstantEnvironment)
    return _first_bounce(scene, bounces, _by_lamp(hole_of(scene.surfaces), scene.environment.radiance))


def _flux(scene: Scene, bounces: int) -> Images:
    """By a point: intensity times the solid angle of what a pixel sees, over its area."""
    [light] = scene.lights
    assert isinstance(light, PointLight)

    def illuminance(sensor: Orthographic, receiver: Quad) -> Array:
        pixels = pixels_on(receiver, sensor)
        [[x], [y], [z]] = pixels.local(np.array([light.position]))
        angles = np.abs(solid_angles(pixels.columns - x, pixels.rows - y, z))
        return angles[..., None] / pixels.area * light.intensity

    return _first_bounce(scene, bounces, illuminance)


def _room_case(
    name: str,
    title: str,
    surfaces: tuple[Surface, ...],
    sensor: Orthographic,
    lights: tuple[Light, ...],
    evaluate: Callable[[Scene, int], Images],
    source: str,
    **texts: Any,
) -> Case:
    return Case(
        name=name,
        family="cie_171",
        title=title,
        scene=Scene(surfaces, sensor, lights),
        answer=Formula(evaluate, source),
        bounces=1,
        max_bounces=1,
        tolerance=TOLERANCE,
        **texts,
    )


_FIRST = """\
E is 0: nothing luminous is in view. From the second bounce on floor and wall light each other; the test case asks
for direct light alone."""


def panel() -> Case:
    """A square metre of 1000 cd in the middle of the ceiling."""
    lamp = Surface("panel", square_of_ceiling(1.0), BLACK, AreaLight((_INTENSITY, _INTENSITY, _INTENSITY)))
    return _room_case(
        "cie-171-panel",
        "CIE 171:2006, 5.3, a panel in the ceiling lights a floor and a wall: form factors per pixel",
        (*room(0.8, 0.6, square_of_ceiling(1.0)), lamp),
        view(2.3, -0.7, 3.2, 64, 96),
        (),
        _panel,
        f"{_TOLD.format('5.3')}; {_RECTANGLES}",
        derivation=f"""\
The panel of the test case is 1 m × 1 m and diffuse, with 1000 cd straight down: L = 1000 cd/m². The room is
4 m × 4 m, 3 m high, and black but for floor and wall. The mean illuminance of a rectangle on either is πL F, with the
form factor F between parallel or perpendicular rectangles. A pixel sees a rectangle of area A on the floor, one on
the wall, or one on each, under the cosines 0.8 and 0.6; a its own area, TE is the sum of ρ L F A cos β / a.
{_FIRST}
At the measuring points, in the middle of the room, illuminances are 32.68, 75.19, 81.32, 69.06, 53.40 and 40.00 lx
on the wall, 0.25 to 2.75 m below the ceiling, and 61.42, 79.26, 95.67 and 105.78 lx on the floor, 0.25 to 1.75 m from
the wall. Those of the report, as transcribed, differ by up to 0.3 %.""",
        blind_to="the look of the panel; indirect light",
    )


_SUM = """\
The camera sees every point of floor and wall once, under the cosines 0.8 and 0.6, in an image of 4 m × 5 m: for the
fluxes Φ₁ on the floor and Φ₂ on the wall its mean is (0.8 ρ₁ Φ₁ + 0.6 ρ₂ Φ₂) / 20π."""
_TO_ALL = """\
The mean of the image is 0.12 Φ / 20π in red, half of that in green, a quarter in blue: all that was emitted."""
_ONE_SIDE = "an image mirrored left to right; indirect light"


def flux() -> Case:
    """10 000 lm from a point in the middle of the room."""
    intensity = _FLUX / (4 * math.pi)
    light = PointLight((SIDE / 2, HEIGHT / 2, SIDE / 2), (intensity, intensity, intensity))
    return _room_case(
        "cie-171-flux",
        "CIE 171:2006, 5.4, 10 000 lm in the middle of a room: the image adds up to them",
        room(0.3, 0.8),
        whole_view(),
        (light,),
        _flux,
        f"{_TOLD.format('5.4')}; the view is our own; Khadjavi 1968, Calculation of solid angle subtended by "
        "rectangular apertures",
        derivation=f"""\
The test case compares the flux that the surfaces of a room of 4 m × 4 m × 3 m receive with the flux that is emitted
in it. A point of intensity I = Φ/4π sends IΩ to what it sees under the solid angle Ω: a pixel that sees a rectangle
of that solid angle has the mean TE = (ρ/π) I Ω cos β / a, a its own area, and the six faces add up to 4π.
{_SUM}
Ceiling and floor get the same, and so do the four walls, Φ = 2 Φ₁ + 4 Φ₂; the albedos have 0.6 ρ₂ = 2 · 0.8 ρ₁.
{_TO_ALL}
{_FIRST}""",
        blind_to=_ONE_SIDE,
    )


def opening() -> Case:
    """A uniform sky above a roof with an opening of 3 m × 3 m."""
    luminance = _FLUX / (9 * math.pi)
    return _room_case(
        "cie-171-opening",
        "CIE 171:2006, 5.4, the sky in an opening of the roof: the image adds up to 10 000 lm",
        room(0.15, 0.8, square_of_ceiling(3.0)),
        whole_view(),
        (ConstantEnvironment((luminance, luminance, luminance)),),
        _opening,
        f"CIE 171:2006, test case 5.4, in its manner; opening, sky and view are our own; {_RECTANGLES}",
        derivation=f"""\
Flux conservation by daylight: what a room receives is what came in through its opening. A sky of luminance L fills an
opening of area A with the flux Φ = πLA and lights the room as a panel of that luminance in its place does (see
cie-171-panel): 10 000 lm for L = 10 000/9π cd/m² and A = 9 m².
{_SUM}
The ceiling gets nothing, and the four walls the same, Φ = Φ₁ + 4 Φ₂; the albedos have 0.6 ρ₂ = 4 · 0.8 ρ₁.
{_TO_ALL}
{_FIRST}""",
        blind_to=f"where in the sky light comes from; {_ONE_SIDE}",
    )


# ---- 5.5: directional transmittance of clear glass


def glass() -> Case:
    """A luminous plane seen through a pane of 6 mm, from steep to grazing angles; all else is dark."""
    half = ((20.0, 0.0, 0.0), (0.0, 0.003, 0.0), (0.0, 0.0, 20.0))
    plane = Quad((-30.0, -0.5, 30.0), (60.0, 0.0, 0.0), (0.0, 0.0, -60.0))
    surfaces = (
        *box("pane", (0.0, -0.003, 0.0), half, Dielectric(interior_ior=1.52)),
        Surface("plane", plane, BLACK, AreaLight((1000.0, 2000.0, 3000.0))),
    )
    camera = Pinhole((0.3, 1.0, 0.4), (0.4, 0.26, -0.27), (0.0, 1.0, 0.0), 74.0, 64, 64)
    return Case(
        name="cie-171-glass",
        family="cie_171",
        title="CIE 171:2006, 5.5, clear glass from 5° to 81°: T²E = (1 − R)² e, in all (1 − R) / (1 + R) e",
        scene=Scene(surfaces, camera),
        answer=Formula(
            slab,
            "CIE 171:2006, test case 5.5, in its manner: 6 mm of clear glass, here with n = 1.52; light and view are "
            "our own; Born and Wolf 1999, Principles of Optics, §1.5.2; the series of §7.6.1, summed as intensities",
        ),
        bounces=2,
        max_bounces=100,
        tolerance=Tolerance(image=(0.005, 0.005, 0.005, 0.01, 0.02), tile=(0.02, 0.02, 0.02, 0.05, 0.1)),
        derivation="""\
1 − R of the plane's light e enters the pane, and 1 − R leaves it: T²E = (1 − R)² e. What is reflected at both faces
on its way follows two bounces later: T⁴E = (1 − R)² R² e, and so on. Odd bounces bring light from this side, where it
is dark. The sum is the transmittance (1 − R) / (1 + R) times e: 0.918 for normal rays, 0.831 at 60°, 0.438 at 80°.
In the image T⁴E is a hundredth of T²E, and few paths find it: it is there for those who ask for four bounces.
R is the mean of both polarisations at each face, as renderers have it. Light that stays polarised from face to face
has 0.843 at 60° and 0.456 at 80°. The glass of the test case also absorbs: its values, a polynomial in the cosine
(Tregenza and Sharples, Daylighting algorithms), are 0.88, 0.80 and 0.42.""",
        blind_to="absorption and polarisation, which are not in the scene; factors of η², which cancel",
    )


CASES: Mapping[str, Callable[[], Case]] = {
    "cie-171-point": point,
    "cie-171-small-lamp": small_lamp,
    "cie-171-panel": panel,
    "cie-171-flux": flux,
    "cie-171-opening": opening,
    "cie-171-glass": glass,
}
