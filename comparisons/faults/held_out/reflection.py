"""Faults of R, held out: diffuse surfaces, glass, blends and textures. Those of rough ones are in ``microfacets``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.faults.fault import Fault
from comparisons.faults.held_out import microfacets
from comparisons.faults.planting import Replacement, in_tracer
from comparisons.faults.throughput import spare
from reference_tracer import sampling
from reference_tracer.bsdfs import fresnel
from reference_tracer.bsdfs.bsdf import BSDFSample, cosine, front
from reference_tracer.bsdfs.specular import DielectricBSDF
from reference_tracer.bsdfs.textures import NearestTexture
from reference_tracer.points import Points
from reference_tracer.reflection import BlendBSDF, LambertianBSDF
from reference_tracer.vectors import dot, unit

Array = NDArray[np.float64]
Method = Callable[..., Any]

ROUGHNESS = 0.5
"""Of the diffuse lobe that should have none."""

# ---- diffuse surfaces


def _retroreflection(points: Points, wi: Array, wo: Array) -> Array:
    """What Burley 2012, Physically based shading at Disney, §5.3, multiplies albedo / π by."""
    cos_i, cos_o = (np.clip(cosine(points, w), 0, 1) for w in (wi, wo))
    grazing = 0.5 + 2 * ROUGHNESS * dot(wi, unit(wi + wo)) ** 2 - 1
    factor: Array = (1 + grazing * (1 - cos_i) ** 5) * (1 + grazing * (1 - cos_o) ** 5)
    return factor


def _f_of_disney(f: Method) -> Method:
    return lambda self, points, wi, wo: f(self, points, wi, wo) * _retroreflection(points, wi, wo)


def _sample_of_disney(sample: Method) -> Method:
    def drawn(self: LambertianBSDF, points: Points, wo: Array, u: Array) -> BSDFSample:
        made: BSDFSample = sample(self, points, wo, u)
        return replace(made, weight=made.weight * _retroreflection(points, made.wi, wo))

    return drawn


def _into_the_ball(sample: Method) -> Method:
    """The normal and a point in the unit ball, not on the unit sphere, are added up: cos³ instead of cos."""

    def drawn(self: LambertianBSDF, points: Points, wo: Array, u: Array) -> BSDFSample:
        ball = np.cbrt(spare(u)) * sampling.square_to_cone(u[:2], 2.0)
        wi = unit(points.ns + ball)
        surface = front(points, wo, wi)
        return BSDFSample(wi, self._albedo(points, surface), self.pdf(points, wi, wo))

    return drawn


# ---- metal and glass


def _at_normal_incidence(conductor: Method) -> Method:
    return lambda cos_theta, eta, k: conductor(np.ones_like(cos_theta), eta, k)


def _weighed_twice(sample: Method) -> Method:
    """A lobe is chosen by its share, and then multiplied by it."""

    def drawn(self: DielectricBSDF, points: Points, wo: Array, u: Array) -> BSDFSample:
        made: BSDFSample = sample(self, points, wo, u)
        cos_o, eta = cosine(points, wo), self._eta.take(points.surface)
        F = fresnel.dielectric(np.maximum(np.abs(cos_o), 1e-12), np.where(cos_o < 0, 1 / eta, eta))
        reflects = cos_o * cosine(points, made.wi) > 0
        return replace(made, weight=made.weight * np.where(reflects, F, 1 - F))

    return drawn


def _always_from_outside(sample: Method) -> Method:
    """Normals have been turned to the viewer before glass asks them which side it is seen from."""

    def drawn(self: DielectricBSDF, points: Points, wo: Array, u: Array) -> BSDFSample:
        n = points.n * np.where(dot(points.n, wo) < 0, -1, 1)
        made: BSDFSample = sample(self, replace(points, n=n, ns=n), wo, u)
        return made

    return drawn


# ---- blends and textures


def _blended_twice(sample: Method) -> Method:
    """What one of the two has chosen is multiplied by its weight, as if it had not been chosen by it."""

    def drawn(self: BlendBSDF, points: Points, wo: Array, u: Array) -> BSDFSample:
        made: BSDFSample = sample(self, points, wo, u)
        w = self._w.take(points.surface)
        share = np.where(u[2] < w, w, 1 - w)
        return replace(made, weight=made.weight * np.where(np.isinf(made.pdf), share, 1))

    return drawn


def _pixel_rounded(texture: Method) -> Method:
    """The coordinate in pixels is rounded to the nearest index, where it should be cut off."""

    def rounded(self: NearestTexture, uv: Array) -> Any:
        rows, columns = self._pixels.shape[1:]
        return texture(self, uv + np.array([[0.5 / columns], [-0.5 / rows]]))

    return rounded


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="diffuse-of-disney",
        operator="R",
        what="Lambertian surfaces have the diffuse lobe of Disney's model, darker or brighter at grazing angles",
        plant=in_tracer(
            Replacement(LambertianBSDF, "f", _f_of_disney),
            Replacement(LambertianBSDF, "sample", _sample_of_disney),
        ),
    ),
    Fault(
        name="diffuse-into-the-ball",
        operator="R",
        what="diffuse directions go to points in the ball that touches the surface, and the density is cos / π",
        plant=in_tracer(Replacement(LambertianBSDF, "sample", _into_the_ball)),
        happened=("https://github.com/tippesi/Atlas-Engine/issues/11",),
    ),
    Fault(
        name="metal-as-at-normal-incidence",
        operator="R",
        what="metal reflects at every angle what it reflects at normal incidence",
        plant=in_tracer(Replacement(fresnel, "conductor", _at_normal_incidence)),
    ),
    Fault(
        name="glass-weighed-twice",
        operator="R",
        what="glass chooses reflection with the probability F, and then multiplies by F, or 1 − F, once more",
        plant=in_tracer(Replacement(DielectricBSDF, "sample", _weighed_twice)),
    ),
    Fault(
        name="glass-always-from-outside",
        operator="R",
        what="normals are turned to the viewer before glass is evaluated: it is entered, never left",
        plant=in_tracer(Replacement(DielectricBSDF, "sample", _always_from_outside)),
        happened=("https://github.com/Derpius/VisTrace/issues/69",),
    ),
    Fault(
        name="blend-weighed-twice",
        operator="R",
        what="smooth lobes of a blend are chosen by their weight, and then multiplied by it",
        plant=in_tracer(Replacement(BlendBSDF, "sample", _blended_twice)),
    ),
    Fault(
        name="texture-pixel-rounded",
        operator="R",
        what="texture coordinates become pixels by rounding: images lie half a pixel too far up and to the left",
        plant=in_tracer(Replacement(NearestTexture, "__call__", _pixel_rounded)),
    ),
    *microfacets.FAULTS,
)
