"""The options of the command line: what they are called, what they mean, what they must be."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Literal

import typer

from comparisons.truth import BATCHES

Cases = Annotated[
    list[str] | None,
    typer.Argument(metavar="[CASE]...", help="See 'lightproof list cases'. Default: a few of them."),
]
Subject = Annotated[
    str | None,
    typer.Argument(metavar="CASE", help="See 'lightproof list cases'. Or a scene, my-scene.json."),
]
Answered = Annotated[
    str | None,
    typer.Argument(
        metavar="CASE", help="See 'lightproof list cases'. Or a scene, my-scene.json, to be estimated."
    ),
]
Own = Annotated[
    str | None,
    typer.Option(
        "--case", metavar="FILE.py:NAME", help="A case of your own: a function that returns a Case."
    ),
]
Owns = Annotated[
    list[str] | None,
    typer.Option(
        "--case",
        metavar="FILE.py:NAME",
        help="A case of your own: a function that returns a Case. May be given several times.",
    ),
]
Families = Annotated[
    list[str] | None,
    typer.Option(
        "--family",
        metavar="NAME",
        help="All cases of a family, as 'lightproof list cases' and docs/cases call it. May be given "
        "several times.",
    ),
]
Everything = Annotated[bool, typer.Option("--all", help="All cases.")]
SceneFile = Annotated[
    Path | None,
    typer.Option(
        "--scene",
        metavar="FILE.json",
        help="A scene of your own, with its --answer; for --relations without.",
    ),
]
AnswerFile = Annotated[
    Path | None,
    typer.Option("--answer", metavar="FILE.exr", help="The answer of --scene: layers bounce0, bounce1, …"),
]
Format = Annotated[
    Literal["json", "mitsuba-xml", "pbrt-v4", "gltf"] | None,
    typer.Option("--format", help="What to write. Default: by the suffix of --out, else json."),
]
Channel = Annotated[
    int | None, typer.Option(help="Only this channel, from 0, as a grey scene. Default: all.", min=0)
]
ExportFile = Annotated[
    Path | None,
    typer.Option("--out", metavar="FILE", help="Default: CASE with the format's usual suffix."),
]
TruthFile = Annotated[
    Path | None, typer.Option("--out", metavar="FILE.exr", help="Default: CASE-answer.exr.")
]
Renderers = Annotated[
    list[str] | None,
    typer.Option("--renderer", help="May be given several times. Default: reference and mitsuba."),
]
Bounces = Annotated[
    int | None, typer.Option(help="Last bounce: 0 is E, 1 direct light. Default: the case's.", min=0)
]
Tolerance = Annotated[
    str | None,
    typer.Option(
        metavar="PERCENT[,…]",
        help="Largest bias of the whole image, as 0.5%, or bounce by bounce, as 0.2%,0.5%,1% (the last one "
        "holds for all later ones). Default: the case's.",
    ),
]
TileTolerance = Annotated[
    str | None, typer.Option(metavar="PERCENT[,…]", help="The same for tiles, as 2%. Default: the case's.")
]
Alpha = Annotated[
    float, typer.Option(help="Probability of a wrong verdict, per comparison.", min=1e-12, max=0.5)
]
Budget = Annotated[
    float,
    typer.Option(
        metavar="SECONDS",
        help="Time per case × renderer; less where the verdict is clear sooner.",
        min=0.001,
        max=1e6,
    ),
]
EarlyStop = Annotated[
    bool,
    typer.Option(
        "--early-stop/--no-early-stop",
        help="Stop when the verdict is clear, or spend the whole budget to resolve as small a bias as possible.",
    ),
]
Total = Annotated[
    bool,
    typer.Option(
        "--total/--no-total",
        help="Also hold each renderer's own sum of all bounces, by its defaults (unlimited depth, Russian roulette), "
        "against the truth; takes up to half of the budget more.",
    ),
]
Size = Annotated[str | None, typer.Option("--size", metavar="WxH", help="Resolution. Default: the case's.")]
Relations = Annotated[
    bool | None,
    typer.Option(
        "--relations/--no-relations",
        help="Checks that need no answer, see 'lightproof list relations', instead of comparisons; or none of them. "
        "Default: a few of them beside the default cases.",
    ),
]
RelationNames = Annotated[
    list[str] | None,
    typer.Option(
        "--relation", metavar="NAME", help="Only this one; implies --relations. May be given several times."
    ),
]
Seed = Annotated[int, typer.Option(help="Different seeds give independent images.", min=0, max=2**32 - 1)]
Spp = Annotated[int, typer.Option(help="Samples per pixel.", min=1)]
EstimateSpp = Annotated[
    int | None,
    typer.Option(
        "--spp",
        help="Of a scene: samples per pixel in all its batches, whose spread is the standard error. Default: what "
        "makes 67 million paths, some minutes.",
        min=BATCHES,
    ),
]
Jobs = Annotated[
    int | None,
    typer.Option(help="Processes that render at the same time. Default: one per processor.", min=1, max=1024),
]
Known = Annotated[
    str,
    typer.Option(
        metavar="FILE",
        help="Declared deviations (TOML) of our cases, or of your own in this run, besides the shipped ones; 'none' "
        "for none at all. Example: comparisons/known.toml.",
    ),
]
OutFolder = Annotated[
    Path,
    typer.Option("--out", metavar="DIR", help="Folder for results.json, report.html, junit.xml and images."),
]
FinishedImage = Annotated[
    Path, typer.Argument(metavar="IMAGE.exr", help="Channels R, G, B or Y, scene-linear; see also --layers.")
]
OfCase = Annotated[
    str,
    typer.Option(
        "--case", metavar="NAME", help="See 'lightproof list cases'; or one of your own, FILE.py:NAME."
    ),
]
Layers = Annotated[
    bool,
    typer.Option(
        "--layers", help="The file has layers bounce0, bounce1, …, as 'lightproof answer' writes them."
    ),
]
Independent = Annotated[
    bool,
    typer.Option(
        "--independent",
        help="Its pixels are: no denoiser, no filter but the box. Whatever is smooth counts as a bias then.",
    ),
]
ReportFolder = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help="Folder for results.json, report.html, junit.xml and images."),
]
OutFile = Annotated[
    Path | None, typer.Option("--out", metavar="FILE.exr", help="Default: CASE-RENDERER.exr.")
]


def _print_version(asked: bool) -> None:
    if asked:
        typer.echo(version("lightproof"))
        raise typer.Exit


Version = Annotated[
    bool, typer.Option("--version", help="Show the version and exit.", callback=_print_version, is_eager=True)
]
AsJson = Annotated[bool, typer.Option("--json", help="For programs.")]
