"""The library of cases: one file per family, and this list of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from scenes.case import Case
from scenes.library.cornell_box import cornell_box
from scenes.library.furnace import furnace_box, furnace_sphere
from scenes.library.integrating_sphere import integrating_sphere
from scenes.names import look_up

CASES: Mapping[str, Callable[[], Case]] = MappingProxyType(
    {
        "furnace-box": furnace_box,
        "furnace-sphere": furnace_sphere,
        "integrating-sphere": integrating_sphere,
        "cornell-box": cornell_box,
    }
)


def case(name: str) -> Case:
    """The case of that name.

    Raises:
        UnknownNameError: there is none.
    """
    return look_up("case", name, CASES)()
