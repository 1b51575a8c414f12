"""Similarities: the whole scene, with its sensor, turned, mirrored or scaled; and the camera rolled.

Radiance along a ray stays what it is under a map x ↦ s U x + b with an orthogonal U, if emission does: f and Le know
neither place nor size, and solid angles stay: areas grow by s², 1 / distance² shrinks by as much. Point and spot
lights have no area that would grow, so their intensity takes s². See ``scenes.transforms``.

A mirrored camera is none, so the image of a mirrored scene is the original one flipped left to right. A camera that
is turned upside down sees the image turned by half. Both bring an offset of the image to light: one of d pixels to
the right becomes one of 2d between the two sides.
"""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from comparisons.relations.relation import Equal, NotApplicableError, Part, Relation
from scenes import Affine, Orthographic, Pinhole, Scene, ThinLens, Tolerance, transformed

TURN = Affine.translation((0.3, -0.2, 0.5)) @ Affine.rotation((1, 2, -3), 50)
MIRROR = Affine.reflection((1, 0, 0))
PIXELWISE = Tolerance(image=(0.05, 0.05, 0.10, 0.10), tile=(0.60, 0.60, 1.20, 1.80))
"""For tiles of a few pixels: an offset of the image shows where something begins, and nowhere else."""
SCALE = 10.0
"""One side is so many times as large as the scene, the other so many times smaller."""


def _turned(scene: Scene, bounces: int, renderer: str) -> Sequence[Equal]:
    return [Equal((Part(transformed(scene, TURN)),), (Part(scene),))]


def _mirrored(scene: Scene, bounces: int, renderer: str) -> Sequence[Equal]:
    return [
        Equal((Part(transformed(scene, MIRROR)),), (Part(scene, view=lambda images: images[:, :, ::-1]),))
    ]


def _rolled(scene: Scene, bounces: int, renderer: str) -> Sequence[Equal]:
    sensor = scene.sensor
    if not isinstance(sensor, Pinhole | ThinLens | Orthographic):
        raise NotApplicableError(f"a {type(sensor).__name__} has no upside")
    x, y, z = sensor.up
    over = msgspec.structs.replace(scene, sensor=msgspec.structs.replace(sensor, up=(-x, -y, -z)))
    first, second = Part(over), Part(scene, view=lambda images: images[:, ::-1, ::-1])
    return [Equal((first,), (second,), bounces=tuple(range(min(bounces, 1) + 1)))]  # later ones show no more


def _scaled(scene: Scene, bounces: int, renderer: str) -> Sequence[Equal]:
    large, small = (transformed(scene, Affine.scaling(s)) for s in (SCALE, 1 / SCALE))
    return [Equal((Part(large),), (Part(small),))]


ROTATION = Relation(
    name="rotation",
    operator="R",
    statement="scene and sensor turned and moved: the same image",
    blind_to="an error that turns with the scene",
    claims=_turned,
    scenes=("lights", "metal"),
)
MIRRORING = Relation(
    name="mirroring",
    operator="G",
    statement="scene and sensor mirrored: the image flipped left to right",
    blind_to="an error that is mirrored with the scene, and an image that is always flipped",
    claims=_mirrored,
    scenes=("room", "lights"),
    tolerance=PIXELWISE,
    tiles=(8, 8),
)
ROLL = Relation(
    name="roll",
    operator="sensor",
    statement="the camera turned upside down: the image turned by half",
    blind_to="an error in the middle of the image, and a wrong angle of view",
    claims=_rolled,
    scenes=("room",),
    tolerance=PIXELWISE,
    tiles=(8, 8),
)
SCALING = Relation(
    name="scaling",
    operator="G",
    statement=f"the scene {SCALE:g} times as large, and {SCALE:g} times smaller (point and spot intensities × s²): "
    "the same image",
    blind_to="an error of the same share of every distance",
    claims=_scaled,
    scenes=("room", "lights"),
)
