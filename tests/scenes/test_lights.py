"""Lights: zones, channels, whether anything is emitted, and frames of environments."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from scenes import (
    Affine,
    AreaLight,
    ConstantEnvironment,
    DirectionalLight,
    EnvironmentMap,
    Image,
    PointLight,
    PolarRange,
    SceneError,
    SphericalHarmonicsEnvironment,
    SpotLight,
)
from scenes.channels import single_channel
from scenes.lights import emits

X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("low", "high"), [(0, 180), (0, 90), (0, 45), (30, 100), (179, 180), (89.999, 90.001)]
)
def test_the_share_of_a_zone(low: float, high: float) -> None:
    """Against (cos low − cos high) / 2 and against ∫ sin θ dθ / 2 by Gauss and Legendre."""
    zone = PolarRange(low, high)
    small, large = zone.cosines
    assert zone.fraction == pytest.approx((large - small) / 2, rel=1e-9)
    x, w = np.polynomial.legendre.leggauss(30)
    a, b = math.radians(low), math.radians(high)
    integral = (np.sin((a + b) / 2 + (b - a) / 2 * x) * w).sum() * (b - a) / 2
    assert zone.fraction == pytest.approx(integral / 2, rel=1e-12)


@pytest.mark.parametrize("channels", [1, 3, 5])
def test_channels_and_emission(channels: int) -> None:
    def lights(value: float) -> list[Any]:
        last = (*([0.0] * (channels - 1)), value)
        return [
            PointLight(X, last),
            SpotLight(X, Z, last, 30, 10),
            DirectionalLight(X, last),
            ConstantEnvironment(last),
            EnvironmentMap(Image([[[0.0] * channels, last]])),
            SphericalHarmonicsEnvironment([last, [0.0] * channels, [0.0] * channels, [0.0] * channels]),
        ]

    assert [light.channels for light in lights(1.0)] == [channels] * 6
    assert all(map(emits, lights(1e-9)))
    assert not any(map(emits, lights(0.0)))


def test_a_profile_may_be_dark_in_a_channel() -> None:
    assert AreaLight((1.0, 1.0), None, ((0.0, 0.0), (0.0, 2.0))).emits
    assert not AreaLight((1.0, 0.0), None, ((0.0, 0.0), (0.0, 2.0))).emits
    light = AreaLight((3.0, 5.0), None, np.array([[0.0, 1.0], [0.0, 2.0]]))
    assert single_channel(light, 1) == AreaLight((5.0,), None, ((1.0,), (2.0,)))
    assert single_channel(light, 0) == AreaLight((0.0,))


def test_radiance_that_formulas_may_take_to_be_diffuse() -> None:
    assert AreaLight((3.0, 5.0)).diffuse_radiance == (3.0, 5.0)
    with pytest.raises(SceneError, match="the same in every direction"):
        AreaLight((1.0,), None, ((1.0,), (1.0,))).diffuse_radiance  # noqa: B018


def test_directions_are_normalised() -> None:
    assert SpotLight(X, (0, 3, 4), (1.0,), 30, 10).direction == pytest.approx((0, 0.6, 0.8))
    assert DirectionalLight((0, 0, -7), (1.0,)).direction == (0, 0, -1)


@pytest.mark.parametrize("make", [lambda axes: EnvironmentMap(Image([[[1.0]]]), axes),
                                  lambda axes: SphericalHarmonicsEnvironment([[1.0]], axes)])  # fmt: skip
def test_frames_of_environments(make: Any) -> None:
    turned = Affine.rotation((1, 2, 3), 40).matrix
    np.testing.assert_array_equal(make(turned).axes, turned)
    np.testing.assert_array_equal(make(-turned).axes, -turned)  # left-handed: mirrored
    with pytest.raises(SceneError, match="three orthonormal vectors"):
        make(turned * 1.00001)
    with pytest.raises(SceneError, match="three orthonormal vectors"):
        make(np.array([turned[0], turned[1], turned[1]]))


@pytest.mark.parametrize("count", [1, 4, 9, 16, 81])
def test_how_many_coefficients(count: int) -> None:
    assert SphericalHarmonicsEnvironment(np.ones((count, 3))).channels == 3
    with pytest.raises(SceneError, match="1, 4, 9, 16 … of them"):
        SphericalHarmonicsEnvironment(np.ones((count + 1, 3)))


def test_the_mean_of_radiance_is_not_negative() -> None:
    """The integral over the sphere of the sum is √4π c_00, all other harmonics integrate to 0."""
    place = r"coefficients\[0\]\[1\]"
    with pytest.raises(SceneError, match=place):
        SphericalHarmonicsEnvironment([[1.0, -0.1]])
    with pytest.raises(SceneError, match=place):
        SphericalHarmonicsEnvironment([[1.0, 0.0], [0.0, 0.1], [0.0, 0.0], [0.0, 0.0]])
    assert SphericalHarmonicsEnvironment([[1.0, 0.0], [0.1, 0.0], [0.0, 0.0], [0.0, 0.0]]).channels == 2
