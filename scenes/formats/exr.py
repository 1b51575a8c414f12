"""Bounce images in one EXR file: a layer per bounce, mean and standard error.

Layer ``bounce2`` holds the mean of T²E, ``bounce2.stderr`` its standard error; a channel is named after its
layer (``bounce2.R``, ``bounce2.stderr.R``). 32-bit floats, scene-linear, row 0 at the top.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from numpy.typing import NDArray

Images = NDArray[np.float64]


class ImageError(ValueError):
    """A file that does not hold bounce images."""


def channel_names(channels: int) -> list[str]:
    """``R, G, B`` for three channels, ``Y`` for one, else ``C0, C1, …``."""
    return {1: ["Y"], 3: ["R", "G", "B"]}.get(channels) or [f"C{i}" for i in range(channels)]


def write_bounces(
    path: Path, mean: Images, stderr: Images | None = None, attributes: Mapping[str, str] | None = None
) -> None:
    """Write bounce images.

    Args:
        path: the file to make; its folder must exist.
        mean: radiance, ``(bounces + 1, height, width, channels)``.
        stderr: its standard error, of the same shape; left out where there is none.
        attributes: texts for the header of the file.

    Raises:
        ImageError: the file can't be written.
    """
    bounces, height, width, channels = mean.shape
    names, layers = [], []
    for k in range(bounces):
        for suffix, image in (("", mean), (".stderr", stderr)):
            if image is not None:
                names += [f"bounce{k}{suffix}.{c}" for c in channel_names(channels)]
                layers.append(image[k])
    pixels = np.ascontiguousarray(np.concatenate(layers, axis=-1), dtype=np.float32)

    spec = oiio.ImageSpec(width, height, len(names), oiio.FLOAT)
    spec.channelnames = names
    spec.attribute("compression", "zip")
    for name, text in (attributes or {}).items():
        spec.attribute(name, text)
    out = oiio.ImageOutput.create(str(path))
    if out is None or not out.open(str(path), spec) or not out.write_image(pixels) or not out.close():
        raise ImageError(f"{path}: can't be written: {oiio.geterror() if out is None else out.geterror()}")


def read_bounces(path: Path) -> tuple[Images, Images]:
    """Read what ``write_bounces`` wrote.

    Returns:
        Mean and standard error, each ``(bounces + 1, height, width, channels)``; the error is 0 where the
        file has none.

    Raises:
        ImageError: no such file, no EXR, or no layers ``bounce0 …`` in it.
    """
    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise ImageError(f"{path}: can't be read: {oiio.geterror()}")
    names, pixels = list(source.spec().channelnames), source.read_image(oiio.FLOAT)
    source.close()
    if pixels is None:
        raise ImageError(f"{path}: its pixels can't be read; the file is incomplete")
    values = np.asarray(pixels, dtype=np.float64)

    bounces = {name.split(".")[0] for name in names if name.startswith("bounce")}
    if bounces != {f"bounce{k}" for k in range(len(bounces))} or not bounces:
        raise ImageError(
            f"{path}: expected layers bounce0, bounce1, …; found channels {', '.join(names[:8])}"
        )
    ordered = [f"bounce{k}" for k in range(len(bounces))]
    try:
        mean = np.stack([_layer(values, names, layer) for layer in ordered])
        if not any(".stderr." in name for name in names):
            return mean, np.zeros_like(mean)
        return mean, np.stack([_layer(values, names, f"{layer}.stderr") for layer in ordered])
    except ValueError as error:  # its own, or layers with different numbers of channels
        raise ImageError(f"{path}: {error}") from None


def read_attribute(path: Path, name: str) -> str:
    """A text in the header of the file, empty if it has none of that name.

    Raises:
        ImageError: no such file, or no EXR.
    """
    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise ImageError(f"{path}: can't be read: {oiio.geterror()}")
    text = str(source.spec().getattribute(name) or "")
    source.close()
    return text


def _layer(values: Images, names: Sequence[str], layer: str) -> Images:
    """The channels of one layer, ``(height, width, channels)``, in the order R, G, B or C0, C1, …."""
    found = {name.rpartition(".")[2]: i for i, name in enumerate(names) if name.rpartition(".")[0] == layer}
    # a file lists its channels in alphabetical order, so their names put them back into ours
    expected = channel_names(len(found) or 1)
    if set(found) != set(expected):
        text = ", ".join(found) or "none"
        raise ImageError(f"layer {layer}: expected channels {', '.join(expected)}; found {text}")
    return values[..., [found[c] for c in expected]]
