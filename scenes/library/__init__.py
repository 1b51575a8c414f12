"""The library of cases: one file per family, and this list of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from scenes.case import Case
from scenes.library import (
    around_the_corner,
    cie_171,
    constant_radiance,
    cornell_box,
    direct_light,
    direct_light_of_lights,
    furnace,
    glossy,
    integrating_sphere,
    interreflection,
    mirrors,
    no_closed_form,
    point_in_sphere,
    rectangles,
    sides,
    spectral,
    specular,
    textures,
)
from scenes.names import look_up

FAMILIES = (
    furnace,
    integrating_sphere,
    interreflection,
    constant_radiance,
    point_in_sphere,
    direct_light,
    direct_light_of_lights,
    rectangles,
    sides,
    textures,
    cie_171,
    mirrors,
    specular,
    glossy,
    no_closed_form,
    around_the_corner,
    spectral,
    cornell_box,
)
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
