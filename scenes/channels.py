"""Channels: the numbers that radiance has at a place, three for RGB. All parts of a scene have the same number."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, TypeVar

import msgspec

from scenes.validation import SceneError

Part = TypeVar("Part", bound=msgspec.Struct)

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


def single_channel(part: Part, channel: int) -> Part:
    """A scene, or a part of one, that has only this channel.

    Raises:
        SceneError: nothing emits in it.
        IndexError: there is no such channel.
    """
    return with_channels(part, (channel,))


def with_channels(part: Part, order: Sequence[int]) -> Part:
    """A scene, or a part of one, whose channel i is channel ``order[i]`` of this one.

    Raises:
        SceneError: nothing emits in these.
        IndexError: there is no such channel.
    """
    changes: dict[str, Any] = {}
    for field in part.__struct_fields__:
        value = getattr(part, field)
        if isinstance(value, msgspec.Struct):
            changes[field] = with_channels(value, order)
        elif field in ("surfaces", "lights"):
            changes[field] = tuple(with_channels(item, order) for item in value)
        elif field in _PER_CHANNEL:
            changes[field] = _picked(value, order)
        elif field == "coefficients":
            changes[field] = tuple(_picked(row, order) for row in value)
        elif field == "pixels":
            changes[field] = tuple(tuple(_picked(pixel, order) for pixel in row) for row in value)
    return msgspec.structs.replace(part, **changes)


def _picked(values: tuple[float, ...], order: Sequence[int]) -> tuple[float, ...]:
    return tuple(values[i] for i in order)
