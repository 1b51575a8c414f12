"""Bounce images in one EXR file: a layer per bounce, mean and standard error.

Layer ``bounce2`` holds the mean of T²E, ``bounce2.stderr`` its standard error; a channel is named after its
layer (``bounce2.R``, ``bounce2.stderr.R``). 32-bit floats, scene-linear, row 0 at the top.

Within a layer, channels that are wavelengths have the names of Fichet et al., An OpenEXR Layout for Spectral
Images, JCGT 10(3), 2021: ``bounce2.S0.550,5nm``. Beside them, as there, the layer of a mean has a picture in linear
sRGB, R, G and B, for programs that show no spectra; reading leaves it out.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from numpy.typing import NDArray

from scenes.channels import channel_names, check_wavelengths

Images = NDArray[np.float64]

_WAVELENGTH = re.compile(r"S0\.(\d+(?:,\d+)?)nm")


class ImageError(ValueError):
    """A file that does not hold bounce images."""


def write_bounces(
    path: Path,
    mean: Images,
    stderr: Images | None = None,
    attributes: Mapping[str, str] | None = None,
    wavelengths: Sequence[float] | None = None,
) -> None:
    """Write bounce images.

    Args:
        path: the file to make; its folder must exist.
        mean: radiance, ``(bounces + 1, height, width, channels)``.
        stderr: its standard error, of the same shape; left out where there is none.
        attributes: texts for the header of the file.
        wavelengths: of the channels, nm, as in ``Case.wavelengths``; None where they are R, G, B, or just numbers.

    Raises:
        ImageError: the file can't be written.
    """
    bounces, height, width, channels = mean.shape
    own = _stored_names(channels, wavelengths)
    parts = [("", own, mean)]
    if stderr is not None:
        parts.append((".stderr", own, stderr))
    if wavelengths is not None:
        from scenes.spectral import linear_srgb  # takes a third of a second, and few images need it

        parts.append(("", channel_names(3), linear_srgb(mean, wavelengths)))
    names = [f"bounce{k}{suffix}.{c}" for k in range(bounces) for suffix, own, _ in parts for c in own]
    layers = [images[k] for k in range(bounces) for _, _, images in parts]
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
    source = _opened(path)
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
        if len({tuple(_wavelengths(names, layer)) for layer in ordered}) > 1:
            raise ValueError("its layers have different wavelengths")
        mean = np.stack([_layer(values, names, layer) for layer in ordered])
        if not any(".stderr." in name for name in names):
            return mean, np.zeros_like(mean)
        return mean, np.stack([_layer(values, names, f"{layer}.stderr") for layer in ordered])
    except ValueError as error:  # its own, or layers with different numbers of channels
        raise ImageError(f"{path}: {error}") from None


def read_wavelengths(path: Path) -> tuple[float, ...] | None:
    """The wavelengths of the channels of ``read_bounces``, nm; None where the file has others.

    Raises:
        ImageError: no such file, or no EXR; or the wavelengths are not such as a case can have.
    """
    source = _opened(path)
    found = tuple(_wavelengths(source.spec().channelnames, "bounce0"))
    source.close()
    try:
        if found:
            check_wavelengths(found, len(found))
    except ValueError as error:
        raise ImageError(f"{path}: {error}") from None
    return found or None


def read_attribute(path: Path, name: str) -> str:
    """A text in the header of the file, empty if it has none of that name.

    Raises:
        ImageError: no such file, or no EXR.
    """
    source = _opened(path)
    text = str(source.spec().getattribute(name) or "")
    source.close()
    return text


def cause(error: str) -> str:
    """What OpenImageIO says first: what follows from it repeats the path, line by line."""
    return error.partition("\n")[0]


def _opened(path: Path) -> oiio.ImageInput:
    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise ImageError(f"{path}: can't be read: {cause(oiio.geterror())}")
    return source


def _stored_names(channels: int, wavelengths: Sequence[float] | None) -> list[str]:
    """What channels are called within their layer."""
    if wavelengths is None:
        return channel_names(channels)
    return ["S0." + f"{w:.9g}nm".replace(".", ",") for w in wavelengths]


def _wavelengths(names: Sequence[str], layer: str) -> dict[float, str]:
    """The wavelengths of a layer, nm, ascending, and the names of their channels."""
    found = ((_WAVELENGTH.fullmatch(name.removeprefix(f"{layer}.")), name) for name in names)
    return dict(sorted((float(m[1].replace(",", ".")), name) for m, name in found if m))


def _layer(values: Images, names: Sequence[str], layer: str) -> Images:
    """The channels of one layer, ``(height, width, channels)``, by wavelength, or as ``channel_names`` has them."""
    if spectral := _wavelengths(names, layer):
        return values[..., [names.index(name) for name in spectral.values()]]
    found = {name.rpartition(".")[2]: i for i, name in enumerate(names) if name.rpartition(".")[0] == layer}
    # a file lists its channels in alphabetical order, so their names put them back into ours
    expected = channel_names(len(found) or 1)
    if set(found) != set(expected):
        text = ", ".join(found) or "none"
        raise ImageError(f"layer {layer}: expected channels {', '.join(expected)}; found {text}")
    return values[..., [found[c] for c in expected]]
