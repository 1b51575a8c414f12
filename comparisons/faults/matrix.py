"""The matrix: every planted fault and every sound variant, put to the suite of cases.

A fault is caught by the first case that fails in its trial (``trial.py``). A sound variant must pass, or stay open,
in every fourth one of the quick cases, a quarter of the variants in the first, the fifth and so on; and so do faults
that say why they can't be seen.
"""

from __future__ import annotations

import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from comparisons.diagnosis import diagnose
from comparisons.faults import FAULTS, SOUND_VARIANTS, held_out
from comparisons.faults.deviation import Deviation, decisive, deviations
from comparisons.faults.fault import Fault, Sound
from comparisons.faults.trial import Seen, caught, seen
from comparisons.results import Comparison, Diagnosis, Operator

_HELD_OUT = frozenset(fault.name for fault in held_out.FAULTS)


class Row(Struct, frozen=True, kw_only=True):
    """What became of one fault, or of one sound variant.

    Attributes:
        name, what: as in the catalogue.
        operator: what was planted; None in a sound variant.
        caught_by: the first case that failed; empty if none did.
        verdict: what that case said: fail or error.
        bounce, bias, detectable_bias: where it failed: of the whole image, or of the worst tile.
        seconds: from the start until it was caught, or to the end.
        cases: how many were run in all.
        diagnosis: of all that was seen.
        nearest: where nothing was caught: the case and bounce that came nearest to it, in words.
        happened, unseen: as in the catalogue.
    """

    name: str
    what: str
    operator: Operator | None
    seconds: float
    cases: int
    caught_by: str = ""
    verdict: str = ""
    bounce: int | None = None
    bias: float | None = None
    detectable_bias: float | None = None
    diagnosis: Diagnosis | None = None
    nearest: str = ""
    happened: tuple[str, ...] = ()
    unseen: str = ""

    @property
    def tuned(self) -> bool:
        """Whether it is one of those that the diagnosis was tuned on."""
        return tuned_on(self.name)

    @property
    def size(self) -> str:
        """Its bias, ``+41 %``; empty where there is none."""
        if self.bias is None:
            return ""
        percent = 100 * self.bias
        return f"{float(f'{percent:.2g}'):+,.0f} %" if abs(percent) >= 99.5 else f"{percent:+.2g} %"

    @property
    def right(self) -> bool:
        """Whether the diagnosis names what was planted."""
        return self.diagnosis is not None and self.diagnosis.suspect == self.operator


class Summary(Struct, frozen=True, kw_only=True):
    """What the rows say together.

    Attributes:
        faults, caught, unseen: how many there are, how many a case has failed, and how many say why none can.
        tuned, held_out: of the caught, how many the diagnosis names, and how many there are: of those that it was
            tuned on, and of the others.
        sound, failed: sound variants, and how many of them a case has failed.
        seconds: of all rows.
    """

    faults: int
    caught: int
    unseen: int
    tuned: tuple[int, int]
    held_out: tuple[int, int]
    sound: int
    failed: int
    seconds: float

    @classmethod
    def of(cls, rows: Sequence[Row], seconds: float) -> Summary:
        """Counts."""
        planted = [row for row in rows if row.operator is not None]
        caught = [row for row in planted if row.caught_by]
        sound = [row for row in rows if row.operator is None]

        def named(tuned: bool) -> tuple[int, int]:
            some = [row for row in caught if row.tuned == tuned]
            return sum(row.right for row in some), len(some)

        return cls(
            faults=len(planted),
            caught=len(caught),
            unseen=sum(bool(row.unseen) for row in planted if not row.caught_by),
            tuned=named(True),
            held_out=named(False),
            sound=len(sound),
            failed=sum(bool(row.caught_by) for row in sound),
            seconds=seconds,
        )

    @property
    def kept(self) -> bool:
        """Whether every fault that can be seen was, and no sound variant failed."""
        return self.caught + self.unseen == self.faults and not self.failed

    def sentences(self) -> Iterator[str]:
        """The same for a reader."""
        if self.faults:
            unseen = f"; {self.unseen} can't be seen, and say why" if self.unseen else ""
            share = f"{self.caught} of {self.faults} faults were" if self.faults > 1 else "The only fault was"
            yield f"{share}{' not' if self.faults == 1 > self.caught else ''} caught{unseen}.{self._named()}"
        if self.sound:
            yield f"{self.failed} of {self.sound} sound variants failed."
        yield f"{self.seconds:.0f} s in all."

    def _named(self) -> str:
        shares = [
            f"{right} of {of} {which}"
            for (right, of), which in (
                (self.tuned, "that it was tuned on"),
                (self.held_out, "that were held out"),
            )
            if of
        ]
        if not shares:
            return ""
        return f" The diagnosis named {', and '.join(shares).replace(' that', ' faults that', 1)}."


class Matrix(Struct, frozen=True, kw_only=True):
    """All rows, and what is needed to repeat them."""

    version: str
    date: str
    processors: int
    jobs: int
    seed: int
    rows: list[Row]
    summary: Summary


def tuned_on(name: str) -> bool:
    """Whether the weights of the diagnosis were set with this fault in view."""
    return name not in _HELD_OUT


def rows(names: Sequence[str], jobs: int, seed: int = 0, keep: Path | None = None) -> Iterator[Row]:
    """One row per name, as each is done.

    Args:
        names: of faults and sound variants.
        jobs: how many at a time, each in a process of its own.
        seed: of all comparisons.
        keep: a folder for what was seen, ``NAME.json``, from which a row can be concluded again.
    """
    at_once = (signal.SIGINT, signal.SIG_DFL)  # on Ctrl-C, not when its row is done
    with ProcessPoolExecutor(jobs, get_context("spawn"), signal.signal, at_once) as executor:
        try:
            for done in as_completed([executor.submit(row, name, seed, keep) for name in names]):
                yield done.result()
        finally:
            executor.shutdown(wait=True, cancel_futures=True)


def row(name: str, seed: int = 0, keep: Path | None = None) -> Row:
    """Put one of them to the cases, in this process."""
    entry = FAULTS.get(name) or SOUND_VARIANTS[name]
    found = seen(entry, seed)
    if keep is not None:
        keep.mkdir(parents=True, exist_ok=True)
        (keep / f"{name}.json").write_bytes(msgspec.json.encode(found))
    return concluded(entry, found)


def concluded(entry: Fault | Sound, found: Seen) -> Row:
    """The row that this makes."""
    first = caught(found)
    row = Row(
        name=entry.name,
        what=entry.what,
        operator=entry.operator if isinstance(entry, Fault) else None,
        seconds=found.seconds[-1],
        cases=len(found.comparisons),
        happened=entry.happened if isinstance(entry, Fault) else (),
        unseen=entry.unseen if isinstance(entry, Fault) else "",
    )
    if first is None:
        return replace(row, nearest=_nearest(found.comparisons))
    comparison = found.comparisons[first]
    worst = _worst(comparison)
    return replace(
        row,
        seconds=found.seconds[first],
        caught_by=comparison.case,
        verdict=comparison.verdict,
        **(worst._asdict() if worst else {}),
        diagnosis=diagnose(found.comparisons, found.relations, found.others),
    )


def _worst(comparison: Comparison) -> Deviation | None:
    """The failed bounce that is clearest; None in an error."""
    failed = (decisive(b) for b in comparison.bounces if b.verdict == "fail")
    return max(failed, key=lambda one: one.clearness, default=None)


def _nearest(comparisons: Sequence[Comparison]) -> str:
    """The bounce of which the bias came nearest to what could have been seen."""
    of = [
        (one.clearness, comparison.case, one) for comparison in comparisons for one in deviations(comparison)
    ]
    if not of:
        return ""
    _, name, (k, bias, detectable) = max(of)
    return f"{name}, bounce {k}: {bias:+.2%}, detectable from {detectable:.2%}"
