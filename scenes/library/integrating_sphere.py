"""Integrating spheres: a cavity lit by a part of its own wall. The field is not uniform, and still exact."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from scenes.case import Case, Formula, Images, Tolerance
from scenes.lights import AreaLight, PolarRange
from scenes.materials import Lambertian
from scenes.round_coverage import cap_coverage
from scenes.scene import Scene
from scenes.sensor import Pinhole
from scenes.shapes import Sphere
from scenes.surfaces import Surface

_DERIVATION = """\
Between two points x, y of a sphere of radius r the angle to either normal is the same and |x − y| = 2r cos θ,
so cos θ cos θ′ / |x − y|² = 1 / 4r²: every element of the wall lights every other one equally, wherever it is.
The irradiance from a zone that emits e and covers the share f of the sphere is therefore π e f everywhere, and
TE = ρ e f, uniform, the zone itself included. A uniform radiance b gives irradiance πb, so
TᵏE = e f ρᵏ for k ≥ 1. E itself is e on the zone and 0 elsewhere; a pixel on the rim of the cap has the share
of its square inside an ellipse, the cone of rays through the rim cut by the image plane."""

_SOURCE = "Walsh 1920; Goebel 1967, Appl. Opt. 6(1):125, eq. 1; a cap's share f = (1 − cos θ) / 2, Archimedes"


def _series(scene: Scene, bounces: int) -> Images:
    """E is e on the cap, TᵏE = e f ρᵏ everywhere for k ≥ 1."""
    surface = scene.surfaces[0]
    assert surface.emission is not None
    assert surface.emission.polar_range is not None
    assert isinstance(surface.material, Lambertian)
    assert isinstance(surface.shape, Sphere)
    assert isinstance(scene.sensor, Pinhole)
    e, rho = np.asarray(surface.emission.diffuse_radiance), np.asarray(surface.material.albedo)
    images = np.empty((bounces + 1, *scene.shape))
    images[0] = cap_coverage(surface.shape, surface.emission.polar_range, scene.sensor)[..., None] * e
    for k in range(1, bounces + 1):
        images[k] = e * surface.emission.polar_range.fraction * rho**k
    return images


def integrating_sphere() -> Case:
    """A cavity lit by a polar cap of 45°; cap and camera are off every axis of symmetry of the image."""
    surface = Surface(
        "sphere",
        Sphere((0.0, 0.0, 0.0), 1.0, inward=True),
        Lambertian((0.8, 0.6, 0.4)),
        AreaLight((4.0, 3.0, 5.0), PolarRange(0.0, 45.0, (0.0, 0.0, 1.0))),
    )
    sensor = Pinhole((0.25, 0.1, -0.3), (-0.1, 0.25, 0.6), (0.0, 1.0, 0.0), 90.0, 64, 64)
    return Case(
        name="integrating-sphere",
        family="integrating_sphere",
        title="Inside of a sphere lit by a polar cap of 45°: E on the cap, TᵏE = e f ρᵏ everywhere",
        scene=Scene((surface,), sensor),
        answer=Formula(_series, _SOURCE),
        bounces=5,
        tolerance=Tolerance(image=(0.005,), tile=(0.02,)),
        derivation=_DERIVATION,
        blind_to=(
            "wrong directions of reflected light: after one bounce the field is uniform; occlusion: a sphere "
            "is convex"
        ),
    )


CASES: Mapping[str, Callable[[], Case]] = {"integrating-sphere": integrating_sphere}
