from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import pytest

from comparisons.results import BounceResult, ChannelResult, Comparison, Place, TileResult

Make = Callable[..., Comparison]

TOLERANCE = 0.005


def bounce(k: int, truth: float, mean: float, error: float = 1e-4, by_tile: bool = False) -> BounceResult:
    """A bounce that was measured with a relative standard error; wrong in a tile alone if asked for."""
    denominator = truth or 1.0
    bias = (mean - truth) / denominator
    low, high = bias - 4 * error, bias + 4 * error
    wrong = by_tile or low > TOLERANCE or high < -TOLERANCE
    numbers: dict[str, Any] = {
        "channel": "G",
        "bias": bias,
        "interval": (low, high),
        "simultaneous_interval": (low, high),
        "detectable_bias": TOLERANCE + 6 * error,
    }
    level = {
        "truth_mean": truth,
        "mean": mean,
        "denominator": denominator,
        "standard_error": error,
        "resolution": 0.001,
    }
    tile = TileResult(place=Place(row=0, column=0, x0=0, y0=0, x1=16, y1=16), **numbers)
    return BounceResult(
        bounce=k,
        verdict="fail" if wrong else "pass",
        decided_by="tile" if by_tile else "image",
        tolerance=TOLERANCE,
        tile_tolerance=5 * TOLERANCE,
        look=1,
        replicates=32,
        spp=512,
        channels=[ChannelResult(**numbers, **level)],
        worst_tile=tile,
        **numbers,
        **level,
    )


@pytest.fixture
def made() -> Make:
    """``made(truth, mean)``: a comparison with these means of its bounces."""

    def comparison(truth: Sequence[float], mean: Sequence[float], **changes: Any) -> Comparison:
        by_tile = changes.pop("by_tile", ())
        pairs = enumerate(zip(truth, mean, strict=True))
        bounces = [bounce(k, t, m, by_tile=k in by_tile) for k, (t, m) in pairs]
        verdict = "fail" if any(b.verdict == "fail" for b in bounces) else "pass"
        fields: dict[str, Any] = {
            "case": "box",
            "renderer": "mine",
            "verdict": verdict,
            "truth": "exact",
            "seconds": 1.0,
            "spp": 512,
            "replicates": 32,
            "bounces": bounces,
            "title": "",
            "derivation": "",
            "blind_to": "",
            "renderer_version": "1",
            "truth_source": "",
            "width": 64,
            "height": 64,
            "channels": ["G"],
            "tiles": (4, 4),
            "alpha": 1e-3,
        }
        return Comparison(**(fields | changes))

    return comparison
