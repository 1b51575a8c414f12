"""Node ids as names of folders."""

from __future__ import annotations

import re

import pytest

from lightproof.pytest_host import folder_names


def test_node_ids_as_folders() -> None:
    assert list(folder_names("tests/test_a.py::Test::test_b[x-1]")) == [
        "tests",
        "test_a.py",
        "Test",
        "test_b[x-1]",
    ]


@pytest.mark.parametrize(
    "hostile", ["../../etc/test_a.py::t", "a.py::t[" + "x" * 300 + "]", "a.py::t[<\x00é>]"]
)
def test_hostile_node_ids_stay_inside_and_apart(hostile: str) -> None:
    names = list(folder_names(hostile))
    assert all(re.fullmatch(r"[\w.,=+\[\]-]+", name, re.ASCII) and len(name) < 120 for name in names)
    assert not {"..", ".", ""} & set(names)
    assert names != list(folder_names(hostile + "?"))
