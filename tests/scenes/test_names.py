"""A mistyped name gets the nearest ones."""

from __future__ import annotations

import pytest

from scenes import UnknownNameError
from scenes.library import CASES, case
from scenes.names import look_up


@pytest.mark.parametrize("name", CASES)
def test_a_case_knows_its_name(name: str) -> None:
    assert case(name).name == name


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("cornel-box", "cornell-box"),
        ("furnace_box", "furnace-box"),
        ("integrating-spere", "integrating-sphere"),
    ],
)
def test_the_nearest_name_comes_first(typed: str, meant: str) -> None:
    with pytest.raises(UnknownNameError, match=rf"^no case is called '{typed}': did you mean {meant}"):
        case(typed)


def test_all_names_where_none_is_near() -> None:
    with pytest.raises(UnknownNameError, match=r"there are one, two$"):
        look_up("thing", "qqqqqq", {"two": 2, "one": 1})
    assert look_up("thing", "two", {"two": 2, "one": 1}) == 2
