"""The operator algebra of the rendering equation, executable: L = E + TL, T = R G.

A radiance field is a function of points and directions; an operator takes one and returns one:

    G(Lo)(x, l) = Lo(r(x, l), −l)
    R(Li)(x, v) = ∫ Li(x, l) f_r(x, l → v) cos θ dl
    T = R @ G
    L = neumann(T, bounces=6)(E)

This is the slow, literal form, to be read beside the equation. ``random_walk`` is the same sum, with shared
prefixes, next-event estimation and multiple importance sampling.

Kajiya 1986, The rendering equation, SIGGRAPH 20(4), eq. 7–9; Immel et al. 1986.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from reference_tracer import sampling
from reference_tracer.arguments import check_whole
from reference_tracer.emission import Emitters
from reference_tracer.emitters.delta_lights import delta_lights
from reference_tracer.points import NOWHERE, Points
from reference_tracer.propagation import RayCaster
from reference_tracer.reflection import bsdf_of
from reference_tracer.samplers import Block
from reference_tracer.sensing import camera_rays
from reference_tracer.vectors import dot
from scenes import Scene

Array = NDArray[np.float64]


class Field:
    """A radiance field: (n points, unit directions ``(3, n)``) → radiance ``(channels, n)``.

    Outgoing fields take the direction towards the viewer, incident ones the direction the light comes from.
    """

    def __init__(self, at: Callable[[Points, Array], Array]) -> None:
        self._at = at

    def __call__(self, x: Points, w: Array) -> Array:
        """Radiance at points in directions."""
        return self._at(x, w)

    def __add__(self, other: Field) -> Field:
        return Field(lambda x, w: self(x, w) + other(x, w))

    def __rmul__(self, factor: float) -> Field:
        return Field(lambda x, w: factor * self(x, w))

    def __sub__(self, other: Field) -> Field:
        return self + (-1.0) * other


class Operator:
    """A linear map from fields to fields. ``A @ B`` applies B first; sums, multiples and powers as written."""

    def __init__(self, apply: Callable[[Field], Field]) -> None:
        self._apply = apply

    def __call__(self, field: Field) -> Field:
        """The field that this operator makes of another."""
        return self._apply(field)

    def __matmul__(self, other: Operator) -> Operator:
        return Operator(lambda field: self(other(field)))

    def __add__(self, other: Operator) -> Operator:
        return Operator(lambda field: self(field) + other(field))

    def __rmul__(self, factor: float) -> Operator:
        return Operator(lambda field: factor * self(field))

    def __sub__(self, other: Operator) -> Operator:
        return self + (-1.0) * other

    def __pow__(self, exponent: int) -> Operator:
        if exponent < 0:
            raise ValueError(f"exponent = {exponent}: this operator has no inverse here")
        return reduce(Operator.__matmul__, [self] * exponent, I)


I = Operator(lambda field: field)  # noqa: E741  the identity is called I
"""The identity."""


def emission(scene: Scene) -> Field:
    """E, the radiance that leaves surfaces, or comes from the environment, by itself."""
    return Field(Emitters(scene).Le)


def delta_emission(scene: Scene) -> Field:
    """T E_δ of the point, spot and directional lights E_δ, which have no radiance as a field.

    Under R their Dirac deltas leave a sum over lights, f cos θ Li where nothing lies between. Bounce k of such a
    scene is T^(k−1) of this field, added to TᵏE.
    """
    r, bsdf, lights = RayCaster(scene), bsdf_of(scene), delta_lights(scene, radius=1.0)

    def Lo(x: Points, v: Array) -> Array:
        total = np.zeros((scene.channels, len(x)))
        for light in lights:
            l, distance, Li = light.incident(x)  # noqa: E741  the lecture's name
            visible = r.visible(x, l, distance, np.full(len(x), NOWHERE))
            total += Li * bsdf.f(x, l, v) * (np.abs(dot(x.ns, l)) * visible)
        return total

    return Field(Lo)


def propagation(scene: Scene) -> Operator:
    """G, outgoing radiance → incident radiance: constant along straight lines."""
    r = RayCaster(scene)
    return Operator(lambda Lo: Field(lambda x, l: Lo(r(x, l), -l)))  # noqa: E741


def reflection(scene: Scene, rng: np.random.Generator, samples: int = 1) -> Operator:
    """R, incident radiance → outgoing radiance, the integral estimated with so many samples.

    One sample makes a path of a power of T. Every evaluation of the field draws new ones.
    """
    check_whole(1, samples=samples)
    bsdf = bsdf_of(scene)
    dimensions = 3 if bsdf.needs_choice else 2

    def R(Li: Field) -> Field:
        def Lo(x: Points, v: Array) -> Array:
            total = np.zeros((scene.channels, len(x)))
            for _ in range(samples):
                l = bsdf.sample(x, v, rng.random((dimensions, len(x))))  # noqa: E741  the lecture's name
                total += Li(x, l.wi) * l.weight  # f cos θ / pdf
            return total / samples

        return Field(Lo)

    return Operator(R)


def reflection_by_quadrature(scene: Scene, order: int = 16) -> Operator:
    """R without noise, the integral by a product rule: Gauss-Legendre in cos θ on each side, equal steps in φ.

    The lowest rung of the ladder. It sees smooth lobes only, not mirrors or glass; T^k costs (4 · order²)ᵏ rays.

    Args:
        scene: the scene.
        order: nodes in cos θ per side; there are 2 · order directions around.
    """
    check_whole(1, order=order)
    bsdf = bsdf_of(scene)
    z, weight = np.polynomial.legendre.leggauss(order)
    cosines, weights = np.concatenate([z - 1, z + 1]) / 2, np.concatenate([weight, weight]) / 2
    phis = np.pi * (np.arange(2 * order) + 0.5) / order

    def R(Li: Field) -> Field:
        def Lo(x: Points, v: Array) -> Array:
            total = np.zeros((scene.channels, len(x)))
            for cos_theta, w in zip(cosines, weights, strict=True):
                sine = np.sqrt(1 - cos_theta**2)
                for phi in phis:
                    local = np.array([[sine * np.cos(phi)], [sine * np.sin(phi)], [cos_theta]])
                    l = sampling.to_world(local, x.ns)  # noqa: E741
                    total += Li(x, l) * bsdf.f(x, l, v) * (abs(cos_theta) * w * np.pi / order)
            return total

        return Field(Lo)

    return Operator(R)


def transport(scene: Scene, rng: np.random.Generator, samples: int = 1) -> Operator:
    """T = R G."""
    return reflection(scene, rng, samples) @ propagation(scene)


def neumann(T: Operator, bounces: int) -> Operator:
    """I + T + T² + … + Tⁿ, n = ``bounces``: the Neumann series of (I − T)⁻¹, cut off."""
    check_whole(0, bounces=bounces)
    return reduce(Operator.__add__, [T**k for k in range(bounces + 1)])


def measure(Lo: Field, scene: Scene, rng: np.random.Generator, spp: int = 1) -> Array:
    """What the scene's sensor sees of an outgoing field: G(Lo) where its rays start, averaged over each pixel.

    Returns:
        ``(height, width, channels)``.
    """
    check_whole(1, spp=spp)
    height, width, channels = scene.shape
    rows, columns = np.divmod(np.arange(height * width), width)
    Li, image = propagation(scene)(Lo), np.zeros((channels, height * width))
    for _ in range(spp):
        position = np.stack([columns, rows]) + rng.random((2, len(rows)))
        rays = camera_rays(scene.sensor, Block(position, lambda d, lanes: rng.random((d, len(lanes)))))
        image += rays.weight * Li(rays.origin, rays.d)
    return image.T.reshape(height, width, channels) / spp
