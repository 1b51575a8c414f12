"""From intervals to verdicts, bounce by bounce.

pass          the own interval of every region and channel lies inside ± tolerance
fail          the simultaneous interval of some region and channel lies outside ± tolerance
inconclusive  neither
known         not a pass, but the deviation is the declared one: as a pass, with the bias less the declared
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from comparisons.known import Deviation
from comparisons.regions import Regions
from comparisons.results import (
    BounceResult,
    BounceVerdict,
    ChannelResult,
    Interval,
    KnownDeviation,
    TileResult,
    Verdict,
)
from comparisons.statistics.intervals import Biases
from scenes import Tolerance
from scenes.formats.exr import channel_names

Array = NDArray[np.float64]


def judge(
    biases: Biases,
    mean: Array,
    truth: Array,
    tolerance: Tolerance,
    regions: Regions,
    known: Mapping[int, Deviation],
    enough: bool,
) -> list[BounceResult]:
    """The verdict and the numbers of every bounce.

    Args:
        biases: of this look.
        mean, truth: means over regions, ``(1 + tiles, bounces + 1, channels)``.
        tolerance: per bounce, for the image and for its tiles.
        regions: which region is where.
        known: declared deviations, by bounce.
        enough: whether there are as many replicates as a verdict needs; if not, all is inconclusive.
    """
    tolerances = np.array(
        [
            [tolerance.of_image(k) if region == 0 else tolerance.of_tile(k) for k in range(mean.shape[1])]
            for region in range(len(mean))
        ]
    )[..., None]
    inside, outside = biases.inside(tolerances), biases.outside(tolerances)
    results = []
    for k in range(mean.shape[1]):
        verdict: BounceVerdict = _decide(inside[:, k], outside[:, k]) if enough else "inconclusive"
        deviation = None
        if k in known:
            verdict, deviation = _declared(biases, tolerances, k, verdict, known[k], enough)
        by_tile = enough and inside[0, k].all() and verdict in ("fail", "inconclusive")
        result = _bounce(k, verdict, deviation, biases, mean[0], truth[0], tolerances, regions)
        results.append(msgspec.structs.replace(result, decided_by="tile" if by_tile else "image"))
    return results


def _decide(inside: NDArray[np.bool_], outside: NDArray[np.bool_]) -> Literal["pass", "fail", "inconclusive"]:
    """One bounce, from where its own intervals lie inside and its simultaneous ones outside, per region."""
    if outside.any():
        return "fail"
    return "pass" if inside.all() else "inconclusive"


def _declared(
    biases: Biases, tolerances: Array, k: int, plain: BounceVerdict, entry: Deviation, enough: bool
) -> tuple[BounceVerdict, KnownDeviation]:
    """The verdict where a deviation was declared, and what became of the declaration.

    A region may deviate as declared or not at all, since a deviation need not touch every channel and tile.
    """
    bias = entry.bias[entry.bounces.index(k)]

    def now(state: Literal["confirmed", "changed", "vanished", "undecided"]) -> KnownDeviation:
        return KnownDeviation(declared_bias=bias, state=state, reason=entry.reason, link=entry.link)

    if plain == "pass":
        return "pass", now("vanished")
    if not enough:
        return "inconclusive", now("undecided")
    within = np.full_like(tolerances, entry.tile_within)
    within[0] = entry.within
    inside = biases.inside(tolerances) | biases.inside(within, shift=bias)
    outside = biases.outside(tolerances) & biases.outside(within, shift=bias)
    match _decide(inside[:, k], outside[:, k]):
        case "pass":
            return "known", now("confirmed")
        case "fail":
            return "fail", now("changed")
        case _:
            return "inconclusive", now("undecided")


def _bounce(
    k: int,
    verdict: BounceVerdict,
    known: KnownDeviation | None,
    biases: Biases,
    mean: Array,
    truth: Array,
    tolerances: Array,
    regions: Regions,
) -> BounceResult:
    """The numbers of one bounce; ``mean`` and ``truth`` are of the whole image, ``(bounces + 1, channels)``."""
    # the worst is the one closest to failing, in standard errors
    margin = (np.abs(biases.bias) - tolerances)[:, k] / np.maximum(biases.error[:, k], 1e-12)
    channel = int(margin[0].argmax())
    tile, tile_channel = np.unravel_index(margin[1:].argmax(), margin[1:].shape)
    names = channel_names(mean.shape[-1])
    image_tolerance, tile_tolerance = float(tolerances[0, k, 0]), float(tolerances[1, k, 0])
    channels = [
        ChannelResult(
            channel=name,
            truth_mean=float(truth[k, c]),
            mean=float(mean[k, c]),
            denominator=float(biases.denominator[0, k, c]),
            bias=float(biases.bias[0, k, c]),
            interval=_interval(biases, 0, k, c),
            standard_error=float(biases.error[0, k, c]),
            detectable_bias=image_tolerance + float(biases.resolution[0, k, c]),
            resolution=float(biases.resolution[0, k, c]),
        )
        for c, name in enumerate(names)
    ]
    worst = channels[channel]
    return BounceResult(
        bounce=k,
        verdict=verdict,
        decided_by="image",
        channel=worst.channel,
        truth_mean=worst.truth_mean,
        mean=worst.mean,
        denominator=worst.denominator,
        bias=worst.bias,
        interval=worst.interval,
        standard_error=worst.standard_error,
        tolerance=image_tolerance,
        tile_tolerance=tile_tolerance,
        detectable_bias=worst.detectable_bias,
        resolution=worst.resolution,
        channels=channels,
        worst_tile=TileResult(
            place=regions.place(int(tile) + 1),
            channel=names[int(tile_channel)],
            bias=float(biases.bias[tile + 1, k, tile_channel]),
            interval=_interval(biases, int(tile) + 1, k, int(tile_channel)),
            detectable_bias=tile_tolerance + float(biases.resolution[tile + 1, k, tile_channel]),
        ),
        known=known,
    )


def _interval(biases: Biases, region: int, k: int, c: int) -> Interval:
    bias, half = float(biases.bias[region, k, c]), float(biases.own[region, k, c])
    return bias - half, bias + half


def overall(verdicts: Iterable[Verdict]) -> Verdict:
    """The verdict of the whole: the first of fail, error, inconclusive, known, pass, unsupported that occurs."""
    found = set(verdicts)
    order: tuple[Verdict, ...] = ("fail", "error", "inconclusive", "known", "pass")
    return next((verdict for verdict in order if verdict in found), "unsupported")
