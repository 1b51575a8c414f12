"""How much light all bounces after some last one may hold, without computing any of them.

Where no surface reflects more than a share ρ < 1 of what it receives, reflection makes a bound of radiance smaller,
whatever the geometry: with ‖L‖ the largest radiance anywhere and in any direction,

    (T L)(x, v) = ∫ f cos θ L dl ≤ ρ ‖L‖      so      Σ_{k > n} TᵏE ≤ ρⁿ b + ρⁿ⁺¹ b + … = ρⁿ b / (1 − ρ),   n ≥ 0

with b ≥ ‖TE‖: ρ ‖E‖ of surfaces and skies, and ρ/π times the irradiance of directional lights. Each channel has its
own ρ. The bound holds in every pixel, and so for every mean of pixels. (The Neumann series converges like that of a
contraction: Kajiya 1986; Arvo, Torrance and Smits 1994, A framework for the analysis of error in global illumination
algorithms, SIGGRAPH.)

There is none for glass and metal, which reflect everything at grazing angles; for albedos of 1; and for points and
spots, whose light has no bound near them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenes.lights import (
    AreaLight,
    ConstantEnvironment,
    DirectionalLight,
    EnvironmentMap,
    Light,
    SphericalHarmonicsEnvironment,
)
from scenes.materials import Blend, Checkerboard, ImageTexture, Lambertian, Material, Mirror
from scenes.scene import Scene
from scenes.sensor import IrradianceMeter

Array = NDArray[np.float64]


def tail_bound(scene: Scene, last: int) -> Array:
    """What no pixel's sum of TᵏE over all k > ``last`` exceeds.

    Args:
        scene: any.
        last: the last bounce that is not in that sum, at least 0.

    Returns:
        ``(channels,)``, in the unit of the image; inf where there is no bound.
    """
    rho = largest_albedo(scene)
    emitted = brightest_emission(scene) + _of_directions(scene) / np.pi
    direct = rho * np.where(rho > 0, emitted, 0.0)  # where nothing reflects, not even a point light matters
    weight = np.pi if isinstance(scene.sensor, IrradianceMeter) else 1.0  # ∫ cos θ dl of its hemisphere
    bound = np.full(scene.channels, np.inf)
    some = rho < 1
    bound[some] = weight * rho[some] ** last * direct[some] / (1 - rho[some])
    return np.where(direct > 0, bound, 0.0)


def largest_albedo(scene: Scene) -> Array:
    """ρ: what the most reflective surface reflects at most, ``(channels,)``; 1 where no bound below is known."""
    dark = np.zeros(scene.channels)
    found: Array = np.max([dark, *(_albedo(s.material, scene.channels) for s in scene.surfaces)], axis=0)
    return found


def brightest_emission(scene: Scene) -> Array:
    """The largest radiance that surfaces and skies emit, ``(channels,)``; 0 where there are none."""
    dark = np.zeros(scene.channels)
    of_surfaces = [_of_area(s.emission) for s in scene.surfaces if s.emission is not None]
    sky = np.sum([dark, *map(_of_sky, scene.lights)], axis=0)
    brightest: Array = np.max([dark, *of_surfaces, sky], axis=0)
    return brightest


def _albedo(material: Material, channels: int) -> Array:
    match material:
        case Lambertian(albedo=Checkerboard() as board):
            return np.asarray(np.max([board.even, board.odd], axis=0))
        case Lambertian(albedo=ImageTexture() as texture):
            return np.asarray(texture.image.array.max(axis=(0, 1)))
        case Lambertian():
            return np.array(material.albedo)
        case Mirror():
            return np.array(material.reflectance)
        case Blend():
            first, second = (_albedo(part, channels) for part in (material.first, material.second))
            return (1 - material.weight) * first + material.weight * second
        case _:
            return np.ones(channels)


def _of_area(emission: AreaLight) -> Array:
    profile = emission.angular_profile
    factor = 1.0 if profile is None else np.max(profile, axis=0)
    return np.array(emission.radiance) * factor


def _of_sky(light: Light) -> Array:
    """Radiance at most; inf of a point or spot, whose irradiance has no bound."""
    match light:
        case ConstantEnvironment():
            return np.array(light.radiance)
        case EnvironmentMap():
            return np.asarray(light.image.array.max(axis=(0, 1)))
        case SphericalHarmonicsEnvironment():
            # |Σ_m c_lm Y_lm| ≤ √(Σ_m c_lm²) √((2l + 1) / 4π), by Cauchy–Schwarz and Unsöld's theorem
            c = np.array(light.coefficients)
            bands = [c[l * l : (l + 1) ** 2] for l in range(int(np.sqrt(len(c))))]  # noqa: E741
            sizes = [
                np.sqrt((2 * i + 1) / (4 * np.pi) * (band**2).sum(axis=0)) for i, band in enumerate(bands)
            ]
            return np.asarray(np.sum(sizes, axis=0))
        case DirectionalLight():
            return np.zeros(light.channels)
        case _:
            return np.where(np.array(light.intensity) > 0, np.inf, 0.0)


def _of_directions(scene: Scene) -> Array:
    """The irradiance of all directional lights together, on a plane that faces them all."""
    found = [light.irradiance for light in scene.lights if isinstance(light, DirectionalLight)]
    return np.asarray(np.sum([np.zeros(scene.channels), *map(np.array, found)], axis=0))
