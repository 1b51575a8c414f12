"""A user's own plugin: it stands in for one of Mitsuba's, and everything else stays as it is.

    [renderers.mine]
    mitsuba = "scalar_rgb"                      # the form of Mitsuba: variant[:integrator[:sampler]]
    imports = ["my_plugins.py"]                 # run first; they call mitsuba.register_bsdf and the like
    integrator = { type = "mine", max_depth = "{max_depth}" }
    bsdf.diffuse = { type = "mydiffuse", reflectance = "{reflectance}" }

What stands in for a plugin is a table of Mitsuba's properties. A text ``"{name}"`` is the property of that name of
the plugin that it stands in for; other values are passed on as they are, and tables in it are plugins of their own. A
shape keeps its bsdf and its emitter. Kinds: ``bsdf``, ``emitter`` and ``shape``, by the types that the adapter uses,
see ``KINDS``; ``integrator`` and ``sampler``, of which there is one. An integrator has these to choose from:

    {max_depth}    as Mitsuba counts it, d: bounces 0 … d − 1; −1 for no limit
    {bounces}      the last bounce, d − 1; −1 for no limit
    {rr_depth}     from which on Russian roulette is allowed: 5 as Mitsuba does, or so many that there is none

One that takes neither depth is asked for the sum of all bounces alone. A property that a scene needs and the table
does not pass on makes the scene unsupported: a sphere seen from inside, say, where ``flip_normals`` is missing. One
that a plugin of the scene has not is left out there: ``flip_normals``, of a sphere seen from outside.
"""

from __future__ import annotations

import re
import runpy
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from comparisons.renderers import mitsuba
from comparisons.renderers.entry import Entry
from comparisons.renderers.mitsuba import MitsubaRenderer
from comparisons.renderers.mitsuba_names import FAMILY, LAST_BOUNCE, FormError, parse
from comparisons.renderers.protocol import RendererFailed, Unsupported
from scenes.names import UnknownNameError

Dict = dict[str, Any]
Properties = dict[str, Any]

_GGX = ("distribution", "alpha", "sample_visible")

KINDS: Mapping[str, Mapping[str, Sequence[str]]] = {
    "bsdf": {
        "blendbsdf": ("weight", "first", "second"),
        "conductor": ("material", "specular_reflectance", "eta", "k"),
        "dielectric": ("int_ior", "ext_ior"),
        "diffuse": ("reflectance",),
        "roughconductor": ("eta", "k", *_GGX),
        "roughdielectric": ("int_ior", "ext_ior", *_GGX),
        "twosided": (),
    },
    "emitter": {
        "area": ("radiance",),
        "constant": ("radiance",),
        "directional": ("direction", "irradiance"),
        "envmap": ("bitmap", "to_world"),
        "point": ("position", "intensity"),
        "spot": ("to_world", "intensity", "cutoff_angle", "beam_width"),
    },
    "shape": {
        "disk": ("to_world",),
        "ply": ("filename", "face_normals"),
        "rectangle": ("to_world",),
        "sphere": ("to_world", "flip_normals"),
    },
}
"""The plugins that the adapter makes scenes of, and all properties that it gives them in one scene or another."""

DEPTHS = ("max_depth", "bounces", "rr_depth")
"""What an integrator may be told."""

_PLACEHOLDER = re.compile(r"\{(\w+)\}")


class PluginError(ValueError):
    """A table that can't be, with the key that is wrong."""


class MitsubaPlugin(msgspec.Struct, kw_only=True, forbid_unknown_fields=True):
    """The keys of the table.

    Attributes:
        mitsuba: the form of Mitsuba, as in its name: ``llvm_ad_rgb``, ``scalar_rgb:volpath``.
        imports: Python files, run before anything is loaded; relative paths begin at the folder of the process.
        integrator, sampler: what stands in for it; left out, Mitsuba's own.
        bsdf, emitter, shape: by the type of Mitsuba's own plugin, what stands in for it.
    """

    mitsuba: str
    imports: list[str] = []
    integrator: Properties | None = None
    sampler: Properties | None = None
    bsdf: dict[str, Properties] = {}
    emitter: dict[str, Properties] = {}
    shape: dict[str, Properties] = {}

    def check(self) -> None:
        """Refuse what can be seen to be wrong without Mitsuba.

        Raises:
            PluginError: a form, a plugin or a placeholder that there is not; with the key.
        """
        try:
            parse(f"{FAMILY}:{self.mitsuba}")
        except FormError as error:
            raise PluginError(f"mitsuba: {error}") from None
        for kind, known in KINDS.items():
            for own, table in getattr(self, kind).items():
                if own not in known:
                    raise PluginError(
                        f"{kind}: {UnknownNameError(f'{kind} plugin of the adapter', own, known)}"
                    )
                _check_type(f"{kind}.{own}", table)
                _check_placeholders(f"{kind}.{own}", table, known[own])
        for kind in ("integrator", "sampler"):
            if (table := getattr(self, kind)) is not None:
                _check_type(kind, table)
                _check_placeholders(kind, table, DEPTHS if kind == "integrator" else ())


def entry(plugin: MitsubaPlugin) -> Entry:
    """What is known of it before it is loaded.

    Raises:
        PluginError: see ``MitsubaPlugin.check``.
    """
    plugin.check()
    form = parse(f"{FAMILY}:{plugin.mitsuba}")
    single = [
        f"{kind} {table['type']}" for kind in ("integrator", "sampler") if (table := getattr(plugin, kind))
    ]
    several = [f"{kind} {table['type']}" for kind in KINDS for table in getattr(plugin, kind).values()]
    return Entry(
        f"{form.name} with {', '.join([*single, *several]) or 'nothing of its own'}",
        "mitsuba_plugin",
        "MitsubaPluginRenderer",
        msgspec.json.encode(plugin).decode(),
        FAMILY,
        last_bounce=None if plugin.integrator else LAST_BOUNCE.get(form.integrator),
        spp_unit=form.spp_unit,
        differences=not form.coupled,
    )


def installed(table: str) -> str | None:
    """Of Mitsuba in that form; see ``mitsuba.installed``."""
    return mitsuba.installed(msgspec.json.decode(table, type=MitsubaPlugin).mitsuba)


def supports(table: str) -> dict[str, Sequence[str]]:
    """What Mitsuba supports in that form; what the plugins don't take is known when a scene is loaded."""
    return mitsuba.supports(msgspec.json.decode(table, type=MitsubaPlugin).mitsuba)


class MitsubaPluginRenderer(MitsubaRenderer):
    """Mitsuba with a user's plugins in it."""

    def __init__(self, table: str) -> None:
        """Of the table as JSON; see ``MitsubaPlugin``."""
        plugin = msgspec.json.decode(table, type=MitsubaPlugin)
        plugin.check()
        super().__init__(plugin.mitsuba, PluginStandIns(plugin))


class PluginStandIns:
    """See ``mitsuba.StandIns``."""

    def __init__(self, plugin: MitsubaPlugin) -> None:
        self._plugin = plugin

    def register(self) -> None:
        """Run the files that register plugins.

        Raises:
            RendererFailed: there is no such file. What goes wrong inside is raised as it is.
        """
        for name in self._plugin.imports:
            file = Path(name).resolve()
            if not file.is_file():
                raise RendererFailed(f"imports: there is no file {file}")
            runpy.run_path(str(file))

    def integrator(self, own: Dict) -> Dict:
        """The user's, told the depth.

        Raises:
            Unsupported: it takes no depth, and one is asked for.
        """
        table = self._plugin.integrator
        if table is None:
            return own
        depth = own.get("max_depth", -1)
        names = _placeholders(table)
        if depth != -1 and not {"max_depth", "bounces"} & set(names):
            raise Unsupported(
                "per-bounce images: its integrator is told no depth; expected a property "
                '"{max_depth}" or "{bounces}"'
            )
        known = {
            "max_depth": depth,
            "bounces": depth if depth == -1 else depth - 1,
            "rr_depth": own.get("rr_depth", 5),
        }
        return _filled(table, known)

    def sampler(self, own: Dict) -> Dict:
        """The user's, or Mitsuba's own."""
        return own if self._plugin.sampler is None else dict(self._plugin.sampler)

    def scene(self, own: Dict) -> Dict:
        """The scene with every plugin replaced for which there is another."""
        made = {key: self.scene(value) if isinstance(value, dict) else value for key, value in own.items()}
        for kind, known in KINDS.items():
            table = getattr(self._plugin, kind).get(own.get("type"))
            if own.get("type") in known and table is not None:
                return _stand_in(f"{kind}.{own['type']}", table, made)
        return made


def _stand_in(key: str, table: Properties, own: Dict) -> Dict:
    """What stands in for a plugin of the scene.

    Raises:
        Unsupported: it passes on too little.
    """
    children = {name: part for name, part in own.items() if name in ("bsdf", "emitter")}
    properties = {name: value for name, value in own.items() if name not in {"type", *children}}
    if lost := [name for name in properties if name not in {*_placeholders(table), *table}]:
        raise Unsupported(f"{lost[0]} of {own['type']}: {key} does not pass it on; expected {{{lost[0]}}}")
    return {**children, **_filled(table, properties)}


def _check_type(key: str, table: Properties) -> None:
    if not isinstance(table.get("type"), str):
        raise PluginError(f'{key}: expected a table with the type of a plugin: {{ type = "mine", … }}')


def _check_placeholders(key: str, table: Properties, known: Sequence[str]) -> None:
    """Refuse what the adapter has in no scene."""
    if unknown := [name for name in _placeholders(table) if name not in known]:
        raise PluginError(f"{key}: {{{unknown[0]}}}: there are {', '.join(known) or 'none'}")


def _placeholders(table: Properties) -> list[str]:
    nested = [name for value in table.values() if isinstance(value, dict) for name in _placeholders(value)]
    matches = [_PLACEHOLDER.fullmatch(value) for value in table.values() if isinstance(value, str)]
    return [match[1] for match in matches if match] + nested


def _filled(table: Properties, values: Mapping[str, Any]) -> Dict:
    """What there is no value for is left out, as the adapter leaves it to Mitsuba's default."""
    made: Dict = {}
    for name, value in table.items():
        if isinstance(value, dict):
            made[name] = _filled(value, values)
        elif isinstance(value, str) and (match := _PLACEHOLDER.fullmatch(value)):
            if match[1] in values:
                made[name] = values[match[1]]
        else:
            made[name] = value
    return made
