"""What a minute of Mitsuba resolves in the Cornell box, and how long the default run takes."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.calibration.limits import Limit
from comparisons import results
from comparisons.results import Results

MINUTE = 60.0
RESOLUTIONS = (0.002, 0.002, 0.005, 0.009, 0.015, 0.015)
TOLERANCES, TILE_TOLERANCE = ",".join(f"{most:.1%}" for most in RESOLUTIONS), "99%"
DEFAULT_RUN = 90.0
"""Seconds."""

_COMMAND = (sys.executable, "-m", "lightproof", "validate")


def limits() -> Iterator[Limit]:
    """The resolution of every bounce, whole image, worst channel; then the default run.

    The resolutions are asked for as tolerances, which say where samples go, and are in no part of a resolution.
    Tiles are not what is asked for here, so theirs are too wide to draw any.
    """
    budget = f"{MINUTE:g}"
    wanted = ("--tolerance", TOLERANCES, "--tile-tolerance", TILE_TOLERANCE)
    outcome, _ = _run("cornell-box", "--renderer", "mitsuba", "--budget", budget, "--no-early-stop", *wanted)
    [comparison] = outcome.comparisons
    for bounce, most in zip(comparison.bounces, RESOLUTIONS, strict=True):
        what = f"cornell-box × mitsuba, {budget} s on {os.cpu_count()} cores: resolution of bounce {bounce.bounce}"
        yield Limit(what, bounce.resolution, most, "%")
    outcome, seconds = _run()
    yield Limit("the default run", seconds, DEFAULT_RUN, "s")
    undecided = sum(c.verdict in ("inconclusive", "error") for c in outcome.comparisons)
    yield Limit("its comparisons without a verdict", undecided, 0, "")


def _run(*arguments: str) -> tuple[Results, float]:
    with TemporaryDirectory() as folder:
        start = time.monotonic()
        # the exit status is the verdict's; without results there is nothing to read, which raises
        subprocess.run([*_COMMAND, *arguments, "--out", folder], stdout=subprocess.DEVNULL, check=False)
        return results.read(Path(folder)), time.monotonic() - start
