"""Looking things up by name, with a hand for those who mistype."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from typing import TypeVar

T = TypeVar("T")


class UnknownNameError(LookupError):
    """A name that nothing has; its message names the nearest ones, or says what else is wrong."""

    def __init__(self, kind: str, name: str, known: Iterable[str], why: str = "") -> None:
        known = tuple(known)
        nearest = difflib.get_close_matches(name, known, n=3, cutoff=0.5)
        hint = f"did you mean {' or '.join(nearest)}?" if nearest else f"there are {', '.join(sorted(known))}"
        super().__init__(kind, name, known, why)  # all of them, so that it survives the way out of a process
        self._message = f"no {kind} is called {name!r}: {why or hint}"

    def __str__(self) -> str:
        return self._message


def look_up(kind: str, name: str, known: Mapping[str, T]) -> T:
    """The entry of that name.

    Raises:
        UnknownNameError: there is none.
    """
    if name not in known:
        raise UnknownNameError(kind, name, known)
    return known[name]
