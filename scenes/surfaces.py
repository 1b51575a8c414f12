"""Surfaces: a shape, what it reflects and what it emits.

Every surface is one-sided: it reflects and emits on the side its normal points to. Its back is black, but it
occludes.
"""

from __future__ import annotations

import math

import msgspec
import numpy as np
from numpy.typing import NDArray

from scenes.lights import Emission
from scenes.materials import Material
from scenes.validation import SceneError, Vector, instance, number, path, vector


class Quad(msgspec.Struct, frozen=True, tag_field="type", tag="quad", forbid_unknown_fields=True):
    """A parallelogram: the points corner + s·edge_u + t·edge_v with s, t in [0, 1]. Normal: edge_u × edge_v.

    Attributes:
        corner: one corner, world coordinates.
        edge_u, edge_v: the two edges that leave it.
    """

    corner: Vector
    edge_u: Vector
    edge_v: Vector

    def __post_init__(self) -> None:
        vector(self, "corner")
        u, v = vector(self, "edge_u"), vector(self, "edge_v")
        # sine of the angle between the edges: a relative measure, so that a small quad is no degenerate one
        if not self.area > 1e-9 * math.hypot(*u) * math.hypot(*v):
            raise SceneError(path(self, "edge_v"), v, f"an edge that spans an area with edge_u = {u}")

    @property
    def _cross(self) -> NDArray[np.float64]:
        return np.cross(self.edge_u, self.edge_v)

    @property
    def area(self) -> float:
        """|edge_u × edge_v|."""
        return float(np.linalg.norm(self._cross))

    @property
    def normal(self) -> NDArray[np.float64]:
        """The unit normal of the front, ``(3,)``."""
        return self._cross / np.linalg.norm(self._cross)

    @property
    def is_rectangle(self) -> bool:
        """Whether the edges are orthogonal, to rounding."""
        u, v = np.asarray(self.edge_u), np.asarray(self.edge_v)
        return bool(abs(u @ v) <= 1e-6 * np.linalg.norm(u) * np.linalg.norm(v))


class Sphere(msgspec.Struct, frozen=True, tag_field="type", tag="sphere", forbid_unknown_fields=True):
    """A sphere.

    Attributes:
        center: world coordinates.
        radius: > 0.
        inward: the front is the inside: for a cavity.
    """

    center: Vector
    radius: float
    inward: bool = False

    def __post_init__(self) -> None:
        vector(self, "center")
        if not number(self, "radius", "a number > 0") > 0:
            raise SceneError(path(self, "radius"), self.radius, "a number > 0")
        instance(self, "inward", bool, "True or False")

    @property
    def area(self) -> float:
        """4πr²."""
        return 4 * math.pi * self.radius**2


Shape = Quad | Sphere


class Surface(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A shape with its material and its emission.

    Attributes:
        name: unique in its scene.
        shape: where it is.
        material: what it reflects.
        emission: what it emits; None for nothing.
    """

    name: str
    shape: Shape
    material: Material
    emission: Emission | None = None

    def __post_init__(self) -> None:
        instance(self, "name", str, "a name")
        instance(self, "shape", Shape, "a shape")
        instance(self, "material", Material, "a material")
        instance(self, "emission", Emission | None, "an emission or None")
        if not self.name:
            raise SceneError(path(self, "name"), self.name, "a name that is not empty")
        if self.emission is None:
            return
        if self.emission.polar_range is not None and not isinstance(self.shape, Sphere):
            raise SceneError(
                path(self, "emission.polar_range"),
                self.emission.polar_range,
                "None: only a sphere has polar angles",
            )
        if len(self.emission.radiance) != len(self.material.albedo):
            expected = f"{len(self.material.albedo)} channels, as the material's albedo has"
            raise SceneError(path(self, "emission.radiance"), self.emission.radiance, expected)

    @property
    def emits(self) -> bool:
        """Whether any channel of its emission is above zero."""
        return self.emission is not None and any(self.emission.radiance)


_BOX_FACES = ("left", "right", "bottom", "top", "back", "front")


def box(
    name: str,
    center: Vector,
    half_edges: tuple[Vector, Vector, Vector],
    material: Material,
    *,
    inward: bool = False,
    emission: Emission | None = None,
) -> tuple[Surface, ...]:
    """Six quads, ``name.left``, ``name.right``, ``name.bottom``, ``name.top``, ``name.back``, ``name.front``.

    Args:
        name: what the six names begin with.
        center: of the box, world coordinates.
        half_edges: three vectors from the centre to the middle of the right, top and front face.
        material, emission: of all six.
        inward: normals point into the box, as in a room.

    Raises:
        SceneError: the half edges are not right-handed: every face would be turned over.
    """
    c, axes = np.asarray(center, dtype=float), np.asarray(half_edges, dtype=float)
    if not np.linalg.det(axes) > 0:
        raise SceneError("box.half_edges", half_edges, "three right-handed vectors that span a volume")
    faces = []
    for i, face in enumerate(_BOX_FACES):
        axis, outward = i // 2, 1 if i % 2 else -1
        u, v = axes[(axis + 1) % 3], axes[(axis + 2) % 3]
        if (outward < 0) != inward:  # u × v points along +axis; exchanging them turns the face over
            u, v = v, u
        corner = c + outward * axes[axis] - u - v
        shape = Quad(tuple(corner.tolist()), tuple((2 * u).tolist()), tuple((2 * v).tolist()))
        faces.append(Surface(f"{name}.{face}", shape, material, emission))
    return tuple(faces)
