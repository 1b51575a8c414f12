"""Furnaces: uniform fields. In a closed scene that emits e and reflects ρ everywhere TᵏE = e ρᵏ everywhere.

What a lobe looks like does not matter as long as it reflects the share ρ at every angle: Lambertian, mirror, or
a blend of such. A convex body in a constant environment is the other uniform field: it reflects ρ once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from msgspec.structs import replace

from scenes.affine import Affine
from scenes.case import Case, Formula, Images, Tolerance
from scenes.library import cornell_box
from scenes.lights import AreaLight, ConstantEnvironment
from scenes.materials import Blend, Lambertian, Material, Mirror
from scenes.round_coverage import sphere_coverage
from scenes.scene import Scene
from scenes.sensor import Pinhole
from scenes.shapes import Mesh, Sphere
from scenes.surfaces import Surface, box
from scenes.transforms import transformed

_DERIVATION = """\
Every surface of a closed scene emits the same radiance e in every direction and reflects with the same albedo
ρ. Whatever direction one looks in, G finds e: incident radiance is e everywhere. R multiplies a uniform
incident radiance by the albedo, ∫ e (ρ/π) cos θ dl = ρ e, so TE = ρe, uniform again, and by induction
TᵏE = e ρᵏ, whatever the geometry."""

_ANY_LOBE = (
    _DERIVATION
    + """
The lobe need not be Lambert's: a mirror finds e in the mirrored direction and returns ρe, and a blend of two
lobes returns (1 − w) ρe + w ρe = ρe."""
)

_CONVEX = """\
From a point of a convex body nothing is seen of the body: incident radiance is e from the whole hemisphere, and
TE = ∫ e (ρ/π) cos θ dl = ρe on the body. What it reflects leaves for good: TᵏE = 0 for k ≥ 2. E is the
environment, e, where the body is not. A pixel on the outline has the share c of its square inside an ellipse,
the cone of rays that touch the sphere cut by the image plane: E = (1 − c) e, TE = c ρe."""

_BLIND_TO = (
    "wrongly distributed rays: every direction carries the same radiance, so a wrong lobe, a wrong visibility "
    "or a flipped image changes nothing as long as energy is kept"
)

_SOURCE = (
    "white furnace test; TE = ρe follows from ∫ (ρ/π) cos θ dl = ρ; Szirmay-Kalos, Kovács and Abbas 2001, Testing "
    "Monte-Carlo Global Illumination Methods with Analytically Computable Scenes, WSCG, p. 419–426, for the sum "
    "e / (1 − ρ)"
)
_SOURCE_CONVEX = "white furnace test; TE = ρe follows from ∫ (ρ/π) cos θ dl = ρ; the outline is exact"

_GLOW = AreaLight((1.0, 2.0, 0.5))
_RHO = (0.9, 0.5, 0.2)


def reflected_share(material: Material) -> tuple[float, ...]:
    """The share ρ of light that a material reflects, per channel, where it is the same at every angle.

    Raises:
        ValueError: the material has no such share, or a blend two different ones.
    """
    if isinstance(material, Lambertian) and isinstance(material.albedo, tuple):
        return material.albedo
    if isinstance(material, Mirror):
        return material.reflectance
    if isinstance(material, Blend):
        shares = {reflected_share(material.first), reflected_share(material.second)}
        if len(shares) == 1:
            return shares.pop()
    raise ValueError(f"{material} does not reflect one share at every angle; expected a Lambertian, a mirror or a "
                     "blend of such that agree")  # fmt: skip


def uniform_field(scene: Scene, bounces: int) -> Images:
    """E ρᵏ in every pixel.

    Raises:
        ValueError: the surfaces do not all emit and reflect the same.
    """
    found = {(surface.emission, reflected_share(surface.material)) for surface in scene.surfaces}
    if len(found) != 1:
        raise ValueError(f"{len(found)} pairs of emission and albedo; expected the same on every surface")
    [(emission, share)] = found
    assert emission is not None
    e, rho = np.asarray(emission.diffuse_radiance), np.asarray(share)
    series = np.stack([e * rho**k for k in range(bounces + 1)])
    return np.broadcast_to(series[:, None, None, :], (bounces + 1, *scene.shape)).copy()


def _convex(scene: Scene, bounces: int) -> Images:
    """The environment beside the ball, ρ times the environment on it, then nothing."""
    [body], [sky] = scene.surfaces, scene.lights
    assert isinstance(body.shape, Sphere)
    assert isinstance(scene.sensor, Pinhole)
    assert isinstance(sky, ConstantEnvironment)
    e, rho = np.asarray(sky.radiance), np.asarray(reflected_share(body.material))
    covered = sphere_coverage(body.shape, scene.sensor)[..., None]
    images = np.zeros((bounces + 1, *scene.shape))
    images[0] = (1 - covered) * e
    if bounces >= 1:
        images[1] = covered * rho * e
    return images


def _furnace(name: str, title: str, scene: Scene, **other: Any) -> Case:
    """A case of this family; ``other`` are fields that differ from the usual ones."""
    usual: dict[str, Any] = {
        "answer": Formula(uniform_field, _SOURCE),
        "bounces": 5,
        "tolerance": Tolerance(image=(0.005,), tile=(0.02,)),
        "derivation": _DERIVATION,
        "blind_to": _BLIND_TO,
    }
    return Case(name=name, family="furnace", title=title, scene=scene, **(usual | other))


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
    return _furnace(
        "furnace-box", "Closed cube, every wall emits 1 and reflects 0.5: TᵏE = 0.5ᵏ", Scene(walls, sensor)
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
    return _furnace(
        "furnace-sphere",
        "Inside of a sphere that emits 1 and reflects 0.5: TᵏE = 0.5ᵏ",
        Scene((surface,), sensor),
    )


def _room(walls: Material, bodies: Material) -> Scene:
    """A closed room with a ball and a tilted block that float in it; everything emits the same."""
    half = ((1.0, 0.0, 0.0), (0.0, 0.8, 0.0), (0.0, 0.0, 1.2))
    tilt = Affine.translation((0.4, -0.25, -0.3)) @ Affine.rotation((1.0, 2.0, 0.5), 40.0)
    upright = box(
        "block",
        (0.0, 0.0, 0.0),
        ((0.25, 0.0, 0.0), (0.0, 0.3, 0.0), (0.0, 0.0, 0.2)),
        bodies,
        emission=_GLOW,
    )
    surfaces = (
        *box("room", (0.0, 0.0, 0.0), half, walls, inward=True, emission=_GLOW),
        *(transformed(face, tilt) for face in upright),
        Surface("ball", Sphere((-0.45, -0.2, -0.5), 0.3), bodies, _GLOW),
    )
    sensor = Pinhole((0.5, 0.4, 0.9), (-0.2, -0.25, -0.6), (0.0, 1.0, 0.0), 80.0, 64, 64)
    return Scene(surfaces, sensor)


def furnace_cornell() -> Case:
    """The Cornell box with its blocks in its camera's view, the room prolonged to a wall behind the camera.

    The lamp is a slab as thin as the gap that it hangs in: a quad's back would be black.
    """
    found, rho = cornell_box.cornell_box().scene, Lambertian((0.7, 0.5, 0.3))
    half = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 2.6))
    slab = ((0.23, 0.0, 0.0), (0.0, 0.005, 0.0), (0.0, 0.0, 0.19))
    surfaces = (
        *box("room", (0.0, 0.0, 1.6), half, rho, inward=True, emission=_GLOW),
        *box("lamp", (0.0, 0.995, 0.01), slab, rho, emission=_GLOW),
        *(replace(s, material=rho, emission=_GLOW) for s in found.surfaces if "block" in s.name),
    )
    return _furnace(
        "furnace-cornell",
        "The Cornell box with its blocks, closed behind the camera, every surface alike: TᵏE = e ρᵏ",
        Scene(surfaces, found.sensor),
    )


def _ring(major: float, minor: float, around: int, across: int) -> Mesh:
    """The inside of a torus about the y axis, ``2 · around · across`` triangles."""
    u = 2 * np.pi * np.arange(around)[:, None] / around
    v = 2 * np.pi * np.arange(across) / across
    radius = major + minor * np.cos(v)
    places = np.stack(np.broadcast_arrays(radius * np.cos(u), minor * np.sin(v), radius * np.sin(u)), axis=-1)
    i, j = np.divmod(np.arange(around * across), across)
    a, b = i * across + j, (i + 1) % around * across + j
    c, d = (i + 1) % around * across + (j + 1) % across, i * across + (j + 1) % across
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Mesh(tuple(map(tuple, places.reshape(-1, 3).tolist())), tuple(map(tuple, triangles.tolist())))


def furnace_mesh() -> Case:
    """A corridor that bites its tail, of 480 triangles: from nowhere in it is more than a part of it seen."""
    surface = Surface("corridor", _ring(1.0, 0.45, 24, 10), Lambertian((0.8, 0.4, 0.6)), _GLOW)
    sensor = Pinhole((1.05, 0.1, 0.0), (0.75, -0.05, 1.0), (0.1, 1.0, 0.0), 90.0, 64, 64)
    return _furnace(
        "furnace-mesh", "Inside of a ring of 480 triangles, not convex: TᵏE = e ρᵏ", Scene((surface,), sensor)
    )


def furnace_channels() -> Case:
    """A room with a ball and a block; emission and albedo differ from channel to channel."""
    return _furnace(
        "furnace-channels",
        "Room with a ball and a block, another e and ρ in every channel: TᵏE = e ρᵏ",
        _room(Lambertian(_RHO), Lambertian(_RHO)),
    )


def furnace_bright() -> Case:
    """The same room with albedos up to 0.95: a path that ends too early is seen."""
    rho = Lambertian((0.95, 0.9, 0.85))
    return _furnace(
        "furnace-bright",
        "Bright room with a ball and a block, ρ up to 0.95, ten bounces: TᵏE = e ρᵏ",
        _room(rho, rho),
        bounces=10,
    )


def furnace_mirrors() -> Case:
    """Mirrors for walls, and a diffuse ball and block between them."""
    return _furnace(
        "furnace-mirrors",
        "Room of mirrors with a diffuse ball and block that reflect as much: TᵏE = e ρᵏ",
        _room(Mirror(_RHO), Lambertian(_RHO)),
        derivation=_ANY_LOBE,
        blind_to=_BLIND_TO + "; so also mirrors that reflect elsewhere",
    )


def furnace_blend() -> Case:
    """Walls of one blend of mirror and Lambert's law, bodies of another, nested one."""
    matt, mirror = Lambertian(_RHO), Mirror(_RHO)
    return _furnace(
        "furnace-blend",
        "Room, ball and block of blends whose every lobe reflects ρ: TᵏE = e ρᵏ",
        _room(Blend(matt, mirror, 0.3), Blend(Blend(mirror, matt, 0.6), matt, 0.2)),
        derivation=_ANY_LOBE,
        blind_to=_BLIND_TO + "; so also the weight of a blend",
    )


def furnace_convex() -> Case:
    """A diffuse ball before a constant environment, whole in the image and off its middle."""
    ball = Surface("ball", Sphere((0.1, -0.2, 0.3), 0.8), Lambertian(_RHO))
    sensor = Pinhole((1.1, 0.9, 2.9), (-0.2, 0.1, 0.2), (0.1, 1.0, 0.0), 45.0, 64, 64)
    return _furnace(
        "furnace-convex",
        "A ball in a constant environment: E beside it, TE = ρe on it, then nothing",
        Scene((ball,), sensor, (ConstantEnvironment((1.0, 2.0, 0.5)),)),
        answer=Formula(_convex, _SOURCE_CONVEX),
        bounces=3,
        derivation=_CONVEX,
        blind_to="wrongly distributed rays, since the environment is the same all round; occlusion: a ball is convex",
    )


def _scaled(name: str, title: str, factor: float) -> Case:
    room = _room(Lambertian(_RHO), Lambertian(_RHO))
    return _furnace(name, title, transformed(room, Affine.scaling(factor)))


def furnace_tiny() -> Case:
    """The room of furnace-channels a thousandth of its size."""
    return _scaled("furnace-tiny", "Room with a ball and a block, two millimetres wide: TᵏE = e ρᵏ", 1e-3)


def furnace_huge() -> Case:
    """The room of furnace-channels a thousand times its size."""
    return _scaled("furnace-huge", "Room with a ball and a block, two kilometres wide: TᵏE = e ρᵏ", 1e3)


CASES: Mapping[str, Callable[[], Case]] = {
    "furnace-box": furnace_box,
    "furnace-sphere": furnace_sphere,
    "furnace-cornell": furnace_cornell,
    "furnace-mesh": furnace_mesh,
    "furnace-channels": furnace_channels,
    "furnace-bright": furnace_bright,
    "furnace-mirrors": furnace_mirrors,
    "furnace-blend": furnace_blend,
    "furnace-convex": furnace_convex,
    "furnace-tiny": furnace_tiny,
    "furnace-huge": furnace_huge,
}
