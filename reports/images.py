"""The bounce images of a comparison: read, checked against each other, and made small enough for a page."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from comparisons.results import Images
from scenes.formats import exr

_LARGEST = 256  # pixels of a side; a page shows 160


class MissingImagesError(Exception):
    """Images that a report can't show; the message says why."""


@dataclass(frozen=True)
class BounceImages:
    """Both sides of a comparison, radiance, each array ``(bounces + 1, height, width, channels)``."""

    truth: exr.Images
    truth_error: exr.Images
    renderer: exr.Images
    renderer_error: exr.Images
    reduction: int
    """Each pixel here is the average of reduction × reduction pixels of the files."""
    size: tuple[int, int]
    """Width and height of the files, pixels."""
    wavelengths: tuple[float, ...] | None
    """Of the channels, nm; None where they are R, G, B, or just numbers."""

    def shown(self, radiance: exr.Images) -> exr.Images:
        """Radiance as a picture shows it, ``(…, channels)``: wavelengths in linear sRGB, others as they are."""
        if self.wavelengths is None:
            return radiance
        from scenes.spectral import linear_srgb  # takes half a second, and few images have wavelengths

        return linear_srgb(radiance, self.wavelengths)

    def chromaticity(self, radiance: exr.Images) -> exr.Images | None:
        """CIE x, y of the mean of each image, ``(images, 2)``; None where channels are no wavelengths."""
        if self.wavelengths is None:
            return None
        from scenes.spectral import chromaticity, to_xyz  # as above

        return chromaticity(to_xyz(radiance.mean(axis=(1, 2)), self.wavelengths))


def read(folder: Path, images: Images) -> BounceImages:
    """Read the two files of a comparison.

    Args:
        folder: the folder of results.json.
        images: the files' names, relative to it.

    Raises:
        MissingImagesError: a file is missing or damaged, or the two don't fit each other.
    """
    truth, truth_error, wavelengths = _read(folder / images.truth)
    renderer, renderer_error, others = _read(folder / images.renderer)
    truth, truth_error = (part[: len(renderer)] for part in (truth, truth_error))  # a renderer may stop early
    if truth.shape != renderer.shape:
        raise MissingImagesError(f"The truth holds {_shape(truth)}, the renderer's file {_shape(renderer)}.")
    if wavelengths != others:
        raise MissingImagesError("The channels of the two files are different wavelengths.")
    height, width = truth.shape[1:3]
    n = -(-max(height, width) // _LARGEST)
    return BounceImages(
        truth=_averaged(truth, n),
        truth_error=np.sqrt(_averaged(truth_error**2, n)) / n,
        renderer=_averaged(renderer, n),
        renderer_error=np.sqrt(_averaged(renderer_error**2, n)) / n,
        reduction=n,
        size=(width, height),
        wavelengths=wavelengths,
    )


def _read(path: Path) -> tuple[exr.Images, exr.Images, tuple[float, ...] | None]:
    """Mean, standard error, and the wavelengths of their channels."""
    try:
        return *exr.read_bounces(path), exr.read_wavelengths(path)
    except (LookupError, ValueError, OSError) as error:  # a damaged file may break at any of its parts
        raise MissingImagesError(str(error) or f"{path}: can't be read") from error


def _shape(images: exr.Images) -> str:
    bounces, height, width, channels = images.shape
    return f"{bounces} bounces of {width} × {height} pixels in {channels} channels"


def _averaged(images: exr.Images, n: int) -> exr.Images:
    """Averages over blocks of n × n pixels; the last block of a row or column may be smaller."""
    for axis in (1, 2) if n > 1 else ():
        starts = np.arange(0, images.shape[axis], n)
        lengths = np.diff(starts, append=images.shape[axis])
        shape = [-1 if i == axis else 1 for i in range(images.ndim)]
        images = np.add.reduceat(images, starts, axis=axis) / lengths.reshape(shape)
    return images
