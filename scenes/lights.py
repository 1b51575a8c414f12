"""Lights: what emits by itself, the data of E.

An area light belongs to a surface. Point, spot and directional lights have no radiance as a field: they are
met by next event only. An environment is the radiance that comes from infinitely far.
"""

from __future__ import annotations

import math

import msgspec
import numpy as np

from scenes.images import Image
from scenes.tables import table
from scenes.validation import (
    SceneError,
    Vector,
    instance,
    number,
    path,
    per_channel,
    unit_vector,
    vector,
)


class PolarRange(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A zone of a sphere: the points whose polar angle, measured from ``axis``, lies in [low, high].

    Attributes:
        low, high: polar angles in degrees, 0 ≤ low < high ≤ 180. ``low=0`` makes a cap.
        axis: where the polar angle is 0, seen from the centre; normalised.
    """

    low: float = 0.0
    high: float = 180.0
    axis: Vector = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        unit_vector(self, "axis")
        expected = "degrees in [0, 180]"
        for field in ("low", "high"):
            if not 0 <= number(self, field, expected) <= 180:
                raise SceneError(path(self, field), getattr(self, field), expected)
        if not self.low < self.high:
            raise SceneError(path(self, "high"), self.high, f"more than low = {self.low:g}")

    @property
    def cosines(self) -> tuple[float, float]:
        """Cosines of the limits, the smaller first: [cos high, cos low]."""
        return math.cos(math.radians(self.high)), math.cos(math.radians(self.low))

    @property
    def fraction(self) -> float:
        """The zone's share of the area of the sphere, (cos low − cos high) / 2 (Archimedes).

        As a product of sines, so that a narrow zone does not cancel.
        """
        low, high = math.radians(self.low), math.radians(self.high)
        return math.sin((high + low) / 2) * math.sin((high - low) / 2)


class AreaLight(
    msgspec.Struct, frozen=True, tag_field="type", tag="area", forbid_unknown_fields=True, omit_defaults=True
):
    """A surface that emits from its front, the same everywhere and, unless it has a profile, in every direction.

    With a profile Le(θ) = radiance · p(cos θ), θ to the surface's own normal; a two-sided surface does so behind,
    too.

    Attributes:
        radiance: per channel, ≥ 0, W·m⁻²·sr⁻¹ or any unit proportional to it.
        polar_range: limits the emission of a sphere to a zone; None for the whole surface.
        angular_profile: p, factors ≥ 0 at equal steps of cos θ from 0 (grazing) to 1 (along the normal), at least
            two of them, each one number per channel; linear in cos θ in between. None for 1.
    """

    radiance: tuple[float, ...]
    polar_range: PolarRange | None = None
    angular_profile: tuple[tuple[float, ...], ...] | None = None

    def __post_init__(self) -> None:
        per_channel(self, "radiance")
        instance(self, "polar_range", PolarRange | None, "a PolarRange or None")
        if self.angular_profile is not None:
            self._check_profile()

    def _check_profile(self) -> None:
        rows = table(self, "angular_profile", (None, len(self.radiance)), low=0.0)
        place, found = path(self, "angular_profile"), self.angular_profile
        if len(rows) < 2:
            raise SceneError(place, found, "factors at two cosines at least: 0 is the first, 1 the last")
        if not rows.any():
            raise SceneError(place, found, "a factor > 0; a surface that emits nothing has no emission")

    @property
    def emits(self) -> bool:
        """Whether any channel is above zero, at some angle."""
        highest = 1.0 if self.angular_profile is None else np.max(self.angular_profile, axis=0)
        return bool(np.any(np.multiply(self.radiance, highest)))

    @property
    def diffuse_radiance(self) -> tuple[float, ...]:
        """The radiance, for formulas that take it to be the same in every direction.

        Raises:
            SceneError: it is not.
        """
        if self.angular_profile is not None:
            raise SceneError(path(self, "angular_profile"), self.angular_profile, "None: the formula is for "
                             "radiance that is the same in every direction")  # fmt: skip
        return self.radiance


Emission = AreaLight


class PointLight(
    msgspec.Struct, frozen=True, tag_field="type", tag="point", forbid_unknown_fields=True, omit_defaults=True
):
    """Emits from one point, the same into every direction.

    Attributes:
        position: world coordinates.
        intensity: per channel, ≥ 0, W·sr⁻¹: at distance r the irradiance is intensity · cos θ / r².
    """

    position: Vector
    intensity: tuple[float, ...]

    def __post_init__(self) -> None:
        vector(self, "position")
        per_channel(self, "intensity")

    @property
    def channels(self) -> int:
        """Channels of the intensity."""
        return len(self.intensity)


class SpotLight(
    msgspec.Struct, frozen=True, tag_field="type", tag="spot", forbid_unknown_fields=True, omit_defaults=True
):
    """Emits from one point into a cone.

    The intensity is the full one up to the angle ``beam`` from the direction, 0 from ``cutoff`` on, and falls
    linearly with the angle in between.

    Attributes:
        position: world coordinates.
        direction: the axis of the cone; normalised.
        intensity: on the axis, per channel, ≥ 0, W·sr⁻¹.
        cutoff, beam: half angles in degrees, 0 ≤ beam ≤ cutoff, 0 < cutoff ≤ 180.
    """

    position: Vector
    direction: Vector
    intensity: tuple[float, ...]
    cutoff: float
    beam: float

    def __post_init__(self) -> None:
        vector(self, "position")
        unit_vector(self, "direction")
        per_channel(self, "intensity")
        if not 0 < number(self, "cutoff", "degrees in (0, 180]") <= 180:
            raise SceneError(path(self, "cutoff"), self.cutoff, "degrees in (0, 180]")
        expected = f"degrees in [0, cutoff = {self.cutoff:g}]"
        if not 0 <= number(self, "beam", expected) <= self.cutoff:
            raise SceneError(path(self, "beam"), self.beam, expected)

    @property
    def channels(self) -> int:
        """Channels of the intensity."""
        return len(self.intensity)


class DirectionalLight(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="directional",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """Parallel light from infinitely far.

    Attributes:
        direction: where the light travels to; normalised.
        irradiance: on a plane across the direction, per channel, ≥ 0, W·m⁻².
    """

    direction: Vector
    irradiance: tuple[float, ...]

    def __post_init__(self) -> None:
        unit_vector(self, "direction")
        per_channel(self, "irradiance")

    @property
    def channels(self) -> int:
        """Channels of the irradiance."""
        return len(self.irradiance)


class ConstantEnvironment(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="constant",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """The same radiance from every direction.

    Attributes:
        radiance: per channel, ≥ 0, W·m⁻²·sr⁻¹.
    """

    radiance: tuple[float, ...]

    def __post_init__(self) -> None:
        per_channel(self, "radiance")

    @property
    def channels(self) -> int:
        """Channels of the radiance."""
        return len(self.radiance)


_WORLD: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class EnvironmentMap(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="environment_map",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """Radiance by latitude and longitude, bilinear between the centres of pixels.

    The top edge of the image is the local direction +z, the bottom edge −z. The left edge looks along local +x;
    to the right the longitude grows towards +y, once round. Beyond the centres of the first and last row the
    values stay constant along the meridian.

    Attributes:
        image: radiance, W·m⁻²·sr⁻¹.
        axes: world directions of the local x, y and z axis, orthonormal (left-handed mirrors the map).
    """

    image: Image
    axes: tuple[Vector, Vector, Vector] = _WORLD

    def __post_init__(self) -> None:
        instance(self, "image", Image, "an Image")
        _orthonormal(self, "axes")

    @property
    def channels(self) -> int:
        """Channels of the radiance."""
        return self.image.channels


class SphericalHarmonicsEnvironment(
    msgspec.Struct,
    frozen=True,
    tag_field="type",
    tag="spherical_harmonics",
    forbid_unknown_fields=True,
    omit_defaults=True,
):
    """Radiance as a sum of real spherical harmonics, Σ c_lm Y_lm, nowhere negative.

    Y_lm are orthonormal, without the Condon–Shortley phase: Y_00 = √(1/4π), Y_1m = √(3/4π) (y, z, x) for
    m = −1, 0, 1, in local coordinates (Ramamoorthi and Hanrahan 2001, eq. 3). That the sum is nowhere negative
    is checked where it is evaluated; here, that its mean is not.

    Attributes:
        coefficients: c_lm at index l(l + 1) + m, each one number per channel; their count is a square.
        axes: world directions of the local x, y and z axis, orthonormal.
    """

    coefficients: tuple[tuple[float, ...], ...]
    axes: tuple[Vector, Vector, Vector] = _WORLD

    def __post_init__(self) -> None:
        rows = table(self, "coefficients", (None, None))
        if math.isqrt(len(rows)) ** 2 != len(rows):
            raise SceneError(path(self, "coefficients"), self.coefficients, "1, 4, 9, 16 … of them")
        # c_00 is the mean: below zero, or zero with anything beside it, the sum is negative somewhere
        for channel, (mean, *rest) in enumerate(rows.T):
            if mean < 0 or (mean == 0 and np.any(rest)):
                expected = "a number > 0, the mean over all directions: radiance is nowhere negative"
                raise SceneError(path(self, f"coefficients[0][{channel}]"), float(mean), expected)
        _orthonormal(self, "axes")

    @property
    def channels(self) -> int:
        """Channels of the radiance."""
        return len(self.coefficients[0])


DeltaLight = PointLight | SpotLight | DirectionalLight
Environment = ConstantEnvironment | EnvironmentMap | SphericalHarmonicsEnvironment
Light = DeltaLight | Environment
"""What emits without being a surface."""


def emits(light: Light) -> bool:
    """Whether any channel is above zero."""
    if isinstance(light, EnvironmentMap):
        return bool(light.image.array.max() > 0)
    if isinstance(light, SphericalHarmonicsEnvironment):
        return any(light.coefficients[0])
    if isinstance(light, DirectionalLight):
        return any(light.irradiance)
    return any(light.radiance if isinstance(light, ConstantEnvironment) else light.intensity)


def _orthonormal(owner: EnvironmentMap | SphericalHarmonicsEnvironment, field: str) -> None:
    axes = table(owner, field, (3, 3), low=-2.0, high=2.0)
    if not np.allclose(axes @ axes.T, np.eye(3), rtol=0, atol=1e-9):
        raise SceneError(path(owner, field), owner.axes, "three orthonormal vectors")
