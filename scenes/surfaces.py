"""Surfaces: a shape, what it reflects and what it emits.

A surface is one-sided: it reflects and emits on the side its normal points to; its back is black, but it
occludes. A two-sided one does so on both sides. A dielectric has two sides of its own.
"""

from __future__ import annotations

import msgspec
import numpy as np

from scenes.channels import check_channels
from scenes.lights import Emission
from scenes.materials import Material, has_dielectric, is_textured
from scenes.shapes import Mesh, Quad, Shape, Sphere
from scenes.validation import SceneError, Vector, instance, path


class Surface(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A shape with its material and its emission.

    Attributes:
        name: unique in its scene.
        shape: where it is.
        material: what it reflects.
        emission: what it emits; None for nothing.
        two_sided: its back reflects and emits as its front does.
    """

    name: str
    shape: Shape
    material: Material
    emission: Emission | None = None
    two_sided: bool = False

    def __post_init__(self) -> None:
        instance(self, "name", str, "a name")
        instance(self, "shape", Shape, "a shape")
        instance(self, "material", Material, "a material")
        instance(self, "emission", Emission | None, "an emission or None")
        instance(self, "two_sided", bool, "True or False")
        if not self.name:
            raise SceneError(path(self, "name"), self.name, "a name that is not empty")
        if isinstance(self.shape, Mesh) and self.shape.uv is None and is_textured(self.material):
            expected = "texture coordinates: the material has a texture"
            raise SceneError(path(self, "shape.uv"), None, expected)
        if self.two_sided and has_dielectric(self.material):
            raise SceneError(path(self, "two_sided"), True, "False: a dielectric has two sides of its own")
        if (
            self.emission is not None
            and self.emission.polar_range is not None
            and not isinstance(self.shape, Sphere)
        ):
            raise SceneError(
                path(self, "emission.polar_range"),
                self.emission.polar_range,
                "None: only a sphere has polar angles",
            )
        check_channels([("Surface", self)])

    @property
    def channels(self) -> int | None:
        """How many numbers its material and its emission have; None if it goes with any number."""
        return len(self.emission.radiance) if self.emission else self.material.channels

    @property
    def emits(self) -> bool:
        """Whether any channel of its emission is above zero."""
        return self.emission is not None and self.emission.emits


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
