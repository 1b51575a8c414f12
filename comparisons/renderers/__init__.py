"""Renderers: the protocol, and one adapter per file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from types import MappingProxyType

from comparisons.renderers.mitsuba_names import FAMILY, LAST_BOUNCE, Form, is_of_family, parse
from comparisons.renderers.mitsuba_samplers import unit
from comparisons.renderers.protocol import (
    Hits,
    Images,
    Renderer,
    RendererError,
    RendererFailed,
    RendererTimeout,
    Unsupported,
)
from scenes.names import look_up

__all__ = [
    "RENDERERS",
    "SHORT_NAMES",
    "Entry",
    "Hits",
    "Images",
    "Renderer",
    "RendererError",
    "RendererFailed",
    "RendererTimeout",
    "Unsupported",
    "canonical",
    "create",
    "strategies_of",
    "traits",
]


@dataclass(frozen=True)
class Entry:
    """A renderer that can be asked for.

    Attributes:
        title: one line.
        module, adapter, argument: which class to make, and with what. It is imported in the worker process
            that runs it, and nowhere else.
        package: the distribution that it needs besides this one's own.
        deterministic: whether it has no noise, so that every seed gives the same image.
        one_walk: whether a bounce brings all earlier ones along for nothing.
        last_bounce: beyond which it has none; None for no limit.
        spp_unit: its samples per pixel come in multiples of this.
    """

    title: str
    module: str
    adapter: str
    argument: str
    package: str = "lightproof"
    deterministic: bool = False
    one_walk: bool = False
    last_bounce: int | None = None
    spp_unit: int = 1


def _mitsuba(form: Form) -> Entry:
    return Entry(
        form.title,
        "mitsuba",
        "MitsubaRenderer",
        ":".join(form),
        FAMILY,
        last_bounce=LAST_BOUNCE.get(form.integrator),
        spp_unit=unit(form),
    )


RENDERERS: Mapping[str, Entry] = MappingProxyType(
    {
        "reference:mis": Entry(
            "the reference tracer: next event and chance, weighted",
            "reference",
            "ReferenceRenderer",
            "mis",
            one_walk=True,
        ),
        "reference:mis:sobol": Entry(
            "the reference tracer, on scrambled Sobol' points over the whole image",
            "reference",
            "ReferenceRenderer",
            "mis:sobol",
            one_walk=True,
        ),
        "reference:nee": Entry(
            "the reference tracer: next event alone", "reference", "ReferenceRenderer", "nee", one_walk=True
        ),
        "reference:bsdf": Entry(
            "the reference tracer: emission found by chance",
            "reference",
            "ReferenceRenderer",
            "bsdf",
            one_walk=True,
        ),
        Form().name: _mitsuba(Form()),
    }
)

SHORT_NAMES: Mapping[str, str] = MappingProxyType(
    {"reference": "reference:mis", "mitsuba": "mitsuba:scalar_rgb"}
)


STRATEGIES = ("reference:mis", "reference:nee", "reference:bsdf", "reference:mis:sobol")
"""Renderers that differ in how they sample, and in nothing else. Variants of Mitsuba run the same strategy."""


def canonical(name: str) -> str:
    """The full name behind a short one: ``mitsuba`` is ``mitsuba:scalar_rgb``.

    Raises:
        UnknownNameError: there is no such renderer.
    """
    full = SHORT_NAMES.get(name, name)
    if is_of_family(full):
        return parse(full).name
    look_up("renderer", full, {**dict.fromkeys(SHORT_NAMES), **RENDERERS})
    return full


def strategies_of(name: str) -> tuple[str, ...]:
    """The other ways in which the renderer of that full name can estimate the same image."""
    return tuple(other for other in STRATEGIES if other != name) if name in STRATEGIES else ()


def traits(name: str) -> Entry:
    """What is declared of a renderer; nothing out of the ordinary for one that is not listed."""
    return _mitsuba(parse(name)) if is_of_family(name) else RENDERERS.get(name, Entry("", "", "", ""))


def create(name: str) -> Renderer:
    """Make the renderer of that name, importing its packages.

    Raises:
        UnknownNameError: there is no such renderer.
        ImportError: its packages are not installed.
    """
    entry = traits(canonical(name))
    adapter: Callable[[str], Renderer] = getattr(import_module(f"{__name__}.{entry.module}"), entry.adapter)
    return adapter(entry.argument)
