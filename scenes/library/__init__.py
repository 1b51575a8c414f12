"""The library of cases: one file per family, and this list of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from scenes.case import Case
from scenes.library import (
    around_the_corner,
    cornell_box,
    furnace,
    integrating_sphere,
    no_closed_form,
    spectral,
)
from scenes.names import look_up

FAMILIES = (furnace, integrating_sphere, cornell_box, no_closed_form, around_the_corner, spectral)
"""Each has ``CASES``: name → function that makes the case."""

CASES: Mapping[str, Callable[[], Case]] = MappingProxyType(
    {name: make for family in FAMILIES for name, make in family.CASES.items()}
)

DEFAULT = ("furnace-box", "furnace-sphere", "integrating-sphere", "cornell-box")
"""What a validation looks at unless told otherwise: little enough for a coffee, much enough for most faults."""


def case(name: str) -> Case:
    """The case of that name.

    Raises:
        UnknownNameError: there is none.
    """
    return look_up("case", name, CASES)()
