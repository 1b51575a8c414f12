"""The whole tracer in furnaces of every closed shape: e ρᵏ where every lobe reflects the same share ρ.

By chance alone there is no noise, so that each pixel must be right to rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from reference_tracer.random_walk import Strategy, render
from scenes import (
    AreaLight,
    Blend,
    Checkerboard,
    Ellipsoid,
    Lambertian,
    Material,
    Mesh,
    Mirror,
    Pinhole,
    Scene,
    Sphere,
    Surface,
    box,
)
from scenes.transforms import Affine, transformed

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("closed_forms.py"))))
mean = shared.mean

NEAR = Pinhole((0.1, -0.2, 0.3), (0.0, 0.1, -1.0), (0.0, 1.0, 0.0), 60.0, 6, 4)

RHO = (0.5, 0.9, 0.2)
GLOW = AreaLight((1.0, 2.0, 0.5))


def closed(shape: str, material: Material) -> tuple[Surface, ...]:
    if shape == "box":
        return box(
            "room", (0, 0, 0), ((1, 0, 0), (0.2, 1, 0), (0, 0, 1)), material, inward=True, emission=GLOW
        )
    if shape == "sphere":
        return (Surface("it", Sphere((0.0, 0.0, 0.0), 1.0, inward=True), material, GLOW),)
    if shape == "ellipsoid":
        egg = Ellipsoid((0.1, 0.0, 0.0), (1.0, 0.2, 0.0), (0.0, 0.8, 0.1), (0.0, 0.0, 1.3), inward=True)
        return (Surface("it", egg, material, GLOW),)
    half = [(-1, -1, -1), (1, -1, -1), (0, 1.2, -1), (0, 0, 1.5)]
    mesh = Mesh(
        tuple(half), ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)), uv=tuple((x, z) for x, _, z in half)
    )  # type: ignore[arg-type]
    return (Surface("it", mesh, material, GLOW),)


SAME_SHARE: dict[str, Material] = {
    "lambertian": Lambertian(RHO),
    "mirror": Mirror(RHO),
    "blend": Blend(Mirror(RHO), Lambertian(RHO), 0.3),
    "nested": Blend(Blend(Lambertian(RHO), Mirror(RHO), 0.6), Lambertian(RHO), 0.5),
    "texture of one value": Lambertian(Checkerboard(RHO, RHO)),
}


@pytest.mark.parametrize("shape", ["box", "sphere", "ellipsoid", "mesh"])
@pytest.mark.parametrize("material", SAME_SHARE)
def test_furnaces(shape: str, material: str) -> None:
    scene = Scene(
        closed(shape, SAME_SHARE[material]), Pinhole((0.1, -0.2, 0.3), (0, 0.1, -1), (0, 1, 0), 60.0, 6, 4)
    )
    images = render(scene, 5, 3, 1, "bsdf")  # which makes no noise here: every walk finds e at every vertex
    for k, image in enumerate(images):
        expected = np.array(GLOW.radiance) * np.array(RHO) ** k
        np.testing.assert_allclose(image, np.broadcast_to(expected, image.shape), rtol=1e-12)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("strategy", ["nee", "mis"])
def test_a_furnace_of_any_size(size: float, strategy: Strategy, expect_means: Callable[..., None]) -> None:
    scene = transformed(Scene(closed("ellipsoid", Lambertian(RHO)), NEAR), Affine.scaling(size))
    found = np.array([mean(scene, 2, 96, strategy, seed) for seed in range(24)])
    for k in range(3):
        expect_means(found[:, k], np.array(GLOW.radiance) * np.array(RHO) ** k, resolution=0.05)


@pytest.mark.parametrize("channels", [1, 2, 5, 16])
def test_any_number_of_channels(channels: int) -> None:
    values: list[Any] = [0.1 + 0.8 * i / channels for i in range(channels)]
    room = box(
        "room",
        (0, 0, 0),
        ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        Lambertian(tuple(values)),
        inward=True,
        emission=AreaLight(tuple(values)),
    )
    for strategy in ("bsdf", "mis"):
        images = render(Scene(room, NEAR), 3, 2, 1, strategy)  # type: ignore[arg-type]
        assert images.shape == (4, 4, 6, channels)
    images = render(Scene(room, NEAR), 3, 2, 1, "bsdf")
    for k in range(4):
        np.testing.assert_allclose(
            images[k], np.broadcast_to(np.array(values) ** (k + 1), images[k].shape), rtol=1e-12
        )
