"""The rows of the table: what is measured, and what it must reach."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from benchmarks import equal_error
from benchmarks.processes import RENDERS, Workers
from benchmarks.row import Row, asked
from benchmarks.sides import Mitsuba, ours
from benchmarks.statistics import Ratio, median_ratio
from benchmarks.timing import Progress, in_turn, interleaved
from reference_tracer.finite_elements import Solution, solve
from scenes.library.cornell_box import empty_box


@dataclass(frozen=True)
class Effort:
    """How much work the measurements are.

    Attributes:
        repetitions: of what is timed, in turn.
        spp: of renders that are only timed.
        trial_spp: of renders whose variance counts.
        seeds: of these.
        few: trials that tell which of Mitsuba's samplers are hopeless.
    """

    repetitions: int
    spp: int
    trial_spp: int
    seeds: int
    few: int


FULL = Effort(repetitions=9, spp=64, trial_spp=16, seeds=64, few=6)
QUICK = Effort(repetitions=2, spp=1, trial_spp=1, seeds=8, few=2)

SECONDS = 5.0
"""What the time of the finite elements is held against."""

ERROR = 1e-5
"""That the finite elements may have, relative, in each wall's L² norm and in each pixel."""

Measure = Callable[[Effort, Progress], list[Row]]


def paths(effort: Effort, progress: Progress) -> list[Row]:
    """Plain paths per second, both with next event and chance, weighted: the same count of paths on both sides."""
    row = asked("paths-per-second", "paths per second, ours ÷ Mitsuba (one render)", must=0.6, aim=1.0)
    sides = {"ours": ours(effort.spp), "Mitsuba": Mitsuba().sum(effort.spp)}
    seconds = interleaved(sides, effort.repetitions, progress)
    count = effort.spp * 64 * 64 / 1e6
    rates = (f"{name} {count / np.median(taken):.3g}" for name, taken in seconds.items())
    return [row.filled(median_ratio(seconds["Mitsuba"], seconds["ours"]),
                       f"{' and '.join(rates)} million/s, {effort.spp} spp")]  # fmt: skip


def bounce_images(effort: Effort, progress: Progress) -> list[Row]:
    """The same six images."""
    row = asked("bounce-images", "time of the six bounce images, Mitsuba (coupled) ÷ ours", must=2.5, aim=4.0)
    sides = {"ours": ours(effort.spp), "Mitsuba": Mitsuba().coupled(effort.spp)}
    seconds = interleaved(sides, effort.repetitions, progress)
    return [row.filled(median_ratio(seconds["Mitsuba"], seconds["ours"]),
                       f"{_medians(seconds)}, {effort.spp} spp")]  # fmt: skip


def equal_errors(effort: Effort, progress: Progress) -> list[Row]:
    """Time to equal standard error, of the image and of its tiles."""
    image = asked("equal-error", "time to equal error per bounce, Mitsuba ÷ ours", must=3.0, aim=8.0)
    tiles = asked("equal-error-tiles", "the same for 8×8 tiles (informs)", must=3.0, aim=8.0, decides=False)
    measured = equal_error.measure(effort.trial_spp, effort.seeds, effort.few, progress)
    return [
        row.filled(
            found.ratio, f"{_each(found.bounces)}; {effort.seeds} seeds, {effort.trial_spp} spp; {found.way}"
        )
        for row, found in zip((image, tiles), measured, strict=True)
    ]


def processes(effort: Effort, progress: Progress) -> list[Row]:
    """Renders per second by two workers and by one."""
    row = asked("processes", "renders per second, two processes ÷ one", must=1.8, aim=1.95)
    progress("starting workers")
    with Workers(1, effort.spp) as one, Workers(2, effort.spp) as two:
        seconds: dict[str, list[float]] = {"one": [], "two": []}
        for repetition in range(effort.repetitions):
            progress(f"repetition {repetition + 1} of {effort.repetitions}")
            for name in in_turn(list(seconds), repetition):
                seconds[name].append({"one": one, "two": two}[name].seconds(repetition))
    taken = {name: np.array(values) for name, values in seconds.items()}
    # the same time for twice as many renders would be a ratio of 2
    return [
        row.filled(
            median_ratio(taken["one"], taken["two"]) * 2, f"{_medians(taken)} for {RENDERS} renders each"
        )
    ]


def finite_elements(effort: Effort, progress: Progress) -> list[Row]:
    """The empty Cornell box; a solution that is not exact enough has a ratio of 0, however fast it was."""
    row = asked("finite-elements", f"{SECONDS:g} s ÷ time of finite elements, empty box", must=1.0, aim=5.0)
    solution = solve(empty_box(), 6)

    def work(repetition: int) -> None:
        solve(empty_box(), 6).image()

    seconds = interleaved({"finite elements": work}, effort.repetitions, progress)
    progress("the twice refined solution")
    return [judged(row, median_ratio(np.array(SECONDS), seconds["finite elements"]), error_of(solution))]


def error_of(solution: Solution) -> float:
    """The largest error of all walls, pixels, bounces and channels, against the twice refined solution."""
    return solution.compared(solution.refined(2)).largest


def judged(row: Row, ratio: Ratio, error: float) -> Row:
    """The row of the finite elements, which fails where the error is too large or not a number."""
    if error <= ERROR:
        return row.filled(ratio, f"{SECONDS / ratio.value:.3g} s, error {error:.1e}")
    return row.filled(
        ratio * 0.0, f"error {error:.1e}, above {ERROR:.0e}; it took {SECONDS / ratio.value:.3g} s"
    )


def _each(bounces: np.ndarray) -> str:
    return "bounces 1 to 5: " + ", ".join(f"{ratio:.3g}" for ratio in bounces)


def _medians(seconds: dict[str, np.ndarray]) -> str:
    return " and ".join(f"{name} {np.median(taken):.3g} s" for name, taken in seconds.items())


ROWS: MappingProxyType[str, Measure] = MappingProxyType(
    {
        "paths-per-second": paths,
        "bounce-images": bounce_images,
        "equal-error": equal_errors,
        "processes": processes,
        "finite-elements": finite_elements,
    }
)
"""By the names that can be asked for; equal-error brings that of tiles along."""
