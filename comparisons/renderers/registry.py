"""From the name of a renderer to what is known of it.

A name is looked for among those of this project, in the user's configuration (``config.py``), among the entry points
of installed packages (group ``lightproof.renderers``), and last it may be ``module:attribute``, an object of the
user's own. What comes first keeps the name.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from importlib.metadata import EntryPoint, PackageNotFoundError, entry_points, version
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import msgspec

from comparisons.renderers import config, opengl_platform
from comparisons.renderers.config import ConfigError
from comparisons.renderers.entry import Entry
from comparisons.renderers.mitsuba_names import entry_of, full_name, shown
from comparisons.renderers.protocol import Renderer
from comparisons.renderers.python_object import is_module
from scenes.names import UnknownNameError

GROUP = "lightproof.renderers"
"""Of the entry points by which installed packages bring renderers along."""

_ANNOUNCED = re.compile(r"[A-Za-z0-9][A-Za-z0-9._:-]*")
_OBJECT = re.compile(r"[^\W\d][\w.]*:[^\W\d][\w.]*")


def _reference(argument: str, title: str) -> Entry:
    return Entry(f"the reference tracer{title}", "reference", "ReferenceRenderer", argument, one_walk=True)


RENDERERS: Mapping[str, Entry] = MappingProxyType(
    {
        "reference:mis": _reference("mis", ": next event and chance, weighted"),
        "reference:mis:sobol": _reference("mis:sobol", ", on scrambled Sobol' points over the whole image"),
        "reference:nee": _reference("nee", ": next event alone"),
        "reference:bsdf": _reference("bsdf", ": emission found by chance"),
        **{name: entry for name in ("mitsuba:scalar_rgb",) if (entry := entry_of(name))},
        "pyrender": Entry(
            "OpenGL by pyrender: a witness for what is visible, how far away, and what it emits",
            "opengl",
            "PyrenderRenderer",
            package="pyrender",
            deterministic=True,
            last_bounce=0,
            install=opengl_platform.INSTALL,
        ),
    }
)

SHORT_NAMES: Mapping[str, str] = MappingProxyType(
    {"reference": "reference:mis", "mitsuba": "mitsuba:scalar_rgb"}
)


class Family(NamedTuple):
    """Names with parts, of which there are more than a table could hold.

    Attributes:
        entry_of: what is known of a name; None for one that is none of the family.
        full_name: of a name that leaves parts out; any other name stays as it is.
        shown: the names that are worth a line in a list.
    """

    entry_of: Callable[[str], Entry | None]
    full_name: Callable[[str], str]
    shown: Callable[[], Iterable[str]]


FAMILIES: tuple[Family, ...] = (Family(entry_of, full_name, lambda: [form.name for form in shown()]),)

STRATEGIES = ("reference:mis", "reference:nee", "reference:bsdf", "reference:mis:sobol")
"""Renderers that differ in how they sample, and in nothing else. Variants of Mitsuba run the same strategy."""


def canonical(name: str) -> str:
    """The full name behind a short one: ``mitsuba`` is ``mitsuba:scalar_rgb``.

    Raises:
        UnknownNameError: there is no such renderer.
        ConfigError: the user's configuration can't be read.
    """
    full = _full(name)
    _found(full)
    return full


def resolve(name: str) -> Entry:
    """What is known of a renderer, by its full name or a short one.

    Raises:
        UnknownNameError, ConfigError: as above.
    """
    entry = _found(_full(name))
    return entry if entry.memory else msgspec.structs.replace(entry, memory=config.current().memory)


def traits(name: str) -> Entry:
    """What is declared of a renderer; nothing out of the ordinary for one that nobody knows."""
    try:
        return _found(name)
    except UnknownNameError:
        return Entry("", "", "")


def strategies_of(name: str) -> tuple[str, ...]:
    """The other ways in which the renderer of that full name can estimate the same image."""
    return tuple(other for other in STRATEGIES if other != name) if name in STRATEGIES else ()


def create(name: str) -> Renderer:
    """Make the renderer of that name in this process, and in its working directory, importing its packages.

    Raises:
        UnknownNameError: there is no such renderer.
        ImportError: its packages are not installed.
    """
    return make(resolve(name))


def make(entry: Entry) -> Renderer:
    """The same of what is known of it already."""
    adapter: Callable[[str], Renderer] = getattr(_module(entry), entry.adapter)
    return adapter(entry.argument)


def listed() -> dict[str, Entry]:
    """All that have a name to be listed by; ``module:attribute`` has none until it is asked for."""
    families = {name: _found(name) for family in FAMILIES for name in family.shown()}
    points = {name: _of_point(point) for name, point in announced().items()}
    return {**RENDERERS, **families, **_own(), **points}


def announced() -> dict[str, EntryPoint]:
    """The renderers of installed packages, by name.

    A name that is ours, or the user's, is not theirs; nor is one that no file could have.
    """
    taken = {*RENDERERS, *SHORT_NAMES, *_own()}
    points = (point for point in entry_points(group=GROUP) if _ANNOUNCED.fullmatch(point.name))
    return {point.name: point for point in points if point.name not in taken}


def installed(entry: Entry) -> str | None:
    """Its version, or that of the package that brings it, without loading it; None if it is not there.

    An adapter may know more than the package does: whether a program is there, and what it says its version is.
    """
    ask = getattr(_module(entry), "installed", None)
    if ask is not None and entry.adapter != "from_package":
        known = (entry.argument, Path(entry.folder))[: len(inspect.signature(ask).parameters)]
        found: str | None = ask(*known)
        return found
    try:
        return version(entry.package)
    except PackageNotFoundError:
        return None


def supports(entry: Entry) -> dict[str, Sequence[str]]:
    """What it can express and do, as its adapter says it; empty where nobody can tell without loading it."""
    ask = getattr(_module(entry), "supports", None) if entry.module else None
    if ask is None:
        return {}
    said: dict[str, Sequence[str]] = ask(entry.argument) if inspect.signature(ask).parameters else ask()
    return said


def _full(name: str) -> str:
    full = SHORT_NAMES.get(name, name)
    for family in FAMILIES:
        full = family.full_name(full)
    return full


def _module(entry: Entry) -> Any:
    return import_module(f"comparisons.renderers.{entry.module}")


def _found(name: str) -> Entry:
    """What is known of a renderer by its full name.

    Raises:
        UnknownNameError, ConfigError: see ``canonical``.
    """
    if name in RENDERERS:
        return RENDERERS[name]
    for candidate in _candidates(name):
        if candidate is not None:
            return candidate
    module = name.partition(":")[0]
    if _is_file(module):
        file, own = Path(module), f"{Path(module).stem}:{name.partition(':')[2] or 'attribute'}"
        why = f"an object goes by its module, {own}, in the folder of {file.name}"
        raise UnknownNameError("renderer", name, (), why)
    if _OBJECT.fullmatch(name) and module not in {known.partition(":")[0] for known in RENDERERS}:
        raise UnknownNameError("renderer", name, (), f"there is no module {module} here, nor installed")
    raise UnknownNameError("renderer", name, [*SHORT_NAMES, *listed()])


def _candidates(name: str) -> Iterator[Entry | None]:
    for family in FAMILIES:
        yield family.entry_of(name)
    if name.partition(":")[0] in {known.partition(":")[0] for known in RENDERERS}:
        return  # a wrong name of ours is not a module of the user's
    yield _own().get(name)
    if point := announced().get(name):
        yield _of_point(point)
    module = name.partition(":")[0]
    if _OBJECT.fullmatch(name) and not _is_file(module) and is_module(module, Path.cwd()):
        yield Entry(
            "an object of one's own", "python_object", "from_folder", name, "", folder=str(Path.cwd())
        )


def _is_file(module: str) -> bool:
    return module.endswith(".py") and Path(module).is_file()


def _own() -> Mapping[str, Entry]:
    """The renderers of the user's configuration.

    Raises:
        ConfigError: it can't be read, or one of them has a name of ours.
    """
    found = config.current()
    for name in found.renderers:
        if name in SHORT_NAMES or name in RENDERERS:
            raise ConfigError(f"{found.file}: renderers.{name}: expected a name that is not one of ours")
    return found.renderers


def _of_point(point: EntryPoint) -> Entry:
    package = point.dist.name if point.dist else ""
    title = f"{point.value} of {package or 'an unknown package'}"
    return Entry(title, "python_object", "from_package", point.value, package)
