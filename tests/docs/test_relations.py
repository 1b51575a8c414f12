"""docs/relations.md has every relation, with what it tests."""

from __future__ import annotations

import re
from pathlib import Path

from comparisons.relations import RELATIONS

PAGE = Path(__file__).parents[2] / "docs" / "relations.md"


def test_every_relation_has_its_row() -> None:
    rows = re.findall(r"^\| `([a-z-]+)` \| (\w+) \|", PAGE.read_text(encoding="utf-8"), re.M)
    assert rows == [(relation.name, relation.operator) for relation in RELATIONS.values()]
