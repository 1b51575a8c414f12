"""Renders the pictures of gallery.md: ``python docs/gallery.py`` writes docs/gallery/*.webp, in about two minutes.

Everything is rendered by the reference tracer. One exposure per row of pictures, so that they can be compared.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import gallery_scenes
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from reference_tracer.random_walk import STRATEGIES, render
from reports.exposure import Pixels, encode
from scenes import Scene
from scenes.library import case

SEED = 1
CORNELL_EXPOSURE, PLATES_EXPOSURE, STILL_LIFE_EXPOSURE = 2.0, 1.5, 1.2
CORNELL_SPP, LADDER_SPP, PLATES_SPP, STILL_LIFE_SPP = 512, 16, 16, 128

Named = Iterator[tuple[str, Pixels]]


def cornell_box(shrink: int = 1) -> Scene:
    """The case, 256 pixels wide."""
    return case("cornell-box").scene.resized(256 // shrink, 256 // shrink)


def bounces(shrink: int = 1) -> Named:
    """E, TE, T²E, T³E of the Cornell box, and their partial sums, as the lecture shows them."""
    terms = render(cornell_box(shrink), 3, CORNELL_SPP // shrink, SEED, sampler="sobol")
    for k, (term, partial_sum) in enumerate(zip(terms, np.cumsum(terms, axis=0), strict=True)):
        yield f"bounce-{k}", encode(term, CORNELL_EXPOSURE)
        yield f"sum-{k}", encode(partial_sum, CORNELL_EXPOSURE)


def ladder(shrink: int = 1) -> Named:
    """TE and T²E of the Cornell box, by every strategy with the same number of samples."""
    for strategy in STRATEGIES:
        yield from _ladder(strategy, render(cornell_box(shrink), 2, LADDER_SPP, SEED, strategy))
    yield from _ladder("sobol", render(cornell_box(shrink), 2, LADDER_SPP, SEED, "mis", "sobol"))


def _ladder(rung: str, terms: NDArray[np.float64]) -> Named:
    for k in (1, 2):
        yield f"ladder-{rung}-{k}", encode(terms[k], CORNELL_EXPOSURE)


def plates(shrink: int = 1) -> Named:
    """E + TE of the four plates, by every strategy."""
    scene = gallery_scenes.plates(320 // shrink, 240 // shrink)
    for strategy in STRATEGIES:
        image = render(scene, 1, PLATES_SPP, SEED, strategy, "sobol").sum(axis=0)
        yield f"plates-{strategy}", encode(image, PLATES_EXPOSURE)


def still_life(shrink: int = 1) -> Named:
    """Σ TᵏE up to k = 6 of shapes and materials."""
    scene = gallery_scenes.still_life(480 // shrink, 320 // shrink)
    image = render(scene, 6, STILL_LIFE_SPP // shrink, SEED, sampler="sobol").sum(axis=0)
    yield "still-life", encode(image, STILL_LIFE_EXPOSURE)


def write(folder: Path, shrink: int = 1) -> None:
    """Write all pictures; ``shrink`` makes them smaller and noisier, for a test."""
    folder.mkdir(parents=True, exist_ok=True)
    for pictures in (bounces, ladder, plates, still_life):
        for name, pixels in pictures(shrink):
            Image.fromarray(pixels).save(folder / f"{name}.webp", quality=90, method=6)


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("gallery"))
