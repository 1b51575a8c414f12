r"""Helmholtz reciprocity: source and meter exchanged.

The source is a directional light of irradiance 1 from direction a. The meter is an orthographic camera that looks
along −b and sees the whole scene; the mean of its image times the area Fᵇ of its film is the power per solid angle
that leaves towards b,

    Fᵇ L̄ₖ(a → b) = ∫∫ Sₖ(a, x₁; xₖ, b) dA(x₁) dA(xₖ)
    Sₖ = cos θ(a, x₁) f(a, x₁, ·) [∏ G(xᵢ, xᵢ₊₁) f(·, xᵢ₊₁, ·)] cos θ(b, xₖ)    over all paths x₁ … xₖ of k points,

x₁ visible from a and xₖ from b. Exchange a and b, and walk every path backwards: visibility and G are symmetric, so
the integrand stays what it is if f(x, l, v) = f(x, v, l) everywhere. Hence, bounce by bounce,

    Fᵇ · mean image from b under a light from a  =  Fᵃ · mean image from a under a light from b.

No albedo, no shape of a lamp enters, so any BSDF may stand there that is no delta: a path tracer can't find a
directional light in a mirror, though the eye can, so scenes with smooth mirrors, metals and glass are refused. Rough
refraction is symmetric in radiance / η², and both ends lie in the same medium. Shading normals break the symmetry by
themselves (Veach 1997, section 5.3): they are refused, and so are closed scenes, into which no light comes.

Of the scene, surfaces are taken; its lights go. Directions are so many degrees off the one that its sensor looks
from, to different sides, so that no symmetry of the scene makes the claim trivial; two pairs of them, since over a
whole scene an asymmetry may balance in one.
"""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from comparisons.relations.relation import Equal, NotApplicableError, Part, Relation
from comparisons.renderers import Images
from scenes import (
    Affine,
    Blend,
    Conductor,
    Dielectric,
    DirectionalLight,
    IrradianceMeter,
    Material,
    Mesh,
    Mirror,
    Orthographic,
    RadianceMeter,
    Scene,
    Tolerance,
)
from scenes.bounds import least
from scenes.first_hit import NOTHING, first_hits_of, sensor_rays
from scenes.materials import has_dielectric
from scenes.variations import lit_by

Array = NDArray[np.float64]

_ANGLES = ((25, 50), (5, 65))
_PIXELS = 16
"""Along each side of the film, whose mean is all that is compared."""


def _claims(scene: Scene, bounces: int, renderer: str) -> Sequence[Equal]:
    if not scene.surfaces:
        raise NotApplicableError("there is no surface")
    for surface in scene.surfaces:
        if isinstance(surface.shape, Mesh) and surface.shape.normals is not None:
            raise NotApplicableError(f"surface {surface.name} has shading normals, which are not reciprocal")
        if (delta := _delta(surface.material)) is not None:
            raise NotApplicableError(
                f"surface {surface.name} is a {delta}, in which a directional light isn't found"
            )
    claims = []
    for angles in _ANGLES:
        a, b = _directions(scene, *angles)
        exchanged = [_lit_and_seen(scene, light, eye) for light, eye in ((a, b), (b, a))]
        if not all(map(_is_seen, exchanged)):
            raise NotApplicableError("the scene is closed: no light gets in from where its sensor is")
        first, second = (_power(part) for part in exchanged)
        label = "{}° and {}°".format(*angles)
        claims.append(Equal((first,), (second,), label, bounces=tuple(range(1, bounces + 1))))
    return claims


def _delta(material: Material) -> str | None:
    """The name of what reflects into single directions; None if nothing does."""
    if isinstance(material, Blend):
        return _delta(material.first) or _delta(material.second)
    return type(material).__name__ if isinstance(material, Mirror | Conductor | Dielectric) else None


def _power(scene: Scene) -> Part:
    """The mean of each image times the area of the film, as an image of one pixel."""
    assert isinstance(scene.sensor, Orthographic)
    area = scene.sensor.extent**2

    def view(images: Images) -> Images:
        power: Images = area * images.mean(axis=(1, 2), keepdims=True)
        return power

    return Part(scene, view=view)


def _directions(scene: Scene, *angles: float) -> tuple[Array, Array]:
    """Two unit vectors, so many degrees off the one to where the sensor looks from."""
    sensor = scene.sensor
    match sensor:
        case RadianceMeter():
            back = -np.array(sensor.direction)
        case IrradianceMeter():
            back = -np.array(sensor.normal)
        case _:
            back = -sensor.frame[:, 2]
    side = np.cross(back, np.eye(3)[np.abs(back).argmin()])
    near, far = (Affine.rotation(side.tolist(), angle).vectors(back) for angle in angles)
    return near, Affine.rotation(back.tolist(), 100).vectors(far)  # to another side


def _lit_and_seen(scene: Scene, light: Array, eye: Array) -> Scene:
    """The scene under a light of irradiance 1 from one direction, all of it seen from another one."""
    up = np.cross(eye, np.eye(3)[np.abs(eye).argmin()])
    up /= np.linalg.norm(up)
    frame = np.array([np.cross(up, eye), up, eye])
    # how far all surfaces reach to the right, upwards and towards the eye
    low = np.array([min(least(s.shape, axis) for s in scene.surfaces) for axis in frame])
    high = -np.array([min(least(s.shape, -axis) for s in scene.surfaces) for axis in frame])
    center, size = (low + high) / 2 @ frame, high - low
    camera = Orthographic(
        origin=tuple((center + size.max() * eye).tolist()),
        target=tuple(center.tolist()),
        up=tuple(up.tolist()),
        extent=float(size[:2].max()) * (1 + 1e-6),
        width=_PIXELS,
        height=_PIXELS,
    )
    sun = DirectionalLight(tuple((-light).tolist()), (1.0,) * scene.channels)
    return msgspec.structs.replace(lit_by(scene, sun), sensor=camera)


def _is_seen(scene: Scene) -> bool:
    """Whether some ray of the camera meets a side that reflects."""
    origin, d = sensor_rays(scene.sensor)
    hits = first_hits_of(scene, origin, d)
    met = hits.surface != NOTHING
    both_sides = np.array([s.two_sided or has_dielectric(s.material) for s in scene.surfaces])
    front = (hits.normal * d).sum(axis=0) < 0
    return bool((met & (front | both_sides[hits.surface])).any())


RECIPROCITY = Relation(
    name="reciprocity",
    operator="R",
    statement="power towards b under a directional light from a = power towards a under one from b",
    blind_to="a BSDF that is wrong and symmetric; where in the image light is",
    claims=_claims,
    scenes=("cornell-box", "metal"),
    tolerance=Tolerance(image=(0.02, 0.02, 0.06, 0.10), tile=(0.02, 0.02, 0.06, 0.10)),  # one pixel, one tile
)
