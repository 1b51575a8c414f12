"""Placeholders in the command of a program: which there are, which must be, and what they stand for.

{scene}     the file of the scene          {seed}              whole number in [0, 2³¹)
{output}    the image file to be made      {bounces}           n: bounces 0 … n are asked for
{spp}       samples per pixel              {bounces+1}         likewise; for who counts rays or vertices
{width}, {height}    pixels                {{ and }}           are braces
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from string import Formatter

from comparisons.renderers.keys import Command

NAMES = ("scene", "output", "spp", "seed", "bounces", "width", "height")

_MORE = re.compile(r"bounces\+\d+")

# these files say themselves up to which bounce they are to be rendered
_DEPTH_IN_FILE = ("mitsuba-xml", "pbrt-v4")


class PlaceholderError(ValueError):
    """Placeholders that can't be.

    Attributes:
        key: of the configuration, where they stand.
    """

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key


def check(keys: Command) -> None:
    """Refuse placeholders that are unknown, missing, or in contradiction to other keys.

    Raises:
        PlaceholderError: which one, and why.
    """
    for key, command in (("command", keys.command), ("total", keys.total)):
        if command and (not command[0] or _names(key, command[:1])):
            raise PlaceholderError(
                key, f"{command[0]!r} is no program: expected ./mine, or a name on the PATH"
            )
    in_env = {name for key, text in keys.env.items() for name in _names(f"env.{key}", [text])}
    _check_command(keys, "command", _names("command", keys.command) | in_env, keys.images != "total")
    if keys.total:
        _check_command(keys, "total", _names("total", keys.total) | in_env, False)


def _check_command(keys: Command, key: str, found: set[str], depth: bool) -> None:
    missing = list(_missing(keys, found, depth))
    if missing:
        name, why = missing[0]
        raise PlaceholderError(key, f"{{{name}}} is missing: {why}")
    if not keys.seed and "seed" in found:
        raise PlaceholderError(key, "{seed} is there, and seed = false says that the program takes none")
    if not depth and "bounces" in found:
        why = 'images = "total" says that the program has no control of depth; if it has, it is "cumulative"'
        if key == "total":
            why = "this is the command as its users run it, without limits of depth"
        raise PlaceholderError(key, f"{{bounces}} is there: {why}")


def _missing(keys: Command, found: set[str], depth: bool) -> Iterator[tuple[str, str]]:
    """What must be there and is not, and why it must."""
    if "scene" not in found:
        yield "scene", "without it the program would not know what to render"
    if "output" not in found:
        yield "output", "without it its image would not be found"
    if depth and "bounces" not in found and keys.scene not in _DEPTH_IN_FILE:
        why = (
            f'images = "{keys.images}" asks for bounces 0 … n, and a {keys.scene} scene does not say how many'
        )
        yield "bounces", f'{why}; a program without control of depth has images = "total"'
    if keys.deterministic:
        return
    if "spp" not in found:
        yield "spp", "sampling goes on until verdicts are clear; what has no noise says deterministic = true"
    if "seed" not in found and keys.seed:
        why = "replicates are told apart by their seeds; it may stand in env as well"
        yield "seed", f"{why}, and a program that takes none says seed = false"


def _names(key: str, texts: Sequence[str]) -> set[str]:
    """The placeholders in these texts, those of depth by their first name.

    Raises:
        PlaceholderError: one is unknown.
    """
    return {field.partition("+")[0] for text in texts for field in _fields(key, text)}


def _fields(key: str, text: str) -> Iterator[str]:
    try:
        parts = list(Formatter().parse(text))
    except ValueError as error:
        raise PlaceholderError(key, f"{text!r}: {error}; a brace by itself is written {{{{ or }}}}") from None
    for _, field, spec, conversion in parts:
        if field is None:
            continue
        if spec or conversion or not (field in NAMES or _MORE.fullmatch(field)):
            shown = field + (f"!{conversion}" if conversion else "") + (f":{spec}" if spec else "")
            known = ", ".join(f"{{{name}}}" for name in NAMES)
            raise PlaceholderError(key, f"{{{shown}}} in {text!r} is no placeholder: there are {known}")
        yield field


def filled(text: str, values: Mapping[str, object]) -> str:
    """The text with its placeholders filled.

    Args:
        text: checked already.
        values: by name.
    """
    return "".join(
        before + ("" if field is None else _value(field, values))
        for before, field, _, _ in Formatter().parse(text)
    )


def _value(field: str, values: Mapping[str, object]) -> str:
    name, _, more = field.partition("+")
    value = values[name]
    return str(int(str(value)) + int(more)) if more else str(value)
