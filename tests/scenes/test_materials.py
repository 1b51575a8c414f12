"""Materials: how many channels they have, and what a blend of them has."""

from __future__ import annotations

from typing import Any

import pytest

from scenes import (
    Blend,
    Checkerboard,
    Conductor,
    Dielectric,
    Image,
    ImageTexture,
    Lambertian,
    Mirror,
    RoughConductor,
    RoughDielectric,
    SceneError,
)
from scenes.materials import has_dielectric, is_textured

FIVE = (0.1, 0.2, 0.3, 0.4, 0.5)
CHECKS, PICTURE = Checkerboard(FIVE, FIVE), ImageTexture(Image([[FIVE]]))
COLOURED = [
    Lambertian(FIVE),
    Lambertian(CHECKS),
    Lambertian(PICTURE),
    Mirror(FIVE),
    Conductor(FIVE, FIVE),
    RoughConductor(FIVE, FIVE, 0.2),
]
CLEAR = [Dielectric(), RoughDielectric(0.2), Blend(Dielectric(), RoughDielectric(0.2), 0.5)]


@pytest.mark.parametrize("material", COLOURED)
def test_channels(material: Any) -> None:
    assert material.channels == 5
    for other in CLEAR:
        assert Blend(material, other, 0.5).channels == 5
        assert Blend(other, Blend(other, material, 0.5), 0.5).channels == 5


@pytest.mark.parametrize("material", CLEAR)
def test_glass_goes_with_any_number(material: Any) -> None:
    assert material.channels is None
    assert has_dielectric(material)
    assert has_dielectric(Blend(Mirror(FIVE), material, 0.5))
    assert not has_dielectric(Blend(Mirror(FIVE), Lambertian(FIVE), 0.5))


def test_textures_are_found_in_blends() -> None:
    for textured in COLOURED[1:3]:
        assert is_textured(textured)
        assert textured.textured
        assert is_textured(Blend(Mirror(FIVE), Blend(textured, Dielectric(), 0.5), 0.5))
    assert not is_textured(Blend(Mirror(FIVE), Lambertian(FIVE), 0.5))


@pytest.mark.parametrize(
    ("first", "second", "place"),
    [
        (Mirror((0.5,)), Lambertian(FIVE), "Blend.second.albedo"),
        (Mirror((0.5,)), Lambertian(CHECKS), "Blend.second.albedo.even"),
        (Mirror((0.5,)), Lambertian(PICTURE), "Blend.second.albedo.image.pixels[0][0]"),
        (Blend(Dielectric(), Mirror((0.5,)), 0.5), Conductor(FIVE, FIVE), "Blend.second.eta"),
        (Mirror((0.5,)), Blend(Dielectric(), Mirror(FIVE), 0.5), "Blend.second.second.reflectance"),
    ],
)
def test_a_blend_of_different_channels(first: Any, second: Any, place: str) -> None:
    with pytest.raises(SceneError) as caught:
        Blend(first, second, 0.5)
    assert (caught.value.path, caught.value.found) == (place, FIVE)
    assert caught.value.expected.startswith("1 channels, as first.")


@pytest.mark.parametrize("alpha", [0.001, 1])
def test_the_limits_of_roughness(alpha: float) -> None:
    assert RoughDielectric(alpha).alpha == RoughConductor(FIVE, FIVE, alpha).alpha == alpha
