"""Precomputed transfer: the light that a diffuse scene receives from far away, as a linear map.

Distant radiance is Σ_lm c_lm y_lm(ω). Each y_lm lights the scene by itself, and transport is linear, so that

    TE(x) = Σ_lm c_lm M_lm(x),     M_lm(x) = ρ/π ∫ y_lm(ω) V(x, ω) cos θ dω,     TᵏE = Σ_lm c_lm (Tᵏ⁻¹ M_lm)(x)

with V = 1 where the ray from x along ω leaves the scene. The vectors Tᵏ⁻¹M(x) are computed once; any light is then
a scalar product (Sloan, Kautz and Snyder 2002, Precomputed radiance transfer, SIGGRAPH). Surfaces are
taken as not emitting, and the bare sky is not in the images: both are E, and known without any transport.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference_tracer.elements import pixel_averages
from reference_tracer import sampling, spherical_harmonics
from reference_tracer.elements.bases import Patches, uniform
from reference_tracer.finite_elements import WITHOUT_STRUCTURE, FormFactors, nodal_albedo
from reference_tracer.elements.meshing import Splits, check, meshed
from reference_tracer.propagation import NOWHERE, Points, RayCaster
from scenes import Scene

Array = NDArray[np.float64]

BATCH = 1_000_000
"""Rays cast at once."""


@dataclass(frozen=True)
class Transfer:
    """How a scene reflects each spherical harmonic of a distant light.

    Attributes:
        scene: what is lit.
        F: its form factors, with the patches.
        vectors: radiance that y_lm gives the nodes after k bounces, ``(bounces + 1, channels, order², nodes)``;
            zero for k = 0, since surfaces emit nothing.
    """

    scene: Scene
    F: FormFactors
    vectors: Array

    def terms(self, light: Array) -> Array:
        """Nodal radiance of every bounce.

        Args:
            light: c_lm per channel, ``(channels, order²)``.

        Returns:
            ``(bounces + 1, channels, nodes)``.

        Raises:
            ValueError: the coefficients have another shape.
        """
        if light.shape != self.vectors.shape[1:3]:
            raise ValueError(
                f"light has the shape {light.shape}; expected (channels, order²) = {self.vectors.shape[1:3]}"
            )
        terms: Array = np.einsum("kcln,cl->kcn", self.vectors, light)
        return terms

    def image(self, light: Array) -> Array:
        """Averages over the sensor's pixels, ``(bounces + 1, height, width, channels)``; the sky itself is black."""
        weights = pixel_averages.weights(self.scene.sensor, self.F.surfaces)
        return pixel_averages.image(weights, self.terms(light), self.scene.sensor)


def precompute(
    scene: Scene,
    bounces: int,
    light_order: int,
    order: int = WITHOUT_STRUCTURE[0],
    levels: int = WITHOUT_STRUCTURE[1],
    splits: Splits | None = None,
    directions: int = 16,
) -> Transfer:
    """The transfer of a diffuse scene of quads.

    Args:
        scene: quads, Lambertian; its lights are left out.
        bounces: the last bounce, ≥ 1.
        light_order: degrees l < light_order of the light.
        order, levels, splits: of the basis, as in ``finite_elements.solve``.
        directions: rays per node are ``directions`` in elevation times four as many in azimuth. Without occlusion
            the integral is exact from light_order on; the rim of an occluder costs about one ray's share.

    Raises:
        UnsupportedSceneError: a surface is not a quad or not Lambertian.
        ValueError: an argument that can't be.
    """
    check(scene)
    if bounces < 1:
        raise ValueError(
            f"bounces = {bounces}: expected 1 or more, since distant light is reflected at least once"
        )
    F = FormFactors(scene, meshed(scene, order, levels, splits))
    albedo = nodal_albedo(scene, F.surfaces)
    vectors = np.zeros((bounces + 1, scene.channels, light_order**2, F.size))
    vectors[1] = albedo[:, None] * incident(scene, F.surfaces, light_order, directions)
    for k in range(1, bounces):
        arrived = F(vectors[k].reshape(-1, F.size)).reshape(vectors[k].shape)
        vectors[k + 1] = albedo[:, None] * arrived
    return Transfer(scene, F, vectors)


def incident(scene: Scene, surfaces: list[Patches], light_order: int, directions: int) -> Array:
    """Irradiance / π at all nodes from each y_lm, ``(light_order², nodes)``.

    ∫ y V cos θ dω = ∫∫ y V μ dμ dφ with μ = cos θ: Gauss's rule in μ, equal steps in φ.
    """
    cast = RayCaster(scene)
    mu, phi = uniform(directions, 1), 2 * np.pi * (np.arange(4 * directions) + 0.5) / (4 * directions)
    sine = np.sqrt(1 - mu.nodes**2)
    flat = np.ones_like(phi)
    local = np.stack([np.outer(sine, np.cos(phi)), np.outer(sine, np.sin(phi)), np.outer(mu.nodes, flat)])
    weights = np.outer(mu.nodes * mu.weights, flat * 2 / len(phi)).ravel()  # 1/π · 2π / steps
    received = []
    for i, patches in enumerate(surfaces):
        d = sampling.to_world(local.reshape(3, -1), np.tile(patches.normal[:, None], len(weights)))
        weighted = spherical_harmonics.evaluate(light_order, d) * weights
        at_once = max(1, BATCH // len(weights))
        for start in range(0, len(patches), at_once):
            x = np.repeat(patches.nodes[:, start : start + at_once], len(weights), axis=1)
            count = x.shape[1] // len(weights)
            origin = Points(x, np.tile(patches.normal[:, None], x.shape[1]), np.full(x.shape[1], i))
            free = cast(origin, np.tile(d, count)).surface == NOWHERE
            received.append(weighted @ free.reshape(count, -1).T)
    return np.concatenate(received, axis=1)
