"""From what the command line names to cases and scenes; what can't be is wrong usage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TypeVar

import typer

from comparisons import relations
from lightproof import cases
from lightproof.parameters import check_bounces
from scenes import Case, Scene, UnknownNameError, library
from scenes.names import look_up

T = TypeVar("T")

DEFAULT_BOUNCES = 5
"""Of a scene that is no case."""


@dataclass(frozen=True)
class Subject:
    """What is rendered or exported.

    Attributes:
        name: what files are called after.
        scene, bounces: the bounces where none are asked for.
        wavelengths: of the channels, nm; None where they are R, G, B, or just numbers.
    """

    name: str
    scene: Scene
    bounces: int
    wavelengths: tuple[float, ...] | None = None


def subject(named: str | None, own: str | None, bounces: int | None = None) -> Subject:
    """The scene of a case, or the one in a JSON file.

    Raises:
        typer.BadParameter: none, more than one, or nothing of that name; or more bounces than it has an answer for.
    """
    if named and named.endswith(".json") and not own:
        path = Path(named)
        return Subject(path.stem, _tried(lambda: cases.load_scene(path), "CASE"), DEFAULT_BOUNCES)
    case = one_case(named, own, bounces, or_else=" or a scene, my-scene.json,")
    return Subject(case.name, case.scene, case.bounces, case.wavelengths)


def one_case(
    named: str | None, own: str | None, bounces: int | None = None, or_else: str = "", hint: str = "CASE"
) -> Case:
    """The case of that name, or of ``--case``.

    Raises:
        typer.BadParameter: as above.
    """
    if (named is None) == (own is None):
        found = "none of them" if named is None else "both"
        raise typer.BadParameter(f"expected a CASE{or_else} or --case, found {found}", param_hint=hint)
    case = _own(own) if own is not None else _named(named or "", hint)
    check_bounces(case, bounces)
    return case


def several_cases(
    named: Sequence[str],
    own: Sequence[str],
    families: Sequence[str],
    everything: bool,
    files: tuple[Path | None, Path | None],
    bounces: int | None,
    size: tuple[int, int] | None,
    default: Sequence[str] = library.DEFAULT,
) -> list[Case]:
    """All that is asked for, each case once; the default where nothing is.

    Raises:
        typer.BadParameter: as above, or two cases of the same name.
    """
    found = [_named(name) for name in dict.fromkeys(named)]
    found += [_own(place) for place in dict.fromkeys(own)]
    if everything or families:
        known = [_named(name) for name in (*library.CASES, *cases.announced())]
        by_family = {case.family: case for case in known}
        for family in families:
            _tried(partial(look_up, "family", family, by_family), "--family")
        taken = {case.name for case in found}
        found += [c for c in known if (everything or c.family in families) and c.name not in taken]
    if any(files):
        scene, answer = files
        if scene is None or answer is None:
            raise typer.BadParameter("--scene and --answer belong together: give both", param_hint="--scene")
        found.append(_tried(lambda: cases.from_answer(scene, answer), "--scene, --answer"))
    found = found or [_named(name) for name in default]
    names = [case.name for case in found]
    for case in found:
        if names.count(case.name) > 1:
            message = f"two cases are called {case.name}: give one of them another name"
            raise typer.BadParameter(message, param_hint="--case")
        check_bounces(case, bounces)
        check_size(case, bounces, size)
    return found


def relation_tasks(names: Sequence[str], chosen: Sequence[Case], scene: Path | None) -> list[relations.Task]:
    """Relations and the scenes that they are tried on: those of cases, or one of the user's, or their own.

    Raises:
        typer.BadParameter: there is no relation of that name, or the scene can't be read.
    """
    wanted = [
        _tried(partial(look_up, "relation", name, relations.RELATIONS), "--relation")
        for name in dict.fromkeys(names or relations.RELATIONS)
    ]
    subjects = [relations.Subject(case.name, case.scene, wavelengths=case.wavelengths) for case in chosen]
    if scene is not None:
        own = _tried(lambda: cases.load_scene(scene), "--scene")
        subjects.append(relations.Subject(scene.stem, own))
    return relations.all_tasks(wanted, subjects)


def check_size(case: Case, bounces: int | None, size: tuple[int, int] | None) -> None:
    """Refuse what an answer image does not hold for.

    Raises:
        typer.BadParameter: naming what it holds for.
    """
    last = case.bounces if bounces is None else bounces
    _tried(lambda: cases.check_answer(case, last, size), "--size")


def _named(name: str, hint: str = "CASE") -> Case:
    if name.endswith(".json"):
        message = (
            f"{name} is a scene, which has no answer by itself: 'lightproof validate' takes it as --scene, with an "
            "--answer, which 'lightproof answer' estimates; 'lightproof render' renders it"
        )
        raise typer.BadParameter(message, param_hint=hint)
    return _tried(lambda: cases.find(name), hint)


def _own(place: str) -> Case:
    return _tried(lambda: cases.from_file(place), "--case")


def _tried(make: Callable[[], T], hint: str) -> T:
    try:
        return make()
    except (cases.CaseError, UnknownNameError) as error:
        raise typer.BadParameter(str(error), param_hint=hint) from None
