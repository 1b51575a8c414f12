"""Scenes that relations are tried on unless others are asked for: small, without an answer, soon without noise.

    cornell-box   the case: one lamp, two blocks, all diffuse, open to the front
    room          closed; two lamps of different size and colour, a mirror, a block of blends
    lights        a floor with a texture, two walls, a ball and a block under a point, a spot and a directional light
    metal         a ball and a slanted plate of rough metal and a diffuse ball before a wall, under a lamp and a sky

Every renderer of this project can express them. They are not symmetric, so that what is left, right, above or below
can be told, and coloured, so that channels can.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from scenes import (
    AreaLight,
    Blend,
    Checkerboard,
    ConstantEnvironment,
    DirectionalLight,
    Lambertian,
    Mirror,
    Pinhole,
    PointLight,
    Quad,
    RoughConductor,
    Scene,
    Sphere,
    SpotLight,
    Surface,
    box,
    library,
)

PIXELS = 24
"""Along each side of the image."""

_GREY = Lambertian((0.5, 0.5, 0.5))
_RED, _GREEN, _BLUE = (
    Lambertian(albedo) for albedo in ((0.6, 0.2, 0.15), (0.2, 0.5, 0.25), (0.15, 0.25, 0.6))
)
_SAND, _WHITE = Lambertian((0.7, 0.6, 0.45)), Lambertian((0.8, 0.75, 0.7))


def _cornell_box() -> Scene:
    return library.case("cornell-box").scene.resized(PIXELS, PIXELS)


def _room() -> Scene:
    walls = (_RED, _GREEN, _SAND, _GREY, _BLUE, _GREY)
    shell = box("wall", (0, 0, 0), ((1, 0, 0), (0, 1, 0), (0, 0, 1)), _GREY, inward=True)
    block = box(
        "block", (-0.4, -0.65, -0.3), ((0.25, 0, -0.1), (0, 0.35, 0), (0.1, 0, 0.25)), Blend(_RED, _BLUE, 0.4)
    )
    return Scene(
        (
            *(Surface(wall.name, wall.shape, paint) for wall, paint in zip(shell, walls, strict=True)),
            *block,
            Surface("mirror", Quad((0.95, -0.6, -0.8), (0, 0, 1.2), (0, 0.9, 0)), Mirror((0.9, 0.8, 0.7))),
            # large lamps: what the mirror throws back is found by chance
            _lamp("ceiling-lamp", Quad((-0.75, 0.95, -0.8), (1.6, 0, 0), (0, 0, 1.5)), (1.0, 0.8, 0.7)),
            _lamp("wall-lamp", Quad((-0.95, -0.4, -0.1), (0, 0.9, 0), (0, 0, 0.8)), (0.4, 0.7, 1.4)),
        ),
        Pinhole((0.2, 0.1, 0.9), (0.0, -0.1, -1.0), (0.0, 1.0, 0.0), 75, PIXELS, PIXELS),
    )


def _lamp(name: str, quad: Quad, radiance: tuple[float, ...]) -> Surface:
    return Surface(name, quad, _GREY, AreaLight(radiance))


def _lights() -> Scene:
    tiles = Lambertian(Checkerboard((0.7, 0.65, 0.5), (0.25, 0.3, 0.5), 5, 4))
    block = box("block", (0.6, 0.3, -0.2), ((0.25, 0, -0.1), (0, 0.3, 0), (0.1, 0, 0.25)), _RED)
    return Scene(
        (
            Surface("floor", Quad((-1.5, 0, 1.5), (3, 0, 0), (0, 0, -2.5)), tiles),
            Surface("wall", Quad((-1.5, 0, -1.0), (3, 0, 0), (0, 2, 0)), _SAND),
            Surface("side", Quad((-1.5, 0, 1.5), (0, 0, -2.5), (0, 2, 0)), _WHITE),
            Surface("ball", Sphere((-0.5, 0.4, 0.1), 0.4), _GREEN),
            *block,
        ),
        Pinhole((0.4, 1.4, 3.5), (0.0, 0.6, -0.3), (0.0, 1.0, 0.0), 42, PIXELS, PIXELS),
        (
            PointLight((-0.6, 1.7, 0.8), (2.5, 2.0, 1.5)),
            SpotLight((1.2, 1.9, 0.9), (-0.5, -1.0, -0.6), (4.0, 4.5, 6.0), 55, 30),
            DirectionalLight((0.3, -1.0, -0.5), (0.5, 0.6, 0.5)),
        ),
    )


def _metal() -> Scene:
    gold = RoughConductor((0.14, 0.37, 1.44), (3.98, 2.39, 1.60), 0.3, "separable")
    steel = RoughConductor((2.9, 2.9, 2.6), (3.1, 3.0, 2.8), 0.5, "separable")
    return Scene(
        (
            Surface("floor", Quad((-1.5, 0, 1.5), (3, 0, 0), (0, 0, -2.7)), _SAND),
            Surface("wall", Quad((-1.5, 0, -1.2), (3, 0, 0), (0, 2, 0)), _WHITE),
            Surface("gold", Sphere((-0.55, 0.45, 0.1), 0.45), gold),
            Surface("plate", Quad((0.0, 0.05, -0.7), (1.2, 0, 0.2), (0.1, 1.0, -0.6)), steel),
            Surface("ball", Sphere((0.55, 0.3, 0.3), 0.3), _BLUE),
            _lamp("lamp", Quad((-0.4, 2.2, -0.5), (1.0, 0, 0), (0, 0, 0.8)), (4.0, 3.5, 3.0)),
        ),
        Pinhole((0.3, 1.5, 3.5), (0.0, 0.5, 0.0), (0.0, 1.0, 0.0), 40, PIXELS, PIXELS),
        (ConstantEnvironment((0.3, 0.4, 0.6)),),
    )


STAGES: Mapping[str, Callable[[], Scene]] = MappingProxyType(
    {"cornell-box": _cornell_box, "room": _room, "lights": _lights, "metal": _metal}
)
