"""Renderers: the protocol, and one adapter per file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from types import MappingProxyType

from comparisons.renderers.entry import Entry
from comparisons.renderers.mitsuba_names import entry_of, full_name
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
        **{name: entry for name in ("mitsuba:scalar_rgb",) if (entry := entry_of(name))},
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
    full = full_name(SHORT_NAMES.get(name, name))
    if entry_of(full) is None:
        look_up("renderer", full, {**dict.fromkeys(SHORT_NAMES), **RENDERERS})
    return full


def strategies_of(name: str) -> tuple[str, ...]:
    """The other ways in which the renderer of that full name can estimate the same image."""
    return tuple(other for other in STRATEGIES if other != name) if name in STRATEGIES else ()


def traits(name: str) -> Entry:
    """What is declared of a renderer; nothing out of the ordinary for one that is not listed."""
    return entry_of(name) or RENDERERS.get(name, Entry("", "", "", ""))


def create(name: str) -> Renderer:
    """Make the renderer of that name, importing its packages.

    Raises:
        UnknownNameError: there is no such renderer.
        ImportError: its packages are not installed.
    """
    entry = traits(canonical(name))
    adapter: Callable[[str], Renderer] = getattr(import_module(f"{__name__}.{entry.module}"), entry.adapter)
    return adapter(entry.argument)
