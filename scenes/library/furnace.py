"""Furnaces: closed scenes in which every surface emits e and reflects ρ, so that TᵏE = e ρᵏ everywhere."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from scenes.case import Case, Formula, Images, Tolerance
from scenes.lights import AreaLight
from scenes.materials import Lambertian
from scenes.scene import Scene
from scenes.sensor import Pinhole
from scenes.shapes import Sphere
from scenes.surfaces import Surface, box

_DERIVATION = """\
Every surface of a closed scene emits the same radiance e in every direction and reflects with the same albedo
ρ. Whatever direction one looks in, G finds e: incident radiance is e everywhere. R multiplies a uniform
incident radiance by the albedo, ∫ e (ρ/π) cos θ dl = ρ e, so TE = ρe, uniform again, and by induction
TᵏE = e ρᵏ, whatever the geometry."""

_BLIND_TO = (
    "wrongly distributed rays: every direction carries the same radiance, so a wrong lobe, a wrong visibility "
    "or a flipped image changes nothing as long as energy is kept"
)

_SOURCE = "white furnace test; TE = ρe follows from ∫ (ρ/π) cos θ dl = ρ"


def _uniform(scene: Scene, bounces: int) -> Images:
    """E ρᵏ in every pixel; e and ρ are those of any surface, since all are the same."""
    surface = scene.surfaces[0]
    assert surface.emission is not None
    assert isinstance(surface.material, Lambertian)
    e, rho = np.asarray(surface.emission.radiance), np.asarray(surface.material.albedo)
    series = np.stack([e * rho**k for k in range(bounces + 1)])
    return np.broadcast_to(series[:, None, None, :], (bounces + 1, *scene.shape)).copy()


def furnace_box() -> Case:
    """A cube with e = 1, ρ = ½, seen from a point off its centre."""
    walls = box(
        "box",
        (0.0, 0.0, 0.0),
        ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        Lambertian((0.5, 0.5, 0.5)),
        inward=True,
        emission=AreaLight((1.0, 1.0, 1.0)),
    )
    sensor = Pinhole((0.3, -0.2, 0.7), (-0.2, 0.1, -1.0), (0.0, 1.0, 0.0), 90.0, 64, 64)
    return Case(
        name="furnace-box",
        family="furnace",
        title="Closed cube, every wall emits 1 and reflects 0.5: TᵏE = 0.5ᵏ",
        scene=Scene(walls, sensor),
        answer=Formula(_uniform, _SOURCE),
        bounces=5,
        tolerance=Tolerance(image=(0.005,), tile=(0.02,)),
        derivation=_DERIVATION,
        blind_to=_BLIND_TO,
    )


def furnace_sphere() -> Case:
    """The inside of a sphere with e = 1, ρ = ½, as a sphere and not as a mesh."""
    surface = Surface(
        "sphere",
        Sphere((0.0, 0.0, 0.0), 1.0, inward=True),
        Lambertian((0.5, 0.5, 0.5)),
        AreaLight((1.0, 1.0, 1.0)),
    )
    sensor = Pinhole((0.2, 0.1, -0.3), (0.0, 0.2, 1.0), (0.0, 1.0, 0.0), 90.0, 64, 64)
    return Case(
        name="furnace-sphere",
        family="furnace",
        title="Inside of a sphere that emits 1 and reflects 0.5: TᵏE = 0.5ᵏ",
        scene=Scene((surface,), sensor),
        answer=Formula(_uniform, _SOURCE),
        bounces=5,
        tolerance=Tolerance(image=(0.005,), tile=(0.02,)),
        derivation=_DERIVATION,
        blind_to=_BLIND_TO,
    )


CASES: Mapping[str, Callable[[], Case]] = {"furnace-box": furnace_box, "furnace-sphere": furnace_sphere}
