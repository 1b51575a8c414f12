"""Checks on what callers pass: each failure names the argument, what was found and what was expected."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from scenes import Scene


def check_scene(scene: object) -> None:
    """Refuse what is no scene.

    Raises:
        TypeError: it is something else, such as a case.
    """
    if not isinstance(scene, Scene):
        hint = ": take its .scene" if isinstance(getattr(scene, "scene", None), Scene) else ""
        raise TypeError(f"scene is a {type(scene).__name__}, expected a Scene{hint}")


def check_whole(low: int, **arguments: object) -> None:
    """Refuse what is no whole number or lies below ``low``.

    Raises:
        ValueError: naming the argument.
    """
    for name, value in arguments.items():
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < low:
            raise ValueError(f"{name} = {value!r}: expected a whole number, at least {low}")


def check_choice(known: Iterable[str], **arguments: object) -> None:
    """Refuse a name that is not one of those known.

    Raises:
        ValueError: naming the argument.
    """
    known = tuple(known)
    for name, value in arguments.items():
        if value not in known:
            raise ValueError(f"{name} = {value!r}: expected one of {', '.join(known)}")
