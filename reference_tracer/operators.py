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

from reference_tracer.emission import Emitters
from reference_tracer.points import Points
from reference_tracer.propagation import RayCaster
from reference_tracer.reflection import LambertianBSDF
from reference_tracer.sensing import camera_rays
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
    """E, the radiance that leaves surfaces by themselves."""
    return Field(Emitters(scene).Le)


def propagation(scene: Scene) -> Operator:
    """G, outgoing radiance → incident radiance: constant along straight lines."""
    r = RayCaster(scene)
    return Operator(lambda Lo: Field(lambda x, l: Lo(r(x, l), -l)))  # noqa: E741


def reflection(scene: Scene, rng: np.random.Generator, samples: int = 1) -> Operator:
    """R, incident radiance → outgoing radiance, the integral estimated with so many samples.

    One sample makes a path of a power of T. Every evaluation of the field draws new ones.
    """
    bsdf = LambertianBSDF(scene)

    def R(Li: Field) -> Field:
        def Lo(x: Points, v: Array) -> Array:
            total = np.zeros((scene.channels, len(x)))
            for _ in range(samples):
                l = bsdf.sample(x, rng)  # noqa: E741  the lecture's name
                cos_theta = np.einsum("in,in->n", x.n, l)
                total += Li(x, l) * bsdf.f(x, l, v) * cos_theta / bsdf.pdf(x, l)
            return total / samples

        return Field(Lo)

    return Operator(R)


def transport(scene: Scene, rng: np.random.Generator, samples: int = 1) -> Operator:
    """T = R G."""
    return reflection(scene, rng, samples) @ propagation(scene)


def neumann(T: Operator, bounces: int) -> Operator:
    """I + T + T² + … + Tⁿ, n = ``bounces``: the Neumann series of (I − T)⁻¹, cut off."""
    return reduce(Operator.__add__, [T**k for k in range(bounces + 1)])


def measure(Lo: Field, scene: Scene, rng: np.random.Generator, spp: int = 1) -> Array:
    """What the scene's sensor sees of an outgoing field: G(Lo) at the pinhole, averaged over each pixel.

    Returns:
        ``(height, width, channels)``.
    """
    height, width, channels = scene.shape
    pixels, Li = np.arange(height * width), propagation(scene)(Lo)
    image = sum(Li(*camera_rays(scene.sensor, pixels, rng)) for _ in range(spp)) / spp
    return np.asarray(image).T.reshape(height, width, channels)
