"""GGX microfacets for the answers of cases: values of f, and albedos by quadrature. Single scattering.

    D(m)      = α² / (π cos⁴ θm (α² + tan² θm)²)                             Walter et al. 2007, eq. 33
    G1(w)     = 2 / (1 + √(1 + α² tan² θ))                                   eq. 34
    G         = G1(wi) G1(wo), the separable form of Smith's shadowing       eq. 23
    f         = F D G / (4 cos θi cos θo)                                    eq. 20, reflected
    f         = |wi·m| |wo·m| / (|cos θi| |cos θo|) · (1 − F) D G / (η wi·m + wo·m)²      eq. 21, refracted

with η the index on the side of wi over that on the side of wo; the last one is for radiance.

Directions are local, +z is the normal on the side of wo, arrays are by component. Walter, Marschner, Li and Torrance
2007, Microfacet models for refraction through rough surfaces, EGSR.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from scenes import fresnel
from scenes.materials import RoughConductor, RoughDielectric

Array = NDArray[np.float64]

NODES = 80
"""Of Gauss's quadrature over each angle of an albedo; from α = 0.3 on, more of them change it by 1e-13."""

COSINES: Array = np.cos((np.polynomial.legendre.leggauss(NODES)[0] + 1) * np.pi / 4)
"""Of these nodes, from the normal to grazing."""

SMOOTHEST = 0.3
"""The least α for which that many nodes are enough."""


def distribution(cos_m: Array, alpha: float) -> Array:
    """D, per solid angle of m and area of the surface."""
    tan2 = 1 / cos_m**2 - 1
    D: Array = alpha**2 / (np.pi * cos_m**4 * (alpha**2 + tan2) ** 2)
    return D


def shadowing(cos_theta: Array, alpha: float) -> Array:
    """G1 of a direction; it is the same above and below."""
    G1: Array = 2 / (1 + np.sqrt(1 + alpha**2 * (1 / cos_theta**2 - 1)))
    return G1


def conductor(material: RoughConductor, wi: Array, wo: Array) -> Array:
    """f of a rough metal between two directions above it, ``(channels, n)``."""
    _separable(material)
    h = wi + wo
    m = h / np.linalg.norm(h, axis=0)
    F = fresnel.conductor((wo * m).sum(axis=0), material.eta, material.k)
    return F * _reflected(m, wi, wo, material.alpha)


def dielectric(material: RoughDielectric, wi: Array, wo: Array) -> Array:
    """f of rough glass, ``(n,)``, for wo outside; wi outside, for reflection, or inside, for refraction."""
    _separable(material)
    eta, above = material.interior_ior / material.exterior_ior, wi[2] > 0
    h = np.where(above, 1, eta) * wi + wo
    m = h / np.linalg.norm(h, axis=0)
    m = m * np.sign(m[2])
    cos_im, cos_om = (wi * m).sum(axis=0), (wo * m).sum(axis=0)
    F = fresnel.dielectric(np.maximum(cos_om, 0), eta)
    D, G = distribution(m[2], material.alpha), _shadowing(wi, wo, material.alpha)
    f_t = np.abs(cos_im * cos_om / (wi[2] * wo[2])) * (1 - F) * D * G / (eta * cos_im + cos_om) ** 2
    exists = (cos_om > 0) & ((cos_im > 0) == above)
    return np.where(exists, np.where(above, F * _reflected(m, wi, wo, material.alpha), f_t), 0)


def conductor_albedo(material: RoughConductor, cos_theta: Array) -> Array:
    """∫ f cos θi dwi over the hemisphere, ``(channels, n)``."""
    return conductor_reflected(material, cos_theta, np.ones((material.channels, NODES)))


def conductor_reflected(material: RoughConductor, cos_theta: Array, incident: Array) -> Array:
    """∫ f Li cos θi dwi over the hemisphere, where Li depends on θi alone, ``(channels, n)``.

    Args:
        material: what reflects.
        cos_theta: of wo, ``(n,)``.
        incident: Li at ``COSINES``, ``(channels, NODES)``.
    """
    _wide(material.alpha)
    all_round = np.tile(incident, NODES)
    return _over_hemisphere(cos_theta, material.alpha, lambda wi, wo: conductor(material, wi, wo) * all_round)


def dielectric_albedos(material: RoughDielectric, cos_theta: Array) -> tuple[Array, Array]:
    """∫ f |cos θi| dwi above and below, each ``(n,)``, for wo outside in the thinner medium.

    Below, over the facets m instead of wi: D (wo·m) G / cos θo is their projected area, 1 − F of it goes on, and
    1/η² of the radiance arrives. In coordinates m = (sin ψ cos β, sin β, cos ψ cos β), wo in the plane of x and z,
    the facets that wo sees are a rectangle, −π/2 < β < π/2, θo − π/2 < ψ < π/2, on which all is analytic.
    """
    eta, alpha = material.interior_ior / material.exterior_ior, material.alpha
    _wide(alpha)
    if eta <= 1:
        raise ValueError(
            f"interior over exterior index {eta:g}: expected more than 1, no total internal reflection"
        )
    above = _over_hemisphere(cos_theta, alpha, lambda wi, wo: dielectric(material, wi, wo)[None])[0]
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    below = np.empty_like(cos_theta)
    for at, c in enumerate(cos_theta):
        theta = np.arccos(c)
        psi, beta = np.meshgrid(np.pi / 2 - (np.pi - theta) * (1 - nodes) / 2, nodes * np.pi / 2)
        areas = np.outer(weights, weights) * np.cos(beta) * (np.pi - theta) / 2 * np.pi / 2
        m = np.stack([np.sin(psi) * np.cos(beta), np.sin(beta), np.cos(psi) * np.cos(beta)])
        wo = np.array([np.sin(theta), 0.0, c])[:, None, None]
        cos_om = np.cos(beta) * np.cos(psi - theta)
        g = np.sqrt(eta**2 - 1 + cos_om**2)
        wi = ((cos_om - g) * m - wo) / eta  # Snell's law
        D, G = distribution(m[2], alpha), _shadowing(wi, wo, alpha)
        below[at] = ((1 - fresnel.dielectric(cos_om, eta)) * D * G * cos_om * areas).sum() / (c * eta**2)
    return above, below


def _wide(alpha: float) -> None:
    if alpha < SMOOTHEST:
        raise ValueError(
            f"alpha {alpha:g}: {NODES} nodes are for {SMOOTHEST:g} and more, a narrower lobe needs more"
        )


def _over_hemisphere(cos_theta: Array, alpha: float, f: Callable[[Array, Array], Array]) -> Array:
    """∫ f cos θi dwi for each cosine of wo, ``(channels, n)``, by Gauss's quadrature in θi and in azimuth.

    With φ from the mirrored direction, D goes as one over the square of P + Q sin² φ/2, P = (sin θi − sin θo)² +
    α² (cos θi + cos θo)², Q = 4 sin θi sin θo: towards grazing angles as narrow as w = 2 √(P / (P + Q)). So it is
    integrated over u, φ = w sinh u, in which it is as wide at all angles.
    """
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    nodes, weights = (nodes + 1) / 2, weights / 2
    ci, si = COSINES, np.sqrt(1 - COSINES**2)
    found = []
    for co in cos_theta:
        so = np.sqrt(1 - co**2)
        P, Q = (si - so) ** 2 + alpha**2 * (ci + co) ** 2, 4 * si * so
        w = 2 * np.sqrt(P / (P + Q))
        end = np.arcsinh(np.pi / w)
        u = end * nodes[:, None]
        phi, d_phi = w * np.sinh(u), w * np.cosh(u) * end * weights[:, None]
        wi = np.stack([-si * np.cos(phi), si * np.sin(phi), np.broadcast_to(ci, phi.shape)])
        # twice, since the other half of the azimuths is the same
        areas = 2 * d_phi * (weights * np.pi / 2 * si * ci)
        found.append(f(wi.reshape(3, -1), np.array([[so], [0.0], [co]])) @ areas.ravel())
    return np.stack(found, axis=1)


def _reflected(m: Array, wi: Array, wo: Array, alpha: float) -> Array:
    """D G / (4 cos θi cos θo)."""
    value: Array = distribution(m[2], alpha) * _shadowing(wi, wo, alpha) / (4 * wi[2] * wo[2])
    return value


def _shadowing(wi: Array, wo: Array, alpha: float) -> Array:
    return shadowing(wi[2], alpha) * shadowing(wo[2], alpha)


def _separable(material: RoughConductor | RoughDielectric) -> None:
    if material.shadowing != "separable":
        raise ValueError(f"shadowing {material.shadowing!r}: these formulas are for 'separable'")
