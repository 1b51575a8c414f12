"""From intervals to verdicts, bounce by bounce.

pass          the own interval of every region and channel lies inside ± tolerance
fail          the simultaneous interval of some region and channel lies outside ± tolerance
inconclusive  neither
known         not a pass, but each of these intervals lies inside ± tolerance or around the declared deviation
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from comparisons.known import Declared
from comparisons.regions import Regions
from comparisons.results import (
    BounceResult,
    BounceVerdict,
    ChannelResult,
    DeclarationState,
    Interval,
    KnownDeviation,
    TileResult,
    Verdict,
)
from comparisons.statistics import skewness
from comparisons.statistics.intervals import Biases, Range
from comparisons.statistics.moments import Moments
from scenes import Tolerance

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Measured:
    """One bounce, measured.

    Attributes:
        bounce: which.
        channels: their names.
        biases: with their intervals, of this look.
        mean, truth, denominator: means over regions and what biases are relative to, ``(regions, channels)``.
        skewness: of a replicate's means over regions.
        dominance: share of the spread that is one replicate's; see ``Moments.dominance``.
        look: which one this is, 1 for the first.
        replicates, spp: how many, and samples per pixel of all of them together.
        enough: whether that is as much as a verdict needs; if not, it is inconclusive.
    """

    bounce: int
    channels: Sequence[str]
    biases: Biases
    mean: Array
    truth: Array
    denominator: Array
    skewness: Array
    dominance: Array
    look: int
    replicates: int
    spp: int
    enough: bool

    @classmethod
    def of(
        cls,
        replicates: Moments,
        found: Biases,
        truth: Array,
        denominator: Array,
        *,
        bounce: int,
        channels: Sequence[str],
        look: int,
        spp: int,
        least: int,
    ) -> Measured:
        """What replicates tell.

        Args:
            replicates: moments of their means over regions, ``(regions, channels)``.
            found, truth, denominator, bounce, channels, look: as above.
            spp: samples per pixel of one replicate.
            least: replicates that a verdict needs.
        """
        return cls(
            bounce=bounce,
            channels=channels,
            biases=found,
            mean=replicates.mean,
            truth=truth,
            denominator=denominator,
            skewness=skewness.of_the_mean(replicates) * np.sqrt(replicates.count),
            dominance=replicates.dominance,
            look=look,
            replicates=replicates.count,
            spp=spp * replicates.count,
            enough=replicates.count >= least,
        )


def judge(measured: Measured, tolerance: Tolerance, regions: Regions, known: Declared | None) -> BounceResult:
    """The verdict and the numbers of one bounce.

    Args:
        measured: the numbers.
        tolerance: for the image and for its tiles.
        regions: which region is where.
        known: the declared deviation of this bounce.
    """
    k = measured.bounce
    tolerances = _per_region(measured, tolerance.of_image(k), tolerance.of_tile(k))
    inside, outside = _decisions(measured.biases, tolerances)
    verdict: BounceVerdict = _decide(inside, outside) if measured.enough else "inconclusive"
    deviation = None
    if known is not None:
        verdict, deviation = _declared(measured, tolerances, verdict, known)
    # what the image alone would have said
    image = _decide(inside[0], outside[0]) if measured.enough else verdict
    by_tile = verdict in ("fail", "inconclusive") and image != verdict
    return _result(measured, tolerances, regions, verdict, "tile" if by_tile else "image", deviation)


def _per_region(measured: Measured, image: float, tile: float) -> Array:
    """A column with one number for the whole image and another one for each tile."""
    column = np.full((len(measured.mean), 1), tile)
    column[0] = image
    return column


def _decisions(
    found: Biases, tolerance: Array, center: Array | float = 0.0
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Where own intervals lie inside center ± tolerance, and where simultaneous ones lie outside."""
    return found.own.inside(tolerance, center), found.simultaneous.outside(tolerance, center)


def _decide(inside: NDArray[np.bool_], outside: NDArray[np.bool_]) -> Literal["pass", "fail", "inconclusive"]:
    if outside.any():
        return "fail"
    return "pass" if inside.all() else "inconclusive"


def _declared(
    measured: Measured, tolerances: Array, plain: BounceVerdict, entry: Declared
) -> tuple[BounceVerdict, KnownDeviation]:
    """The verdict where a deviation was declared, and what became of the declaration."""
    names = measured.channels
    biases = entry.biases(measured.bounce, names)
    center = np.array([biases.get(name, 0.0) for name in names])
    shown = float(center[_margin(measured, tolerances)[0].argmax()])

    def now(state: DeclarationState) -> KnownDeviation:
        return KnownDeviation(declared_bias=shown, state=state, reason=entry.reason, link=entry.link)

    if not measured.enough:
        return "inconclusive", now("undecided")
    deviates = np.array([name in biases for name in names])
    within = np.where(deviates, _per_region(measured, entry.within, entry.tile_within), tolerances)
    as_declared = _decide(*_decisions(measured.biases, within, center))
    if plain == "pass":
        # within a tolerance as loose as that, one can't tell a declared deviation from none
        return "pass", now("vanished" if as_declared == "fail" else "tolerated")
    match as_declared:
        case "pass":
            return "known", now("confirmed")
        case "fail":
            return plain, now("changed")
        case _:
            return "inconclusive", now("undecided")


def _margin(measured: Measured, tolerances: Array) -> Array:
    """How far outside its tolerance each region and channel lies, in standard errors; the worst is shown."""
    return (np.abs(measured.biases.bias) - tolerances) / np.maximum(measured.biases.error, 1e-12)


def _result(
    measured: Measured,
    tolerances: Array,
    regions: Regions,
    verdict: BounceVerdict,
    decided_by: Literal["image", "tile"],
    known: KnownDeviation | None,
) -> BounceResult:
    """The numbers of one bounce."""
    found, margin = measured.biases, _margin(measured, tolerances)
    channels = [_channel(measured, c, float(tolerances[0, 0])) for c in range(measured.mean.shape[1])]
    worst = channels[int(margin[0].argmax())]
    tile, tile_channel = divmod(int(margin[1:].argmax()), len(channels))
    return BounceResult(
        bounce=measured.bounce,
        verdict=verdict,
        decided_by=decided_by,
        channel=worst.channel,
        truth_mean=worst.truth_mean,
        mean=worst.mean,
        denominator=worst.denominator,
        bias=worst.bias,
        interval=worst.interval,
        simultaneous_interval=worst.simultaneous_interval,
        standard_error=worst.standard_error,
        tolerance=float(tolerances[0, 0]),
        tile_tolerance=float(tolerances[1, 0]),
        detectable_bias=max(c.detectable_bias for c in channels),
        resolution=max(c.resolution for c in channels),
        look=measured.look,
        replicates=measured.replicates,
        spp=measured.spp,
        channels=channels,
        worst_tile=_tile(measured, 1 + tile, tile_channel, regions, tolerances),
        skewness=float(measured.skewness[0, int(margin[0].argmax())]),
        dominance=float(measured.dominance.max()),
        p_values=_histogram(found.p_value[1:][found.error[1:] > 0]),
        known=known,
    )


def _channel(measured: Measured, c: int, tolerance: float) -> ChannelResult:
    found = measured.biases
    return ChannelResult(
        channel=measured.channels[c],
        truth_mean=float(measured.truth[0, c]),
        mean=float(measured.mean[0, c]),
        denominator=float(measured.denominator[0, c]),
        bias=float(found.bias[0, c]),
        interval=_at(found.own, 0, c),
        simultaneous_interval=_at(found.simultaneous, 0, c),
        standard_error=float(found.error[0, c]),
        detectable_bias=tolerance + float(found.resolution[0, c]),
        resolution=float(found.resolution[0, c]),
    )


def _tile(measured: Measured, region: int, c: int, regions: Regions, tolerances: Array) -> TileResult:
    found = measured.biases
    return TileResult(
        place=regions.place(region),
        channel=measured.channels[c],
        bias=float(found.bias[region, c]),
        interval=_at(found.own, region, c),
        simultaneous_interval=_at(found.simultaneous, region, c),
        detectable_bias=float(tolerances[region, 0] + found.resolution[region, c]),
    )


def _at(limits: Range, region: int, c: int) -> Interval:
    return float(limits.low[region, c]), float(limits.high[region, c])


def _histogram(p_values: Array) -> list[int]:
    """How many p-values of tiles fall into each tenth of 0 … 1: flat where there is no bias (Jung et al. 2020)."""
    counts: list[int] = np.histogram(p_values, bins=10, range=(0.0, 1.0))[0].tolist()
    return counts


def overall(verdicts: Iterable[Verdict]) -> Verdict:
    """The verdict of the whole: the first of fail, error, inconclusive, known, pass, unsupported that occurs."""
    found = set(verdicts)
    order: tuple[Verdict, ...] = ("fail", "error", "inconclusive", "known", "pass")
    return next((verdict for verdict in order if verdict in found), "unsupported")
