"""The user's configuration: ``lightproof.toml``, or ``[tool.lightproof]`` in ``pyproject.toml``.

    memory = "4 GB"                 # of each renderer's process with all it starts; default: half of the machine's

    [renderers.mine]                # --renderer mine
    command = ["./mine", "{scene}", "--spp", "{spp}", "--seed", "{seed}", "--bounces", "{bounces}", "-o", "{output}"]
    scene = "json"
    images = "cumulative"

It is looked for in the working directory, then in the folders above it; the first one found counts, and what it says
holds for the whole run. Relative paths begin at its folder. ``tables.py`` has the keys of a renderer.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from comparisons.renderers.entry import Entry
from comparisons.renderers.limits import default_memory
from comparisons.renderers.tables import ConfigError, Place, bytes_of, checked_name, renderer

__all__ = ["FILE", "PYPROJECT", "Config", "ConfigError", "current", "find", "load"]

FILE, PYPROJECT = "lightproof.toml", "pyproject.toml"


class Config(NamedTuple):
    """What the user has configured.

    Attributes:
        file: where; None where there is no such file.
        memory: bytes that a renderer's process and all it starts may take, unless it has a number of its own.
        renderers: by name.
    """

    file: Path | None
    memory: int
    renderers: Mapping[str, Entry]


def current() -> Config:
    """That of the working directory, read once.

    Raises:
        ConfigError: see ``load``.
    """
    return _read(Path.cwd())


@lru_cache(maxsize=64)
def _read(folder: Path) -> Config:
    file = find(folder)
    return load(file) if file else Config(None, default_memory(), MappingProxyType({}))


def find(folder: Path) -> Path | None:
    """The file that counts for this folder.

    Raises:
        ConfigError: a ``pyproject.toml`` on the way is no TOML.
    """
    for above in (folder, *folder.parents):
        if (above / FILE).is_file():
            return above / FILE
        project = above / PYPROJECT
        if project.is_file() and _section(project) is not None:
            return project
    return None


def load(file: Path) -> Config:
    """Read a configuration.

    Raises:
        ConfigError: it can't be read, or a key or a value can't be that; naming it, and what was expected.
    """
    document = _section(file) if file.name == PYPROJECT else _toml(file)
    place = Place(file, ("tool", "lightproof") if file.name == PYPROJECT else ())
    if not isinstance(document, dict):
        raise place.error(document, "a table")
    place.refuse_unknown(document, ("memory", "renderers"))
    memory = bytes_of(document["memory"], place / "memory") if "memory" in document else default_memory()
    tables, where = document.get("renderers", {}), place / "renderers"
    if not isinstance(tables, dict):
        raise where.error(tables, "a table of renderers, [renderers.NAME]")
    found = {name: renderer(table, where / checked_name(name, where)) for name, table in tables.items()}
    return Config(file, memory, MappingProxyType(found))


def _section(file: Path) -> Any:
    """What stands in ``[tool.lightproof]``; None where there is no such table."""
    tool = _toml(file).get("tool")
    return tool.get("lightproof") if isinstance(tool, dict) else None


def _toml(file: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{file}: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{file}: expected TOML: {error}") from None
