"""What a relation is: claims that hold for every scene, whatever its image is.

A relation needs neither a truth nor a second renderer: it says that two ways to the same image agree. What it claims
of a scene and a renderer is

    Equal    the means of two sums of renders are the same, bounce by bounce: judged by intervals
    Exact    something that one look decides, without statistics
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

from comparisons.renderers import Hits, Images
from scenes import Scene, Tolerance

Operator = Literal["E", "G", "R", "T", "sensor", "estimator"]
"""What a relation tests first: a term of the equation, the sensor, or how the renderer samples them."""


class NotApplicableError(ValueError):
    """The relation says nothing of this scene or this renderer; the message says why."""


def _as_it_is(images: Images) -> Images:
    return images


@dataclass(frozen=True)
class Part:
    """One render, and what it counts for in a sum.

    Attributes:
        scene: what is rendered.
        weight: what bounce k is multiplied by.
        view: what becomes of the images, ``(bounces, height, width, channels)``, before they are added.
        asked: for which bounces the renderer is asked when these are wanted; one it isn't asked for counts as 0.
        spp: samples per pixel, when so many are given to each part.
        renderer: which renders it; None: the one that is tested.
        first_seed: replicate r gets this + r; None: seeds that no other part has.
    """

    scene: Scene
    weight: Callable[[int], float] = lambda k: 1.0
    view: Callable[[Images], Images] = _as_it_is
    asked: Callable[[Sequence[int]], Sequence[int]] = lambda wanted: wanted
    spp: Callable[[int], int] = lambda spp: spp
    renderer: str | None = None
    first_seed: int | None = None


Side = tuple[Part, ...]
"""A sum of renders, with independent seeds."""


@dataclass(frozen=True)
class Equal:
    """Two sides have the same mean, in every bounce.

    Attributes:
        first, second: the two. Deviations are of the first, relative to the second.
        label: which one, where a relation claims several things; else empty.
        bounces: which; None: those that are asked for.
    """

    first: Side
    second: Side
    label: str = ""
    bounces: tuple[int, ...] | None = None


class Witness(Protocol):
    """The renderer, asked one question at a time."""

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        """An image; see ``renderers.Renderer``."""

    def first_hits(self, scene: Scene) -> Hits:
        """What its rays meet first; see ``renderers.protocol.SeesFirstHits``."""

    def restart(self) -> None:
        """End its process: the next question goes to a new one."""


@dataclass(frozen=True)
class Told:
    """What one look has decided, and why.

    Attributes:
        operator: which one is at fault, where that is another than the relation tests first.
    """

    verdict: Literal["pass", "fail", "inconclusive"]
    message: str
    operator: Operator | None = None


@dataclass(frozen=True)
class Exact:
    """Something that one look decides.

    Attributes:
        look: asks the renderer and decides.
        label: as of ``Equal``.
    """

    look: Callable[[Witness], Told]
    label: str = ""


Claim = Equal | Exact


TOLERANCE = Tolerance(image=(0.05, 0.02, 0.03, 0.05), tile=(0.25, 0.10, 0.15, 0.25))
"""Of a relation unless it has its own: what some seconds can tell."""


@dataclass(frozen=True)
class Relation:
    """One relation.

    Attributes:
        name: as on the command line.
        operator: which one it tests.
        statement: the formula.
        blind_to: what holds it and is wrong all the same.
        claims: what it claims of a scene, for bounces up to n and the renderer of that full name: (scene, n, name).
            It raises ``NotApplicableError`` where it says nothing.
        scenes: names of the scenes that it is tried on unless others are asked for; see ``stages.py``.
        cheap: whether a default run has it.
        of_noise: whether it says nothing of a renderer that declares to have none.
        tolerance: relative, per bounce.
        tiles: rows and columns of the grid of tiles.
    """

    name: str
    operator: Operator
    statement: str
    blind_to: str
    claims: Callable[[Scene, int, str], Sequence[Claim]]
    scenes: tuple[str, ...]
    cheap: bool = False
    of_noise: bool = False
    tolerance: Tolerance = TOLERANCE
    tiles: tuple[int, int] = (2, 2)
