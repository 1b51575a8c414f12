"""What a BSDF is: f, the density of its sampling, its sampling, and what single scattering leaves out.

    Lo(x, wo) = ∫ f(x, wi, wo) Li(x, wi) |cos θi| dwi

``wi`` points towards the light, ``wo`` towards the viewer, both away from the point; f carries no cosine. Lobes
that reflect into a single direction (mirror, glass) are delta distributions: f and pdf leave them out, and only
``sample`` finds them.

Cosines are taken to the shading normal. The side a direction is on is that of the geometric normal; where the two
normals disagree about it, nothing is reflected.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from reference_tracer.points import NOWHERE, Points
from reference_tracer.vectors import dot

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass
class BSDFSample:
    """Directions that a BSDF has chosen.

    Attributes:
        wi: unit directions, ``(3, n)``.
        weight: f · |cos θi| / pdf, ``(channels, n)``; 0 where nothing is reflected.
        pdf: solid angle density of wi, ``(n,)``; inf where a delta lobe was chosen, 0 where nothing is reflected.
    """

    wi: Array
    weight: Array
    pdf: Array


class BSDF(Protocol):
    """The reflection of all surfaces of a scene that have one type of material.

    Its tables have one column per surface of the scene and a last one, which ``NOWHERE`` = −1 finds and which is
    black, as are the columns of surfaces of another type.

    Attributes:
        needs_choice: whether ``sample`` chooses between lobes, and looks at ``u[2]``.
    """

    needs_choice: bool

    def f(self, points: Points, wi: Array, wo: Array) -> Array:
        """Value per channel, ``(channels, n)``, 1/sr; 0 for delta lobes."""

    def pdf(self, points: Points, wi: Array, wo: Array) -> Array:
        """Solid angle density with which ``sample`` chooses wi, given wo, ``(n,)``; 0 for delta lobes."""

    def sample(self, points: Points, wo: Array, u: Array) -> BSDFSample:
        """Directions for numbers u in [0, 1), ``(3, n)``: two of a direction, and one that chooses the lobe."""

    def single_scattering_loss(self, surface: int, cos_theta: Array) -> Array:
        """Share of the energy that a lossless material of this roughness loses, since light scatters once only.

        Args:
            surface: index of the surface in the scene.
            cos_theta: cosines of wo to the normal, any shape; below 0 on the back.

        Returns:
            Shares in [0, 1], of the shape of ``cos_theta``.
        """


def cosine(points: Points, w: Array) -> Array:
    """cos θ of directions to the shading normal, ``(n,)``; 0 where the two normals disagree about the side."""
    cos_theta = dot(points.ns, w)
    if points.ns is not points.n:
        cos_theta[cos_theta * dot(points.n, w) <= 0] = 0
    return cos_theta


def front(points: Points, *directions: Array) -> Indices:
    """The surfaces of the points, NOWHERE, which is black, where a direction lies behind them."""
    seen = cosine(points, directions[0]) > 0
    for w in directions[1:]:
        seen &= cosine(points, w) > 0
    return np.where(seen, points.surface, NOWHERE)


def table(materials: Sequence[Any | None], value: Callable[[Any], Any], otherwise: Any) -> Array:
    """A parameter per surface, ``(surfaces + 1,)`` or ``(channels, surfaces + 1)``.

    Args:
        materials: one per surface; None for one of another type.
        value: reads the parameter from a material.
        otherwise: its value where there is none.
    """
    rows = [otherwise if material is None else value(material) for material in (*materials, None)]
    return np.ascontiguousarray(np.array(rows, dtype=float).T)
