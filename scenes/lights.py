"""Lights: what a surface emits by itself, the data of E."""

from __future__ import annotations

import math

import msgspec

from scenes.validation import SceneError, instance, number, numbers, path, unit_vector


class PolarRange(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A zone of a sphere: the points whose polar angle, measured from ``axis``, lies in [low, high].

    Attributes:
        low, high: polar angles in degrees, 0 ≤ low < high ≤ 180. ``low=0`` makes a cap.
        axis: where the polar angle is 0, seen from the centre; normalised.
    """

    low: float = 0.0
    high: float = 180.0
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)

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


class AreaLight(msgspec.Struct, frozen=True, tag_field="type", tag="area", forbid_unknown_fields=True):
    """A surface that emits the same radiance from its front into every direction.

    Attributes:
        radiance: per channel, ≥ 0, W·m⁻²·sr⁻¹ or any unit proportional to it.
        polar_range: limits the emission of a sphere to a zone; None for the whole surface.
    """

    radiance: tuple[float, ...]
    polar_range: PolarRange | None = None

    def __post_init__(self) -> None:
        if not numbers(self, "radiance", low=0.0):
            raise SceneError(path(self, "radiance"), self.radiance, "one number per channel")
        instance(self, "polar_range", PolarRange | None, "a PolarRange or None")


Emission = AreaLight
