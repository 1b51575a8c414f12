"""``lightproof list``: what is known of each renderer, and rows for the eye."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console
from rich.padding import Padding
from rich.text import Text

from comparisons.renderers import SHORT_NAMES, Entry, listed
from comparisons.renderers.registry import installed, supports
from lightproof import terminal


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


def show_renderers(out: Console, rows: Sequence[Mapping[str, Any]]) -> None:
    """The renderers one by one, and then what they support, those that support the same together."""
    terminal.show_rows(out, table([_in_short(row) for row in rows]))
    alike: dict[str, list[str]] = {}
    for row in rows:
        what = "\n".join(f"{kind}: {', '.join(which)}" for kind, which in row["supports"].items())
        alike.setdefault(what or "that is known once it runs", []).append(row["name"])
    out.print()
    for what, names in alike.items():
        out.print(Text(", ".join(names), "bold"), soft_wrap=True)
        out.print(Padding(Text(what, "dim"), (0, 0, 0, 4), expand=False))
        out.print()


def _in_short(row: Mapping[str, Any]) -> dict[str, Any]:
    name = f"{row['name']} ({row['short']})" if row["short"] else row["name"]
    there = (
        row["version"] or "yes" if row["installed"] else f"not installed: {row['install'] or 'see its docs'}"
    )
    return {"name": name, "installed": there, "title": row["title"]}


def table(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, str]]:
    """Rows for the eye, all of them with the same columns."""
    shown = [_texts(row) for row in rows]
    columns = dict.fromkeys((key for row in shown for key in row), "")
    return [columns | row for row in shown]


def _texts(row: Mapping[str, Any]) -> dict[str, str]:
    """Lists with commas, nothing for None."""
    return {
        key: ", ".join(value) if isinstance(value, list) else "" if value is None else str(value)
        for key, value in row.items()
    }
