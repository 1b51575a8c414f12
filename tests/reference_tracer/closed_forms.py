"""What tests against closed forms share: a plane, the ray that looks at one of its points, the mean of an image."""

from __future__ import annotations

import math

import numpy as np
import pytest

from reference_tracer.random_walk import STRATEGIES, Strategy, render
from scenes import Lambertian, Light, Material, Quad, RadianceMeter, Scene, Sensor, Shape, Surface

strategies = pytest.mark.parametrize("strategy", STRATEGIES)
BLACK = Lambertian((0.0,))
PLANE = Quad((-1.0, -1.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0))


def down_at(x: float, y: float, degrees: float = 0.0) -> RadianceMeter:
    """Looks at (x, y, 0) from above, inclined by so many degrees in the x–z plane."""
    s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    return RadianceMeter((x + 2 * s, y, 2 * c), (-s, 0.0, -c))


def lit(surface: Surface | Shape, *lights: Light, sensor: Sensor, material: Material | None = None) -> Scene:
    if not isinstance(surface, Surface):
        assert material is not None
        surface = Surface("it", surface, material)
    return Scene((surface,), sensor, lights)


def mean(scene: Scene, bounces: int, spp: int = 1, strategy: Strategy = "mis", seed: int = 0) -> np.ndarray:
    """Of all pixels, ``(bounces + 1, channels)``."""
    return render(scene, bounces, spp, seed, strategy).mean(axis=(1, 2))
