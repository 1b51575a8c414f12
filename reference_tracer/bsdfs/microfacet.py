"""Rough surfaces: metal and glass made of microfacets with the GGX distribution of normals m.

    D(m)      = α² / (π ((α² − 1) cos² θm + 1)²)                        Walter et al. 2007, eq. 33
    G1(w)     = 2 / (1 + √(1 + α² tan² θ))                              eq. 34
    G2(wi,wo) = 2 / (√(1 + α² tan² θi) + √(1 + α² tan² θo))             Heitz 2014, eq. 99
    D_wo(m)   = G1(wo) D(m) max(wo·m, 0) / cos θo                       Heitz 2014, §3: the normals that wo sees

G2 is Smith's shadowing, correlated by height; a material may ask for the separable G1(wi) G1(wo) instead (Walter
et al., eq. 23). Refraction has the same one. Light scatters once, and what would scatter again is lost. The
sampling draws m from D_wo, so that f · cos / pdf is F G2 / G1, and a lossless surface loses 1 − G2 / G1 on average
over D_wo: that is ``single_scattering_loss``.

Walter et al. 2007, Microfacet models for refraction through rough surfaces, EGSR.
Heitz 2014, Understanding the masking-shadowing function in microfacet-based BRDFs, JCGT 3(2).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference_tracer import sampling
from reference_tracer.bsdfs import fresnel
from reference_tracer.bsdfs.bsdf import BSDFSample, cosine, front, table
from reference_tracer.bsdfs.specular import on_right_side, reflected, refracted
from reference_tracer.points import NOWHERE, Points
from reference_tracer.vectors import TINY, dot, unit
from scenes import RoughConductor, RoughDielectric

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

NODES = 256
"""Per axis, of the quadrature of single_scattering_loss."""


def D(cos_m: Array, alpha: Array) -> Array:
    """GGX density of facets about the normal, per solid angle of m and area of the surface, 1/sr."""
    return alpha**2 / (np.pi * ((alpha**2 - 1) * cos_m**2 + 1) ** 2)


def G1(cos_theta: Array, alpha: Array) -> Array:
    """Share of the facets facing a direction that it sees; cos θ > 0. Written without tan θ, which overflows."""
    return 2 * cos_theta / (cos_theta + _projected(cos_theta, alpha))


def G2(cos_i: Array, cos_o: Array, alpha: Array, separable: Mask) -> Array:
    """Share of the facets facing both directions that both see, for cosines > 0, of either side."""
    correlated = 2 * cos_i * cos_o / (cos_o * _projected(cos_i, alpha) + cos_i * _projected(cos_o, alpha))
    if not np.any(separable):
        return correlated
    return np.where(separable, G1(cos_i, alpha) * G1(cos_o, alpha), correlated)


def _projected(cos_theta: Array, alpha: Array) -> Array:
    """cos θ √(1 + α² tan² θ)."""
    return np.sqrt(cos_theta**2 + alpha**2 * (1 - cos_theta**2))


def square_to_visible_normals(u: Array, wo: Array, alpha: Array) -> Array:
    """Normals m about +z that wo sees, ``(3, n)``: a cap of the sphere, reflected and stretched.

    Dupuy and Benyoub 2023, Sampling visible GGX normals with spherical caps, CGF 42(8).

    Args:
        u: points of the unit square, ``(2, n)``.
        wo: unit directions with z ≥ 0, ``(3, n)``.
        alpha: roughness, ``(n,)``.
    """
    wx, wy, wz = unit(np.stack([alpha * wo[0], alpha * wo[1], wo[2]]))
    # c is uniform on the cap z > −wz, and c + wo is normal to the facet that mirrors wo into c
    height = (1 - u[1]) * (1 + wz)
    x, y = np.sqrt(np.maximum(1 - (height - wz) ** 2, 0)) * sampling.circle(u[0])
    return unit(np.stack([alpha * (x + wx), alpha * (y + wy), height]))


def square_to_visible_normals_pdf(cos_om: Array, cos_m: Array, cos_o: Array, alpha: Array) -> Array:
    """D_wo, the density of the above per solid angle of m; cos_om = wo·m > 0."""
    return G1(cos_o, alpha) * D(cos_m, alpha) * cos_om / cos_o


def _visible_normals(u: Array, wo: Array, n: Array, alpha: Array) -> Array:
    """Normals m about n that wo sees, in world coordinates, ``(3, n)``; wo is on the side of n."""
    s, t = sampling.frame(n)
    local = np.stack([dot(s, wo), dot(t, wo), np.maximum(dot(n, wo), TINY)])
    x, y, z = square_to_visible_normals(u, local, alpha)
    m: Array = x * s + y * t + z * n
    return m


class RoughConductorBSDF:
    """A rough metal: f = F D G2 / (4 cos θi cos θo) (Walter et al. 2007, eq. 20); its back is black."""

    needs_choice = False

    def __init__(self, materials: Sequence[RoughConductor | None], channels: int) -> None:
        # the index of the outside itself reflects nothing
        self._eta = table(materials, lambda m: m.eta, (1.0,) * channels)
        self._k = table(materials, lambda m: m.k, (0.0,) * channels)
        self._alpha = table(materials, lambda m: m.alpha, 1.0)
        self._separable = table(materials, lambda m: m.shadowing == "separable", 0.0) > 0

    def f(self, points: Points, wi: Array, wo: Array) -> Array:
        """F D G2 / (4 cos θi cos θo), ``(channels, n)``, 1/sr."""
        surface, alpha = front(points, wi, wo), self._alpha.take(points.surface)
        cos_i, cos_o = (np.maximum(cosine(points, w), TINY) for w in (wi, wo))
        m = unit(wi + wo)
        DG = D(dot(points.ns, m), alpha) * G2(cos_i, cos_o, alpha, self._separable.take(points.surface))
        value: Array = self._F(dot(wo, m), surface) * (DG / (4 * cos_i * cos_o))
        return value

    def pdf(self, points: Points, wi: Array, wo: Array) -> Array:
        """Solid angle density D_wo(m) / (4 wo·m), ``(n,)``."""
        surface, alpha = front(points, wi, wo), self._alpha.take(points.surface)
        cos_o = np.maximum(cosine(points, wo), TINY)
        m = unit(wi + wo)
        cos_om = np.maximum(dot(wo, m), TINY)
        density = square_to_visible_normals_pdf(cos_om, dot(points.ns, m), cos_o, alpha)
        return np.where(surface == NOWHERE, 0, density / (4 * cos_om))

    def sample(self, points: Points, wo: Array, u: Array) -> BSDFSample:
        """Directions mirrored by a facet that wo sees, with F G2 / G1."""
        alpha, n = self._alpha.take(points.surface), points.ns
        m = _visible_normals(u, wo, n, alpha)
        wi = reflected(wo, m)
        surface = front(points, wo, wi)
        cos_i, cos_o = (np.maximum(cosine(points, w), TINY) for w in (wi, wo))
        cos_om = np.maximum(dot(wo, m), TINY)
        density = square_to_visible_normals_pdf(cos_om, dot(n, m), cos_o, alpha)
        G = G2(cos_i, cos_o, alpha, self._separable.take(points.surface)) / G1(cos_o, alpha)
        weight = self._F(cos_om, surface) * G
        return BSDFSample(wi, weight, np.where(surface == NOWHERE, 0, density / (4 * cos_om)))

    def single_scattering_loss(self, surface: int, cos_theta: Array) -> Array:
        """1 − ∫ D_wo G2/G1 dm, what a metal with F = 1 loses, to 3e-4."""

        def kept(wo: Array, m: Array, alpha: Array, separable: Mask) -> Array:
            cos_i = 2 * dot(wo, m) * m[2] - wo[2]
            G = G2(np.maximum(cos_i, TINY), wo[2], alpha, separable)
            return np.where(cos_i > 0, G / G1(wo[2], alpha), 0)

        parameters = self._alpha[surface], self._separable[surface]
        return _loss(kept, np.maximum(cos_theta, TINY), *parameters) * (cos_theta > 0)

    def _F(self, cos_om: Array, surface: NDArray[np.intp]) -> Array:
        eta, k = self._eta.take(surface, axis=1), self._k.take(surface, axis=1)
        return fresnel.conductor(np.maximum(cos_om, TINY), eta, k)


@dataclass
class _Facet:
    """Microfacets m that reflect or refract wo into wi, one per lane.

    Attributes:
        cos_i, cos_o: |cos| of wi and wo to the normal of the surface.
        cos_im, cos_om: |cos| of the two to m.
        cos_m: cos of m to the normal.
        alpha, separable: roughness, and which G2.
        eta: η_i / η_o, the index on the other side over that on the side of wo.
        reflects: wi is on the side of wo.
        exists: there is such a facet; the rest of a lane means something.
    """

    cos_i: Array
    cos_o: Array
    cos_im: Array
    cos_om: Array
    cos_m: Array
    alpha: Array
    separable: Mask
    eta: Array
    reflects: Mask
    exists: Mask

    def pdf(self) -> Array:
        """Solid angle density of wi: D_wo × the share that goes there × dm/dwi (Walter et al. 2007, eq. 14, 17)."""
        F = fresnel.dielectric(self.cos_om, self.eta)
        half = np.maximum((self.cos_om - self.eta * self.cos_im) ** 2, TINY)
        share = np.where(self.reflects, F / (4 * self.cos_om), (1 - F) * self.eta**2 * self.cos_im / half)
        density = square_to_visible_normals_pdf(self.cos_om, self.cos_m, self.cos_o, self.alpha)
        return np.where(self.exists, density * share, 0)

    def weight(self) -> Array:
        """f · |cos θi| / pdf: G2 / G1, over η² for refracted radiance."""
        G = G2(self.cos_i, self.cos_o, self.alpha, self.separable) / G1(self.cos_o, self.alpha)
        return np.where(self.exists, np.where(self.reflects, G, G / self.eta**2), 0)


class RoughDielectricBSDF:
    """Rough glass, from both sides; the front looks into the exterior (Walter et al. 2007, eq. 20 and 21).

        f reflected = F D G2 / (4 cos θi cos θo)
        f refracted = |wi·m| |wo·m| / (|cos θi| |cos θo|) · (1 − F) D G2 / (wo·m + η wi·m)²

    with η = η_i / η_o; the latter holds for radiance, f(wi, wo) / η_o² is the same with the two exchanged. A facet
    that wo sees reflects with probability F and refracts otherwise.
    """

    needs_choice = True

    def __init__(self, materials: Sequence[RoughDielectric | None], channels: int) -> None:
        self._channels = channels
        self._eta = table(materials, lambda m: fresnel.relative_index(m.interior_ior, m.exterior_ior), 1.5)
        self._alpha = table(materials, lambda m: m.alpha, 1.0)
        self._separable = table(materials, lambda m: m.shadowing == "separable", 0.0) > 0

    def f(self, points: Points, wi: Array, wo: Array) -> Array:
        """weight · pdf / |cos θi|, where G1 cancels; the same in each channel, ``(channels, n)``, 1/sr."""
        facet = self._facet(points, wi, wo)
        return np.tile(facet.weight() * facet.pdf() / facet.cos_i, (self._channels, 1))

    def pdf(self, points: Points, wi: Array, wo: Array) -> Array:
        """Solid angle density of ``sample`` over the whole sphere, ``(n,)``."""
        return self._facet(points, wi, wo).pdf()

    def sample(self, points: Points, wo: Array, u: Array) -> BSDFSample:
        """Directions reflected or refracted by a facet that wo sees, with G2 / G1, over η² where refracted."""
        cos_o, n, eta, alpha = self._side(points, wo)
        m = _visible_normals(u, wo, n, alpha)
        cos_om = np.maximum(dot(wo, m), TINY)
        reflects = u[2] < fresnel.dielectric(cos_om, eta)
        wi = np.where(reflects, reflected(wo, m), refracted(wo, m, eta))
        cos_i, cos_im = cosine(points, wi), np.abs(dot(wi, m))
        exists = on_right_side(points, cos_i, cos_o, reflects)
        cos_i, cos_o = (np.maximum(np.abs(c), TINY) for c in (cos_i, cos_o))
        separable = self._separable.take(points.surface)
        facet = _Facet(cos_i, cos_o, cos_im, cos_om, dot(n, m), alpha, separable, eta, reflects, exists)
        return BSDFSample(wi, np.tile(facet.weight(), (self._channels, 1)), facet.pdf())

    def single_scattering_loss(self, surface: int, cos_theta: Array) -> Array:
        """1 − ∫ D_wo (F G2/G1 reflected + (1 − F) G2/G1 refracted) dm, where radiance is counted over η².

        Glass absorbs nothing, so this is all that it loses, to 3e-4.
        """

        def kept(wo: Array, m: Array, alpha: Array, separable: Mask, eta: Array) -> Array:
            cos_om = np.maximum(dot(wo, m), TINY)
            F = fresnel.dielectric(cos_om, eta)
            total = np.zeros_like(cos_om)
            for share, wi, side in ((F, reflected(wo, m), 1), (1 - F, refracted(wo, m, eta), -1)):
                cos_i = side * wi[2]
                G = G2(np.maximum(cos_i, TINY), wo[2], alpha, separable) / G1(wo[2], alpha)
                total += np.where(cos_i > 0, share * G, 0)
            return total

        eta = np.where(cos_theta > 0, self._eta[surface], 1 / self._eta[surface])
        return _loss(kept, np.abs(cos_theta), self._alpha[surface], self._separable[surface], eta)

    def _facet(self, points: Points, wi: Array, wo: Array) -> _Facet:
        """The facet between two directions: half way, or where they obey Snell's law."""
        cos_o, n, eta, alpha = self._side(points, wo)
        cos_i = cosine(points, wi)
        reflects = cos_i * cos_o > 0
        m = unit(wo + np.where(reflects, 1, eta) * wi)
        m *= np.where(dot(n, m) < 0, -1, 1)
        cos_im, cos_om = dot(wi, m), dot(wo, m)
        exists = on_right_side(points, cos_i, cos_o, reflects) & (cos_om > 0) & ((cos_im > 0) == reflects)
        cos_i, cos_o, cos_om = (np.maximum(np.abs(c), TINY) for c in (cos_i, cos_o, cos_om))
        separable = self._separable.take(points.surface)
        return _Facet(
            cos_i, cos_o, np.abs(cos_im), cos_om, dot(n, m), alpha, separable, eta, reflects, exists
        )

    def _side(self, points: Points, wo: Array) -> tuple[Array, Array, Array, Array]:
        """cos θo, the normals on the side of wo, η_i / η_o of refraction, and the roughness."""
        cos_o = cosine(points, wo)
        inside = cos_o < 0
        eta = self._eta.take(points.surface)
        n = np.where(inside, -points.ns, points.ns)
        return cos_o, n, np.where(inside, 1 / eta, eta), self._alpha.take(points.surface)


def _loss(kept: Callable[..., Array], cos_theta: Array, *parameters: Array) -> Array:
    """1 − ∫ D_wo(m) kept(wo, m, …) dm by Gauss's quadrature over the unit square, for each cosine of wo."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    nodes, weights = (nodes + 1) / 2, weights / 2
    u = np.stack(np.meshgrid(nodes / 2, nodes)).reshape(2, -1)  # what is right of wo is as what is left of it
    areas = np.outer(weights, weights).ravel()
    loss = np.empty_like(cos_theta)
    for place, c in np.ndenumerate(cos_theta):
        alpha, *others = (np.full(len(areas), np.broadcast_to(p, loss.shape)[place]) for p in parameters)
        wo = np.array([[np.sqrt(1 - c**2)], [0.0], [c]]) * np.ones(len(areas))
        loss[place] = 1 - areas @ kept(wo, square_to_visible_normals(u, wo, alpha), alpha, *others)
    return loss
