"""Renders that are wrong in one way each: what a relation is there to find. (scene, bounces, spp, seed) → images."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace as changed
from typing import Any
from unittest.mock import patch

import msgspec
import numpy as np

from comparisons.renderers import Hits, Images
from comparisons.renderers.reference import ReferenceRenderer
from reference_tracer import random_walk
from reference_tracer.bsdfs.bsdf import cosine
from reference_tracer.propagation import RayCaster
from scenes import Checkerboard, Lambertian, Mirror, Quad, Scene
from scenes.first_hit import first_hits
from scenes.variations import emitters, with_emitters

Render = Callable[[Scene, Sequence[int], int, int], Images]
_replace = msgspec.structs.replace
right: Render = ReferenceRenderer("mis").render


def _with_materials(scene: Scene, change: Callable[[Any], Any]) -> Scene:
    return _replace(scene, surfaces=tuple(_replace(s, material=change(s)) for s in scene.surfaces))


def one_lamp_lost(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    """Of several emitters, the last is never chosen."""
    lit = emitters(scene)
    return right(with_emitters(scene, lit[:-1]) if len(lit) > 1 else scene, bounces, spp, seed)


def clamped(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    """Fireflies are cut at a radiance of 1."""
    return np.minimum(right(scene, bounces, spp, seed), 1.0)


def albedo_twice(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    """Throughput takes the albedo once too often: ρ²ᵏ instead of ρᵏ."""

    def squared(surface: Any) -> Any:
        if isinstance(surface.material, Lambertian) and isinstance(surface.material.albedo, tuple):
            return Lambertian(tuple(a * a for a in surface.material.albedo))
        return surface.material

    return right(_with_materials(scene, squared), bounces, spp, seed)


def last_bounce_open(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    """Paths end one vertex late: the last bounce asked for holds the next one as well."""
    last = max(bounces)
    images = right(scene, [*bounces, last + 1], spp, seed)
    images[-2] += images[-1]
    return images[:-1]


def normal_in_object_space(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    """What a wall reflects depends on its direction in the world."""

    def tilted(surface: Any) -> Any:
        material = surface.material
        if not isinstance(surface.shape, Quad) or not isinstance(material, Lambertian):
            return material
        factor = 0.7 + 0.3 * abs(float(surface.shape.normal[0]))
        if isinstance(material.albedo, Checkerboard):
            even, odd = (tuple(factor * a for a in c) for c in (material.albedo.even, material.albedo.odd))
            return Lambertian(_replace(material.albedo, even=even, odd=odd))
        assert isinstance(material.albedo, tuple)
        return Lambertian(tuple(factor * a for a in material.albedo))

    return right(_with_materials(scene, tilted), bounces, spp, seed)


def one_pixel_right(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    return np.roll(right(scene, bounces, spp, seed), 1, axis=2)


def one_row_low(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    return np.roll(right(scene, bounces, spp, seed), 1, axis=1)


def fixed_offset(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    """Rays start 0.02 above the surface, however small the scene."""
    cast = RayCaster.__call__

    def lifted(caster: RayCaster, origin: Any, d: Any) -> Any:
        points = cast(caster, origin, d)
        return changed(points, x=points.x + 0.02 * points.n * (points.surface >= 0))

    with patch.object(RayCaster, "__call__", lifted):
        return right(scene, bounces, spp, seed)


def swapped_channels(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    """Blue comes first."""
    return right(scene, bounces, spp, seed)[..., ::-1]


def one_sample_short(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    """Divides by one sample less than it took, or by one."""
    return right(scene, bounces, spp, seed) * spp / max(spp - 1, 1)


def deaf_to_its_seed(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    return right(scene, bounces, spp, 7)


_calls = itertools.count()


def never_the_same(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    return right(scene, bounces, spp, next(_calls))


def small_seeds_are_dark(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    return right(scene, bounces, spp, seed) * (0.5 if seed < 1000 else 1.0)


class _NotReciprocal:
    """A BSDF that reflects less towards grazing viewers: f(x, l, v) is not f(x, v, l)."""

    def __init__(self, bsdf: Any) -> None:
        self._bsdf = bsdf

    def __getattr__(self, name: str) -> Any:
        return getattr(self._bsdf, name)

    def f(self, points: Any, wi: Any, wo: Any) -> Any:
        return self._bsdf.f(points, wi, wo) * np.abs(cosine(points, wo))

    def sample(self, points: Any, wo: Any, u: Any) -> Any:
        sample = self._bsdf.sample(points, wo, u)
        return changed(sample, weight=sample.weight * np.abs(cosine(points, wo)))


def not_reciprocal(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    bsdf_of = random_walk.bsdf_of
    with patch.object(random_walk, "bsdf_of", lambda scene: _NotReciprocal(bsdf_of(scene))):
        return right(scene, bounces, spp, seed)


def weights_beyond_one(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    """The weights of next event and chance sum to 1.5."""
    images = right(scene, bounces, spp, seed)
    images[[k > 0 for k in bounces]] *= 1.5
    return images


def mirrors_are_dull(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    """Holds every relation, and is wrong: what relations can't see."""
    return right(
        _with_materials(
            scene, lambda s: Mirror((0.1, 0.1, 0.1)) if isinstance(s.material, Mirror) else s.material
        ),
        bounces,
        spp,
        seed,
    )


def black(scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    return np.zeros((len(bounces), *scene.shape))


# ---- first hits


def _as_hits(found: Any) -> Hits:
    return np.stack([found.distance, *found.normal, found.surface])


def through_the_nearest(scene: Scene) -> Hits:
    """One surface of the room is not met: rays go on to what is behind it."""
    found = first_hits(scene)
    seen = np.bincount(found.surface[found.surface >= 0]).argmax()
    dented = list(scene.surfaces)
    gone = dented.pop(int(seen))
    behind = first_hits(_replace(scene, surfaces=tuple(s for s in scene.surfaces if s is not gone)))
    index = np.where(behind.surface >= seen, behind.surface + 1, behind.surface)
    return _as_hits(changed(behind, surface=index))


def too_far(scene: Scene) -> Hits:
    """Everything is a thousandth farther."""
    found = first_hits(scene)
    return _as_hits(changed(found, distance=1.001 * found.distance))


def normals_behind(scene: Scene) -> Hits:
    """Normals point to the back."""
    found = first_hits(scene)
    return _as_hits(changed(found, normal=-found.normal))


def without_normals(scene: Scene) -> Hits:
    """It can't tell normals, which is no fault."""
    found = first_hits(scene)
    return _as_hits(changed(found, normal=0 * found.normal))


def too_far_without_normals(scene: Scene) -> Hits:
    """It can't tell normals, and distances are wrong."""
    found = too_far(scene)
    found[1:4] = 0
    return found


def half_a_pixel_off(scene: Scene) -> Hits:
    """Rays through the corners of pixels."""
    return _as_hits(first_hits(scene, (0.0, 0.0)))
