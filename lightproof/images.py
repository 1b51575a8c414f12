"""Images that ``lightproof render`` and ``lightproof answer`` write: where to, over nothing that is the user's."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import typer

from lightproof.parameters import size
from scenes import Scene, SceneError
from scenes.formats import exr

SOURCE = "lightproof:source"
"""The name of the header's text that says how an image was made; that it is there says who wrote it."""


def exr_file(path: Path) -> Path:
    """The file to be written, before any time is spent on its content.

    Raises:
        typer.BadParameter: no name of an EXR file, no folder, or a file that this command has not written.
    """
    if path.suffix != ".exr":
        raise typer.BadParameter(f"{path}: expected a name that ends in .exr", param_hint="--out")
    in_a_folder(path)
    if path.exists() and not _ours(path):
        message = f"{path} is there already, and may be your own: give another name, or move it away first"
        raise typer.BadParameter(message, param_hint="--out")
    return path


def _ours(path: Path) -> bool:
    try:
        return bool(exr.read_attribute(path, SOURCE))
    except exr.ImageError:  # no image at all
        return False


def in_a_folder(path: Path) -> Path:
    """The same path.

    Raises:
        typer.BadParameter: its folder does not exist.
    """
    if not path.resolve().parent.is_dir():
        raise typer.BadParameter(
            f"{path}: there is no folder {path.parent}; make it first", param_hint="--out"
        )
    return path


def resized(scene: Scene, size_text: str | None) -> Scene:
    """The scene at the resolution that is asked for, or as it is.

    Raises:
        typer.BadParameter: no such resolution, or none that its sensor can have.
    """
    resolution = size(size_text)
    try:
        return scene.resized(*resolution) if resolution else scene
    except SceneError as error:
        raise typer.BadParameter(str(error), param_hint="--size") from None


def header(source: str, name: str, scene: Scene) -> dict[str, str]:
    """What the header of an image says: how it was made, and of which scene, as those of exported scenes do."""
    height, width, _ = scene.shape
    which = {"lightproof:scene": f"{name}, {width}x{height} pixels", "lightproof:sha256": scene.sha256}
    return {SOURCE: source, **which}


def written(path: Path, last: int, wavelengths: Sequence[float] | None, replaced: bool) -> str:
    """What the file holds, as a line for the user."""
    text = f"{path}: layers bounce0 to bounce{last}"
    if wavelengths is not None:
        ends = f"{wavelengths[0]:g} to {wavelengths[-1]:g} nm"
        text += f", each of {len(wavelengths)} wavelengths from {ends} and a picture in linear sRGB"
    return text + (", in place of an earlier image" if replaced else "")
