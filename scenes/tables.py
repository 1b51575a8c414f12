"""Long lists of numbers, checked at the speed of NumPy: vertices, triangles, pixels, coefficients."""

from __future__ import annotations

import math
from itertools import chain
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from scenes.validation import SceneError, between, finite, path

Shape = tuple[int | None, ...]


def table(
    owner: Any, field: str, shape: Shape, low: float = -math.inf, high: float = math.inf, whole: bool = False
) -> NDArray[Any]:
    """Freeze the field into nested tuples of finite numbers and return them as an array.

    Args:
        owner, field: what holds them, as lists, tuples or an array.
        shape: length along each axis; None for any but 0, the same throughout.
        low, high: limits of every number.
        whole: whole numbers only.

    Raises:
        SceneError: naming the first number or list that is wrong, ``Mesh.vertices[7][2]``.
    """
    value = getattr(owner, field)
    kind = np.dtype(np.int64 if whole else np.float64)
    found = _as_array(value, len(shape), "iu" if whole else "iuf")
    if found is None or not _fits(found, shape, low, high):
        _Search(owner, list(shape), low, high, whole).below(field, value)
        found = np.array(value)  # nothing was wrong: numbers of a rarer type, such as fractions
    array = found.astype(kind)
    msgspec.structs.force_setattr(owner, field, _tuples(array.tolist()))
    return array


def _as_array(value: Any, axes: int, kinds: str) -> NDArray[Any] | None:
    """What is plainly an array of numbers; None for anything that has to be looked at one by one."""
    try:
        found = np.asarray(value)
        if not isinstance(value, np.ndarray):  # among other numbers, NumPy takes True for 1
            for _ in range(axes - 1):
                value = chain.from_iterable(value)
            if not {bool, np.bool_}.isdisjoint(map(type, value)):
                return None
    except (TypeError, ValueError, OverflowError):  # lists of different lengths, no lists at all
        return None
    return found if found.ndim == axes and found.dtype.kind in kinds else None


def _fits(found: NDArray[Any], shape: Shape, low: float, high: float) -> bool:
    lengths = all(n > 0 and expected in (None, n) for n, expected in zip(found.shape, shape, strict=True))
    return lengths and bool((np.isfinite(found) & (found >= low) & (found <= high)).all())


class _Search:
    """Goes through the numbers one by one until one is wrong; slow, and run only to say which."""

    def __init__(self, owner: Any, shape: list[int | None], low: float, high: float, whole: bool) -> None:
        self._owner, self._shape, self._limits, self._whole = owner, shape, (low, high), whole

    def below(self, place: str, value: Any, level: int = 0) -> None:
        if level == len(self._shape):
            return self._number(place, value)
        if not isinstance(value, list | tuple | np.ndarray) or (
            isinstance(value, np.ndarray) and not value.ndim
        ):
            raise SceneError(path(self._owner, place), value, f"a list of {self._shape[level] or 'numbers'}")
        if not len(value) or len(value) != (self._shape[level] or len(value)):
            expected = f"a list of {self._shape[level] or 'at least one'}"
            raise SceneError(path(self._owner, place), value, expected)
        self._shape[level] = len(value)  # the others must be as long as the first
        for i, item in enumerate(value):
            self.below(f"{place}[{i}]", item, level + 1)
        return None

    def _number(self, place: str, value: Any) -> None:
        expected = between(*self._limits)
        if self._whole:
            expected = expected.replace("a number", "a whole number")
        number = finite(self._owner, place, value, expected)
        if not self._limits[0] <= number <= self._limits[1] or (self._whole and not _is_whole(value)):
            raise SceneError(path(self._owner, place), value, expected)


def _is_whole(value: object) -> bool:
    return isinstance(value, int | np.integer)


def _tuples(value: list[Any]) -> tuple[Any, ...]:
    return tuple(map(_tuples, value)) if isinstance(value[0], list) else tuple(value)
