"""Renderers that are wrong on purpose, in a real worker process: ``python wrong_renderers.py NAME``.

Each is the reference tracer with one thing wrong, or a process that misbehaves. A ``right`` one is here too, so
that a test can tell the fault from the way it is planted.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable, Sequence

import msgspec
import numpy as np

from comparisons.renderers import Entry, Images, Unsupported, worker
from reference_tracer.random_walk import render
from scenes import Lambertian, Scene


def brighter(scene: Scene, bounces: int, spp: int, seed: int) -> Images:
    """Every albedo is 1 % too high."""
    surfaces = [
        msgspec.structs.replace(s, material=Lambertian(tuple(1.01 * a for a in s.material.albedo)))
        for s in scene.surfaces
    ]
    return render(Scene(tuple(surfaces), scene.sensor), bounces, spp, seed)


def one_bounce_too_many(scene: Scene, bounces: int, spp: int, seed: int) -> Images:
    """Bounce 5 holds the sixth as well, as when paths end one vertex late."""
    images = render(scene, bounces + 1, spp, seed)
    if bounces == 5:
        images[5] += images[6]
    return images[: bounces + 1]


def flipped(scene: Scene, bounces: int, spp: int, seed: int) -> Images:
    """The image is upside down."""
    return render(scene, bounces, spp, seed)[:, ::-1]


def mirrored(scene: Scene, bounces: int, spp: int, seed: int) -> Images:
    """Left is right."""
    return render(scene, bounces, spp, seed)[:, :, ::-1]


def third_bounce_brighter(scene: Scene, bounces: int, spp: int, seed: int) -> Images:
    """Bounce 3 is 2 % too bright."""
    images = render(scene, bounces, spp, seed)
    images[3:4] *= 1.02
    return images


def ignore_the_seed(scene: Scene, bounces: int, spp: int, seed: int) -> Images:
    return render(scene, bounces, spp, 7)


def crash(scene: Scene, bounces: int, spp: int, seed: int) -> Images:
    print("about to crash", flush=True)
    os.kill(os.getpid(), signal.SIGSEGV)
    raise AssertionError


def leave(scene: Scene, bounces: int, spp: int, seed: int) -> Images:
    os._exit(7)


def hang(scene: Scene, bounces: int, spp: int, seed: int) -> Images:
    time.sleep(3600)
    raise AssertionError


def chatter(scene: Scene, bounces: int, spp: int, seed: int) -> Images:
    """Right, but it prints what might be taken for a reply, from Python and from below it."""
    print('{"type": "ready"}\ngarbage', flush=True)
    os.write(1, b"garbage from below\n")
    return render(scene, bounces, spp, seed)


def nan(scene: Scene, bounces: int, spp: int, seed: int) -> Images:
    images = render(scene, bounces, spp, seed)
    images[2:, 3, 1] = np.nan
    return images


def wrong_shape(scene: Scene, bounces: int, spp: int, seed: int) -> Images:
    return render(scene, bounces, spp, seed)[:, :-1]


def complain(scene: Scene, bounces: int, spp: int, seed: int) -> Images:
    raise RuntimeError("out of texture memory")


def refuse(scene: Scene, bounces: int, spp: int, seed: int) -> Images:
    raise Unsupported("spheres")


WRONG: dict[str, Callable[[Scene, int, int, int], Images]] = {
    "wrong:right": render,
    **{
        f"wrong:{f.__name__.replace('_', '-')}": f
        for f in (
            brighter,
            one_bounce_too_many,
            flipped,
            mirrored,
            third_bounce_brighter,
            ignore_the_seed,
            crash,
            leave,
            hang,
            chatter,
            nan,
            wrong_shape,
            complain,
            refuse,
        )
    },
}

MISSING = "wrong:missing"
"""A renderer whose package is not installed."""

ENTRIES = {name: Entry(name, "none", "None", name) for name in [*WRONG, MISSING]}


class WrongRenderer:
    def __init__(self, name: str) -> None:
        self._render = WRONG[name]

    def version(self) -> str:
        return "1.2.3"

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        return self._render(scene, max(bounces), spp, seed)[list(bounces)]


def make(entry: Entry) -> WrongRenderer:
    if entry.argument == MISSING:
        raise ModuleNotFoundError("No module named 'missing'")
    return WrongRenderer(entry.argument)


if __name__ == "__main__":
    worker.make = make
    worker.main(*sys.argv[1:])
