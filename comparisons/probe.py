"""Does a renderer heed its seed? Asked once for each, on a scene that is noisy for sure.

Noise is what intervals are made of: replicates that are all the same image have none, and would prove anything.
A bounce without variance says nothing about that, since many bounces have none; nor does a black image, which is
what a renderer makes that has lost this bounce.
"""

from __future__ import annotations

from concurrent.futures import Future
from typing import Protocol

import numpy as np

from comparisons.renderers import Images, RendererError, RendererFailed, Unsupported, traits
from comparisons.renderers.protocol import makes_totals_only
from comparisons.sequential import Renders
from scenes import Scene, library

_SEEDS = (1_000_003, 2_000_003)
_BOUNCES = (1, 2)
"""Light from a lamp with an extent: a sample of it differs from another one, whatever the strategy. Two bounces,
since who counts from another number has emission for the first, which may have no noise."""


class Asked(Renders, Protocol):
    """Who renders, totals too."""

    def total(self, name: str, scene: Scene, spp: int, seed: int, timeout: float) -> Future[Images]:
        """As ``Crew.total``."""


class Probe:
    """Asks each renderer once and remembers the answer.

    Args:
        crew: whom to ask.
        timeout: seconds after which one that gives no answer is stopped.
    """

    def __init__(self, crew: Asked, timeout: float) -> None:
        self._crew, self._timeout = crew, timeout
        self._heard: dict[str, RendererError | None] = {}

    def complaint(self, name: str) -> RendererError | None:
        """What is wrong; None if nothing is, or if the renderer declares that it has no noise.

        Args:
            name: the renderer's full name.
        """
        if name not in self._heard:
            self._heard[name] = None if traits(name).deterministic else self._ask(name)
        return self._heard[name]

    def _ask(self, name: str, of_total: bool = False) -> RendererError | None:
        scene = library.case("cornell-box").scene.resized(8, 8)
        try:
            one, other = (
                self._crew.total(name, scene, 1, seed, self._timeout).result()
                if of_total
                else self._crew.render(name, scene, _BOUNCES, 1, seed, self._timeout).result()
                for seed in _SEEDS
            )
        except Unsupported as error:
            if makes_totals_only(error) and not of_total:
                return self._ask(name, of_total=True)
            return None  # of this scene; it may well render another one
        except RendererError as error:
            if error.at_start:
                return error
            asked = "asked for the Cornell box, which tells whether it heeds its seed"
            return type(error)(f"{error} ({asked})", error.log)
        if one.any() and np.array_equal(one, other):
            what = "the total" if of_total else "bounces 1 and 2"
            if not traits(name).seeded:
                return RendererFailed(
                    "takes no seed (seed = false), and gives the same image of a scene that is noisy each time "
                    f"({what} of the Cornell box, one sample per pixel), so its noise can't be told from a "
                    "deviation. What's missing: {seed} in its command or its environment, or noise of its own that "
                    "differs from call to call; one without any noise says deterministic = true"
                )
            return RendererFailed(
                f"takes no notice of its seed: seeds {_SEEDS[0]} and {_SEEDS[1]} give the same image of a scene "
                f"that is noisy ({what} of the Cornell box, one sample per pixel), so its noise can't be "
                "told from a deviation. Expected: different seeds, independent images"
            )
        return None
