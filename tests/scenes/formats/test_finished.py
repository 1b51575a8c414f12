"""A finished image from any program, and what is said of one that can't be read."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest
from PIL import Image

from scenes.formats import exr, finished


def write(
    path: Path,
    names: list[str],
    pixels: np.ndarray,
    kind: str = "float",
    window: tuple[int, int] | None = None,
) -> Path:
    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, kind)
    spec.channelnames = names
    if window:
        spec.full_width, spec.full_height = window
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec), out.geterror()
    assert out.write_image(np.ascontiguousarray(pixels, dtype=np.float32))
    out.close()
    return path


@pytest.fixture
def pixels() -> np.ndarray:
    """4 rows of 5 pixels, every number another one."""
    return np.arange(1.0, 61.0).reshape(4, 5, 3)


@pytest.mark.parametrize(
    "names",
    [
        ["R", "G", "B"],
        ["ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B"],
        ["R", "G", "B", "A", "Z", "albedo.R", "albedo.G", "albedo.B"],
    ],
    ids=["plain", "one layer", "with others"],
)
def test_red_green_and_blue_are_found(tmp_path: Path, pixels: np.ndarray, names: list[str]) -> None:
    more = np.concatenate([pixels, np.zeros((4, 5, len(names) - 3))], axis=-1)
    found = finished.read(write(tmp_path / "a.exr", names, more), layers=False, channels=3)
    assert found.summed
    assert np.array_equal(found.images, pixels[None])


@pytest.mark.parametrize(("kind", "error"), [("float", 2.0**-24), ("half", 2.0**-11)])
def test_how_its_numbers_are_rounded(tmp_path: Path, kind: str, error: float) -> None:
    values = np.random.default_rng(1).uniform(0.1, 10, (64, 64, 3)).astype(np.float32)
    path = write(tmp_path / "a.exr", ["R", "G", "B"], values, kind)
    found = finished.read(path, layers=False, channels=3)
    assert found.rounding == error
    if kind == "half":
        off = np.abs(found.images[0] / values - 1).max()
        assert error / 2 < off <= error


def test_luminance_will_do(tmp_path: Path, pixels: np.ndarray) -> None:
    path = write(tmp_path / "a.exr", ["Y"], pixels[..., :1])
    assert finished.read(path, layers=False, channels=3).images.shape == (1, 4, 5, 1)


def test_channels_of_a_spectrum(tmp_path: Path) -> None:
    names, values = exr.channel_names(12), np.arange(12.0).reshape(1, 1, 12)
    # the file lists them in alphabetical order, C10 before C2
    order = sorted(range(12), key=names.__getitem__)
    path = write(tmp_path / "a.exr", [names[i] for i in order], values[..., order])
    assert np.array_equal(finished.read(path, layers=False, channels=12).images, values[None])


def test_layers_are_bounces(tmp_path: Path, pixels: np.ndarray) -> None:
    exr.write_bounces(tmp_path / "a.exr", np.stack([pixels, 2 * pixels]))
    found = finished.read(tmp_path / "a.exr", layers=True, channels=3)
    assert not found.summed
    assert np.array_equal(found.images, np.stack([pixels, 2 * pixels]))


def test_a_file_with_several_parts(tmp_path: Path, pixels: np.ndarray) -> None:
    """The picture may be in the second part."""
    specs = []
    for name, channels in (("depth", ["Z"]), ("beauty", ["R", "G", "B"])):
        spec = oiio.ImageSpec(5, 4, len(channels), "float")
        spec.channelnames = channels
        spec["oiio:subimagename"] = name
        specs.append(spec)
    path = str(tmp_path / "a.exr")
    out = oiio.ImageOutput.create(path)
    assert out.open(path, specs)
    assert out.write_image(np.zeros((4, 5, 1), np.float32))
    assert out.open(path, specs[1], "AppendSubimage")
    assert out.write_image(pixels.astype(np.float32))
    out.close()
    assert np.array_equal(finished.read(tmp_path / "a.exr", False, 3).images, pixels[None])


def complaint(path: Path, layers: bool = False) -> str:
    with pytest.raises(exr.ImageError) as error:
        finished.read(path, layers, 3)
    return str(error.value)


def test_what_is_no_linear_picture_is_refused(tmp_path: Path, pixels: np.ndarray) -> None:
    assert "a.exr: there is no such file" in complaint(tmp_path / "a.exr")
    assert "is no file" in complaint(tmp_path)
    (tmp_path / "text.exr").write_text("no image")
    assert "expected an EXR file; it can't be read" in complaint(tmp_path / "text.exr")
    Image.fromarray(np.zeros((4, 4, 3), np.uint8)).save(tmp_path / "a.png")
    told = complaint(tmp_path / "a.png")
    assert "expected EXR, found a png file of 8-bit integers, rounded, clipped at white" in told
    assert "Save the linear image as EXR" in told
    # the name is not what counts
    (tmp_path / "a.png").rename(tmp_path / "renamed.exr")
    assert "found a png file" in complaint(tmp_path / "renamed.exr")
    write(tmp_path / "a.tif", ["R", "G", "B"], pixels)
    assert "expected EXR, found a tiff file." in complaint(tmp_path / "a.tif")


def test_other_channels_are_named(tmp_path: Path, pixels: np.ndarray) -> None:
    path = write(tmp_path / "a.exr", ["depth.Z", "normal.X", "normal.Y2"], pixels)
    assert "expected channels R, G, B, or Y; found depth.Z, normal.X, normal.Y2." in complaint(path)
    several = np.concatenate([pixels, pixels], axis=-1)
    path = write(
        tmp_path / "b.exr", [f"{layer}.{c}" for layer in ("direct", "indirect") for c in "RGB"], several
    )
    assert "more than one layer has them: direct, indirect" in complaint(path)
    exr.write_bounces(tmp_path / "c.exr", np.stack([pixels, pixels]))
    assert complaint(tmp_path / "c.exr").endswith(
        'Did you mean --layers, or images = "layers" in a configuration?'
    )
    assert "expected layers bounce0" in complaint(path, layers=True)


def test_a_part_of_a_picture_is_refused(tmp_path: Path, pixels: np.ndarray) -> None:
    path = write(tmp_path / "a.exr", ["R", "G", "B"], pixels, window=(10, 8))
    told = "a data window of 5x4 pixels from (0, 0) in a display window of 10x8"
    assert told in complaint(path)


def test_a_file_cut_short_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "a.exr", ["R", "G", "B"], np.random.default_rng(1).random((64, 64, 3)))
    content = path.read_bytes()
    for length in (20, 200, 20000):
        path.write_bytes(content[:length])
        assert "a.exr: " in complaint(path)
        assert "\n" not in complaint(path), "one cause, on one line"
