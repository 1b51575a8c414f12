"""Folders of results with every verdict, and the reports of them that several files look at."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest

import reports
from comparisons.results import (
    BounceResult,
    ChannelResult,
    Comparison,
    Images,
    KnownDeviation,
    Look,
    Metrics,
    Place,
    Provenance,
    RelationResult,
    Results,
    TileResult,
    write,
)
from scenes.formats import exr

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("page.py"))))
Page, rendered = shared.Page, shared.rendered

SCRIPT = "<script>alert(1)</script>"
CONTROL = "\x1b[31mred\x1b[0m\x00\x08 bell\x07 \ufffe"
PROVENANCE = Provenance(
    date="2025-11-03T09:30:00Z",
    command_line=["lightproof", "validate", "--only", "a case"],
    versions={"lightproof": "0.1.0", "numpy": "2.4.6"},
    platform="Linux x86_64",
    processors=8,
    seed=1,
    seeds="SeedSequence(seed).spawn",
    budget=60.0,
    alpha=0.05,
    jobs=4,
    seconds=187.0,
)


def bounce(k: int, verdict: Any, bias: float = 0.0, *, truth: float = 0.5, **changes: Any) -> BounceResult:
    """A bounce whose interval is ± 0.3 %, held against 1 %; its worst tile is in row 1, column 2 of 4 × 4."""
    interval = bias - 0.003, bias + 0.003
    fields = {
        "bounce": k,
        "verdict": verdict,
        "decided_by": "image",
        "channel": "G",
        "truth_mean": truth,
        "denominator": truth or 0.25,
        "mean": truth * (1 + bias),
        "bias": bias,
        "interval": interval,
        "simultaneous_interval": interval,
        "standard_error": 0.001,
        "tolerance": 0.01,
        "tile_tolerance": 0.05,
        "detectable_bias": 0.0142,
        "resolution": 0.0042,
        "look": 1,
        "replicates": 64,
        "spp": 1024,
        "channels": [
            ChannelResult(
                channel=name,
                truth_mean=truth,
                denominator=truth or 0.25,
                mean=truth * (1 + bias),
                bias=bias,
                interval=interval,
                simultaneous_interval=interval,
                standard_error=0.001,
                detectable_bias=0.0142,
                resolution=0.0042,
            )
            for name in "RGB"
        ],
        "worst_tile": tile(bias + 0.005, 0.01),
    }
    return BounceResult(**(fields | changes))


def tile(bias: float, half: float) -> TileResult:
    place = Place(row=1, column=2, x0=32, y0=16, x1=48, y1=32)
    interval = bias - half, bias + half
    return TileResult(
        place=place,
        channel="R",
        bias=bias,
        interval=interval,
        simultaneous_interval=interval,
        detectable_bias=0.071,
    )


def comparison(
    case: str, renderer: str, verdict: Any, bounces: list[BounceResult], **changes: Any
) -> Comparison:
    fields = {
        "case": case,
        "renderer": renderer,
        "verdict": verdict,
        "truth": "exact",
        "seconds": 12.5,
        "spp": 1024,
        "replicates": 64,
        "bounces": bounces,
        "title": f"The {case} case",
        "derivation": "since the walls are equal",
        "blind_to": "the direction of reflection",
        "renderer_version": "3.7.1",
        "truth_source": "a geometric series, see its derivation",
        "width": 64,
        "height": 64,
        "channels": ["R", "G", "B"],
        "tiles": (4, 4),
        "alpha": 0.05,
        "looks": [Look(replicates=32, seconds=4.0, alpha=0.025, open_bounces=[1, 2])],
        "metrics": [
            Metrics(bounces=k, nrmse=0.01 * k, psnr=None if k == 0 else 40.0, ssim=0.99) for k in range(2)
        ],
    }
    return Comparison(**(fields | changes))


def pictures(
    folder: Path, name: str, bounces: int, channels: int = 3, *, factor: float = 1.0, dark: int = -1
) -> Images:
    """Write a truth and a noisy renderer, wrong by a factor in bounce 1; one bounce may hold no light."""
    rng = np.random.default_rng(7)
    y, x = np.mgrid[0:64, 0:64] / 64
    base = (1.2 + np.sin(7 * x) * np.cos(5 * y))[..., None] * np.linspace(1, 0.4, channels)
    truth = np.stack([base * 0.5**k for k in range(bounces)])
    truth[0] *= ((x > 0.4) & (x < 0.6) & (y < 0.2))[..., None] * 12
    if dark >= 0:
        truth[dark] = 0
    error = 0.03 * truth
    renderer = truth + error * rng.standard_normal(truth.shape)
    if bounces > 1:
        renderer[1] *= factor
    names = Images(truth=f"{name}.truth.exr", renderer=f"{name}.renderer.exr")
    exr.write_bounces(folder / names.truth, truth)
    exr.write_bounces(folder / names.renderer, renderer, error)
    return names


def every_verdict(folder: Path) -> Results:
    """Write a run with all six verdicts, hostile texts, a bounce without energy and odd channels."""
    known = KnownDeviation(
        declared_bias=-0.04,
        state="confirmed",
        reason=f"rounding {SCRIPT}",
        link="https://example.org/issues/1",
    )
    bad_link = KnownDeviation(declared_bias=0.02, state="vanished", reason="old", link="javascript:alert(1)")
    in_tile = bounce(2, "fail", 0.001, truth=0.12, decided_by="tile", worst_tile=tile(0.12, 0.03))
    passing = [bounce(k, "pass", 0.001 * (-1) ** k, truth=0.5**k) for k in range(7)]
    comparisons = [
        comparison("cornell_box", "mitsuba", "pass", passing, images=pictures(folder, "pass", 7)),
        comparison(
            "furnace",
            "mitsuba",
            "fail",
            [bounce(0, "pass"), bounce(1, "fail", 0.031, truth=0.25), in_tile, bounce(3, "pass", truth=0.0)],
            images=pictures(folder, "fail", 4, factor=1.031, dark=3),
            message=f"budget {SCRIPT}",
            notes=["depends on a convention", "a second note"],
        ),
        comparison(
            f"sphere {SCRIPT}",
            "reference",
            "inconclusive",
            [bounce(0, "pass"), bounce(1, "inconclusive", 0.009, truth=1e-7)],
            images=pictures(folder, "grey", 2, channels=1),
            message="The budget of 10 s is used up.",
            title=f"{SCRIPT}{CONTROL}",
            channels=["Y"],
        ),
        comparison(
            "spectral",
            "pyrender",
            "known",
            [bounce(0, "pass", known=bad_link), bounce(1, "known", -0.04, truth=0.2, known=known)],
            images=pictures(folder, "five", 2, channels=5, factor=0.96),
            channels=[f"{w} nm" for w in range(400, 900, 100)],
        ),
        comparison("glass", "pyrender", "unsupported", [], message="no dielectric materials"),
        comparison(
            "furnace",
            "broken",
            "error",
            [],
            message=f"exit code 139 {SCRIPT}{CONTROL}",
            log=["starting", f"{CONTROL}", f"]]> {SCRIPT} & more"],
        ),
    ]
    results = Results(provenance=PROVENANCE, comparisons=comparisons)
    write(results, folder)
    return results


def relation(name: str, verdict: Any, bounces: list[BounceResult], **changes: Any) -> RelationResult:
    fields = {
        "relation": name,
        "claim": "",
        "scene": "room",
        "renderer": "mitsuba",
        "verdict": verdict,
        "operator": "G",
        "statement": f"one way to {SCRIPT} = another",
        "blind_to": "what is wrong on both sides",
        "renderer_version": "3.7.1",
        "channels": ["R", "G", "B"],
        "alpha": 0.05,
        "seconds": 2.5,
        "spp": 64,
        "replicates": 32,
        "bounces": bounces,
    }
    return RelationResult(**(fields | changes))


def relations_too(results: Results, folder: Path) -> Results:
    """The same run, which has tried relations too."""
    offset = KnownDeviation(
        declared_bias=0.013, state="confirmed", reason=f"the ray offset {SCRIPT}", link="docs/offset.md"
    )
    tried = [
        relation("superposition", "pass", [bounce(k, "pass", 0.002) for k in range(3)]),
        relation("reciprocity", "fail", [bounce(1, "fail", 0.04), bounce(2, "pass")], claim="25° and 50°"),
        relation("seeds", "fail", [], message="it takes no notice of its seed", operator="estimator"),
        relation(
            "linearity", "inconclusive", [bounce(0, "inconclusive", 0.009)], message="the budget was used up"
        ),
        relation(
            "rotation",
            "known",
            [bounce(1, "known", 0.013, known=offset), bounce(2, "pass")],
            notes=["one replicate dominates"],
        ),
        relation("homogeneity", "unsupported", [], message=f"not applicable: {SCRIPT}{CONTROL}"),
        relation("scaling", "error", [], message="exit code 139", log=["starting", f"]]> {SCRIPT}"]),
    ]
    changed = msgspec.structs.replace(results, relations=tried)
    write(changed, folder)
    return changed


@pytest.fixture
def with_relations(results: Results, tmp_path: Path) -> Results:
    return relations_too(results, tmp_path)


@pytest.fixture(scope="module")
def run_with_relations(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of such results for tests that change nothing in it."""
    folder = tmp_path_factory.mktemp("run-with-relations")
    relations_too(every_verdict(folder), folder)
    return folder


@pytest.fixture(scope="session")
def run_of_many(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of results of each comparison twice, for tests that change nothing in it."""
    folder = tmp_path_factory.mktemp("run-of-many")
    results = every_verdict(folder)
    write(msgspec.structs.replace(results, comparisons=results.comparisons * 2), folder)
    return folder


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of results for tests that change nothing in it."""
    folder = tmp_path_factory.mktemp("run")
    every_verdict(folder)
    return folder


@pytest.fixture(scope="session")
def page(run: Path) -> Page:
    """The report of that run."""
    return rendered(run)


@pytest.fixture(scope="session")
def many(run_of_many: Path) -> Path:
    """The file of the report of a run of each comparison twice."""
    path, _ = reports.render(run_of_many)
    return path


@pytest.fixture
def results(tmp_path: Path) -> Results:
    return every_verdict(tmp_path)


@pytest.fixture
def make_bounce() -> Callable[..., BounceResult]:
    return bounce


@pytest.fixture
def make_comparison() -> Callable[..., Comparison]:
    return comparison
