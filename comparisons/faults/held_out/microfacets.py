"""Faults of R, held out: factors of the microfacet model that belong to another one, or to another angle."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Fault
from comparisons.faults.planting import Replacement, in_tracer
from reference_tracer.bsdfs import microfacet
from reference_tracer.bsdfs.bsdf import BSDFSample, cosine, front
from reference_tracer.bsdfs.microfacet import RoughConductorBSDF, RoughDielectricBSDF
from reference_tracer.bsdfs.specular import on_right_side
from reference_tracer.points import Points
from reference_tracer.vectors import TINY, dot, unit

Array = NDArray[np.float64]
Method = Callable[..., Any]


def _beckmann(D: Method) -> Method:
    """Walter et al. 2007, eq. 25."""

    def density(cos_m: Array, alpha: Array) -> Array:
        square = np.maximum(cos_m, 1e-6) ** 2
        facets: Array = np.exp((1 - 1 / square) / alpha**2) / (np.pi * alpha**2 * square**2)
        return facets

    return density


def _of_an_engine(G2: Method) -> Method:
    """Karis 2013, Real shading in Unreal Engine 4, for analytic lights: k = (√α + 1)² / 8."""

    def shadowing(cos_i: Array, cos_o: Array, alpha: Array, separable: Any) -> Array:
        k = (np.sqrt(alpha) + 1) ** 2 / 8
        visible: Array = cos_i / (cos_i * (1 - k) + k) * cos_o / (cos_o * (1 - k) + k)
        return visible

    return shadowing


def _by_the_tilt(points: Points, wi: Array, wo: Array, bsdf: Any) -> Array:
    """F at the angle between the facet and the surface, over that at the facet."""
    surface, m = front(points, wi, wo), unit(wi + wo)
    tilted = bsdf._F(np.maximum(dot(points.ns, m), TINY), surface)
    right = bsdf._F(np.maximum(dot(wo, m), TINY), surface)
    ratio: Array = np.divide(tilted, right, out=np.zeros_like(right), where=right > 0)
    return ratio


def _f_by_the_tilt(f: Method) -> Method:
    return lambda self, points, wi, wo: f(self, points, wi, wo) * _by_the_tilt(points, wi, wo, self)


def _sample_by_the_tilt(sample: Method) -> Method:
    def drawn(self: RoughConductorBSDF, points: Points, wo: Array, u: Array) -> BSDFSample:
        made: BSDFSample = sample(self, points, wo, u)
        made.weight *= _by_the_tilt(points, made.wi, wo, self)
        return made

    return drawn


def _half_way_by_the_inverse(facet: Method) -> Method:
    """The facet that refracts is taken from wo + wi / η instead of wo + η wi, in f and in its density."""

    def between(self: RoughDielectricBSDF, points: Points, wi: Array, wo: Array) -> Any:
        cos_o, n, eta, alpha = self._side(points, wo)
        cos_i = cosine(points, wi)
        reflects = cos_i * cos_o > 0
        m = unit(wo + np.where(reflects, 1, 1 / eta) * wi)
        m *= np.where(dot(n, m) < 0, -1, 1)
        cos_im, cos_om = np.abs(dot(wi, m)), np.abs(dot(wo, m))
        exists = on_right_side(points, cos_i, cos_o, reflects)
        cos_i, cos_o, cos_om = (np.maximum(np.abs(c), TINY) for c in (cos_i, cos_o, cos_om))
        separable = self._separable.take(points.surface)
        return microfacet._Facet(
            cos_i, cos_o, cos_im, cos_om, dot(n, m), alpha, separable, eta, reflects, exists
        )

    return between


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="facets-of-beckmann",
        operator="R",
        what="the density of facets is Beckmann's, and GGX's normals are sampled",
        plant=in_tracer(Replacement(microfacet, "D", _beckmann)),
    ),
    Fault(
        name="shadowing-of-an-engine",
        operator="R",
        what="facets shadow each other by Schlick's approximation, with the k of a game engine",
        plant=in_tracer(Replacement(microfacet, "G2", _of_an_engine)),
    ),
    Fault(
        name="fresnel-by-the-tilt",
        operator="R",
        what="F of rough metal is taken at the angle between facet and surface, n·m, not at wo·m",
        plant=in_tracer(
            Replacement(RoughConductorBSDF, "f", _f_by_the_tilt),
            Replacement(RoughConductorBSDF, "sample", _sample_by_the_tilt),
        ),
        happened=("https://github.com/michal-z/SimpleDirectPBR/issues/1",),
    ),
    Fault(
        name="refracting-facet-by-the-inverse",
        operator="R",
        what="next event looks for the facet that refracts with the inverse of the index",
        plant=in_tracer(Replacement(RoughDielectricBSDF, "_facet", _half_way_by_the_inverse)),
        happened=("https://github.com/appleseedhq/appleseed/pull/1945",),
    ),
)
