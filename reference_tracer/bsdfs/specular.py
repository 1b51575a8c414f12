"""Perfectly smooth surfaces: mirror, glass, metal. They reflect and refract into single directions.

f is a delta distribution, so ``f`` and ``pdf`` are 0 and only ``sample`` finds these directions:

    reflected   wi = 2 (wo·n) n − wo                          weight F
    refracted   wi = ((c − g) n − wo) / η                     weight (1 − F) / η²

with n on the side of wo, c = wo·n, η = η_i / η_o the index on the other side over that on the side of wo, and
g = √(η² − 1 + c²) (Snell's law). Radiance is a density of solid angle, which refraction compresses: it is
Lo = (1 − F) Li / η² (Veach 1997, §5.2).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from reference_tracer.bsdfs import fresnel
from reference_tracer.bsdfs.bsdf import BSDFSample, cosine, front, table
from reference_tracer.points import NOWHERE, Points
from reference_tracer.vectors import TINY, dot
from scenes import Conductor, Dielectric, Mirror

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def reflected(wo: Array, n: Array) -> Array:
    """The mirrored directions, ``(3, n)``, about normals."""
    return 2 * dot(wo, n) * n - wo


def refracted(wo: Array, n: Array, eta: Array) -> Array:
    """The refracted directions, ``(3, n)``; of no meaning under total internal reflection.

    Args:
        wo: directions on the side of n.
        n: unit normals.
        eta: index on the other side over that on the side of wo.
    """
    c = dot(wo, n)
    return ((c - fresnel.refracted(c, eta)) * n - wo) / eta


def on_right_side(points: Points, cos_i: Array, cos_o: Array, reflects: Mask) -> Mask:
    """Whether wi is on the side of wo, for reflection, or on the other, for refraction; NOWHERE it never is."""
    same, other = cos_i * cos_o > 0, cos_i * cos_o < 0
    found: Mask = np.where(reflects, same, other) & (points.surface != NOWHERE)
    return found


class SpecularBSDF:
    """What all delta lobes have in common: no value, no density, and no loss, since light scatters once only."""

    def __init__(self, channels: int) -> None:
        self._channels = channels

    def f(self, points: Points, wi: Array, wo: Array) -> Array:
        """0, ``(channels, n)``."""
        return np.zeros((self._channels, len(points)))

    def pdf(self, points: Points, wi: Array, wo: Array) -> Array:
        """0, ``(n,)``."""
        return np.zeros(len(points))

    def single_scattering_loss(self, surface: int, cos_theta: Array) -> Array:
        """None."""
        return np.zeros_like(cos_theta)


class MirrorBSDF(SpecularBSDF):
    """Reflects the same share at any angle; its back is black."""

    needs_choice = False

    def __init__(self, materials: Sequence[Mirror | None], channels: int) -> None:
        super().__init__(channels)
        self._reflectance = table(materials, lambda m: m.reflectance, (0.0,) * channels)

    def sample(self, points: Points, wo: Array, u: Array) -> BSDFSample:
        """The mirrored direction, with the reflectance."""
        wi = reflected(wo, points.ns)
        surface = front(points, wo, wi)
        pdf = np.where(surface == NOWHERE, 0.0, np.inf)
        return BSDFSample(wi, self._reflectance.take(surface, axis=1), pdf)


class ConductorBSDF(SpecularBSDF):
    """A smooth metal: F of the complex index, per channel; its back is black."""

    needs_choice = False

    def __init__(self, materials: Sequence[Conductor | None], channels: int) -> None:
        super().__init__(channels)
        # the index of the outside itself reflects nothing
        self._eta = table(materials, lambda m: m.eta, (1.0,) * channels)
        self._k = table(materials, lambda m: m.k, (0.0,) * channels)

    def sample(self, points: Points, wo: Array, u: Array) -> BSDFSample:
        """The mirrored direction, with F."""
        wi = reflected(wo, points.ns)
        surface = front(points, wo, wi)
        cos_o = np.maximum(cosine(points, wo), TINY)
        F = fresnel.conductor(cos_o, self._eta.take(surface, axis=1), self._k.take(surface, axis=1))
        return BSDFSample(wi, F, np.where(surface == NOWHERE, 0.0, np.inf))


class DielectricBSDF(SpecularBSDF):
    """Glass, from both sides: reflects with probability F, refracts otherwise; the front looks into the exterior."""

    needs_choice = True

    def __init__(self, materials: Sequence[Dielectric | None], channels: int) -> None:
        super().__init__(channels)
        self._eta = table(materials, lambda m: fresnel.relative_index(m.interior_ior, m.exterior_ior), 1.0)

    def sample(self, points: Points, wo: Array, u: Array) -> BSDFSample:
        """The mirrored direction, with 1, or the refracted one, with 1 / η²."""
        cos_o = cosine(points, wo)
        inside = cos_o < 0
        eta = self._eta.take(points.surface)
        eta = np.where(inside, 1 / eta, eta)
        n = np.where(inside, -points.ns, points.ns)
        reflects = u[2] < fresnel.dielectric(np.maximum(np.abs(cos_o), TINY), eta)
        wi = np.where(reflects, reflected(wo, n), refracted(wo, n, eta))
        found = on_right_side(points, cosine(points, wi), cos_o, reflects)
        scale = np.where(reflects, 1.0, 1 / eta**2) * found
        return BSDFSample(wi, np.tile(scale, (self._channels, 1)), np.where(found, np.inf, 0.0))
