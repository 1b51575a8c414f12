"""scenes.md shows every part that a scene can have; ``test_equation`` runs its session and follows its links."""

from __future__ import annotations

import re
from pathlib import Path
from typing import get_args

import msgspec
import pytest

from scenes import AreaLight, Light, Material, Sensor, Shape, Texture

PAGE = (Path(__file__).parents[2] / "docs" / "scenes.md").read_text()
SESSION = "\n".join(re.findall(r"^```pycon\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL))
PARTS = [kind for union in (Shape, Material, Texture, Light, Sensor) for kind in get_args(union)]


@pytest.mark.parametrize("part", [*PARTS, AreaLight], ids=lambda part: part.__name__)
def test_every_part_has_a_row_and_an_example(part: type[msgspec.Struct]) -> None:
    name, tag = part.__name__, part.__struct_config__.tag
    assert f"\n| `{name}` | `{tag}` |" in PAGE, f"scenes.md has no row '| `{name}` | `{tag}` |'"
    assert re.search(rf"\b{name}\(", SESSION), f"scenes.md has no example of {name}"


def test_no_row_is_of_something_else() -> None:
    rows = re.findall(r"^\| `(\w+)` \| `\w+` \|", PAGE, re.MULTILINE)
    assert sorted(rows) == sorted(part.__name__ for part in (*PARTS, AreaLight))
