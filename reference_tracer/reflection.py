"""R, local reflection: the BSDF of a scene, which goes to that of each surface's material.

    Lo(x, wo) = ∫ f(x, wi, wo) Li(x, wi) |cos θi| dwi

See ``bsdf`` for what a BSDF is. All surfaces with the same type of material are evaluated at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reference_tracer import sampling
from reference_tracer.bsdfs.bsdf import BSDF, BSDFSample, cosine, front, table
from reference_tracer.bsdfs.microfacet import RoughConductorBSDF, RoughDielectricBSDF
from reference_tracer.bsdfs.specular import ConductorBSDF, DielectricBSDF, MirrorBSDF
from reference_tracer.bsdfs.textures import Albedo
from reference_tracer.points import NOWHERE, Points
from reference_tracer.vectors import TINY, norm
from scenes import (
    Blend,
    Conductor,
    Dielectric,
    Lambertian,
    Material,
    Mirror,
    RoughConductor,
    RoughDielectric,
    Scene,
)

__all__ = ["BSDF", "BSDFSample", "BlendBSDF", "LambertianBSDF", "PerSurfaceBSDF", "bsdf_of"]

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

BELOW_ONE = np.nextafter(1.0, 0.0)
"""The largest number below 1: quotients that choose a lobe are rounded, and may become 1."""


def bsdf_of(scene: Scene) -> BSDF:
    """The BSDF of all surfaces of a scene."""
    return _bsdf([surface.material for surface in scene.surfaces], scene.channels)


class LambertianBSDF:
    """f = albedo / π on the front, 0 on the back (Lambert 1760). Nothing is lost."""

    needs_choice = False

    def __init__(self, materials: Sequence[Lambertian | None], channels: int) -> None:
        self._albedo = Albedo([None if m is None else m.albedo for m in materials], channels)

    def f(self, points: Points, wi: Array, wo: Array) -> Array:
        """albedo / π, ``(channels, n)``, 1/sr."""
        return self._albedo(points, front(points, wi, wo)) / np.pi

    def pdf(self, points: Points, wi: Array, wo: Array) -> Array:
        """Solid angle density cos θi / π, ``(n,)``."""
        return sampling.square_to_cosine_hemisphere_pdf(cosine(points, wi)) * (cosine(points, wo) > 0)

    def sample(self, points: Points, wo: Array, u: Array) -> BSDFSample:
        """Directions to the points of the unit sphere that touches the surface at x; they have density cos θi / π.

        A Lambertian x lights that sphere evenly, as it does an integrating sphere. A chord of length l from x to
        it makes cos θi = l / 2. This needs no frame about the normal, and half the time of a lifted disk.
        """
        sphere = np.stack([*(2 * np.sqrt(u[0] * (1 - u[0])) * sampling.circle(u[1])), 1 - 2 * u[0]])
        chord = sphere + points.ns
        length = norm(chord)
        wi = chord / (length + TINY)
        # every chord is on the side of the shading normal, so without one of its own wo alone decides; one point
        # of the sphere is x itself, and gives no direction
        surface = front(points, wo) if points.ns is points.n else front(points, wo, wi)
        surface = np.where(length > 0, surface, NOWHERE)
        return BSDFSample(wi, self._albedo(points, surface), length * (surface != NOWHERE) * (0.5 / np.pi))

    def single_scattering_loss(self, surface: int, cos_theta: Array) -> Array:
        """None."""
        return np.zeros_like(cos_theta)


class PerSurfaceBSDF:
    """The BSDFs of several types of material; each is evaluated where it is met."""

    def __init__(self, types: Sequence[type | None], bsdfs: dict[type, BSDF], channels: int) -> None:
        """``types`` has that of the material of each surface, None where there is none."""
        self._bsdfs, self._channels = list(bsdfs.values()), channels
        order = {kind: i for i, kind in enumerate(bsdfs)}
        self._which = np.array([-1 if kind is None else order[kind] for kind in (*types, None)])
        self.needs_choice = any(bsdf.needs_choice for bsdf in self._bsdfs)

    def f(self, points: Points, wi: Array, wo: Array) -> Array:
        """Value per channel, ``(channels, n)``, 1/sr."""
        value = np.zeros((self._channels, len(points)))
        for bsdf, lanes in self._met(points):
            value[:, lanes] = bsdf.f(points[lanes], wi[:, lanes], wo[:, lanes])
        return value

    def pdf(self, points: Points, wi: Array, wo: Array) -> Array:
        """Solid angle density of ``sample``, ``(n,)``."""
        density = np.zeros(len(points))
        for bsdf, lanes in self._met(points):
            density[lanes] = bsdf.pdf(points[lanes], wi[:, lanes], wo[:, lanes])
        return density

    def sample(self, points: Points, wo: Array, u: Array) -> BSDFSample:
        """Directions chosen by the BSDF of each point."""
        return _sample_each(self._met(points), self._channels, points, wo, u)

    def single_scattering_loss(self, surface: int, cos_theta: Array) -> Array:
        """That of the surface's own BSDF."""
        return self._bsdfs[int(self._which[surface])].single_scattering_loss(surface, cos_theta)

    def _met(self, points: Points) -> Iterator[tuple[BSDF, Indices]]:
        """Each BSDF that is met, and where."""
        return _lanes(self._bsdfs, self._which.take(points.surface))


class BlendBSDF:
    """f = (1 − w) f₁ + w f₂; the second is chosen with probability w. Loses what its two parts lose.

    A direction that a smooth lobe has chosen is weighted with the density of all smooth lobes together.
    """

    needs_choice = True

    def __init__(self, materials: Sequence[Blend | None], channels: int) -> None:
        self._channels = channels
        self._w = table(materials, lambda m: m.weight, 0.0)
        self._first = _bsdf([None if m is None else m.first for m in materials], channels)
        self._second = _bsdf([None if m is None else m.second for m in materials], channels)

    def f(self, points: Points, wi: Array, wo: Array) -> Array:
        """(1 − w) f₁ + w f₂, ``(channels, n)``, 1/sr."""
        w = self._w.take(points.surface)
        return (1 - w) * self._first.f(points, wi, wo) + w * self._second.f(points, wi, wo)

    def pdf(self, points: Points, wi: Array, wo: Array) -> Array:
        """(1 − w) p₁ + w p₂, ``(n,)``."""
        w = self._w.take(points.surface)
        return (1 - w) * self._first.pdf(points, wi, wo) + w * self._second.pdf(points, wi, wo)

    def sample(self, points: Points, wo: Array, u: Array) -> BSDFSample:
        """Directions of one of the two, which gets the rest of the number that chose it."""
        w = self._w.take(points.surface)
        second = u[2] < w
        rest = np.where(second, u[2] / np.where(second, w, 1), (u[2] - w) / np.where(second, 1, 1 - w))
        u = np.stack([u[0], u[1], np.minimum(rest, BELOW_ONE)])
        lanes = _lanes([self._first, self._second], second.astype(np.intp))
        sample = _sample_each(lanes, self._channels, points, wo, u)
        # a delta lobe keeps its own weight; a direction that its lobe has refused stays refused
        smooth = np.flatnonzero((sample.pdf > 0) & np.isfinite(sample.pdf))
        if len(smooth):
            points, wi, wo = points[smooth], sample.wi[:, smooth], wo[:, smooth]
            pdf = self.pdf(points, wi, wo)
            sample.pdf[smooth] = pdf
            sample.weight[:, smooth] = self.f(points, wi, wo) * (np.abs(cosine(points, wi)) / pdf)
        return sample

    def single_scattering_loss(self, surface: int, cos_theta: Array) -> Array:
        """(1 − w) · loss₁ + w · loss₂."""
        w, parts = float(self._w[surface]), (self._first, self._second)
        first, second = (part.single_scattering_loss(surface, cos_theta) for part in parts)
        return (1 - w) * first + w * second


_BSDFS: dict[type, Callable[[Sequence[Any], int], BSDF]] = {
    Lambertian: LambertianBSDF,
    Mirror: MirrorBSDF,
    Dielectric: DielectricBSDF,
    Conductor: ConductorBSDF,
    RoughConductor: RoughConductorBSDF,
    RoughDielectric: RoughDielectricBSDF,
    Blend: BlendBSDF,
}
"""What evaluates a type of material."""


def _bsdf(materials: Sequence[Material | None], channels: int) -> BSDF:
    """The BSDF of materials, one per surface; a single type needs no distribution among several."""
    types = [None if material is None else type(material) for material in materials]
    bsdfs = {
        kind: _BSDFS[kind]([m if type(m) is kind else None for m in materials], channels)
        for kind in dict.fromkeys(types)
        if kind is not None
    }
    return next(iter(bsdfs.values())) if len(bsdfs) == 1 else PerSurfaceBSDF(types, bsdfs, channels)


def _lanes(bsdfs: Sequence[BSDF], which: Indices) -> Iterator[tuple[BSDF, Indices]]:
    """Each BSDF with the lanes that have its index, where there are any."""
    for i, bsdf in enumerate(bsdfs):
        lanes = np.flatnonzero(which == i)
        if len(lanes):
            yield bsdf, lanes


def _sample_each(
    parts: Iterable[tuple[BSDF, Indices]], channels: int, points: Points, wo: Array, u: Array
) -> BSDFSample:
    """The samples of several BSDFs, each in its own lanes; black in lanes of none."""
    n = len(points)
    sample = BSDFSample(wo.copy(), np.zeros((channels, n)), np.zeros(n))
    for bsdf, lanes in parts:
        part = bsdf.sample(points[lanes], wo[:, lanes], u[:, lanes])
        sample.wi[:, lanes], sample.weight[:, lanes], sample.pdf[lanes] = part.wi, part.weight, part.pdf
    return sample
