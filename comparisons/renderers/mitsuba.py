"""Mitsuba 3 in each of its forms: variant, integrator and sampler; ``mitsuba_names.py`` has their names.

Conventions are translated in these files, and nowhere else:

- which image contains which bounces, and what couples two of them: ``mitsuba_integrators.py``
- how many samples one call gets: ``mitsuba_samplers.py``
- channels as colours: ``mitsuba_colours.py``
- what a scene is made of: ``mitsuba_scene.py``
- the LLVM that compiled variants need: ``mitsuba_llvm.py``
- a user's own plugins: ``mitsuba_plugin.py``

Switched off, because it makes an image inexact on purpose: Russian roulette, the Gaussian reconstruction filter
(``box``) and half-precision output. ``total`` leaves the integrator as it is.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from comparisons.renderers.mitsuba_colours import colours
from comparisons.renderers.mitsuba_first_hits import first_hits
from comparisons.renderers.mitsuba_integrators import difference, passes, production, properties
from comparisons.renderers.mitsuba_llvm import ensure_llvm
from comparisons.renderers.mitsuba_names import FAMILY, Form, parse
from comparisons.renderers.mitsuba_particles import refuse_what_particles_cannot_reach
from comparisons.renderers.mitsuba_samplers import calls
from comparisons.renderers.mitsuba_scene import scene_dict
from comparisons.renderers.protocol import Hits, Images, RendererFailed, Unsupported
from scenes import Scene
from scenes.variations import black

Array = NDArray[np.float64]
Dict = dict[str, Any]


class StandIns(Protocol):
    """Plugins that stand in for Mitsuba's own."""

    def register(self) -> None:
        """Make them known to Mitsuba, whose variant is set."""

    def integrator(self, own: Dict) -> Dict:
        """What stands in for the integrator."""

    def sampler(self, own: Dict) -> Dict:
        """What stands in for the sampler."""

    def scene(self, own: Dict) -> Dict:
        """The scene with all that stands in for its parts."""


class MitsubaRenderer:
    """Mitsuba 3 in one of its forms: ``scalar_rgb``, ``llvm_ad_rgb:ptracer`` …"""

    def __init__(self, form: str, stand_ins: StandIns | None = None) -> None:
        self._form: Form = parse(f"{FAMILY}:{form}")
        if self._form.variant.startswith("llvm"):
            ensure_llvm()
        import drjit
        import mitsuba

        self._mi: Any = mitsuba
        self._stand_ins = stand_ins
        self._set_variant()
        mitsuba.set_log_level(mitsuba.LogLevel.Warn)
        drjit.set_thread_count(1)  # work is split over processes, by replicate
        if stand_ins:
            stand_ins.register()
        self._compiled = set[Any]()
        self._load = lru_cache(maxsize=8)(self._load_scene)  # relations take scenes in turn

    def version(self) -> str:
        """Of Mitsuba."""
        return str(self._mi.__version__)

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        """Differences of depths that share their seeds; see ``mitsuba_integrators`` and the protocol.

        Mitsuba's scalar sampler starts the stream of a pixel at the state pixel + seed × pixels, modulo 2³².
        Streams of consecutive states begin alike: with consecutive seeds, a sample each, the errors of TE form
        a lattice over the image. So seeds are drawn at random; now and then one comes twice, which does no
        harm.
        """
        differences = [difference(self._form, k) for k in bounces]
        images = {
            image: (black(scene) if image.black else scene, properties(self._form, image))
            for image in passes(differences)
        }
        total, sums = np.zeros((len(bounces), *scene.shape)), np.zeros(len(bounces))
        for weight, sum_of in self._rendered(scene, images, spp, seed):
            total += [weight * (sum_of[more] - (sum_of[less] if less else 0)) for more, less in differences]
            sums += [weight * sum_of[more].mean() for more, _ in differences]
        if self._form.coupled:  # if not, noise is larger than what precision takes
            _refuse_cancellation(bounces, total.mean(axis=(1, 2, 3)), sums)
        return total

    def total(self, scene: Scene, spp: int, seed: int) -> Array:
        """The sum of all bounces by the integrator as it is: unlimited depth, Russian roulette on.

        Returns:
            ``(height, width, channels)``.
        """
        made = {"all": (scene, production(self._form))}
        mean = np.zeros(scene.shape)
        for weight, images in self._rendered(scene, made, spp, seed):
            mean += weight * images["all"]
        return mean

    def first_hits(self, scene: Scene) -> Hits:
        """Its camera's rays through the centres of pixels, met by its ``ray_intersect``; see the protocol."""
        self._set_variant()
        return first_hits(self._mi, self._load(scene), scene, self._form)

    def _rendered(
        self, scene: Scene, wanted: Mapping[Any, tuple[Scene, Dict]], spp: int, seed: int
    ) -> Iterator[tuple[float, dict[Any, Array]]]:
        """Call after call its weight and all images that are wanted, with the same seed.

        Args:
            scene: for its size and channels.
            wanted: by any key, a scene and an integrator's dictionary.
            spp, seed: as asked for.
        """
        self._set_variant()
        read = colours(self._mi, self._form, scene.channels).radiance
        ready = {key: (self._load(part), self._integrator(own)) for key, (part, own) in wanted.items()}
        if self._form.compiled:
            self._compile_ahead(wanted, ready)
        height, width, _ = scene.shape
        samples = calls(self._form, spp, height * width)
        seeds = np.random.default_rng(seed).integers(2**32 // (height * width), size=len(samples))
        for count, stream in zip(samples, seeds.tolist(), strict=True):
            options = {"spp": count, "seed": stream}
            rendered = {
                key: np.array(self._mi.render(part, integrator=own, **options), dtype=np.float64)
                for key, (part, own) in ready.items()
            }
            yield count / sum(samples), {key: read(image) for key, image in rendered.items()}

    def _compile_ahead(
        self, wanted: Mapping[Any, tuple[Scene, Dict]], ready: Mapping[Any, tuple[Any, Any]]
    ) -> None:
        """Take the time for compiling once, at the first image, whose time nobody takes for that of others."""
        for key, (part, own) in wanted.items():
            new = (part, tuple(own.items()))
            if new not in self._compiled:
                self._compiled.add(new)
                self._mi.render(ready[key][0], integrator=ready[key][1], spp=self._form.spp_unit)

    def _set_variant(self) -> None:
        # it is the process's, not ours: another renderer of this process may have another
        if self._mi.variant() != self._form.variant:
            self._mi.set_variant(self._form.variant)

    def _integrator(self, own: Dict) -> Any:
        return self._mi.load_dict(self._stand_ins.integrator(own) if self._stand_ins else own)

    def _load_scene(self, scene: Scene) -> Any:
        if self._form.integrator == "ptracer":
            refuse_what_particles_cannot_reach(scene)
        sampler: Dict = {"type": self._form.sampler}
        if self._stand_ins:
            sampler = self._stand_ins.sampler(sampler)
        with TemporaryDirectory() as folder:  # meshes are read when the dictionary is loaded, and not again
            made = scene_dict(colours(self._mi, self._form, scene.channels), scene, Path(folder), sampler)
            if self._stand_ins:
                made = self._stand_ins.scene(made)
            # optimised, shapes come in the order of their addresses in memory, and so do the emitters among which a
            # random number chooses: the same seed would give another image each time
            return self._mi.load_dict(made, optimize=False)


def installed(form: str) -> str | None:
    """Mitsuba's version, without importing it; None where it is not installed, or a compiled form has no LLVM."""
    try:
        if parse(f"{FAMILY}:{form}").variant.startswith("llvm"):
            ensure_llvm()
        return version("mitsuba")
    except (PackageNotFoundError, RendererFailed):
        return None


def supports(form: str = "scalar_rgb") -> dict[str, Sequence[str]]:
    """What a form can express and do, in the words of ``scenes.features``; nothing is imported for that."""
    told = parse(f"{FAMILY}:{form}")
    particles = told.integrator == "ptracer"
    delta = () if particles else ("mirror", "dielectric", "conductor")
    rough = ("rough_conductor", "rough_dielectric", "blend")
    pictures = () if told.spectral else ("image texture",)
    skies = ("constant",) if told.spectral else ("constant", "environment_map")
    images = ("bounces 0 and 1",) if told.integrator == "direct" else ("bounces", "total")
    meters = () if particles else ("orthographic", "radiance_meter")
    return {
        "shapes": ("quad", "disk", "sphere", "mesh"),
        "materials": ("lambertian", "checkerboard texture", *pictures, *delta, *rough),
        "lights": ("area", "point", "spot", "directional", *skies),
        "sensors": ("pinhole", "thin_lens", *meters),
        "images": (*images, "first hits"),
        "seed": ("yes",),
    }


def _refuse_cancellation(bounces: Sequence[int], terms: Array, sums: Array) -> None:
    """Refuse terms so small that single precision can't hold them as a difference of two sums.

    A sum is rounded to 2⁻²⁴ of itself, so a term of 2⁻¹³ of the sum is exact to 2⁻¹¹, a twentieth of a percent.
    A term that is exactly 0 is judged: a lost bounce must fail, not be refused.

    Raises:
        Unsupported: naming the bounce.
    """
    for k, term, partial_sum in zip(bounces, terms, sums, strict=True):
        if 0 < abs(term) < 2**-13 * partial_sum:
            share = term / partial_sum
            raise Unsupported(
                f"bounce {k}, {share:.0e} of the sum: too little for a difference in single precision"
            )
