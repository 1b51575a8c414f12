"""Bounce images go into an EXR and back; anything else is refused with the path of the file."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from scenes.formats import exr


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "images.exr"


def images(bounces: int, channels: int, seed: int = 1) -> np.ndarray:
    """Not square, and every value another, so that no axis can be taken for another one."""
    values = np.random.default_rng(seed).random((bounces + 1, 5, 7, channels)) * 1e3
    return values.astype(np.float32).astype(float)


def foreign(file: Path, *names: str) -> None:
    spec = oiio.ImageSpec(4, 3, len(names), oiio.FLOAT)
    spec.channelnames = names
    out = oiio.ImageOutput.create(str(file))
    assert out.open(str(file), spec)
    assert out.write_image(np.ones((3, 4, len(names)), np.float32))
    out.close()


@pytest.mark.parametrize("channels", [1, 2, 3, 5, 12])
@pytest.mark.parametrize("bounces", [0, 3, 11])
def test_round_trip(file: Path, bounces: int, channels: int) -> None:
    mean, stderr = images(bounces, channels), images(bounces, channels, seed=2)
    exr.write_bounces(file, mean, stderr)
    for found, expected in zip(exr.read_bounces(file), (mean, stderr), strict=True):
        np.testing.assert_array_equal(found, expected)
        assert found.dtype == np.float64


def test_without_an_error_it_is_zero(file: Path) -> None:
    exr.write_bounces(file, images(2, 3))
    mean, stderr = exr.read_bounces(file)
    np.testing.assert_array_equal(mean, images(2, 3))
    assert stderr.shape == mean.shape
    assert not stderr.any()


def test_radiance_is_neither_clamped_nor_rounded(file: Path) -> None:
    values = np.array([0.0, -1.5, 1e-30, 3e38, np.inf]).reshape(1, 1, 5, 1)
    exr.write_bounces(file, values)
    np.testing.assert_array_equal(exr.read_bounces(file)[0], values.astype(np.float32))


def test_other_programs_find_layers_and_row_0_at_the_top(file: Path) -> None:
    mean = images(1, 3)
    exr.write_bounces(file, mean, mean)
    source = oiio.ImageInput.open(str(file))
    names, pixels = source.spec().channelnames, source.read_image(oiio.FLOAT)
    source.close()
    assert {"bounce0.R", "bounce1.B", "bounce1.stderr.G"} <= set(names)
    np.testing.assert_array_equal(pixels[0, :, names.index("bounce1.R")], mean[1, 0, :, 0])


@pytest.mark.parametrize("wavelengths", [(404, 412, 420), (360, 510, 660, 810), (380.25, 381.5)], ids=str)
@pytest.mark.parametrize("bounces", [0, 11])
def test_wavelengths(file: Path, bounces: int, wavelengths: tuple[float, ...]) -> None:
    mean, stderr = images(bounces, len(wavelengths)), images(bounces, len(wavelengths), seed=2)
    exr.write_bounces(file, mean, stderr, wavelengths=wavelengths)
    for found, expected in zip(exr.read_bounces(file), (mean, stderr), strict=True):
        np.testing.assert_array_equal(found, expected)
    assert exr.read_wavelengths(file) == wavelengths
    exr.write_bounces(file, mean)
    assert exr.read_wavelengths(file) is None


def test_a_spectrum_s_names_and_its_picture(file: Path) -> None:
    """Those of Fichet et al. 2021; equal energy is XYZ = (1, 1, 1), so sRGB is what the matrix's rows add up to."""
    visible = tuple(380 + 2.5 * i for i in range(161))
    exr.write_bounces(file, np.ones((2, 4, 3, 161)), np.ones((2, 4, 3, 161)), wavelengths=visible)
    source = oiio.ImageInput.open(str(file))
    names, pixels = source.spec().channelnames, source.read_image(oiio.FLOAT)
    source.close()
    assert {"bounce1.S0.380nm", "bounce1.S0.382,5nm", "bounce0.stderr.S0.780nm"} <= set(names)
    picture = [pixels[..., names.index(f"bounce1.{channel}")] for channel in "RGB"]
    np.testing.assert_allclose(
        picture, np.broadcast_to([[[1.2048]], [[0.9483]], [[0.9087]]], (3, 4, 3)), atol=5e-4
    )
    assert "bounce1.stderr.R" not in names


def test_texts_in_the_header(file: Path) -> None:
    exr.write_bounces(file, images(0, 1), attributes={"lightproof:source": "seeds 1 to 64, ρ = ½"})
    assert exr.read_attribute(file, "lightproof:source") == "seeds 1 to 64, ρ = ½"
    assert exr.read_attribute(file, "lightproof:other") == ""


@pytest.mark.parametrize(
    "names",
    [
        ("R", "G", "B"),
        ("bounce0",),
        ("bounce1.Y",),
        ("bounce0.Y", "bounce2.Y"),
        ("bounce0.R", "bounce0.G"),
        ("bounce0.stderr.Y",),
        ("bounce0.Y", "bounce1.Y", "bounce0.stderr.Y"),
        ("bounce0.Y", "bounce1.R", "bounce1.G", "bounce1.B"),
        ("bouncer.Y",),
        ("bounce0.S0.400nm", "bounce0.S0.410nm", "bounce1.S0.400nm", "bounce1.S0.420nm"),
        ("bounce0.S0.400nm", "bounce0.S0.410nm", "bounce1.C0", "bounce1.C1"),
        ("bounce0.S1.400nm", "bounce0.S1.410nm"),
    ],
    ids=" ".join,
)
def test_foreign_channels_are_refused(file: Path, names: tuple[str, ...]) -> None:
    foreign(file, *names)
    with pytest.raises(exr.ImageError, match=re.escape(str(file))):
        exr.read_bounces(file)


def test_wavelengths_in_other_steps_are_refused(file: Path) -> None:
    foreign(file, "bounce0.S0.400nm", "bounce0.S0.410nm", "bounce0.S0.430nm")
    assert exr.read_bounces(file)[0].shape == (1, 3, 4, 3)
    with pytest.raises(exr.ImageError, match=f"{re.escape(str(file))}.*equal steps"):
        exr.read_wavelengths(file)


@pytest.mark.parametrize("share", [0.0, 0.001, 0.01, 0.5, 0.99])
def test_a_truncated_file_is_refused(file: Path, share: float) -> None:
    exr.write_bounces(file, np.random.default_rng(1).random((4, 64, 64, 3)))
    content = file.read_bytes()
    file.write_bytes(content[: int(share * len(content))])
    with pytest.raises(exr.ImageError, match=re.escape(str(file))):
        exr.read_bounces(file)


@pytest.mark.parametrize(
    "read", [exr.read_bounces, exr.read_wavelengths, lambda file: exr.read_attribute(file, "any")]
)
def test_no_such_file_and_no_image(file: Path, read: object) -> None:
    with pytest.raises(exr.ImageError, match=re.escape(str(file))):
        read(file)
    file.write_text("a text")
    with pytest.raises(exr.ImageError, match=re.escape(str(file))):
        read(file)


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(exr.ImageError, match="can't be written"):
        exr.write_bounces(tmp_path / "none" / "images.exr", images(0, 1))
