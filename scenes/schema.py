"""The JSON Schema of scenes, for editors and other programs.

It says which parts and fields there are and of what type. What the values may be (an albedo in [0, 1], a normal that
is no zero vector) is checked when a scene is read.

python -m scenes.schema     writes scene.schema.json beside this file; ``make schema``
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from scenes.scene import Scene

SCHEMA_FILE = Path(__file__).with_name("scene.schema.json")
_DRAFT = "https://json-schema.org/draft/2020-12/schema"


def schema() -> dict[str, Any]:
    """The JSON Schema (2020-12) of a scene."""
    found = msgspec.json.schema(Scene)
    parts = found["$defs"]
    # as when a scene is read: an emission can be nothing else, and a file may name its schema
    parts["AreaLight"]["required"].remove("type")
    parts["Scene"]["properties"] = {"$schema": {"type": "string"}, **parts["Scene"]["properties"]}
    return {"$schema": _DRAFT, "title": "A scene of Lightproof", **found}


def write_schema() -> None:
    """Write the schema beside this file."""
    SCHEMA_FILE.write_bytes(msgspec.json.format(msgspec.json.encode(schema()), indent=2) + b"\n")


if __name__ == "__main__":
    write_schema()
