"""renderers.md and workers.md: their tables have every key, placeholder and message there is, and no other."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any, get_args

import msgspec
import pytest

from comparisons.renderers import config, messages, placeholders
from comparisons.renderers.keys import Command, PythonObject, Shared, WorkerFile

DOCS = Path(__file__).parents[2] / "docs"
PAGE, WORKERS = ((DOCS / f"{name}.md").read_text() for name in ("renderers", "workers"))
BLOCKS = re.findall(r"^```toml\n(.*?)^```$", PAGE + WORKERS, re.MULTILINE | re.DOTALL)


def rows(first: str) -> dict[str, list[str]]:
    """The table whose first row is about this, by what stands first in a row."""
    for table in re.findall(r"^\|[^\n]*\|\n\|[-|]+\|\n((?:\|.*\|\n)+)", PAGE + WORKERS, re.MULTILINE):
        cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
        if cells[0][0] == f"`{first}`":
            return {row[0].strip("`"): row[1:] for row in cells}
    raise AssertionError(f"no table begins with {first}")


@pytest.mark.parametrize("keys", [Command, Shared, PythonObject, WorkerFile])
def test_every_key_has_its_row_and_its_default(keys: type[msgspec.Struct]) -> None:
    shared = () if keys is Shared else Shared.__struct_fields__
    fields = {f.name: f for f in msgspec.structs.fields(keys) if f.name not in shared}
    table = rows(next(iter(fields)))
    assert set(table) == set(fields)
    for name, (default, meaning) in table.items():
        value: Any = fields[name].default
        if fields[name].default_factory is not msgspec.NODEFAULT:
            value = fields[name].default_factory()
        required = value is msgspec.NODEFAULT
        assert default == ("–" if required else f"`{json.dumps(value)}`"), name
        assert meaning


def test_every_placeholder_has_its_row() -> None:
    named = {name for row in rows("{scene}") for name in re.findall(r"\{([a-z]+)\}", row)}
    assert named == set(placeholders.NAMES)


def test_every_message_has_its_row() -> None:
    for first, kinds in (("render", messages.Request), ("rendered", messages.Reply)):
        table = rows(first)
        for kind in get_args(kinds):
            tag = kind.__struct_config__.tag
            if tag == "ready":
                continue
            assert re.findall(r"`(\w+)`", table[tag][0]) == list(kind.__struct_fields__)


def test_what_the_pages_configure_can_be(tmp_path: Path) -> None:
    for name in ("my_worker.py", "quads.py"):
        (tmp_path / name).touch()
    (tmp_path / config.FILE).write_text("")
    tables = [block for block in BLOCKS if "[renderers." in block]
    assert len(tables) == 4
    for block in tables:
        (tmp_path / config.FILE).write_text(block)
        assert len(config.load(tmp_path / config.FILE).renderers) == 1
    [entry_point] = [tomllib.loads(block) for block in BLOCKS if "entry-points" in block]
    assert list(entry_point["project"]["entry-points"]) == ["lightproof.renderers"]
