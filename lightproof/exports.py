"""Writing a scene for another renderer: in which format, into which file, and over nothing that is the user's."""

from __future__ import annotations

from pathlib import Path

import typer

from lightproof.choice import Subject
from scenes import Scene, SceneError
from scenes.channels import single_channel
from scenes.formats.export import Export, Source
from scenes.formats.exporters import EXPORTERS, SUFFIXES

_MARK = b"lightproof"
_HEAD = 1000
"""Bytes at the beginning of a file, among which its header says who wrote it."""


def format_and_file(name: str, format: str | None, out: Path | None) -> tuple[str, Path]:
    """What is asked for: the format by its name, or by the suffix of the file, or else JSON.

    Raises:
        typer.BadParameter: a suffix of no format, or of another one.
    """
    if out is None:
        format = format or "json"
        return format, Path(f"{name}{SUFFIXES[format]}")
    found = out.suffix.lower()
    if format is None:
        format = next((known for known, suffix in SUFFIXES.items() if suffix == found), None)
    if format is None:
        expected = ", ".join(SUFFIXES.values())
        raise typer.BadParameter(f"{out}: expected a name that ends in one of {expected}", param_hint="--out")
    if found != SUFFIXES[format]:
        message = f"{out}: expected a name that ends in {SUFFIXES[format]}, as {format} needs"
        raise typer.BadParameter(message, param_hint="--out")
    return format, out


def one_channel(scene: Scene, channel: int | None) -> Scene:
    """The scene in one of its channels, or all of it.

    Raises:
        typer.BadParameter: there is no such channel, or no light in it.
    """
    if channel is None:
        return scene
    if channel >= scene.channels:
        message = f"{channel}: the scene has the channels 0 to {scene.channels - 1}"
        raise typer.BadParameter(message, param_hint="--channel")
    try:
        return single_channel(scene, channel)
    except SceneError:
        raise typer.BadParameter(f"{channel}: nothing emits in it", param_hint="--channel") from None


def made(subject: Subject, scene: Scene, channel: int | None, format: str, path: Path) -> Export:
    """The files.

    Args:
        subject: what is exported, for the header.
        scene: its scene, as it is to be written.
        channel: the only one of the subject's that the scene has; None for all.
        format: a name in ``EXPORTERS``.
        path: of the main file.

    Raises:
        UnsupportedFeatureError: naming what the format lacks, or means differently.
    """
    height, width, _ = scene.shape
    text = f"{subject.name}, {width}x{height} pixels"
    if channel is not None:
        text += f", channel {channel} of 0 to {subject.scene.channels - 1}"
    return EXPORTERS[format](scene, path.stem, Source(text, subject.bounces))


def refuse_to_overwrite(export: Export, path: Path) -> None:
    """Refuse if a file is there that this command has not written, main file or neighbour.

    A file of the same content does no harm. JSON has no header, so that a scene is never taken for ours: it may
    have been written by hand.

    Raises:
        typer.BadParameter: naming the file.
    """
    if path.is_file() and path.suffix.lower() != SUFFIXES["json"] and _MARK in path.read_bytes()[:_HEAD]:
        return  # ours, and so are its neighbours
    contents = {path: export.content} | {path.with_name(n): content for n, content in export.files.items()}
    for file, content in contents.items():
        if file.exists() and not (file.is_file() and file.read_bytes() == content):
            message = (
                f"{file} is there already, and may be your own: give another name, or move it away first"
            )
            raise typer.BadParameter(message, param_hint="--out")
