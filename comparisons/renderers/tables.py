"""The tables ``[renderers.NAME]`` of a configuration: their keys, checked one by one.

Which of the keys ``command``, ``worker``, ``object`` and ``mitsuba`` a table has says what kind of renderer it is.
What can't be is an error that names the file, the key, what stands there and what may.
"""

from __future__ import annotations

import re
import shutil
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import msgspec
from msgspec import NODEFAULT, inspect

from comparisons.renderers import placeholders
from comparisons.renderers.entry import Entry
from comparisons.renderers.keys import Command, PythonObject, Shared, WorkerFile
from comparisons.renderers.mitsuba_plugin import MitsubaPlugin, PluginError
from comparisons.renderers.mitsuba_plugin import entry as plugin_entry
from comparisons.renderers.placeholders import PlaceholderError
from scenes.names import UnknownNameError

T = TypeVar("T", bound=msgspec.Struct)

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
_SIZE = re.compile(r"(\d+(?:\.\d+)?) ?([kMGT]B)")
_UNITS = {"kB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12}


class ConfigError(ValueError):
    """A configuration that can't be."""


class Place(NamedTuple):
    """Where something stands: the file, and the keys on the way there."""

    file: Path
    keys: tuple[str, ...] = ()

    def __truediv__(self, key: str) -> Place:
        return Place(self.file, (*self.keys, key))

    def __str__(self) -> str:
        return f"{self.file}: {'.'.join(self.keys)}"

    def error(self, found: object, expected: str) -> ConfigError:
        """What stands there, and what was expected."""
        return ConfigError(f"{self} = {found!r}: expected {expected}")

    def refuse_unknown(self, table: Mapping[str, object], known: Iterable[str]) -> None:
        """Refuse keys that have no meaning.

        Raises:
            ConfigError: naming the nearest one that has.
        """
        for key in table:
            if key not in (known := tuple(known)):
                raise ConfigError(f"{self / key}: {UnknownNameError('key', key, known)}")


def renderer(table: object, place: Place) -> Entry:
    """What a table ``[renderers.NAME]`` says.

    Raises:
        ConfigError: it can't be.
    """
    if not isinstance(table, dict):
        raise place.error(table, f"a table with one of the keys {', '.join(_KINDS)}")
    kinds = [kind for kind in _KINDS if kind in table]
    if len(kinds) != 1:
        found = " and ".join(kinds) or ("no key" if not table else ", ".join(table))
        raise ConfigError(f"{place}: expected one of the keys {', '.join(_KINDS)}; found {found}")
    return _KINDS[kinds[0]](table, place)


def _command(table: dict[str, Any], place: Place) -> Entry:
    said = _read(Command, table, place)
    try:
        placeholders.check(said)
    except PlaceholderError as error:
        raise ConfigError(f"{place / error.key}: {error}") from None
    if said.coupled and (not said.seed or said.images != "cumulative"):
        expected = 'false: only a program with a seed, and images = "cumulative", couples its depths'
        raise (place / "coupled").error(said.coupled, expected)
    entry = Entry(
        f"{Path(said.command[0]).name}, a command",
        "command",
        "CommandRenderer",
        msgspec.json.encode(said).decode(),
        one_walk=said.images == "layers",
        differences=said.images == "cumulative" and not said.coupled,
        package="",
        seeded=said.seed,
        install=f"make or install {said.command[0]}",
    )
    return _with_shared(entry, said, place)


def _worker(table: dict[str, Any], place: Place) -> Entry:
    said = _read(WorkerFile, table, place)
    file = place.file.parent / said.worker
    if not file.is_file():
        raise (place / "worker").error(said.worker, f"a file: there is none at {file}")
    start = [find_uv() or "uv", "run", "--no-project", "--script"]
    if said.python:
        named = Path(said.python).expanduser()
        start = [str(place.file.parent / named) if len(named.parts) > 1 else said.python]
    entry = Entry(
        f"{file.name}, a worker file",
        "worker_file",
        "",
        msgspec.json.encode([start[0], said.version]).decode(),
        worker=(*start, str(file.resolve())),
        package="",
        install=f"install {said.python}" if said.python else "pip install uv",
        start_timeout=said.start_timeout,
    )
    return _with_shared(entry, said, place)


def _object(table: dict[str, Any], place: Place) -> Entry:
    said = _read(PythonObject, table, place)
    entry = Entry(
        f"{said.object}, a Python object",
        "python_object",
        "from_folder",
        said.object,
        package="",
        start_timeout=said.start_timeout,
    )
    return _with_shared(entry, said, place)


def _mitsuba(table: dict[str, Any], place: Place) -> Entry:
    shared = Shared.__struct_fields__
    place.refuse_unknown(table, (*shared, *MitsubaPlugin.__struct_fields__))
    said = _read(Shared, {key: value for key, value in table.items() if key in shared}, place)
    plugin = _read(MitsubaPlugin, {key: value for key, value in table.items() if key not in shared}, place)
    try:
        entry = plugin_entry(plugin)
    except PluginError as error:
        raise ConfigError(f"{place}: {error}") from None
    return _with_shared(entry, said, place)


_KINDS: dict[str, Callable[[dict[str, Any], Place], Entry]] = {
    "command": _command,
    "worker": _worker,
    "object": _object,
    "mitsuba": _mitsuba,
}


def _with_shared(entry: Entry, said: Shared, place: Place) -> Entry:
    return msgspec.structs.replace(
        entry,
        title=said.title or entry.title,
        deterministic=said.deterministic,
        memory=bytes_of(said.memory, place / "memory") if said.memory else None,
        install=said.install or entry.install,
        folder=str(place.file.parent.resolve()),
    )


def find_uv() -> str | None:
    """Where uv is: beside this Python, or anywhere on the path."""
    return shutil.which("uv", path=str(Path(sys.executable).parent)) or shutil.which("uv")


def bytes_of(text: object, place: Place) -> int:
    """How many bytes ``"4 GB"`` are.

    Raises:
        ConfigError: it is no size.
    """
    match = _SIZE.fullmatch(text) if isinstance(text, str) else None
    size = int(float(match[1]) * _UNITS[match[2]]) if match else 0
    if not size:
        raise place.error(text, 'a size such as "500 MB" or "4 GB"')
    return size


def checked_name(name: str, place: Place) -> str:
    """The name, fit for those of files, and for none that has parts.

    Raises:
        ConfigError: it has other characters.
    """
    if not _NAME.fullmatch(name):
        raise ConfigError(f"{place}: {name!r}: expected a name of letters, digits, '.', '_' and '-'")
    return name


def _read(kind: type[T], table: dict[str, Any], place: Place) -> T:
    """The table as that kind, each key by itself.

    Raises:
        ConfigError: a key is unknown or missing, or has a value that can't be.
    """
    fields = {field.name: field for field in msgspec.structs.fields(kind)}
    place.refuse_unknown(table, fields)
    for name, field in fields.items():
        if name not in table and field.default is NODEFAULT and field.default_factory is NODEFAULT:
            raise ConfigError(f"{place / name}: missing; expected {_expected(field.type)}")
    values = {}
    for name, value in table.items():
        try:
            values[name] = msgspec.convert(value, type=fields[name].type)
        except msgspec.ValidationError:
            raise (place / name).error(value, _expected(fields[name].type)) from None
    return kind(**values)


def _expected(kind: Any) -> str:
    """What may stand there, in words."""
    match inspect.type_info(kind):
        case inspect.LiteralType(values=values):
            return " or ".join(f'"{value}"' for value in values)
        case inspect.ListType(min_length=least):
            return "a list of texts" + (", at least one" if least else "")
        case inspect.DictType(value_type=inspect.StrType()):
            return "a table of texts"
        case inspect.DictType():
            return 'a table of tables, each by the type of what it stands in for: diffuse = { type = "mine" }'
        case inspect.FloatType():
            return "a number > 0, and no more than 1,000,000"
        case inspect.BoolType():
            return "true or false"
        case inspect.UnionType(types=types) if any(isinstance(one, inspect.DictType) for one in types):
            return 'a table with the type of a plugin: { type = "mine" }'
        case inspect.UnionType():
            return "a text or a list of texts, at least one"
        case inspect.StrType(pattern=pattern) if pattern:
            return "module:attribute" if ":" in pattern else 'an extension such as ".exr"'
    return "a text"
