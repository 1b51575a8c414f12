"""Images that programs have written, as they stand in their files: scene-linear, row 0 at the top, unclamped.

OpenImageIO reads them: EXR, PFM, float TIFF, Radiance HDR. Integers are refused, since they are rounded, clipped and
encoded for a screen. How coarse the numbers of a file are is told: a difference of two coarse images is no bounce.
"""

from __future__ import annotations

from pathlib import Path

from comparisons.renderers.finite import check_finite
from comparisons.renderers.protocol import RendererFailed
from scenes.formats import finished
from scenes.formats.exr import ImageError
from scenes.formats.finished import Finished

FORMATS = ("openexr", "pnm", "tiff", "hdr")


def read(path: Path, layers: bool, shape: tuple[int, int, int]) -> Finished:
    """Read a picture, or one per bounce.

    Args:
        path: the file.
        layers: whether it has a layer or a part per bounce, ``bounce0``, ``bounce1``, …
        shape: (height, width, channels) as asked for. A single channel may come as R, G and B, whose mean counts:
            formats that know colours only have grey scenes.

    Raises:
        RendererFailed: there is no file, no image in it, or another one than was asked for.
    """
    if not path.is_file():
        raise RendererFailed(f"wrote no image: expected it at {{output}}, {path}")
    height, width, channels = shape
    wanted = 3 if channels == 1 else channels
    try:
        found = finished.read(path, layers, wanted, FORMATS)
    except ImageError as error:
        raise RendererFailed(f"wrote something else than the image that was asked for: {error}") from None
    images = found.images
    if images.shape[1:3] != (height, width):
        size = f"{images.shape[2]}x{images.shape[1]}"
        raise RendererFailed(f"wrote an image of {size} pixels, expected {width}x{height}")
    if channels == 1 and images.shape[-1] == 3:
        images = images.mean(axis=-1, keepdims=True)
    if images.shape[-1] != channels:
        raise RendererFailed(f"wrote an image of {images.shape[-1]} channels, expected {channels}")
    check_finite(images, "wrote")
    return Finished(images, found.summed, found.rounding)
