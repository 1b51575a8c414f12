"""Sound variants that any renderer can be: how it is asked, and how its numbers are kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from multiprocessing import get_context
from multiprocessing.pool import Pool

import numpy as np

from comparisons.faults.fault import Plant, Sound
from comparisons.faults.planting import of_image, of_request
from comparisons.renderers import Images, Renderer, create
from scenes import Scene, SceneError
from scenes.channels import with_channels

APART = 2**31
"""How far apart seeds must lie that a run can't ask for both: it takes them from [2³⁰, 2³¹)."""


def _with_seed(other: Callable[[int], int]) -> Plant:
    return of_request(lambda inner, scene, bounces, spp, seed: inner.render(scene, bounces, spp, other(seed)))


def _hashed(seed: int) -> int:
    return int(np.random.SeedSequence([seed, 2024]).generate_state(1, np.uint64)[0])


def _as(name: str) -> Plant:
    """Another renderer altogether, as long as it is one of the reference tracer's strategies."""
    return lambda inner: create(name)


def _strategies_in_turn(inner: Renderer, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    strategy = ("mis", "nee", "bsdf")[seed % 3]
    return create(f"reference:{strategy}").render(scene, bounces, spp, seed)


@cache
def _processes() -> Pool:
    """Started once; they are daemons, and end with this process."""
    return get_context("spawn").Pool(2)


def _in_two_processes(inner: Renderer, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    half, asked = (spp + 1) // 2, tuple(bounces)
    seeds = (seed, seed + APART)
    parts = [_processes().apply_async(inner.render, (scene, asked, half, one)) for one in seeds]
    first, second = (part.get() for part in parts)
    return (first + second) / 2


def _in_two_halves(inner: Renderer, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    half = (spp + 1) // 2
    first, second = (inner.render(scene, bounces, half, seed + part * APART) for part in range(2))
    return (first + second) / 2


def _bounces_apart(inner: Renderer, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    return np.concatenate([inner.render(scene, [k], spp, seed + k * APART) for k in bounces])


def _channels_apart(inner: Renderer, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
    """In three parts: red, green and blue alone, or every third wavelength."""
    images = np.zeros((len(bounces), *scene.shape))
    for part in range(3):
        order = range(part, scene.channels, 3)
        if not order:
            continue
        try:
            some = with_channels(scene, order)
        except SceneError:
            continue  # nothing emits in these
        images[..., order] = inner.render(some, bounces, spp, seed + part * APART)
    return images


def _rounded(images: Images, bits: int) -> Images:
    mantissa, exponent = np.frexp(images)
    rounded: Images = np.ldexp(np.round(mantissa * 2.0**bits) / 2.0**bits, exponent)
    return rounded


def _shaken(images: Images) -> Images:
    """By 10⁻⁷ of itself, as sums in another order are."""
    rng = np.random.Generator(np.random.SFC64(int(images.sum() * 1e6) % 2**32))
    return images * (1 + 1e-7 * rng.standard_normal(images.shape))


VARIANTS: tuple[Sound, ...] = (
    Sound(
        name="single-precision",
        what="images go through 32-bit floats",
        plant=of_image(lambda images: images.astype(np.float32).astype(np.float64)),
    ),
    Sound(
        name="half-precision",
        what="images are rounded to the 11 bits of a 16-bit float",
        plant=of_image(lambda images: _rounded(images, 11)),
    ),
    Sound(
        name="last-digits-differ",
        what="every pixel is off by about 10⁻⁷ of itself",
        plant=of_image(_shaken),
    ),
    Sound(
        name="other-seeds",
        what="seeds begin elsewhere",
        plant=_with_seed(lambda seed: seed + APART),
    ),
    Sound(
        name="hashed-seeds",
        what="seeds are scattered over 64 bits",
        plant=_with_seed(_hashed),
    ),
    Sound(
        name="next-event-alone",
        what="the strategy nee",
        plant=_as("reference:nee"),
    ),
    Sound(
        name="chance-alone",
        what="the strategy bsdf",
        plant=_as("reference:bsdf"),
    ),
    Sound(
        name="sobol-points",
        what="scrambled Sobol' points over the whole image, so that pixels are not independent",
        plant=_as("reference:mis:sobol"),
    ),
    Sound(
        name="strategies-in-turn",
        what="each replicate comes from another strategy",
        plant=of_request(_strategies_in_turn),
    ),
    Sound(
        name="more-samples",
        what="four times the samples that were asked for",
        plant=of_request(
            lambda inner, scene, bounces, spp, seed: inner.render(scene, bounces, 4 * spp, seed)
        ),
    ),
    Sound(
        name="two-processes",
        what="the mean of two images of half the samples, each rendered by a process of its own",
        plant=of_request(_in_two_processes),
    ),
    Sound(
        name="two-halves",
        what="the mean of two images of half the samples",
        plant=of_request(_in_two_halves),
    ),
    Sound(
        name="bounces-apart",
        what="each bounce comes from walks of its own",
        plant=of_request(_bounces_apart),
    ),
    Sound(
        name="channels-apart",
        what="each channel comes from walks of its own, in a scene that has no others",
        plant=of_request(_channels_apart),
    ),
)
