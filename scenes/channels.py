"""Channels: the numbers that radiance has at a place, three for RGB. All parts of a scene have the same number."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import msgspec

from scenes.validation import SceneError

_PER_CHANNEL = ("albedo", "even", "odd", "reflectance", "eta", "k", "radiance", "intensity", "irradiance")


def channel_fields(part: msgspec.Struct, place: str) -> Iterator[tuple[str, object, int]]:
    """Every field in a part of a scene that has a number per channel: its place, its value, how many."""
    for field in part.__struct_fields__:
        value, where = getattr(part, field), f"{place}.{field}"
        if isinstance(value, msgspec.Struct):
            yield from channel_fields(value, where)
        elif field in _PER_CHANNEL:
            yield where, value, len(value)
        elif field == "coefficients":
            yield f"{where}[0]", value[0], len(value[0])
        elif field == "pixels":
            yield f"{where}[0][0]", value[0][0], len(value[0][0])


def check_channels(parts: Iterable[tuple[str, msgspec.Struct]]) -> int | None:
    """How many channels all the parts have; None if all of them go with any number.

    Args:
        parts: each with its place.

    Raises:
        SceneError: naming the first field that has another number than the fields before it.
    """
    first, channels = "", None
    for place, part in parts:
        for where, value, count in channel_fields(part, place):
            if channels is None:
                first, channels = where.partition(".")[2], count
            if count != channels:
                raise SceneError(where, value, f"{channels} channels, as {first} has")
    return channels
