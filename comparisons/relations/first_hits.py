"""First hits: G by itself. What each camera ray meets first, how far away, and with which normal.

The renderer is asked for the ray through the centre of each pixel, and held against the closed forms of
``scenes.first_hit``. There are no samples and no statistics: each pixel agrees or it does not. Renderers compute in
single precision, so distances may differ by 10⁻⁴ of themselves and normals by 10⁻³; besides, by as much as they
change within a hundredth of a pixel. Where another surface begins within that, the pixel lies on an edge and is left
out. A renderer that can't tell normals returns (0, 0, 0): there they are not judged, and the verdict says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from comparisons.relations.other_camera import other_camera
from comparisons.relations.relation import Exact, NotApplicableError, Relation, Told
from comparisons.renderers import Hits
from scenes import IrradianceMeter, Scene
from scenes.first_hit import NOTHING, FirstHits, first_hits
from scenes.materials import has_dielectric

Array = NDArray[np.float64]

_AROUND = tuple((0.5 + dx, 0.5 + dy) for dx in (-0.01, 0.01) for dy in (-0.01, 0.01))
_DISTANCE, _NORMAL = 1e-4, 1e-3


def _claims(scene: Scene, bounces: int, renderer: str) -> Sequence[Exact]:
    if isinstance(scene.sensor, IrradianceMeter):
        raise NotApplicableError("the pixel of an IrradianceMeter is no ray")
    return [Exact(lambda renderer: _told(scene, renderer.first_hits(scene)))]


@dataclass(frozen=True)
class _Expected:
    """The closed form, how far from it is still right, and for which pixels it is clear; all ``(n,)``."""

    hits: FirstHits
    distance: Array
    normal: Array
    clear: NDArray[np.bool_]


def _expected(scene: Scene) -> _Expected:
    hits = first_hits(scene)
    distance, normal = _DISTANCE * hits.distance, np.full(len(hits.surface), _NORMAL)
    clear = np.ones(len(hits.surface), dtype=bool)
    there = hits.surface != NOTHING
    for at in _AROUND:
        near = first_hits(scene, at)
        clear &= near.surface == hits.surface
        with np.errstate(invalid="ignore"):
            distance = np.maximum(distance, np.abs(near.distance - hits.distance), where=there, out=distance)
        normal = np.maximum(normal, np.linalg.norm(near.normal - hits.normal, axis=0))
    return _Expected(hits, distance, normal, clear)


def _told(scene: Scene, found: Hits) -> Told:
    expected = _expected(scene)
    exact, (height, width, _) = expected.hits, scene.shape
    distance, normal, surface = found[0], found[1:4], found[4].astype(int)
    there = exact.surface != NOTHING
    silent = there & ~normal.any(axis=0)
    turned = np.where(_sides(scene, exact.surface) & ((normal * exact.normal).sum(axis=0) < 0), -1, 1)
    with np.errstate(invalid="ignore"):
        wrong = {
            "another surface": surface != exact.surface,
            "another distance": there & ~(np.abs(distance - exact.distance) <= expected.distance),
            "another normal": there
            & ~silent
            & ~(np.linalg.norm(turned * normal - exact.normal, axis=0) <= expected.normal),
        }
    clear = int(expected.clear.sum())
    for what, where in wrong.items():
        pixels = np.flatnonzero(where & expected.clear)
        if len(pixels):
            row, column = divmod(i := int(pixels[0]), width)
            seen = _described(scene, distance[i], normal[:, i], surface[i])
            right = _described(scene, exact.distance[i], exact.normal[:, i], exact.surface[i])
            place = f"the first in row {row}, column {column}"
            message = f"{len(pixels)} of {clear} pixels have {what}, {place}: {seen}, expected {right}"
            if camera := other_camera(scene, found):
                return Told("fail", f"{message}; {camera}", "sensor")
            return Told("fail", message)
    if not (there & expected.clear).any():
        return Told("inconclusive", "no pixel sees a surface away from its edges")
    untold = f"; {count} normals were not told" if (count := int((silent & expected.clear).sum())) else ""
    return Told("pass", f"{clear} of {height * width} pixels agree; the others lie on edges{untold}")


def _sides(scene: Scene, surface: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Where the surface has two sides that reflect, so that its normal may point to either."""
    both = [s.two_sided or has_dielectric(s.material) for s in scene.surfaces]
    return np.array([*both, False])[surface]  # the last one is for NOTHING, −1


def _described(scene: Scene, distance: float, normal: Array, surface: int) -> str:
    if surface == NOTHING:
        return "nothing"
    name = scene.surfaces[surface].name if 0 <= surface < len(scene.surfaces) else f"surface {surface}"
    if not normal.any():
        return f"{name} at {distance:.6g}"
    x, y, z = normal
    return f"{name} at {distance:.6g} with normal ({x:.4f}, {y:.4f}, {z:.4f})"


FIRST_HITS = Relation(
    name="first-hits",
    operator="G",
    statement="the ray through the centre of each pixel meets the surface that the closed form says, as far away",
    blind_to="rays from surfaces; shading normals; what pixels on edges see",
    claims=_claims,
    scenes=("room", "lights", "metal"),
    cheap=True,
)
