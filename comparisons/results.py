"""What a run found out: the schema of ``results.json``, its reader and its writer.

``results.json`` is the only truth of a run. The report, the JUnit file and the table in the terminal are
views of it, and anyone can read it: the JSON Schema lies beside this file as ``results.schema.json``.

All biases, intervals and tolerances are relative: a bias of 0.01 is one percent of the truth of its region.
A region's denominator is max(its truth, 5 % of the mean of that bounce's image); see
``comparisons.statistics.intervals``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta, Struct

SCHEMA_VERSION = "1.0"
RESULTS_FILE = "results.json"
SCHEMA_FILE = Path(__file__).with_name("results.schema.json")

BounceVerdict = Literal["pass", "fail", "inconclusive", "known"]
Verdict = Literal["pass", "fail", "inconclusive", "known", "unsupported", "error"]
DeclarationState = Literal["confirmed", "changed", "vanished", "tolerated", "undecided"]
Interval = tuple[float, float]
Operator = Literal["E", "G", "R", "series", "estimator", "sensor", "sampler"]


class Place(Struct, frozen=True, kw_only=True):
    """Where a tile lies: row and column in the grid of tiles, from 0, and its pixels [x0, x1) × [y0, y1)."""

    row: int
    column: int
    x0: int
    y0: int
    x1: int
    y1: int


class ChannelResult(Struct, frozen=True, kw_only=True):
    """One channel of one bounce, over the whole image."""

    channel: str
    truth_mean: float
    mean: float
    denominator: Annotated[float, Meta(description="what bias and interval are relative to")]
    bias: float
    interval: Interval
    simultaneous_interval: Interval
    standard_error: float
    detectable_bias: float
    resolution: float


class TileResult(Struct, frozen=True, kw_only=True):
    """The tile that lies furthest outside its tolerance, or closest to it."""

    place: Place
    channel: str
    bias: float
    interval: Interval
    simultaneous_interval: Interval
    detectable_bias: float


class KnownDeviation(Struct, frozen=True, kw_only=True):
    """A deviation that was declared beforehand in known.toml, held against what was measured."""

    declared_bias: Annotated[
        float, Meta(description="in the channel that is shown; 0 if nothing is declared of it")
    ]
    state: Annotated[
        DeclarationState,
        Meta(
            description="confirmed: measured to be what was declared; changed: neither that nor nothing; "
            "vanished: remove the entry; tolerated: the run's tolerance is too loose to tell; "
            "undecided: too few samples to tell"
        ),
    ]
    reason: str
    link: str


class BounceResult(Struct, frozen=True, kw_only=True):
    """One bounce: the numbers of the whole image in its worst channel, all channels, and the worst tile.

    ``interval`` decides a pass, ``simultaneous_interval`` a fail. ``detectable_bias`` and ``resolution`` are those
    of the channel in which they are largest.
    """

    bounce: int
    verdict: BounceVerdict
    decided_by: Annotated[
        Literal["image", "tile"],
        Meta(description="tile: the whole image alone would have passed; a tile made the verdict what it is"),
    ]
    channel: str
    truth_mean: float
    mean: float
    denominator: float
    bias: float
    interval: Interval
    simultaneous_interval: Interval
    standard_error: float
    tolerance: float
    tile_tolerance: float
    detectable_bias: float
    resolution: float
    look: Annotated[int, Meta(description="which look these numbers are from, 1 for the first")]
    replicates: int
    spp: Annotated[int, Meta(description="samples per pixel, over all replicates")]
    channels: list[ChannelResult]
    worst_tile: TileResult
    skewness: Annotated[float, Meta(description="of a replicate's mean over the image, in that channel")] = (
        0.0
    )
    dominance: Annotated[
        float,
        Meta(description="largest share of a region's squared deviations that a single replicate makes"),
    ] = 0.0
    p_values: Annotated[
        list[int],
        Meta(
            description="tiles and channels by the p-value of no bias, in ten bins from 0 to 1, each judged by "
            "itself; flat where there is no bias; those without noise are left out"
        ),
    ] = []
    known: KnownDeviation | None = None


class Metrics(Struct, frozen=True, kw_only=True):
    """Image metrics of one image; formulas: ``comparisons.metrics``. They inform, they never decide."""

    bounces: Annotated[int, Meta(description="which bounce, or the last one of the sum")]
    nrmse: float | None
    psnr: float | None
    ssim: float | None
    rmse: float | None = None
    rel_mse: float | None = None
    flip: Annotated[float | None, Meta(description="HDR-FLIP, mean over pixels")] = None
    delta_e: Annotated[float | None, Meta(description="CIEDE2000, mean over pixels")] = None


class Outlier(Struct, frozen=True, kw_only=True):
    """A single pixel that holds far more than its surroundings."""

    x: int
    y: Annotated[int, Meta(description="row 0 is the top")]
    channel: str
    value: float
    truth: float


class ResidualNoise(Struct, frozen=True, kw_only=True):
    """What the residuals of one image say of its noise; ``comparisons.statistics.residuals``."""

    correlation: Annotated[float, Meta(description="of neighbouring pixels' residuals")]
    correlation_error: Annotated[float, Meta(description="its standard error if they are independent")]
    reach: Annotated[
        int | None, Meta(description="pixels; 0: independent; null: noise and a smooth bias look alike")
    ]
    inflation: Annotated[float, Meta(description="of the variance of a tile's mean, by correlation")]
    outliers: int
    brightest_outliers: list[Outlier]


class Hint(Struct, frozen=True, kw_only=True):
    """What an image seems to have gone through; ``comparisons.hints``."""

    kinds: Annotated[
        list[str],
        Meta(description="of turned, encoded, exchanged, scaled, clipped, bounces, shifted, soft"),
    ]
    text: str


class SingleImage(Struct, frozen=True, kw_only=True):
    """A finished image from anywhere, held against a case without replicates; ``comparisons.single_image``."""

    file: str
    summed: Annotated[bool, Meta(description="it is the sum of all bounces up to that of its only entry")]
    independent: Annotated[
        bool, Meta(description="its pixels were said to be; what is smooth is a bias then")
    ]
    noise: Annotated[list[ResidualNoise], Meta(description="per bounce, or of the sum")]
    limits: Annotated[list[str], Meta(description="what can't be told from it")]
    hints: Annotated[list[str], Meta(description="what it may have gone through")] = []


class Images(Struct, frozen=True, kw_only=True):
    """EXR files, relative to the folder of results.json. Layers: ``scenes.formats.exr``."""

    truth: str
    renderer: str


class Look(Struct, frozen=True, kw_only=True):
    """One interim analysis: after so many replicates and seconds, at this level, these bounces stayed open."""

    replicates: Annotated[int, Meta(description="of the bounces that were open")]
    seconds: float
    alpha: float
    open_bounces: list[int]


class TotalResult(Struct, frozen=True, kw_only=True):
    """The sum of all bounces by the renderer's own defaults, held against Σ TᵏE; ``comparisons.total``."""

    verdict: Verdict
    scale: Annotated[float, Meta(description="s, of every albedo; the truth is Σ sᵏ TᵏE then")] = 1.0
    result: Annotated[
        BounceResult | None, Meta(description="of the sum; its bounce is the last one that the truth adds up")
    ] = None
    tail: Annotated[float, Meta(description="what later ones may hold, relative, where it is most")] = 0.0
    truth: Annotated[str, Meta(description="how the sum is known")] = ""
    seconds: float = 0.0
    looks: list[Look] = []
    message: Annotated[str, Meta(description="why there is no verdict")] = ""
    log: list[str] = []


class Comparison(Struct, frozen=True, kw_only=True):
    """One case held against one renderer."""

    case: str
    renderer: str
    verdict: Verdict
    truth: Literal["exact", "computed", "estimated"]
    seconds: float
    spp: Annotated[int, Meta(description="samples per pixel of the bounce that needed most")]
    replicates: Annotated[int, Meta(description="of the bounce that needed most")]
    bounces: list[BounceResult]
    title: str
    derivation: Annotated[str, Meta(description="why the truth is what it is")]
    blind_to: Annotated[str, Meta(description="what this case can't reveal")]
    renderer_version: str
    truth_source: Annotated[
        str, Meta(description="the formula's source, or the estimator that made the truth")
    ]
    width: int
    height: int
    channels: list[str]
    tiles: Annotated[tuple[int, int], Meta(description="rows and columns of the grid of tiles")]
    alpha: float
    looks: list[Look] = []
    metrics: Annotated[list[Metrics], Meta(description="of the partial sums E + TE + … + TⁿE")] = []
    term_metrics: Annotated[list[Metrics], Meta(description="of each term TᵏE by itself")] = []
    images: Images | None = None
    message: Annotated[str, Meta(description="why: the missing feature, the crash, the exhausted budget")] = (
        ""
    )
    log: Annotated[list[str], Meta(description="the last lines the renderer's process printed")] = []
    notes: list[str] = []
    features: Annotated[list[str], Meta(description="what the scene is made of; scenes.features")] = []
    hints: Annotated[
        list[Hint], Meta(description="what the sum of a failed comparison seems to have gone through")
    ] = []
    single_image: SingleImage | None = None
    totals: Annotated[
        list[TotalResult], Meta(description="one, or of a renderer without depth control several scales")
    ] = []


class RelationResult(Struct, frozen=True, kw_only=True):
    """One claim of a relation, tried on one scene with one renderer.

    In ``bounces`` the second side stands where a comparison has the truth: ``mean`` is that of the first side,
    ``truth_mean`` that of the second, and ``bias`` the deviation of the first, relative to the second.
    """

    relation: str
    claim: Annotated[str, Meta(description="which, of a relation that claims several; else empty")]
    scene: str
    renderer: str
    verdict: Verdict
    operator: Annotated[str, Meta(description="what it tests: E, G, R, T, sensor or estimator")]
    statement: str
    blind_to: Annotated[str, Meta(description="what this relation can't reveal")]
    renderer_version: str
    channels: list[str]
    alpha: float
    seconds: float
    spp: Annotated[
        int, Meta(description="samples per pixel of each side, in the bounce that needed most")
    ] = 0
    replicates: Annotated[int, Meta(description="of the bounce that needed most")] = 0
    bounces: Annotated[
        list[BounceResult], Meta(description="empty where no statistics decide, or nothing was compared")
    ] = []
    looks: list[Look] = []
    message: Annotated[
        str, Meta(description="what was found where no statistics decide; why not, otherwise")
    ] = ""
    log: Annotated[list[str], Meta(description="the last lines the renderer's process printed")] = []
    notes: list[str] = []


class Diagnosis(Struct, frozen=True, kw_only=True):
    """What is most likely at fault in a renderer that failed; ``comparisons.diagnosis``."""

    renderer: str
    suspect: Annotated[
        Operator | None, Meta(description="null: can't tell; what comes nearest is in also_possible")
    ]
    sentence: Annotated[str, Meta(description="the suspect, with the strongest evidence")]
    evidence: Annotated[list[str], Meta(description="all that was weighed, the strongest first")]
    also_possible: list[Operator] = []
    next_case: Annotated[str, Meta(description="the cheapest case that would tell more; empty: none")] = ""


class Provenance(Struct, frozen=True, kw_only=True):
    """What is needed to repeat the run."""

    date: Annotated[str, Meta(description="ISO 8601, UTC")]
    command_line: list[str]
    versions: Annotated[dict[str, str | None], Meta(description="null: not installed")]
    platform: str
    processors: int
    seed: int
    seeds: Annotated[str, Meta(description="how the seeds of the replicates follow from the seed")]
    budget: Annotated[float, Meta(description="seconds per case × renderer")]
    alpha: float
    jobs: int
    seconds: Annotated[float, Meta(description="wall-clock time of the whole run")]


class Results(Struct, frozen=True, kw_only=True):
    """The content of results.json."""

    version: str = SCHEMA_VERSION
    provenance: Provenance
    comparisons: list[Comparison]
    relations: Annotated[
        list[RelationResult], Meta(description="checks that need no truth and no second renderer")
    ] = []
    diagnoses: Annotated[list[Diagnosis], Meta(description="one for each renderer that failed")] = []


class ResultsError(ValueError):
    """A results.json that can't be read: missing, damaged, or of another version."""


def schema() -> dict[str, Any]:
    """The JSON Schema (2020-12) of results.json."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **msgspec.json.schema(Results)}


def write(results: Results, folder: Path) -> Path:
    """Write ``results.json`` into the folder and return its path.

    Raises:
        ResultsError: a number is NaN or infinite: JSON has none, and no reader could read it.
    """
    content = msgspec.json.encode(results)
    try:
        msgspec.json.decode(content, type=Results)
    except msgspec.ValidationError as error:
        raise ResultsError(f"a number that is not finite: {error}") from None
    path, partial = folder / RESULTS_FILE, folder / f"{RESULTS_FILE}.partial"
    partial.write_bytes(msgspec.json.format(content, indent=2) + b"\n")
    partial.replace(path)  # a run that is killed leaves the file of the last comparison, whole
    return path


def read(folder: Path) -> Results:
    """Read the folder's ``results.json``.

    Raises:
        ResultsError: there is none, it is no valid JSON, or its version is not the one this program reads.
    """
    path = folder / RESULTS_FILE
    try:
        content = path.read_bytes()
    except OSError as error:
        raise ResultsError(
            f"{path}: {error.strerror}. Expected a folder written by 'lightproof validate'"
        ) from error
    try:
        version = msgspec.json.decode(content, type=dict[str, msgspec.Raw]).get(
            "version", msgspec.Raw(b"null")
        )
        if (found := msgspec.json.decode(version)) != SCHEMA_VERSION:
            raise ResultsError(
                f"{path}: version {found!r}, expected {SCHEMA_VERSION!r}. Run 'lightproof validate' again"
            )
        return msgspec.json.decode(content, type=Results)
    except msgspec.DecodeError as error:
        raise ResultsError(f"{path}: {error}") from error


def write_schema() -> None:
    """Write the schema beside this file; ``make schema``."""
    SCHEMA_FILE.write_bytes(msgspec.json.format(msgspec.json.encode(schema()), indent=2) + b"\n")


if __name__ == "__main__":
    write_schema()
