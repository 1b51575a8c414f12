"""Checks on what a scene is made of. Each failure names the field's path, what was found and what was expected."""

from __future__ import annotations

import math
from collections.abc import Iterable
from numbers import Real
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

Vector = tuple[float, float, float]


_LONGEST = 300  # characters of a value in a message: a mesh has millions


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
        found = repr(self.found)
        if len(found) > _LONGEST:
            found = f"{found[:_LONGEST]} … ({len(found)} characters)"
        return f"{self.path} = {found}: expected {self.expected}"

    def below(self, parent: str) -> SceneError:
        """The same error as seen from a parent: ``Lambertian.albedo[1]`` becomes ``parent.albedo[1]``."""
        field = self.path.partition(".")[2]
        return SceneError(".".join(filter(None, (parent, field))), self.found, self.expected)


def path(owner: object, field: str) -> str:
    """``Type.field``, where a path begins."""
    return f"{type(owner).__name__}.{field}"


def finite(owner: object, field: str, value: object, expected: str = "a finite number") -> float:
    """The value as a float; refuses NaN, infinity and anything that is no number."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value.item()
    try:
        number = math.nan if isinstance(value, bool) or not isinstance(value, Real) else float(value)
    except OverflowError:  # an integer beyond all floats
        number = math.inf
    if not math.isfinite(number):
        raise SceneError(path(owner, field), value, expected)
    return number


def number(owner: Any, field: str, expected: str = "a finite number") -> float:
    """Freeze the field into a finite float and return it."""
    value = finite(owner, field, getattr(owner, field), expected)
    msgspec.structs.force_setattr(owner, field, value)
    return value


def whole(owner: Any, field: str, expected: str) -> int:
    """Freeze the field into an int and return it."""
    value = getattr(owner, field)
    if not isinstance(value, int | np.integer) or isinstance(value, bool):
        raise SceneError(path(owner, field), value, expected)
    msgspec.structs.force_setattr(owner, field, int(value))
    return int(value)


def positive(owner: Any, *fields: str) -> None:
    """Freeze each field into a finite float; refuse what is not above zero."""
    for field in fields:
        if not number(owner, field, "a number > 0") > 0:
            raise SceneError(path(owner, field), getattr(owner, field), "a number > 0")


def instance(owner: Any, field: str, kind: Any, expected: str) -> None:
    """Refuse what is not of that kind; in JSON, msgspec does the same."""
    if not isinstance(getattr(owner, field), kind):
        raise SceneError(path(owner, field), getattr(owner, field), expected)


def numbers(
    owner: Any, field: str, low: float = -math.inf, high: float = math.inf, each: str = ""
) -> tuple[float, ...]:
    """Freeze the field into a tuple of finite numbers in [low, high] and return it; ``each`` says what they are."""
    values = getattr(owner, field)
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise SceneError(path(owner, field), values, f"a list of numbers{each}")
    expected = between(low, high)
    frozen = []
    for i, value in enumerate(values):
        number = finite(owner, f"{field}[{i}]", value, expected)
        if not low <= number <= high:
            raise SceneError(path(owner, f"{field}[{i}]"), value, expected)
        frozen.append(number)
    msgspec.structs.force_setattr(owner, field, tuple(frozen))
    return tuple(frozen)


def per_channel(owner: Any, field: str, low: float = 0.0, high: float = math.inf) -> tuple[float, ...]:
    """Freeze the field into at least one finite number in [low, high] and return it."""
    values = numbers(owner, field, low, high, ", one per channel")
    if not values:
        raise SceneError(path(owner, field), values, "one number per channel")
    return values


def between(low: float, high: float) -> str:
    """What a message expects of a number in [low, high]."""
    if math.isfinite(high):
        return f"a number in [{low:g}, {high:g}]"
    return f"a finite number ≥ {low:g}" if math.isfinite(low) else "a finite number"


def vector(owner: Any, field: str) -> Vector:
    """Freeze the field into a tuple of three finite numbers and return it."""
    values = numbers(owner, field, each=" x, y, z")
    if len(values) != 3:
        raise SceneError(path(owner, field), values, "three numbers x, y, z")
    return values


def unit_vector(owner: Any, field: str) -> Vector:
    """Freeze the field into a unit vector and return it; any length but zero may be given."""
    x, y, z = vector(owner, field)
    length = math.hypot(x, y, z)
    if not 0 < length < math.inf:
        raise SceneError(path(owner, field), (x, y, z), "a direction, not the zero vector")
    if abs(length - 1) < 1e-15:  # dividing once more would change its last digits: not what JSON has kept
        return x, y, z
    unit = (x / length, y / length, z / length)
    msgspec.structs.force_setattr(owner, field, unit)
    return unit


def sine(u: NDArray[np.float64], v: NDArray[np.float64]) -> float:
    """Of the angle between two vectors; 0 where one of them has no direction."""
    with np.errstate(over="ignore", invalid="ignore"):  # lengths beyond all floats: no direction either
        lengths = math.hypot(*u), math.hypot(*v)
        if not 0 < min(lengths) <= max(lengths) < math.inf:
            return 0.0
        return math.hypot(*np.cross(u / lengths[0], v / lengths[1]))
