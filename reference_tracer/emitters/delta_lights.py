"""Point, spot and directional lights: each is seen in exactly one direction, which no other strategy finds.

They have no radiance as a field. Their incident light is a Dirac delta of direction, so that the integral over
directions leaves f · cos θ times

    point, spot    intensity / d²   (W·m⁻²·sr⁻¹ per unit of f)
    directional    irradiance

which takes the place of Li. ``incident`` gives it for one light; TE is the sum over all lights.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference_tracer.emitters.emitter_sample import EmitterSample
from reference_tracer.points import NOWHERE, Points
from reference_tracer.vectors import norm
from scenes import DeltaLight, DirectionalLight, PointLight, Scene, SpotLight

Array = NDArray[np.float64]


@dataclass
class DeltaEmitter:
    """One point, spot or directional light.

    Attributes:
        light: the light.
        radius: of a sphere around the scene, which a directional light illuminates; its power depends on it.
    """

    light: DeltaLight
    radius: float

    @property
    def power(self) -> float:
        """W, the mean of the channels.

        4πI for a point, π R² E for a directional light, and for a spot, whose intensity falls linearly from the
        beam b to the cutoff c,

            2πI [∫₀ᵇ sin θ dθ + ∫ᵇᶜ (c − θ) / (c − b) sin θ dθ] = 2πI [1 − (sin c − sin b) / (c − b)]
        """
        if isinstance(self.light, DirectionalLight):
            return float(np.mean(self.light.irradiance)) * np.pi * self.radius**2
        return float(np.mean(self.light.intensity)) * self._solid_angle()

    def _solid_angle(self) -> float:
        if isinstance(self.light, PointLight):
            return 4 * np.pi
        assert isinstance(self.light, SpotLight)
        c, b = np.radians(self.light.cutoff), np.radians(self.light.beam)
        # (sin c − sin b) / (c − b) as a product, which does not cancel; a sharp edge leaves cos c
        chord = np.cos((c + b) / 2) * np.sinc((c - b) / 2 / np.pi)
        return float(2 * np.pi * (1 - chord))

    def incident(self, reference: Points) -> tuple[Array, Array, Array]:
        """What arrives at the references if nothing lies between.

        Returns:
            wi ``(3, n)``, distance ``(n,)`` (inf for directional light), Li ``(channels, n)`` as above. 0 at the
            very place of the light.
        """
        if isinstance(self.light, DirectionalLight):
            n = len(reference)
            wi = np.tile(-np.array(self.light.direction)[:, None], n)
            return wi, np.full(n, np.inf), np.tile(np.array(self.light.irradiance)[:, None], n)
        segment = np.array(self.light.position)[:, None] - reference.x
        distance = norm(segment)
        there = distance == 0
        distance[there] = 1
        wi = segment / distance
        Li = np.array(self.light.intensity)[:, None] * (self._falloff(wi) * ~there / distance**2)
        return wi, distance, Li

    def _falloff(self, wi: Array) -> Array | float:
        """The share of the full intensity that leaves along −wi."""
        if not isinstance(self.light, SpotLight):
            return 1.0
        axis = np.array(self.light.direction)[:, None]
        # the angle between unit vectors that keeps its digits near 0 and π (Kahan 2006, §12)
        angle = np.degrees(
            2 * np.arctan2(np.linalg.norm(-wi - axis, axis=0), np.linalg.norm(-wi + axis, axis=0))
        )
        fall = self.light.cutoff - self.light.beam
        sharp = np.where(angle < self.light.cutoff, 1.0, 0.0)
        return sharp if fall == 0 else np.clip((self.light.cutoff - angle) / fall, 0.0, 1.0)

    def sample(self, reference: Points, u: Array) -> EmitterSample:
        """The one direction there is; the pdf is that of the choice, 1 here."""
        wi, distance, Li = self.incident(reference)
        n = len(reference)
        return EmitterSample(wi, distance, Li, np.ones(n), True, np.full(n, NOWHERE))

    def pdf(self, reference: Points, points: Points, wi: Array) -> Array:
        """0: no ray meets it."""
        return np.zeros(len(reference))


def delta_lights(scene: Scene, radius: float) -> list[DeltaEmitter]:
    """The point, spot and directional lights of a scene, in its order; its bounding sphere has that radius."""
    return [DeltaEmitter(light, radius) for light in scene.lights if isinstance(light, DeltaLight)]
