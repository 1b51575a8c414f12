"""What a planted fault is, and what a sound variant is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from comparisons.renderers import Renderer
from comparisons.results import Operator

Plant = Callable[[Renderer], Renderer]
"""Makes a renderer another one that has the fault; the one it is given stays as it is."""


@dataclass(frozen=True)
class Fault:
    """A way to be wrong.

    Attributes:
        name: as ``lightproof faults`` takes it.
        operator: what is wrong, as a diagnosis names it.
        what: how, in one line.
        plant: puts it into a renderer.
        happened: addresses of public issues or commits where it did, in a real renderer.
        unseen: why no comparison can see it; empty if one must.
    """

    name: str
    operator: Operator
    what: str
    plant: Plant
    happened: tuple[str, ...] = ()
    unseen: str = ""


@dataclass(frozen=True)
class Sound:
    """A renderer that differs from the reference tracer's default, and is right: no check may fail it."""

    name: str
    what: str
    plant: Plant
