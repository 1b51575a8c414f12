"""Tables of pictures: truth, renderer and their difference, one column per bounce or per partial sum."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from PIL import Image as PillowImage

from comparisons.results import BounceResult
from reports import difference, exposure, quantities
from reports.exposure import Pixels
from reports.images import BounceImages


@dataclass(frozen=True)
class Marker:
    """A rectangle on a picture: its edges in percent of the picture's width and height, and what it marks."""

    left: float
    top: float
    width: float
    height: float
    meaning: str


@dataclass(frozen=True)
class Picture:
    """One picture of a gallery."""

    uri: str
    width: int
    height: int
    alt: str
    scale: str = ""
    """The end of the difference map, ``3.1 %``; empty for radiance."""
    marker: Marker | None = None
    chromaticity: str = ""
    """Of the mean of a spectral image, ``x 0.333, y 0.333``; empty for all others."""


@dataclass(frozen=True)
class Column:
    """The head of a column: what it shows, and the exposure both sides share, ``×2.0``."""

    term: str
    exposure: str


@dataclass(frozen=True)
class Gallery:
    """Columns, and rows with a name and one picture per column."""

    columns: list[Column]
    rows: list[tuple[str, list[Picture]]]


def of_bounces(
    images: BounceImages, bounces: list[BounceResult], term: Callable[[int], str] = quantities.term
) -> Gallery:
    """One column per term E, TE, T²E, …, with the difference also in units of its standard error.

    Args:
        images: both sides.
        bounces: what was found; the worst tile is marked in those that didn't pass.
        term: what each column is called.
    """
    whole = float(images.truth.sum(axis=0).mean())
    gallery = _compared(images, images.truth, images.renderer, term, whole)
    markers = {k: _marker(b, images.size) for k, b in enumerate(bounces) if b.verdict != "pass"}
    name, differences = gallery.rows[-1]
    marked = [replace(picture, marker=markers.get(k)) for k, picture in enumerate(differences)]
    rows = [*gallery.rows[:-1], (name, marked)]
    if images.renderer_error.any():
        rows.append(("difference ÷ standard error", _significance(images)))
    return Gallery(gallery.columns, rows)


def of_partial_sums(images: BounceImages) -> Gallery:
    """One column per partial sum E, E + TE, …."""
    truth, renderer = np.cumsum(images.truth, axis=0), np.cumsum(images.renderer, axis=0)
    return _compared(images, truth, renderer, quantities.partial_sum, float(truth[-1].mean()))


def _compared(
    images: BounceImages,
    truth: exposure.Image,
    renderer: exposure.Image,
    name: Callable[[int], str],
    whole: float,
) -> Gallery:
    """The three rows that both galleries have.

    Truth and renderer are ``(columns, height, width, channels)``; ``whole`` is the mean of the truth's whole sum,
    which dark columns are relative to.
    """
    shown, seen = images.shown(truth), images.shown(renderer)
    colours = [_chromaticities(images.chromaticity(side), len(truth)) for side in (truth, renderer)]
    columns: list[Column] = []
    rows: dict[str, list[Picture]] = {"truth": [], "renderer": [], "signed difference": []}
    for k, (theirs, ours) in enumerate(zip(renderer, truth, strict=True)):
        factor = exposure.automatic(shown[k], seen[k])
        columns.append(Column(name(k), f"×{quantities.number(factor)}"))
        for row, image, xy in (("truth", shown[k], colours[0][k]), ("renderer", seen[k], colours[1][k])):
            alt = f"{name(k)}, {row}, exposure ×{quantities.number(factor)}"
            rows[row].append(replace(_picture(exposure.encode(image, factor), alt), chromaticity=xy))
        field, is_relative = difference.relative(ours, theirs, whole)
        scale = difference.automatic_scale(field)
        text = quantities.percent(scale) if is_relative else quantities.number(scale)
        alt = f"{name(k)}, renderer minus truth, from −{text} in blue to +{text} in red"
        rows["signed difference"].append(_picture(difference.colours(field, scale), alt, text))
    return Gallery(columns, list(rows.items()))


def _chromaticities(xy: exposure.Image | None, count: int) -> list[str]:
    """The chromaticity of each of the images; empty where it is unknown, or there is no light to have one."""
    if xy is None:
        return [""] * count
    return [f"x {x:.3f}, y {y:.3f}" if np.isfinite(x) else "" for x, y in xy]


def _significance(images: BounceImages) -> list[Picture]:
    pictures = []
    sides = zip(images.truth, images.renderer, images.truth_error, images.renderer_error, strict=True)
    for k, (truth, renderer, truth_error, renderer_error) in enumerate(sides):
        field = difference.in_standard_errors(truth, renderer, truth_error, renderer_error)
        alt = f"{quantities.term(k)}, renderer minus truth in standard errors, from −4 in blue to +4 in red"
        pixels = difference.colours(field, difference.SIGMAS)
        pictures.append(_picture(pixels, alt, f"{difference.SIGMAS:g}"))
    return pictures


def _marker(bounce: BounceResult, size: tuple[int, int]) -> Marker:
    place, (width, height) = bounce.worst_tile.place, size
    return Marker(
        left=100 * place.x0 / width,
        top=100 * place.y0 / height,
        width=100 * (place.x1 - place.x0) / width,
        height=100 * (place.y1 - place.y0) / height,
        meaning=f"worst tile: {quantities.bias(bounce.worst_tile.bias, bounce.worst_tile.interval)}",
    )


def _picture(pixels: Pixels, alt: str, scale: str = "") -> Picture:
    height, width = pixels.shape[:2]
    file = io.BytesIO()
    PillowImage.fromarray(pixels).save(file, "WEBP", lossless=True)  # less than half of what a PNG takes
    uri = "data:image/webp;base64," + base64.b64encode(file.getvalue()).decode("ascii")
    return Picture(uri, width, height, alt, scale)
