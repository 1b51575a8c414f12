"""Checks on what a scene is made of. Each failure names the field's path, what was found and what was expected."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import msgspec

Vector = tuple[float, float, float]


class SceneError(ValueError):
    """A scene that can't be.

    Attributes:
        path: the field, ``surfaces[3].material.albedo[1]`` in a scene read from JSON; where a part was made
            in Python by itself, the path starts at that part's type, ``Lambertian.albedo[1]``.
        found: the value that stands there.
        expected: what may stand there.
    """

    def __init__(self, path: str, found: object, expected: str) -> None:
        super().__init__(path, found, expected)  # all of them, so that it survives the way out of a process
        self.path, self.found, self.expected = path, found, expected

    def __str__(self) -> str:
        return f"{self.path} = {self.found!r}: expected {self.expected}"

    def below(self, parent: str) -> SceneError:
        """The same error as seen from a parent: ``Lambertian.albedo[1]`` becomes ``parent.albedo[1]``."""
        field = self.path.partition(".")[2]
        return SceneError(".".join(filter(None, (parent, field))), self.found, self.expected)


def path(owner: object, field: str) -> str:
    """``Type.field``, where a path begins."""
    return f"{type(owner).__name__}.{field}"


def finite(owner: object, field: str, value: object, expected: str = "a finite number") -> float:
    """The value as a float; refuses NaN, infinity and anything that is no number."""
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        raise SceneError(path(owner, field), value, expected) from None
    if isinstance(value, bool | str | bytes) or not math.isfinite(number):
        raise SceneError(path(owner, field), value, expected)
    return number


def number(owner: Any, field: str, expected: str = "a finite number") -> float:
    """Freeze the field into a finite float and return it."""
    value = finite(owner, field, getattr(owner, field), expected)
    msgspec.structs.force_setattr(owner, field, value)
    return value


def instance(owner: Any, field: str, kind: Any, expected: str) -> None:
    """Refuse what is not of that kind; in JSON, msgspec does the same."""
    if not isinstance(getattr(owner, field), kind):
        raise SceneError(path(owner, field), getattr(owner, field), expected)


def numbers(owner: Any, field: str, low: float = -math.inf, high: float = math.inf) -> tuple[float, ...]:
    """Freeze the field into a tuple of finite numbers in [low, high] and return it."""
    values = getattr(owner, field)
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise SceneError(path(owner, field), values, "a list of numbers")
    expected = f"a number in [{low:g}, {high:g}]" if math.isfinite(low) else "a finite number"
    frozen = []
    for i, value in enumerate(values):
        number = finite(owner, f"{field}[{i}]", value, expected)
        if not low <= number <= high:
            raise SceneError(path(owner, f"{field}[{i}]"), value, expected)
        frozen.append(number)
    msgspec.structs.force_setattr(owner, field, tuple(frozen))
    return tuple(frozen)


def vector(owner: Any, field: str) -> Vector:
    """Freeze the field into a tuple of three finite numbers and return it."""
    values = numbers(owner, field)
    if len(values) != 3:
        raise SceneError(path(owner, field), values, "three numbers x, y, z")
    return values


def vector_of(owner: Any, field: str, value: Any) -> Vector:
    """The value as three finite numbers; the field is named in errors only."""
    if isinstance(value, str) or not isinstance(value, Iterable) or len(tuple(value)) != 3:
        raise SceneError(path(owner, field), value, "three numbers x, y, z")
    x, y, z = (finite(owner, f"{field}[{i}]", v) for i, v in enumerate(value))
    return x, y, z


def unit_vector(owner: Any, field: str) -> Vector:
    """Freeze the field into a unit vector and return it; any length but zero may be given."""
    x, y, z = vector(owner, field)
    length = math.hypot(x, y, z)
    if length == 0:
        raise SceneError(path(owner, field), (x, y, z), "a direction, not the zero vector")
    if abs(length - 1) < 1e-15:  # dividing once more would change its last digits: not what JSON has kept
        return x, y, z
    unit = (x / length, y / length, z / length)
    msgspec.structs.force_setattr(owner, field, unit)
    return unit
