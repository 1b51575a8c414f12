"""Channels: the numbers that radiance has at a place, three for RGB. All parts of a scene have the same number."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, TypeVar

import msgspec
import numpy as np

from scenes.validation import SceneError

Part = TypeVar("Part", bound=msgspec.Struct)

_PER_CHANNEL = ("albedo", "even", "odd", "reflectance", "eta", "k", "radiance", "intensity", "irradiance")
_ROWS = ("coefficients", "angular_profile")
"""Lists with a number per channel in each item."""
_VISIBLE = (360, 830)  # nm: where the observer's matching functions are tabulated


def channel_names(channels: int, wavelengths: Sequence[float] | None = None) -> list[str]:
    """What channels are called: ``404 nm, …`` by wavelength, else ``R, G, B``, ``Y`` of one, or ``C0, C1, …``."""
    if wavelengths is not None:
        return [f"{w:.9g} nm" for w in wavelengths]
    return {1: ["Y"], 3: ["R", "G", "B"]}.get(channels) or [f"C{i}" for i in range(channels)]


def check_wavelengths(wavelengths: Sequence[float], channels: int) -> None:
    """Refuse wavelengths that are no sampling of what the CIE's observer of 1931 sees, or not those of the channels.

    Raises:
        ValueError: they are not within 360 to 830 nm, not in equal steps, or not as many as channels.
    """
    steps, found = np.diff(wavelengths), f"wavelengths {list(wavelengths)}"
    if not len(steps) or not (steps > 0).all() or np.ptp(steps) > 1e-9 * steps[0]:
        raise ValueError(f"{found}: expected two or more, ascending in equal steps")
    if wavelengths[0] < _VISIBLE[0] or wavelengths[-1] > _VISIBLE[1]:
        raise ValueError(f"{found}: expected nanometres from {_VISIBLE[0]} to {_VISIBLE[1]}")
    if channels != len(wavelengths):
        raise ValueError(f"{channels} channels, expected one per wavelength: {len(wavelengths)}")


def channel_fields(part: msgspec.Struct, place: str) -> Iterator[tuple[str, object, int]]:
    """Every field in a part of a scene that has a number per channel: its place, its value, how many."""
    for field in part.__struct_fields__:
        value, where = getattr(part, field), f"{place}.{field}"
        if isinstance(value, msgspec.Struct):
            yield from channel_fields(value, where)
        elif field in _PER_CHANNEL:
            yield where, value, len(value)
        elif field in _ROWS and value is not None:
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
        elif (
            field == "angular_profile"
            and value is not None
            and not any(any(_picked(row, order)) for row in value)
        ):
            changes |= {
                field: None,
                "radiance": (0.0,) * len(order),
            }  # black at every angle: no profile says that
        elif field in _ROWS and value is not None:
            changes[field] = tuple(_picked(row, order) for row in value)
        elif field == "pixels":
            changes[field] = tuple(tuple(_picked(pixel, order) for pixel in row) for row in value)
    return msgspec.structs.replace(part, **changes)


def _picked(values: tuple[float, ...], order: Sequence[int]) -> tuple[float, ...]:
    return tuple(values[i] for i in order)
