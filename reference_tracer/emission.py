"""E, emission: the radiance that surfaces and the environment emit, and how next event finds it.

Next event chooses one emitter with a probability proportional to its power, then a direction towards it. What
each kind does is in ``area_lights``, ``delta_lights`` and ``environments``; all densities are per solid angle at
the reference. Powers are estimates where the scene as a whole comes in, since any positive choice is right:

    area           π A · mean radiance, twice for two sides,         W
                   times 2 ∫ p(μ) μ dμ of an angular profile p
    point, spot    the integral of the intensity                     W
    directional    π R² · irradiance                                 W on the disk of the bounding sphere
    environment    4π · mean radiance · π R²                         W through the same
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from reference_tracer.emitters.area_lights import AreaEmitter, ZoneEmitter, area_lights
from reference_tracer.emitters.delta_lights import DeltaEmitter, delta_lights
from reference_tracer.emitters.emitter_sample import EmitterSample
from reference_tracer.emitters.environments import EnvironmentEmitter, NegativeRadianceError, environment
from reference_tracer.points import NOWHERE, Points
from reference_tracer.vectors import dot
from scenes import Disk, Mesh, Quad, Scene, Shape, Sphere

__all__ = ["EmitterSample", "Emitters", "NegativeRadianceError", "bounding_radius"]

Array = NDArray[np.float64]


class Emitters:
    """All that emits in a scene.

    Args:
        scene: the scene.
        delta_only: next event chooses among point, spot and directional lights alone, which nothing else finds.

    Attributes:
        dimensions: random numbers that a sample takes: 2, one more for a choice among several emitters; 0 if
            there is nothing to choose from.
        emits: whether a ray finds light on a surface, ``(surfaces + 1,)``; the last one, NOWHERE, is the
            environment.

    Raises:
        NegativeRadianceError: a spherical-harmonics environment is negative somewhere.
    """

    def __init__(self, scene: Scene, delta_only: bool = False) -> None:
        self._channels, radius = scene.channels, bounding_radius(scene)
        self._areas = area_lights(scene)
        self._environment = environment(scene, radius)
        # one entry more than there are surfaces: NOWHERE = −1 finds it
        self.emits = np.zeros(len(scene.surfaces) + 1, dtype=bool)
        self._radiance = np.zeros((self._channels, len(self.emits)))
        for i, area in self._areas.items():
            self.emits[i], self._radiance[:, i] = True, area.radiance[:, 0]
        self.emits[NOWHERE] = self._environment is not None
        self._zones = [i for i, area in self._areas.items() if isinstance(area, ZoneEmitter)]
        self._profiles = {i: area.profile for i, area in self._areas.items() if area.profile is not None}
        self._prepare_choice(delta_lights(scene, radius), delta_only)

    def _prepare_choice(self, deltas: list[DeltaEmitter], delta_only: bool) -> None:
        by_surface: dict[int, AreaEmitter | EnvironmentEmitter] = {}
        if not delta_only:
            by_surface |= self._areas
            if self._environment is not None and self._environment.power > 0:
                by_surface[NOWHERE] = self._environment
        self._emitters = [*by_surface.values(), *(light for light in deltas if light.power > 0)]
        # where it is no float any more, any other positive number does
        power = np.clip([emitter.power for emitter in self._emitters], 1e-300, 1e300)
        self._choice = power / power.sum()
        self._ends = np.cumsum(self._choice)[:-1]
        self.dimensions = 0 if not len(power) else 2 if len(power) == 1 else 3
        # which of them a ray finds where it meets a surface, or NOWHERE; −1 for none
        self._found_on = np.full(len(self.emits), -1)
        self._found_on[list(by_surface)] = np.arange(len(by_surface))

    def Le(self, points: Points, wo: Array) -> Array:
        """Radiance emitted from points along wo; from NOWHERE that of the environment in direction −wo.

        Args:
            points: n points.
            wo: unit directions away from them, ``(3, n)``.

        Returns:
            ``(channels, n)``; 0 from the back and outside the zone that emits, by the angle where there is a profile.
        """
        radiance = np.zeros((self._channels, len(points)))
        lanes = np.flatnonzero(self.emits[points.surface])
        if len(lanes):
            surface = points.surface[lanes]
            cosine = dot(points.n[:, lanes], wo[:, lanes])
            lit = cosine > 0
            for i in self._zones:
                here = np.flatnonzero(surface == i)
                lit[here] &= self._areas[i].in_zone(points.x[:, lanes[here]])
            Le = self._radiance[:, surface] * lit
            for i, profile in self._profiles.items():
                here = np.flatnonzero(surface == i)
                Le[:, here] *= profile(cosine[here])
            radiance[:, lanes] = Le
        if self._environment is not None:
            lanes = np.flatnonzero(points.surface == NOWHERE)
            radiance[:, lanes] = self._environment.radiance(-wo[:, lanes])
        return radiance

    def sample(self, reference: Points, u: Array) -> EmitterSample:
        """A direction towards an emitter for each reference.

        Args:
            reference: n points.
            u: numbers in [0, 1), ``(dimensions, n)``.

        Raises:
            ValueError: there is nothing to choose from (``dimensions`` is 0).
        """
        if not self._emitters:
            raise ValueError("no emitter to choose from: expected dimensions > 0, look at it before sampling")
        if len(self._emitters) == 1:
            return self._emitters[0].sample(reference, u)
        n = len(reference)
        all_lanes = EmitterSample(
            np.empty((3, n)),
            np.empty(n),
            np.empty((self._channels, n)),
            np.empty(n),
            np.empty(n, dtype=bool),
            np.empty(n, dtype=np.intp),
        )
        chosen = np.searchsorted(self._ends, u[2], side="right")
        for i, lanes in _groups(chosen):
            part = self._emitters[i].sample(reference[lanes], u[:2, lanes])
            part = replace(part, pdf=self._choice[i] * part.pdf)
            for field, values in vars(part).items():
                getattr(all_lanes, field)[..., lanes] = values
        return all_lanes

    def pdf(self, reference: Points, points: Points, wi: Array) -> Array:
        """Solid angle density with which ``sample`` would have chosen directions that were found by chance.

        Args:
            reference: n points.
            points: what rays from there along wi meet; NOWHERE is the environment.
            wi: unit directions, ``(3, n)``.

        Returns:
            ``(n,)``, the choice of the emitter included; 0 where nothing is emitted towards the reference, and
            everywhere for ``delta_only``.
        """
        density = np.zeros(len(points))
        emitter = self._found_on[points.surface]
        lanes = np.flatnonzero(emitter >= 0)
        facing = dot(points.n[:, lanes], wi[:, lanes]) < 0
        lanes = lanes[facing | (points.surface[lanes] == NOWHERE)]
        for i, here in _groups(emitter[lanes]):
            some = lanes[here]
            part = self._emitters[i].pdf(reference[some], points[some], wi[:, some])
            density[some] = self._choice[i] * part
        return density


def _groups(index: NDArray[np.intp]) -> Iterator[tuple[int, NDArray[np.intp]]]:
    """Each value that occurs, with the lanes where it does."""
    for i in np.flatnonzero(np.bincount(index)):
        yield int(i), np.flatnonzero(index == i)


def bounding_radius(scene: Scene) -> float:
    """Radius of a sphere around all surfaces: half the diagonal of their box; 1 if there are none."""
    if not scene.surfaces:
        return 1.0
    corners = np.concatenate([_corners(surface.shape) for surface in scene.surfaces])
    return float(np.linalg.norm(np.ptp(corners, axis=0))) / 2


def _corners(shape: Shape) -> Array:
    """Points whose box holds the shape, ``(k, 3)``."""
    if isinstance(shape, Mesh):
        return np.array(shape.vertices)
    if isinstance(shape, Quad):
        corner, u, v = (np.array(e) for e in (shape.corner, shape.edge_u, shape.edge_v))
        return np.array([corner, corner + u, corner + v, corner + u + v])
    center = np.array(shape.center)
    if isinstance(shape, Sphere):
        return np.array([center - shape.radius, center + shape.radius])
    axes = [shape.axis_u, shape.axis_v] if isinstance(shape, Disk) else [*shape.matrix.T]
    half = np.sqrt((np.array(axes) ** 2).sum(axis=0))  # of the box around an ellipse or an ellipsoid, exactly
    return np.array([center - half, center + half])
