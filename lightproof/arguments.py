"""The arguments of an assertion, checked: what can't be is a ``ValueError`` or a ``TypeError``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

import typer

from comparisons import known
from comparisons.renderers import canonical
from comparisons.settings import Settings
from lightproof import cases, parameters
from lightproof.folder import prepare
from lightproof.host import Host
from scenes import Case

Shares = float | str | Sequence[float | str]
"""Relative, for all bounces or one for each."""

N = TypeVar("N", int, float)

BUDGET = (0.001, 1e6)
"""Seconds."""


def check_renderer(renderer: Any) -> None:
    """Refuse what is neither the name of a renderer nor an object that could be one.

    Raises:
        UnknownNameError: there is no such name.
        TypeError: no name, and no object with the methods of ``Renderer``.
    """
    if isinstance(renderer, str):
        canonical(renderer)
        return
    if isinstance(renderer, type):
        raise TypeError(
            f"renderer: expected an object, found the class {renderer.__name__}: {renderer.__name__}()?"
        )
    missing = [name for name in ("version", "render") if not callable(getattr(renderer, name, None))]
    if missing:
        raise TypeError(
            f"renderer: expected a name, or an object with version() and render(scene, bounces, spp, seed); found "
            f"a {type(renderer).__name__} without {' and '.join(missing)}"
        )


def found(case: Any) -> Case:
    """The case.

    Raises:
        UnknownNameError, CaseError: there is none, or it can't be made.
        TypeError: something else was given.
    """
    if isinstance(case, str):
        return cases.find(case)
    if not isinstance(case, Case):
        call = ": call it" if callable(case) else ""
        raise TypeError(
            f"case: expected a name, FILE.py:NAME or a scenes.Case, found a {type(case).__name__}{call}"
        )
    cases.checked_name(case.name, "case")
    return case


def skips(unsupported: str) -> bool:
    """Whether a scene that the renderer can't express skips the test.

    Raises:
        ValueError: neither ``skip`` nor ``fail``.
    """
    if unsupported not in ("skip", "fail"):
        raise ValueError(f"unsupported: expected 'skip' or 'fail', found {unsupported!r}")
    return unsupported == "skip"


def settings(
    host: Host,
    tolerance: Shares | None,
    tile_tolerance: Shares | None,
    bounces: int | None,
    size: tuple[int, int] | str | None,
    budget: float | None,
    alpha: float,
    seed: int,
) -> Settings:
    """How to compare.

    Raises:
        ValueError: an argument can't be that.
    """
    return Settings(
        bounces=None if bounces is None else within(bounces, (0, 1_000_000), "bounces"),
        tolerance=_shares(tolerance, "tolerance"),
        tile_tolerance=_shares(tile_tolerance, "tile_tolerance"),
        size=_size(size),
        alpha=within(alpha, (1e-12, 0.5), "alpha"),
        budget=within(host.budget if budget is None else budget, BUDGET, "budget"),
        seed=within(seed, (0, 2**32 - 1), "seed"),
        jobs=host.jobs,
        known=tuple(known.load(known.SHIPPED)),
    )


def check_answer(case: Case, settings: Settings) -> None:
    """Refuse what the answer of the case does not hold for.

    Raises:
        ValueError: naming what it holds for.
    """
    last = case.bounces if settings.bounces is None else settings.bounces
    try:
        parameters.check_bounces(case, settings.bounces)
    except typer.BadParameter as error:
        raise ValueError(f"bounces: {error.message}") from None
    cases.check_answer(case, last, settings.size)


def prepared(folder: Path) -> Path:
    """The folder, made and cleared of what an earlier comparison left.

    Raises:
        ValueError: it can't be written.
    """
    try:
        prepare(folder)
    except typer.BadParameter as error:
        raise ValueError(f"report: {error.message}") from None
    return folder


def within(value: N, limits: tuple[float, float], name: str) -> N:
    """The value.

    Raises:
        ValueError: it lies outside the limits.
    """
    low, high = limits
    if not low <= value <= high:
        raise ValueError(f"{name}: expected a number from {low:g} to {high:g}, found {value}")
    return value


def _shares(value: Shares | None, name: str) -> tuple[float, ...] | None:
    """``0.005``, ``"0.5%"``, or one for each bounce: ``(0.002, 0.005)``, ``"0.2%,0.5%"``."""
    text = ",".join(map(str, value)) if isinstance(value, Sequence) and not isinstance(value, str) else value
    try:
        return parameters.percents(None if text is None else str(text), name)
    except typer.BadParameter as error:
        raise ValueError(f"{name}: {error.message}") from None


def _size(value: tuple[int, int] | str | None) -> tuple[int, int] | None:
    """``(64, 48)`` or ``"64x48"``."""
    text = value if value is None or isinstance(value, str) else "x".join(map(str, value))
    try:
        return parameters.size(text)
    except typer.BadParameter as error:
        raise ValueError(f"size: {error.message}") from None
