"""Irradiance by lights that are no surfaces, in closed form.

- point: I cos θ / d²; spot: the same times its fall-off; directional: E cos θ (Lambert 1760);
- environment map: E = n·v with v = Σ L ∫ h(θ) h(φ) l dl over the texels. A texel's share is the product of two
  hat functions of half width Δ, of which all that is needed is, by ∫ (1 − |t|/Δ) cos kt dt = 2 (1 − cos kΔ) / k²Δ,

      ∫ h sin² θ dθ = Δ/2 − cos 2θ₀ sin² Δ / 2Δ      ∫ h sin θ cos θ dθ = sin 2θ₀ sin² Δ / 2Δ
      ∫ h (cos φ, sin φ) dφ = (cos φ₀, sin φ₀) 2 (1 − cos Δ) / Δ      ∫ h dφ = Δ

- spherical harmonics: E(n) = Σ A_l c_lm Y_lm(n), A = π, 2π/3, π/4, 0 for l = 0, 1, 2, 3 (Ramamoorthi and Hanrahan
  2001, An Efficient Representation for Irradiance Environment Maps).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from scenes.lights import (
    ConstantEnvironment,
    DirectionalLight,
    EnvironmentMap,
    Light,
    PointLight,
    SphericalHarmonicsEnvironment,
    SpotLight,
)

Array = NDArray[np.float64]


def irradiance_by_light(light: Light, x: Array, n: Array) -> Array:
    """Irradiance at points x ``(3, n)`` with unit normals n ``(3, n)``, nothing in between: ``(channels, n)``.

    Raises:
        ValueError: a lit texel of an environment map that is not wholly above each horizon, or lies in its first
            or last row; spherical harmonics beyond degree 3.
    """
    match light:
        case PointLight():
            return np.outer(light.intensity, _inverse_square(light, x, n))
        case SpotLight():
            return np.outer(light.intensity, _inverse_square(light, x, n) * _falloff(light, x))
        case DirectionalLight():
            return np.outer(light.irradiance, np.maximum(-np.array(light.direction) @ n, 0))
        case ConstantEnvironment():
            return np.outer(light.radiance, np.full(n.shape[1], np.pi))
        case EnvironmentMap():
            return _environment_map(light, n)
        case SphericalHarmonicsEnvironment():
            return _spherical_harmonics(light, n)


def _inverse_square(light: PointLight | SpotLight, x: Array, n: Array) -> Array:
    """cos θ / d², 0 behind the surface."""
    d = np.reshape(light.position, (3, 1)) - x
    geometry: Array = np.maximum((n * d).sum(axis=0), 0) / (d**2).sum(axis=0) ** 1.5
    return geometry


def _falloff(spot: SpotLight, x: Array) -> Array:
    """Linear in the angle from 1 at the beam to 0 at the cutoff."""
    d = x - np.reshape(spot.position, (3, 1))
    cosine = np.array(spot.direction) @ d / np.linalg.norm(d, axis=0)
    angle = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    if spot.cutoff == spot.beam:
        return np.where(angle < spot.cutoff, 1.0, 0.0)
    share: Array = np.clip((spot.cutoff - angle) / (spot.cutoff - spot.beam), 0, 1)
    return share


def _environment_map(light: EnvironmentMap, n: Array) -> Array:
    """n·v, summed over the lit texels."""
    image, axes = light.image.array, np.array(light.axes)
    rows, columns, channels = image.shape
    wide, high = 2 * math.pi / columns, math.pi / rows  # Δ along φ and along θ
    E = np.zeros((channels, n.shape[1]))
    for row, column in np.argwhere(image.any(axis=2)):
        if not 0 < row < rows - 1:
            raise ValueError(f"row {row} of the map is lit: expected none beside a pole")
        theta, phi = (row + 0.5) * high, (column + 0.5) * wide
        longitude = np.array([math.cos(phi), math.sin(phi)])
        center = axes.T @ np.array([*(math.sin(theta) * longitude), math.cos(theta)])
        if not (center @ n > math.sin(high + wide)).all():  # no corner is farther than that from the centre
            raise ValueError(f"texel ({row}, {column}) of the map: expected it above every horizon")
        horizontal = high / 2 - math.cos(2 * theta) * math.sin(high) ** 2 / (2 * high)
        vertical = math.sin(2 * theta) * math.sin(high) ** 2 / (2 * high)
        v = [*(horizontal * 2 * (1 - math.cos(wide)) / wide * longitude), vertical * wide]
        E += np.outer(image[row, column], (axes.T @ np.array(v)) @ n)
    return E


def _spherical_harmonics(light: SphericalHarmonicsEnvironment, n: Array) -> Array:
    """Σ A_l c_lm Y_lm(n); degree 3 gives nothing."""
    c = np.array(light.coefficients)
    if len(c) > 16:
        raise ValueError(f"{len(c)} coefficients: expected none beyond degree 3, which are 16")
    x, y, z = np.array(light.axes) @ n
    a, b = math.sqrt(3 / (4 * math.pi)), math.sqrt(15 / (4 * math.pi))
    flat = np.full_like(x, math.sqrt(1 / (4 * math.pi)))
    bent = [b * x * y, b * y * z, b / math.sqrt(12) * (3 * z**2 - 1), b * x * z, b / 2 * (x**2 - y**2)]
    harmonics = [
        math.pi * flat,
        *(2 * math.pi / 3 * a * w for w in (y, z, x)),
        *(math.pi / 4 * w for w in bent),
    ]
    count = min(len(c), 9)
    E: Array = c[:count].T @ np.stack(harmonics[:count])
    return E
