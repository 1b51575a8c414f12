"""Renderers: the protocol, and one adapter per file."""

from __future__ import annotations

from comparisons.renderers.config import ConfigError
from comparisons.renderers.entry import Entry
from comparisons.renderers.protocol import (
    Hits,
    Images,
    Renderer,
    RendererError,
    RendererFailed,
    RendererTimeout,
    Unsupported,
)
from comparisons.renderers.registry import (
    RENDERERS,
    SHORT_NAMES,
    STRATEGIES,
    canonical,
    create,
    listed,
    make,
    resolve,
    strategies_of,
    traits,
)

__all__ = [
    "RENDERERS",
    "SHORT_NAMES",
    "STRATEGIES",
    "ConfigError",
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
    "listed",
    "make",
    "resolve",
    "strategies_of",
    "traits",
]
