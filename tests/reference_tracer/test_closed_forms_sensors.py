"""The whole tracer against closed forms of sensors: irradiance meters, and a lens in focus."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import numpy as np

from reference_tracer.random_walk import render
from scenes import (
    AreaLight,
    ConstantEnvironment,
    Disk,
    Image,
    ImageTexture,
    IrradianceMeter,
    Lambertian,
    Pinhole,
    Scene,
    Surface,
    ThinLens,
)

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("closed_forms.py"))))
BLACK, PLANE = shared.BLACK, shared.PLANE
lit, mean = shared.lit, shared.mean


def test_irradiance_meters(expect_means: Callable[..., None]) -> None:
    for normal in ((0.0, 0.0, 1.0), (0.0, 0.6, 0.8)):  # the plane is out of its sight
        meter = IrradianceMeter((0.0, 0.0, 3.0), normal)
        sky = lit(PLANE, ConstantEnvironment((0.5, 2.0)), sensor=meter, material=Lambertian((0.0, 0.0)))
        np.testing.assert_allclose(mean(sky, 0, 500)[0], [0.5 * math.pi, 2 * math.pi], rtol=1e-12)
    # under a coaxial disk: π e r² / (r² + h²)
    disk = Surface("disk", Disk((0, 0, 1), (0.5, 0, 0), (0, -0.5, 0)), BLACK, AreaLight((3.0,)))
    under = Scene((disk,), IrradianceMeter((0.0, 0.0, 0.2), (0.0, 0.0, 1.0)))
    found = np.array([mean(under, 0, 2000, seed=seed)[0] for seed in range(24)])
    expect_means(found, 3 * math.pi * 0.25 / (0.25 + 0.64), resolution=0.05)


def test_a_lens_in_focus_sees_what_a_pinhole_sees() -> None:
    """A linear texture in the plane of focus: each pixel its mean, whatever the aperture."""
    ramp = ImageTexture(Image((((0.25,), (0.75,)),)))  # 0.25 at u = ¼ to 0.75 at u = ¾
    surface = Surface("it", PLANE, Lambertian(ramp))
    where = {
        "origin": (0.0, 0.0, 3.0),
        "target": (0.0, 0.0, 0.0),
        "up": (0.0, 1.0, 0.0),
        "fov": 15.0,
        "width": 4,
        "height": 4,
    }
    lens = ThinLens(aperture_radius=0.4, focus_distance=3.0, **where)  # type: ignore[arg-type]
    sky, spp = ConstantEnvironment((1.0,)), 4000
    sharp, pinhole = (
        render(lit(surface, sky, sensor=s), 1, spp, 3, sampler="sobol")[1] for s in (lens, Pinhole(**where))
    )  # type: ignore[arg-type]
    edge = 3 * math.tan(math.radians(7.5))
    expected = 0.5 + edge * (np.arange(4) - 1.5) / 2 / 2
    for image in (sharp, pinhole):
        np.testing.assert_allclose(image[..., 0], np.broadcast_to(expected, (4, 4)), atol=2e-4)
