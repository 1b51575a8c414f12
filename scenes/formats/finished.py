"""A finished image: one picture in an EXR file, from any program.

Its channels are ``R, G, B`` (or ``Y``, or what ``channel_names`` calls those of a case), scene-linear; alone, or in
one layer, ``ViewLayer.Combined.R``. Or it has a layer per bounce, as ``lightproof answer`` writes them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

from scenes.channels import channel_names
from scenes.formats.exr import ImageError, Images, cause, read_bounces

_LINEAR = "Save the linear image as EXR, with 16- or 32-bit floats"


_OR_LAYERS = ' Did you mean --layers, or images = "layers" in a configuration?'


@dataclass(frozen=True)
class Finished:
    """What is in the file.

    Attributes:
        images: radiance, ``(1 or bounces + 1, height, width, channels)``.
        summed: whether there is one image, the sum of all bounces.
        rounding: the largest relative error by which its numbers were rounded.
    """

    images: Images
    summed: bool
    rounding: float


def read(path: Path, layers: bool, channels: int, formats: Collection[str] = ("openexr",)) -> Finished:
    """Read a finished image.

    Args:
        path: the file.
        layers: whether it has a layer per bounce, or, in an EXR file, a part.
        channels: how many are expected; Y alone will do too.
        formats: those that will do, as OpenImageIO calls them; of each of them only floats.

    Raises:
        ImageError: no such file, another format, other channels, or only a part of the picture.
    """
    if not path.is_file():
        raise ImageError(f"{path}: there is no such file" if not path.exists() else f"{path} is no file")
    upright = oiio.ImageSpec()
    upright.attribute("pnm:pfmflip", 1)  # a PFM begins with its last row, and is read so unless one asks
    source = oiio.ImageInput.open(str(path), upright)
    if source is None:
        raise ImageError(f"{path}: expected an EXR file; it can't be read: {cause(oiio.geterror())}")
    try:
        _check_format(path, source, formats)
        if layers:
            named = _named_parts(source)
            images = _read_parts(path, source, named, channels) if named else read_bounces(path)[0]
            return Finished(images, False, _rounding(source))
        return _read_sum(path, source, channels)
    finally:
        source.close()


def _check_format(path: Path, source: oiio.ImageInput, formats: Collection[str]) -> None:
    name, pixels = source.format_name(), source.spec().format
    integers = str(pixels).startswith(("uint", "int"))
    if name not in formats or (integers and name != "openexr"):
        why = (
            f"a {name} file of {8 * pixels.size()}-bit integers, rounded, clipped at white and encoded for a screen: "
            "it says nothing certain about radiance"
            if integers
            else f"a {name} file"
        )
        raise ImageError(f"{path}: expected EXR, found {why}. {_LINEAR}")
    spec = source.spec()
    data, display = (
        (spec.x, spec.y, spec.width, spec.height),
        (spec.full_x, spec.full_y, spec.full_width, spec.full_height),
    )
    if data != display or spec.deep:
        found = (
            "deep samples"
            if spec.deep
            else f"a data window of {spec.width}x{spec.height} pixels from ({spec.x}, {spec.y}) in a display window "
            f"of {spec.full_width}x{spec.full_height}"
        )
        raise ImageError(f"{path}: expected all pixels of one flat picture, found {found}")


def _read_sum(path: Path, source: oiio.ImageInput, channels: int) -> Finished:
    """The picture among all parts and layers; the one without a layer's name comes first."""
    found = list(_pictures(source, [channel_names(channels), ["Y"]]))
    unnamed = [picture for picture in found if not picture[1]]
    if not unnamed and len(found) != 1:
        names = [name for part in _parts(source) for name in part.channelnames]
        shown = ", ".join(names[:8]) + (", …" if len(names) > 8 else "")
        wanted = ", ".join(channel_names(channels)[:3]) + (", …" if channels > 3 else "")
        several = f"; more than one layer has them: {', '.join(p[1] for p in found)}" if found else ""
        layered = _OR_LAYERS if any(name.startswith("bounce") for name in names) else ""
        raise ImageError(f"{path}: expected channels {wanted}, or Y; found {shown}{several}.{layered}")
    if len(unnamed) > 1:
        parts = [str(part.getattribute("oiio:subimagename") or "") for part in _parts(source)]
        named = ", ".join(parts[part] for part, *_ in unnamed)
        layered = _OR_LAYERS if all(part.startswith("bounce") for part in parts) else ""
        raise ImageError(f"{path}: expected one picture; found one in each of the parts {named}.{layered}")
    part, layer, names = (unnamed or found)[0]
    source.seek_subimage(part, 0)
    spec, pixels = source.spec(), source.read_image(oiio.FLOAT)
    if pixels is None:
        raise ImageError(
            f"{path}: its pixels can't be read; the file is incomplete: {cause(source.geterror())}"
        )
    order = [spec.channelnames.index(f"{layer}.{name}" if layer else name) for name in names]
    values = np.asarray(pixels, dtype=np.float64).reshape(spec.height, spec.width, -1)[..., order]
    return Finished(values[None], True, _rounding(source))


def _parts(source: oiio.ImageInput) -> Iterator[oiio.ImageSpec]:
    part = 0
    while source.seek_subimage(part, 0):
        yield source.spec()
        part += 1


def _pictures(source: oiio.ImageInput, wanted: list[list[str]]) -> Iterator[tuple[int, str, list[str]]]:
    """Which part and layer has all of these channels: the first of the wanted lists that any has."""
    specs = list(_parts(source))
    for names in wanted:
        found = False
        for part, spec in enumerate(specs):
            has = set(spec.channelnames)
            for layer in dict.fromkeys(name.rpartition(".")[0] for name in spec.channelnames):
                if all((f"{layer}.{name}" if layer else name) in has for name in names):
                    found = True
                    yield part, layer, names
        if found:
            return


def _named_parts(source: oiio.ImageInput) -> dict[str, int]:
    """Parts of an EXR file that are called as bounces are, where it has more than one part."""
    names = [str(spec.getattribute("oiio:subimagename") or "") for spec in _parts(source)]
    source.seek_subimage(0, 0)
    named = {name: part for part, name in enumerate(names) if name.startswith("bounce")}
    return named if len(names) > 1 else {}


def _read_parts(path: Path, source: oiio.ImageInput, named: dict[str, int], channels: int) -> Images:
    """The images of parts ``bounce0``, ``bounce1``, …, ``(bounces + 1, height, width, channels)``."""
    ordered = [f"bounce{k}" for k in range(len(named))]
    if set(ordered) != set(named):
        raise ImageError(f"{path}: expected parts bounce0, bounce1, …; found {', '.join(named)}")
    images = []
    for name in ordered:
        source.seek_subimage(named[name], 0)
        spec, pixels = source.spec(), source.read_image(oiio.FLOAT)
        if pixels is None:
            raise ImageError(
                f"{path}: its pixels can't be read; the file is incomplete: {cause(source.geterror())}"
            )
        found = [channel.rpartition(".")[2] for channel in spec.channelnames]
        wanted = next((w for w in (channel_names(channels), ["Y"]) if set(w) <= set(found)), None)
        if wanted is None:
            expected = ", ".join(channel_names(channels))
            raise ImageError(f"{path}: part {name}: expected channels {expected}; found {', '.join(found)}")
        values = np.asarray(pixels, dtype=np.float64).reshape(spec.height, spec.width, -1)
        images.append(values[..., [found.index(channel) for channel in wanted]])
    source.seek_subimage(0, 0)
    if len({image.shape for image in images}) > 1:
        raise ImageError(f"{path}: its parts have different sizes or channels")
    return np.stack(images)


def _rounding(source: oiio.ImageInput) -> float:
    """Half a unit in the last place of a half or a float, relative; of RGBE, a whole one of its 8 bits."""
    if source.format_name() == "hdr":
        return 2.0**-7
    return 2.0**-11 if str(source.spec().format) == "half" else 2.0**-24
