"""Faults of R in what has Fresnel's equations: glass and metal, smooth and rough."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Fault, Plant
from comparisons.faults.planting import Replacement, in_tracer
from comparisons.faults.scene_changes import of_materials, replace
from reference_tracer.bsdfs import fresnel, microfacet
from reference_tracer.bsdfs.bsdf import BSDFSample, cosine
from reference_tracer.bsdfs.microfacet import RoughConductorBSDF
from reference_tracer.bsdfs.specular import DielectricBSDF
from reference_tracer.points import Points
from reference_tracer.vectors import TINY, dot, unit
from scenes import Conductor, RoughConductor, RoughDielectric

Array = NDArray[np.float64]
Method = Callable[..., Any]
Rough = RoughConductor | RoughDielectric

LEAST_DENOMINATOR = 0.5

# ---- Fresnel's equations


def _schlick(c: Array, F0: Array) -> Array:
    """Schlick 1994, An inexpensive BRDF model for physically-based rendering, eq. 15."""
    share: Array = F0 + (1 - F0) * (1 - np.minimum(c, 1)) ** 5
    return share


def _schlick_for_glass(exact: Method) -> Method:
    def dielectric(cos_theta: Array, eta: Array) -> Array:
        inside = fresnel.refracted(cos_theta, eta)
        c = np.where(
            eta < 1, inside / eta, cos_theta
        )  # on the side of the lower index, 0 beyond the critical angle
        return _schlick(c, ((eta - 1) / (eta + 1)) ** 2)

    return dielectric


def _schlick_for_metal(exact: Method) -> Method:
    def conductor(cos_theta: Array, eta: Array, k: Array) -> Array:
        return _schlick(cos_theta, exact(np.ones_like(cos_theta), eta, k))

    return conductor


def _large_index(exact: Method) -> Method:
    """What Fresnel's equations become where η² + k² is much larger than 1."""

    def conductor(cos_theta: Array, eta: Array, k: Array) -> Array:
        c, square = cos_theta, eta**2 + k**2
        r_s = (square - 2 * eta * c + c**2) / (square + 2 * eta * c + c**2)
        r_p = (square * c**2 - 2 * eta * c + 1) / (square * c**2 + 2 * eta * c + 1)
        mean: Array = (r_s + r_p) / 2
        return mean

    return conductor


def _s_polarised(exact: Method) -> Method:
    def dielectric(cos_theta: Array, eta: Array) -> Array:
        g = fresnel.refracted(cos_theta, eta)
        share: Array = ((cos_theta - g) / (cos_theta + g)) ** 2
        return share

    return dielectric


# ---- smooth glass


def _without_eta_squared(sample: Method) -> Method:
    def drawn(self: DielectricBSDF, points: Points, wo: Array, u: Array) -> BSDFSample:
        made: BSDFSample = sample(self, points, wo, u)
        return BSDFSample(made.wi, (made.weight > 0).astype(float), made.pdf)

    return drawn


def _without_total_reflection(sample: Method) -> Method:
    """A walk ends where there is no refracted direction."""

    def drawn(self: DielectricBSDF, points: Points, wo: Array, u: Array) -> BSDFSample:
        made: BSDFSample = sample(self, points, wo, u)
        cos_o, eta = cosine(points, wo), self._eta.take(points.surface)
        eta = np.where(cos_o < 0, 1 / eta, eta)
        refracts = fresnel.refracted(np.abs(cos_o), eta) > 0
        return BSDFSample(made.wi, made.weight * refracts, made.pdf * np.where(refracts, 1, TINY))

    return drawn


# ---- microfacets


def _rough(
    factor: Callable[[Any, Points, Array, Array], Array], *, drawn: bool = True
) -> tuple[Replacement, ...]:
    """f of rough metal is a factor of (bsdf, points, wi, wo) off, and the weight of samples with it."""

    def evaluate(f: Method) -> Method:
        return lambda self, points, wi, wo: f(self, points, wi, wo) * factor(self, points, wi, wo)

    def draw(sample: Method) -> Method:
        def weighted(self: RoughConductorBSDF, points: Points, wo: Array, u: Array) -> BSDFSample:
            made: BSDFSample = sample(self, points, wo, u)
            made.weight *= factor(self, points, made.wi, wo)
            return made

        return weighted

    return (
        Replacement(RoughConductorBSDF, "f", evaluate),
        Replacement(RoughConductorBSDF, "sample", draw),
    )[: 2 if drawn else 1]


def _density(factor: Callable[[Any, Points, Array, Array], Array]) -> Plant:
    """The density of rough metal is a factor off: wherever it is asked for, and in the weight of samples."""

    def density(pdf: Method) -> Method:
        return lambda self, points, wi, wo: pdf(self, points, wi, wo) * factor(self, points, wi, wo)

    def draw(sample: Method) -> Method:
        def weighted(self: RoughConductorBSDF, points: Points, wo: Array, u: Array) -> BSDFSample:
            made: BSDFSample = sample(self, points, wo, u)
            off = factor(self, points, made.wi, wo)
            return BSDFSample(made.wi, made.weight / off, made.pdf * off)

        return weighted

    return in_tracer(
        Replacement(RoughConductorBSDF, "pdf", density), Replacement(RoughConductorBSDF, "sample", draw)
    )


def _four_cos_om(bsdf: Any, points: Points, wi: Array, wo: Array) -> Array:
    return 4 * np.maximum(dot(wo, unit(wi + wo)), TINY)


def _cos_om_over_cos_m(bsdf: Any, points: Points, wi: Array, wo: Array) -> Array:
    m = unit(wi + wo)
    return np.maximum(dot(wo, m), TINY) / np.maximum(dot(points.ns, m), TINY)


def _clamped_denominator(bsdf: Any, points: Points, wi: Array, wo: Array) -> Array:
    denominator = 4 * np.maximum(cosine(points, wi), 0) * np.maximum(cosine(points, wo), 0)
    factor: Array = denominator / np.maximum(denominator, LEAST_DENOMINATOR)
    return factor


def _other_shadowing(material: Rough) -> Rough:
    other = {"separable": "correlated", "correlated": "separable"}[material.shadowing]
    return replace(material, shadowing=other)


def _one_jacobian(pdf: Method) -> Method:
    """dm/dwi of refraction without the square of the index (Walter et al. 2007, eq. 17)."""
    return lambda self: pdf(self) * np.where(self.reflects, 1, 1 / self.eta**2)


def _unscaled_radiance(weight: Method) -> Method:
    return lambda self: weight(self) * np.where(self.reflects, 1, self.eta**2)


def _in_fresnel(name: str, made_of: Callable[[Method], Method]) -> Plant:
    return in_tracer(Replacement(fresnel, name, made_of))


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="fresnel-swapped",
        operator="R",
        what="glass reflects what it should refract: 1 − F for F",
        plant=_in_fresnel("dielectric", lambda exact: lambda c, eta: 1 - exact(c, eta)),
    ),
    Fault(
        name="indices-swapped",
        operator="R",
        what="the indices of refraction inside and outside are exchanged",
        plant=_in_fresnel("relative_index", lambda ratio: lambda inside, outside: ratio(outside, inside)),
        happened=("https://github.com/mmp/pbrt-v3/issues/210",),
    ),
    Fault(
        name="fresnel-of-one-polarisation",
        operator="R",
        what="glass reflects as if all light were polarised across the plane of incidence",
        plant=_in_fresnel("dielectric", _s_polarised),
    ),
    Fault(
        name="schlick-for-glass",
        operator="R",
        what="glass has Schlick's approximation of Fresnel's equations",
        plant=_in_fresnel("dielectric", _schlick_for_glass),
    ),
    Fault(
        name="schlick-for-metal",
        operator="R",
        what="metal has Schlick's approximation of Fresnel's equations",
        plant=_in_fresnel("conductor", _schlick_for_metal),
    ),
    Fault(
        name="metal-of-large-index",
        operator="R",
        what="metal has the approximation of Fresnel's equations for η² + k² much larger than 1",
        plant=_in_fresnel("conductor", _large_index),
    ),
    Fault(
        name="metal-without-absorption",
        operator="R",
        what="k of metal is taken to be 0",
        plant=of_materials(
            Conductor, RoughConductor, change=lambda metal: replace(metal, k=(0.0,) * len(metal.k))
        ),
    ),
    Fault(
        name="eta-squared-missing",
        operator="R",
        what="radiance stays the same where smooth glass refracts it",
        plant=in_tracer(Replacement(DielectricBSDF, "sample", _without_eta_squared)),
        happened=("https://github.com/knightcrawler25/GLSL-PathTracer/issues/25",),
    ),
    Fault(
        name="total-reflection-missed",
        operator="R",
        what="beyond the critical angle glass reflects nothing",
        plant=in_tracer(Replacement(DielectricBSDF, "sample", _without_total_reflection)),
        happened=("https://github.com/Twinklebear/ChameleonRT/issues/3",),
    ),
    Fault(
        name="rough-eta-squared-missing",
        operator="R",
        what="radiance stays the same where rough glass refracts it",
        plant=in_tracer(Replacement(microfacet._Facet, "weight", _unscaled_radiance)),
    ),
    Fault(
        name="rough-glass-jacobian",
        operator="R",
        what="the density of directions that rough glass refracts lacks the square of the index",
        plant=in_tracer(Replacement(microfacet._Facet, "pdf", _one_jacobian)),
    ),
    Fault(
        name="alpha-is-roughness",
        operator="R",
        what="alpha is the square root of what it should be: a roughness that was not squared",
        plant=of_materials(
            RoughConductor, RoughDielectric, change=lambda m: replace(m, alpha=float(np.sqrt(m.alpha)))
        ),
        happened=("https://github.com/mmp/pbrt-v4/issues/479",),
    ),
    Fault(
        name="alpha-squared-twice",
        operator="R",
        what="alpha is taken for a roughness, and squared again",
        plant=of_materials(
            RoughConductor, RoughDielectric, change=lambda m: replace(m, alpha=max(m.alpha**2, 0.001))
        ),
        happened=("https://github.com/NVIDIAGameWorks/Falcor/issues/212",),
    ),
    Fault(
        name="ggx-without-4",
        operator="R",
        what="f of rough metal lacks the 4 in its denominator",
        plant=in_tracer(*_rough(lambda bsdf, points, wi, wo: np.full(len(points), 4.0))),
    ),
    Fault(
        name="ggx-density-of-facets",
        operator="R",
        what="the density of reflected directions is that of the facets, not divided by 4 wo·m",
        plant=_density(_four_cos_om),
        happened=("https://github.com/mmp/pbrt-v3/pull/172",),
    ),
    Fault(
        name="ggx-jacobian-of-the-normal",
        operator="R",
        what="the density of facets is divided by 4 n·m, not 4 wo·m",
        plant=_density(_cos_om_over_cos_m),
    ),
    Fault(
        name="ggx-denominator-clamped",
        operator="R",
        what="4 cos θi cos θo below 0.5 is taken to be 0.5 in f of rough metal",
        plant=in_tracer(*_rough(_clamped_denominator)),
    ),
    Fault(
        name="ggx-without-shadowing",
        operator="R",
        what="facets do not shadow each other",
        plant=in_tracer(
            Replacement(
                microfacet, "G2", lambda G2: lambda cos_i, cos_o, alpha, separable: np.ones_like(cos_i)
            )
        ),
    ),
    Fault(
        name="ggx-other-shadowing",
        operator="R",
        what="shadowing is correlated where separable was asked for, and the other way round",
        plant=of_materials(RoughConductor, RoughDielectric, change=_other_shadowing),
    ),
)
