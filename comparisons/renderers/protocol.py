"""What every renderer can do, and what can go wrong with one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from scenes import Scene

Images = NDArray[np.float64]
Hits = NDArray[np.float64]
"""What a renderer's rays meet first, ``(5, height · width)``; see ``SeesFirstHits``."""


class RendererError(Exception):
    """A renderer did not do its part. A result of the comparison, never the end of the run.

    RendererError
    ├── Unsupported      the scene needs a feature that the renderer does not have
    ├── RendererFailed   it raised, crashed, could not be imported, or returned something that is no image
    └── RendererTimeout  it did not answer in time, and was stopped

    Attributes:
        log: the last lines that it printed.
        at_start: whether it was never ready, and has not been asked for anything.
    """

    def __init__(self, message: str, log: list[str] | None = None) -> None:
        super().__init__(message)
        self.log = log or []
        self.at_start = False


class Unsupported(RendererError):
    """The scene needs a feature that the renderer does not have; the message names it."""


NO_BOUNCES = "per-bounce images"
"""How the message of ``Unsupported`` begins where a renderer has no depth control, and makes totals alone."""


NO_TOTAL = "total: its adapter has no total(scene, spp, seed)"
"""What is said of a renderer that is not a ``RendersTotal``."""


def makes_totals_only(error: RendererError) -> bool:
    """Whether a renderer has refused to ``render`` since it can't tell one bounce from another."""
    return isinstance(error, Unsupported) and str(error).startswith(NO_BOUNCES)


class RendererFailed(RendererError):
    """It raised, crashed, could not be imported, or returned something that is no image."""


class RendererTimeout(RendererError):
    """It did not answer in time, and was stopped."""


class Renderer(Protocol):
    """A renderer, as comparisons see it. One file each in this folder."""

    def version(self) -> str:
        """Of the renderer itself, as its authors number it."""

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        """Estimate TᵏE for the bounces k that are asked for.

        Args:
            scene: what to render; the sensor says at which resolution.
            bounces: ascending.
            spp: samples per pixel.
            seed: different seeds give independent images, the same seed the same one.

        Returns:
            One image per bounce asked for, ``(len(bounces), height, width, channels)``: row 0 at the top,
            scene-linear, unclamped.

        Raises:
            Unsupported: naming the feature that is missing.
        """


@runtime_checkable
class SeesFirstHits(Protocol):
    """A renderer that can tell what its rays meet: an option, which lets G be tested by itself."""

    def first_hits(self, scene: Scene) -> Hits:
        """What the ray through the centre of each pixel meets first; of a lens, the ray through its centre.

        Returns:
            ``(5, height · width)``, row by row: distance along the ray from where it leaves the sensor, inf where
            there is nothing; unit normal of the shape, not of shading, x, y, z, on the front, or on either side
            where both reflect, and (0, 0, 0) from who can't tell; index of the surface in the scene, −1 where there
            is none.

        Raises:
            Unsupported: naming the feature that is missing.
        """


@runtime_checkable
class RendersTotal(Protocol):
    """A renderer that also renders as its users run it: an option, which lets its production settings be tested."""

    def total(self, scene: Scene, spp: int, seed: int) -> NDArray[np.float64]:
        """Estimate the sum of all bounces with the renderer's own defaults: unlimited depth, Russian roulette on.

        Args:
            scene, spp, seed: as of ``Renderer.render``.

        Returns:
            ``(height, width, channels)``: row 0 at the top, scene-linear, unclamped.

        Raises:
            Unsupported: naming the feature that is missing.
        """
