"""``lightproof list``: what is known of each renderer, and rows for the eye."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from comparisons.renderers import SHORT_NAMES, Entry, listed
from comparisons.renderers.registry import installed, supports


def renderers() -> list[dict[str, Any]]:
    """A row for each: version, whether it is installed, how to install it, and what it supports.

    Raises:
        ConfigError: the user's configuration can't be read.
    """
    short = {full: name for name, full in SHORT_NAMES.items()}
    return [_row(name, short.get(name), entry) for name, entry in listed().items()]


def _row(name: str, short: str | None, entry: Entry) -> dict[str, Any]:
    version = installed(entry)
    return {
        "name": name,
        "short": short,
        "title": entry.title,
        "version": version,
        "installed": version is not None,
        "install": entry.install or (f"pip install {entry.package}" if entry.package else None),
        "supports": {what: list(which) for what, which in supports(entry).items()},
    }


def table(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, str]]:
    """Rows for the eye, all of them with the same columns."""
    shown = [_texts(row) for row in rows]
    columns = dict.fromkeys((key for row in shown for key in row), "")
    return [columns | row for row in shown]


def _texts(row: Mapping[str, Any]) -> dict[str, str]:
    """Lists with commas, a table as columns of its own, yes or no."""
    shown: dict[str, str] = {}
    for key, value in row.items():
        if isinstance(value, Mapping):
            shown |= _texts(value)
        elif isinstance(value, bool):
            shown[key] = "yes" if value else "no"
        else:
            shown[key] = ", ".join(value) if isinstance(value, list) else "" if value is None else str(value)
    return shown
