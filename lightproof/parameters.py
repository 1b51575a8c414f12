"""Values as people write them on the command line: percentages, sizes, bounces."""

from __future__ import annotations

import re

import typer

from scenes import Case

_LARGE = 0.1
"""Whoever writes such a number without % means percent: taken as a share, it would let everything pass."""


def percents(text: str | None, option: str) -> tuple[float, ...] | None:
    """``0.5%`` or ``0.005``: (0.005,), for every bounce; ``0.2%,0.5%``: of bounce 0, and of all later ones.

    Raises:
        typer.BadParameter: no numbers, or one that is not above 0 and below 100 %; or a share from 10 % on without
            its sign.
    """
    return None if text is None else tuple(_percent(part.strip(), option) for part in text.split(","))


def _percent(text: str, option: str) -> float:
    try:
        value = float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        value = float("nan")
    if not 0 < value < float("inf"):
        raise typer.BadParameter(
            f"{text!r}: expected a share above 0, such as 0.5% or 0.005, or one for each bounce, as 0.2%,0.5%",
            param_hint=option,
        )
    if value >= _LARGE and not text.endswith("%"):
        raise typer.BadParameter(
            f"{text!r} is a share, {100 * value:g} %: expected the sign, {text}% or {100 * value:g}%",
            param_hint=option,
        )
    if value >= 1:
        raise typer.BadParameter(
            f"{text!r}: expected less than 100%; a black image would pass", param_hint=option
        )
    return value


def size(text: str | None) -> tuple[int, int] | None:
    """``64x48``: width and height in pixels.

    Raises:
        typer.BadParameter: not of that form, or zero.
    """
    if text is None:
        return None
    match = re.fullmatch(r"([1-9]\d*)[x×]([1-9]\d*)", text)
    if match is None:
        raise typer.BadParameter(
            f"{text!r}: expected WIDTHxHEIGHT in pixels, such as 64x48", param_hint="--size"
        )
    return int(match[1]), int(match[2])


def check_bounces(case: Case, bounces: int | None) -> None:
    """Refuse more bounces than the answer of the case holds for.

    Raises:
        typer.BadParameter: naming how many it has.
    """
    if bounces is not None and case.max_bounces is not None and bounces > case.max_bounces:
        message = f"{bounces}: the answer of {case.name} holds for bounces 0 to {case.max_bounces}"
        raise typer.BadParameter(message, param_hint="--bounces")
