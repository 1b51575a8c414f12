"""A Python object with ``render``, found as ``module:attribute``; or a class or a function that makes one.

Its folder, the working directory, comes last on the path of imports: a user's ``scenes.py`` is not taken for ours.
"""

from __future__ import annotations

import sys
from importlib import import_module
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Any

from comparisons.renderers.protocol import Renderer, RendererFailed


def installed(argument: str, folder: Path) -> str | None:
    """Unknown, without importing it; None where there is no such module in the folder, nor installed."""
    return "unknown" if is_module(argument.partition(":")[0], folder) else None


def is_module(name: str, folder: Path) -> bool:
    """Whether there is one, in the folder or installed; nothing is imported for that."""
    return PathFinder.find_spec(name.partition(".")[0], [*sys.path, str(folder)]) is not None


def from_folder(place: str) -> Renderer:
    """That of a module in the working directory, or of an installed one, which comes first.

    Raises:
        RendererFailed: it can't be found, or has no ``render``.
        Exception: whatever the module raises.
    """
    sys.path.append(str(Path.cwd()))
    return from_package(place)


def from_package(place: str) -> Renderer:
    """That of an installed module.

    Raises:
        RendererFailed, Exception: as above.
    """
    name, _, attribute = place.partition(":")
    found: Any = import_module(name)
    for part in attribute.split("."):
        if not hasattr(found, part):
            there = ", ".join(key for key in vars(found) if not key.startswith("_"))
            raise RendererFailed(f"{place}: {name} has no {attribute}; there are {there}")
        found = getattr(found, part)
    if isinstance(found, type) or not callable(getattr(found, "render", None)):
        if not callable(found):
            raise RendererFailed(
                f"{place} is a {type(found).__name__}: expected an object with render(scene, bounces, spp, seed)"
            )
        found = found()
    if not callable(getattr(found, "render", None)):
        raise RendererFailed(
            f"{place} makes a {type(found).__name__} without render(scene, bounces, spp, seed)"
        )
    made: Renderer = found
    return made
