"""Any program: told by a command what to render, read by the image that it writes.

What is translated here, and nothing else is:

- The scene goes through one of the exporters in ``scenes.formats``. Where the file says itself up to which bounce it
  is to be rendered (Mitsuba XML, pbrt), it says so.
- ``images = "cumulative"``: a call per depth. S_n = E + TE + … + TⁿE, so TᵏE = S_k − S_{k−1}.
- ``images = "layers"``: one call, a layer per bounce.
- ``images = "total"``: L = E + TE + … without control of depth. Where every surface is black, L = E: that is bounce
  0, and later ones can't be had.

Seeds. The seed of a replicate is drawn anew from its own (as the state of NumPy's ``SeedSequence``), into [0, 2³¹),
which any program can read: replicates have consecutive seeds, and a program that gives pixel i of seed s the stream
s + i would render the same noise twice, shifted by a pixel. The depths of a replicate share one seed where the
program says that they then share their paths (``coupled``): the difference holds the noise of that bounce alone.
Otherwise each depth has a seed of its own. The mean of the difference is TᵏE either way, since the mean of a sum
needs no independence; how noisy it is, replicates tell.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec
import numpy as np
from numpy.typing import NDArray

from comparisons.renderers import pictures, placeholders, program
from comparisons.renderers.keys import Command
from comparisons.renderers.protocol import Images, RendererFailed, Unsupported
from scenes import Scene
from scenes.formats.export import Export, Source, UnsupportedFeatureError
from scenes.formats.exporters import EXPORTERS, SUFFIXES
from scenes.formats.finished import Finished
from scenes.formats.support import expressible
from scenes.variations import black

Array = NDArray[np.float64]

ENDLESS = 1000
"""The last bounce of a file that has to name one, where no limit is meant."""

_COARSE = 2.0**-20
"""Relative rounding beyond which a difference of two images is no bounce: 16-bit floats, RGBE."""

_VERSION_TIMEOUT = 10.0
_NUMBER = re.compile(r"\d+(?:\.\d+)+[\w.+-]*")


def supports(argument: str) -> dict[str, Sequence[str]]:
    """What the format of its scenes can express, and what the program does, as its configuration says."""
    keys = msgspec.json.decode(argument, type=Command)
    images = {"total": ("bounce 0", "total")}.get(keys.images, ("bounces",))
    if keys.total:
        images = (*images, "total")
    seed = ("yes",) if keys.seed else ("no",)
    return {**expressible(keys.scene), "images": images, "seed": seed}


def installed(argument: str, folder: Path) -> str | None:
    """Its version, as its configuration in that folder says or asks; None where there is no such program.

    Of a program that is there and does not say its version, ``unknown`` and why.
    """
    keys = msgspec.json.decode(argument, type=Command)
    try:
        program.executable(keys.command[0], folder)
    except RendererFailed:
        return None
    try:
        return _version(keys, folder)
    except RendererFailed as error:
        return f"unknown: {error}"


class CommandRenderer:
    """A program, as a table of the configuration describes it; its folder is the working directory."""

    def __init__(self, argument: str) -> None:
        self._keys, self._folder = msgspec.json.decode(argument, type=Command), Path.cwd()
        self._program = program.executable(self._keys.command[0], self._folder)
        self._export = lru_cache(maxsize=32)(self._exported)  # relations take scenes in turn, at some depths

    def version(self) -> str:
        """As the configuration says or asks."""
        return _version(self._keys, self._folder)

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        """By calls of the program; see the protocol."""
        match self._keys.images:
            case "layers":
                return self._layers(scene, bounces, spp, seed)
            case "cumulative":
                return self._differences(scene, bounces, spp, seed)
            case "total":
                if max(bounces) > 0:
                    raise Unsupported('per-bounce images: it has no control of depth (images = "total")')
                return self._sum(black(scene), ENDLESS, spp, _drawn(seed), self._keys.command).images

    def total(self, scene: Scene, spp: int, seed: int) -> Array:
        """The sum of all bounces, as its users render it; see the protocol."""
        command = self._keys.total or (self._keys.command if self._keys.images == "total" else [])
        if not command:
            raise Unsupported("total: its configuration has no command for it (total = […])")
        image: Array = self._sum(scene, ENDLESS, spp, _drawn(seed), command).images[0]
        return image

    def _layers(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        found = self._called(scene, max(bounces), spp, _drawn(seed), self._keys.command, layers=True).images
        if len(found) <= max(bounces):
            raise RendererFailed(
                f"wrote layers bounce0 to bounce{len(found) - 1}, expected bounce0 to bounce{max(bounces)}"
            )
        return found[list(bounces)]

    def _differences(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        depths = sorted({n for k in bounces for n in (k - 1, k)} - {-1})  # below bounce 0 there is nothing
        sums = {-1: np.zeros(scene.shape)}
        for n in depths:
            drawn = _drawn(seed) if self._keys.coupled else _drawn(seed, n)
            picture = self._sum(scene, n, spp, drawn, self._keys.command)
            if picture.rounding > _COARSE and depths != [0]:
                raise Unsupported(
                    f"per-bounce images: its numbers are rounded by up to {picture.rounding:.0e} of themselves, and "
                    "differences of two such images say little; write 32-bit floats"
                )
            sums[n] = picture.images[0]
        if self._keys.coupled:
            _refuse_cancellation(bounces, sums)
        return np.array([sums[k] - sums[k - 1] for k in bounces])

    def _sum(self, scene: Scene, bounces: int, spp: int, seed: int, command: Sequence[str]) -> Finished:
        return self._called(scene, bounces, spp, seed, command, layers=False)

    def _called(
        self, scene: Scene, bounces: int, spp: int, seed: int, command: Sequence[str], layers: bool
    ) -> Finished:
        """One call of the program, in a folder of its own.

        Raises:
            Unsupported: the format of the scene lacks a feature.
            RendererTimeout, RendererFailed: see ``program.run`` and ``pictures.read``.
        """
        keys, exported = self._keys, self._export(scene, bounces)
        height, width, _ = scene.shape
        with TemporaryDirectory(prefix="call-") as folder:
            file, output = (
                Path(folder, f"scene{SUFFIXES[keys.scene]}"),
                Path(folder, f"image{keys.extension}"),
            )
            exported.write(file)
            values = {
                "scene": file,
                "output": output,
                "spp": spp,
                "seed": seed,
                "bounces": bounces,
                "width": width,
                "height": height,
            }
            arguments = [placeholders.filled(text, values) for text in command]
            arguments[0] = program.executable(arguments[0], self._folder)
            environment = {name: placeholders.filled(text, values) for name, text in keys.env.items()}
            program.run(arguments, self._folder, environment, keys.timeout)
            return pictures.read(output, layers, scene.shape)

    def _exported(self, scene: Scene, bounces: int) -> Export:
        try:
            return EXPORTERS[self._keys.scene](scene, "scene", Source("a scene to be validated", bounces))
        except UnsupportedFeatureError as error:
            raise Unsupported(str(error)) from None


def _drawn(*key: int) -> int:
    return int(np.random.SeedSequence(key).generate_state(1)[0] >> 1)


def _refuse_cancellation(bounces: Sequence[int], sums: dict[int, Array]) -> None:
    """Refuse terms so small that single precision can't hold them as a difference of two sums.

    A sum is rounded to 2⁻²⁴ of itself, so a term of 2⁻¹³ of the sum is exact to 2⁻¹¹, a twentieth of a percent.
    A term that is exactly 0 is judged: a lost bounce must fail, not be refused.

    Raises:
        Unsupported: naming the bounce.
    """
    for k in bounces:
        term, whole = float(np.mean(sums[k] - sums[k - 1])), float(sums[k].mean())
        if 0 < abs(term) < 2**-13 * whole:
            share = term / whole
            raise Unsupported(
                f"bounce {k}, {share:.0e} of the sum: too little for a difference in single precision; if the same "
                "seed does not walk the same paths at every depth, leave out coupled = true"
            )


def _version(keys: Command, folder: Path) -> str:
    if isinstance(keys.version, str):
        return keys.version or "unknown"
    try:
        line = program.asked(keys.version, folder, _VERSION_TIMEOUT).partition("\n")[0].strip()
    except RendererFailed as error:
        raise RendererFailed(f"its version can't be had: {error}") from None
    number = _NUMBER.search(line)
    return number[0] if number else line or "unknown"
