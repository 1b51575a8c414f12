"""Deviations that are known: proved real, measured, and declared in a file, so that only what is new is red.

    [[deviation]]
    case = "furnace-sphere"
    renderer = "mitsuba:scalar_rgb"   # or a list; * stands for anything in a name that is spelled out, all forms of
                                      # Mitsuba with the integrator path are "mitsuba:*:path:*"
    versions = "==3.9.*"
    bounces = [1, 2]
    bias = [0.013, [0.015, 0.014]]    # relative, one per bounce, or for each of its channels one
    onwards = true                    # the last one holds for all later bounces too; left out: it does not
    channels = ["R", "G"]             # which deviate; left out: all of them
    within = 0.002                    # it is known as long as the whole image is this close to that
    tile_within = 0.01                # and every tile this close
    reason = "…"
    link = "https://…"
    relation = "scaling"              # of this relation, tried on the scene of the case; left out: of the comparison

A bounce whose deviation is measured to be the declared one has the verdict ``known``: the intervals of the declared
channels lie inside declared ± within, those of the others inside ± tolerance. Clearly anything else fails, a smaller
deviation as well as a larger one. One that has vanished passes, and the report asks for the entry to go.

Of the whole sum, too, what the declared bounces explain is known, and nothing else: Σ (bias × mean of TᵏE) relative
to the sum, within Σ (within × mean of TᵏE) and the tolerance of all other bounces (``declared_of_sum``). What goes
wrong in the sum alone, as the renderer's users make it, has an entry of its own, which then counts:

    total = 0.013                     # relative to the sum, or for each channel one; in place of bounces and bias

Of a relation, the bias is that of the first side, relative to the second, and ``case`` may also be one of the scenes
that relations bring along. The entry speaks of each of its claims.

A file for ``--known`` may also name cases and scenes of the user's own, those of the run. A name that nothing has is
refused, since it would be passed over in silence.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from importlib.resources import files
from pathlib import Path
from typing import Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray
from packaging.specifiers import InvalidSpecifier, SpecifierSet

from comparisons.renderers import RENDERERS, ConfigError, canonical
from comparisons.renderers.mitsuba_names import shown, spelled_out
from scenes import Tolerance
from scenes.library import CASES
from scenes.names import UnknownNameError, look_up

SHIPPED = Path(str(files("comparisons") / "known.toml"))
"""The deviations this project has found itself."""


class KnownError(ValueError):
    """A file of known deviations that can't be read."""


class Deviation(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One entry; see above. ``versions`` are those of the renderer, as in a requirement of a Python package."""

    case: str
    renderer: str | list[str]
    versions: str
    within: float
    tile_within: float
    reason: str
    link: str
    bounces: list[int] = []
    bias: list[float | list[float]] = []
    total: float | list[float] | None = None
    onwards: bool = False
    channels: list[str] | None = None
    relation: str | None = None

    def __post_init__(self) -> None:
        biases = self.bias if self.total is None else [self.total]
        self._check_what(biases)
        smallest = min(abs(b) for bias in biases for b in (bias if isinstance(bias, list) else [bias]))
        if not (0 < self.within < smallest < math.inf and 0 < self.tile_within < math.inf):
            shown = f"bias = {self.bias}" if self.total is None else f"total = {self.total}"
            raise ValueError(
                f"{shown}, within = {self.within}, tile_within = {self.tile_within}: expected "
                "0 < within < |bias|, so that a deviation can't be taken for none, and 0 < tile_within"
            )
        try:
            SpecifierSet(self.versions)
        except InvalidSpecifier as error:
            raise ValueError(f"versions = {self.versions!r}: {error}") from None

    def _check_what(self, biases: Sequence[float | list[float]]) -> None:
        """Refuse what does not say what deviates, or says it twice.

        Raises:
            ValueError: what was found, and what was expected.
        """
        if not (self.bounces or self.bias or self.total is not None):
            raise ValueError("it says nothing of what deviates: expected bounces and bias, or total")
        if self.total is not None and (
            self.bounces or self.bias or self.onwards or self.relation is not None
        ):
            raise ValueError(
                "total stands by itself: expected no bounces, bias, onwards or relation beside it"
            )
        if self.total is None and (not self.bounces or len(self.bias) != len(self.bounces)):
            raise ValueError(
                f"bias has {len(self.bias)} numbers, bounces has {len(self.bounces)}: expected as many"
            )
        lists = [bias for bias in biases if isinstance(bias, list)]
        if any(not bias or len(bias) != len(self.channels or []) for bias in lists):
            raise ValueError(
                f"bias = {biases}, channels = {self.channels}: expected a number for each bounce, or a list "
                "with one for each of the channels, which are then named"
            )
        if self.bounces and (min(self.bounces) < 0 or sorted(set(self.bounces)) != self.bounces):
            raise ValueError(f"bounces = {self.bounces}: expected each once, ascending, from 0")

    @property
    def renderers(self) -> list[str]:
        """Names, full or short, and patterns of names."""
        return self.renderer if isinstance(self.renderer, list) else [self.renderer]

    def means(self, renderer: str) -> bool:
        """Whether it is about the renderer of that full name."""
        return any(
            fnmatchcase(spelled_out(renderer), name) if "*" in name else canonical(name) == renderer
            for name in self.renderers
        )

    def speaks_of(self, bounce: int) -> bool:
        """Whether something is declared of a bounce."""
        return bounce in self.bounces or (self.onwards and bounce > max(self.bounces))

    def of_total(self, names: Sequence[str]) -> DeclaredSum | None:
        """What it says of the sum itself; None if it is about bounces."""
        if self.total is None:
            return None
        by_channel = self._by_channel(self.total, names)
        return DeclaredSum(by_channel, self.within, self.tile_within, self.reason, self.link)

    def biases(self, bounce: int, names: Sequence[str]) -> dict[str, float]:
        """The declared biases of a bounce that the entry speaks of, by channel; those it does not name are left out.

        Args:
            bounce: which.
            names: of all channels of the case.
        """
        bias = self.bias[self.bounces.index(bounce) if bounce in self.bounces else -1]
        return self._by_channel(bias, names)

    def _by_channel(self, bias: float | list[float], names: Sequence[str]) -> dict[str, float]:
        deviate = list(names) if self.channels is None else self.channels
        by_name = zip(deviate, bias if isinstance(bias, list) else [bias] * len(deviate), strict=True)
        return {name: b for name, b in by_name if name in names}


class Declared(Protocol):
    """What is declared of one image, a bounce or the sum."""

    @property
    def within(self) -> float:
        """How close to that the whole image must be."""

    @property
    def tile_within(self) -> float:
        """And every tile."""

    @property
    def reason(self) -> str:
        """Why."""

    @property
    def link(self) -> str:
        """Where more is told."""

    def biases(self, bounce: int, names: Sequence[str]) -> dict[str, float]:
        """By channel, as of ``Deviation``."""


@dataclass(frozen=True)
class DeclaredSum:
    """What is declared of the sum, or what the entries of single bounces explain of it."""

    by_channel: dict[str, float]
    within: float
    tile_within: float
    reason: str
    link: str

    def biases(self, bounce: int, names: Sequence[str]) -> dict[str, float]:
        """Of the sum, whatever the bounce."""
        return self.by_channel


def declared_of_sum(
    entries: Sequence[Deviation], means: NDArray[np.float64], names: Sequence[str], tolerance: Tolerance
) -> DeclaredSum | None:
    """What is declared of a sum, by itself or by what is declared of its bounces; None if nothing is.

    Args:
        entries: of the comparison; of two that speak of the same, the later one counts.
        means: of TᵏE over the image, ``(bounces + 1, channels)``; the last may hold all that follows.
        names: of the channels.
        tolerance: of bounces that no entry speaks of.
    """
    if of_total := [found for entry in entries if (found := entry.of_total(names))]:
        return of_total[-1]
    spoken = {k: entry for entry in entries for k in range(len(means)) if entry.speaks_of(k)}
    if not spoken:
        return None
    shares = means / np.where((whole := means.sum(axis=0)) > 0, whole, 1.0)
    largest, sums = shares.max(axis=1), dict[str, float]()
    within, tile_within = 0.0, 0.0
    for k, share in enumerate(shares):
        entry = spoken.get(k)
        within += float(largest[k]) * (entry.within if entry else tolerance.of_image(k))
        tile_within += float(largest[k]) * (entry.tile_within if entry else tolerance.of_tile(k))
        for name, bias in (entry.biases(k, names) if entry else {}).items():
            sums[name] = sums.get(name, 0.0) + bias * float(share[names.index(name)])
    entry = next(iter(spoken.values()))
    bounces = ", ".join(map(str, sorted(spoken)[:6])) + (" …" if len(spoken) > 6 else "")
    noun = "bounce" if len(spoken) == 1 else "bounces"
    reason = f"What is declared of {noun} {bounces} explains it."
    return DeclaredSum(sums, within, tile_within, reason, entry.link)


class _File(msgspec.Struct, forbid_unknown_fields=True):
    deviation: list[Deviation] = []


def load(path: Path, own: Iterable[str] = (), scenes: Iterable[str] = ()) -> list[Deviation]:
    """Read a file of known deviations.

    Args:
        path: the file.
        own: names of cases, besides the library's, that it may speak of.
        scenes: of scenes, besides those of cases, that it may speak of where it speaks of a relation.

    Raises:
        KnownError: it does not exist, or a field is wrong; with its path and what was expected.
    """
    from comparisons.relations import (
        RELATIONS,
        STAGES,
    )  # late: relations are judged with what is declared here

    try:
        entries = msgspec.toml.decode(path.read_bytes(), type=_File).deviation
    except OSError as error:
        raise KnownError(f"{path}: {error.strerror}") from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise KnownError(f"{path}: {error}") from error
    cases = {**CASES, **dict.fromkeys(own)}
    for i, entry in enumerate(entries):  # one that can never apply would be silent
        try:
            if entry.relation is None:
                look_up("case", entry.case, cases)
            else:
                look_up("relation", entry.relation, RELATIONS)
                look_up("scene", entry.case, {**cases, **STAGES, **dict.fromkeys(scenes)})
            _check_renderers(entry)
        except (UnknownNameError, ConfigError) as error:
            raise KnownError(f"{path}: deviation[{i}]: {error}") from error
    return entries


def _check_renderers(entry: Deviation) -> None:
    """Refuse a name that nothing has, and a pattern of none.

    Raises:
        UnknownNameError: which.
    """
    known = [form.spelled_out for form in shown()]
    for name in entry.renderers:
        if "*" not in name:
            canonical(name)
        elif not any(fnmatchcase(full, name) for full in [*RENDERERS, *known]):
            raise UnknownNameError("renderer", name, known)


def declared(
    deviations: list[Deviation], case: str, renderer: str, version: str, relation: str | None = None
) -> list[Deviation]:
    """The entries that apply to a comparison; of two that speak of the same bounce, the later one counts.

    Args:
        deviations: all of them.
        case: its name.
        renderer: its full name.
        version: of the renderer.
        relation: which one is tried on the scene of the case; None: the case is held against its truth.
    """
    ours = _about(deviations, case, renderer, relation)
    return [entry for entry in ours if _covers(entry, version)]


def of_other_versions(
    deviations: list[Deviation], case: str, renderer: str, version: str, relation: str | None = None
) -> list[str]:
    """What is to be said of entries that apply but for the version; arguments as of ``declared``."""
    others = [e for e in _about(deviations, case, renderer, relation) if not _covers(e, version)]
    return [
        f"A deviation that is declared of versions {versions} does not apply: this one's is {version or 'not known'}"
        for versions in dict.fromkeys(entry.versions for entry in others)
    ]


def _about(
    deviations: list[Deviation], case: str, renderer: str, relation: str | None
) -> Iterator[Deviation]:
    for entry in deviations:
        if (entry.case, entry.relation) == (case, relation) and entry.means(renderer):
            yield entry


def _covers(entry: Deviation, version: str) -> bool:
    return SpecifierSet(entry.versions).contains(version, prereleases=True)
