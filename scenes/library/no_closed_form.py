"""Diffuse scenes without a closed form, computed without noise by finite elements, to a stated error."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from scenes.case import Case, Computed, Tolerance
from scenes.library.cornell_box import empty_box
from scenes.lights import AreaLight
from scenes.materials import Lambertian
from scenes.scene import Scene
from scenes.sensor import Pinhole
from scenes.shapes import Quad
from scenes.surfaces import Surface

_METHOD = """\
No closed form is known. Every TᵏE was computed by finite elements (reference_tracer/finite_elements.py): Legendre
polynomials on patches graded towards the edges, T applied k times, each pixel the exact average of the polynomials it
sees. No sample is drawn, so there is no noise. The error is what a solution of lower order on a coarser mesh is off
by: the root mean square of its pixels, relative to the mean of the image."""

# a hundred times the error and more; what a renderer's own noise allows in later bounces
_TOLERANCE = Tolerance(image=(0.005, 0.005, 0.01, 0.02), tile=(0.025, 0.025, 0.05, 0.1))

_RESOLVED = """
The reference tracer is not held to ±0.2 % at every bounce, since few paths carry the later ones:
in a quarter of the image 1.5 million of them resolve {} % of TE to T⁵E."""

_BLIND_TO = "specular reflection and every emitter but an area light"


def cornell_box_empty() -> Case:
    """The Cornell box without blocks, its lamp flush in the ceiling: convex."""
    return Case(
        name="cornell-box-empty",
        family="no_closed_form",
        title="The Cornell box without its blocks, the lamp flush in the ceiling",
        scene=empty_box(),
        answer=Computed("cornell-box-empty.exr"),
        bounces=5,
        tolerance=_TOLERANCE,
        derivation=(
            f"{_METHOD}\nThe box is convex: everything in it sees everything it faces."
            + _RESOLVED.format("0.2, 1, 3, 5 and 7")
        ),
        blind_to=f"visibility: no surface hides another; {_BLIND_TO}",
    )


def facing_squares() -> Case:
    """Two unit squares, face to face at a distance of 0.5; the lower one emits."""
    lower = Surface(
        "lamp",
        Quad((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        Lambertian((0.9, 0.7, 0.5)),
        AreaLight((1.0, 2.0, 3.0)),
    )
    upper = Surface(
        "square", Quad((0.0, 0.0, 0.5), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)), Lambertian((0.6, 0.8, 0.95))
    )
    camera = Pinhole((1.1, -0.2, 0.22), (0.45, 0.6, 0.25), (0.0, 0.0, 1.0), 70.0, 64, 64)
    return Case(
        name="facing-squares",
        family="no_closed_form",
        title="Two squares face to face, one of which emits: each bounce is seen on one of them only",
        scene=Scene((lower, upper), camera),
        answer=Computed("facing-squares.exr"),
        bounces=5,
        tolerance=_TOLERANCE,
        derivation=(
            f"{_METHOD}\n"
            "Neither square sees itself, so light is handed from one to the other: odd bounces are on the upper\n"
            "square and nowhere else, even ones on the lamp; a bounce that is counted wrong shows on the wrong\n"
            "square. Nothing hides anything, and most light leaves the scene."
            + _RESOLVED.format("1, 2, 5, 12 and 15")
        ),
        blind_to=f"visibility; light that comes back from all around; {_BLIND_TO}",
    )


CASES: Mapping[str, Callable[[], Case]] = {
    "cornell-box-empty": cornell_box_empty,
    "facing-squares": facing_squares,
}
