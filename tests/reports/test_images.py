"""The images of a run: read from their files, and shown in the page, whatever has become of them."""

from __future__ import annotations

import base64
import io
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import numpy as np
import OpenImageIO
import pytest
from PIL import Image

from comparisons.results import Images, Results
from reports.images import MissingImagesError, read
from scenes.formats import exr

shared = SimpleNamespace(**run_path(str(Path(__file__).with_name("page.py"))))
alone, rendered = shared.alone, shared.rendered


# ---- read


def written(folder: Path, truth: int, renderer: int) -> Images:
    """Files of so many bounces each."""
    for name, bounces in (("truth", truth), ("renderer", renderer)):
        means = np.arange(1.0, bounces + 1)[:, None, None, None] * np.ones((1, 4, 6, 3))
        exr.write_bounces(folder / f"{name}.exr", means, np.zeros_like(means))
    return Images(truth="truth.exr", renderer="renderer.exr")


def test_of_the_truth_as_many_bounces_as_the_renderer_has(tmp_path: Path) -> None:
    images = read(tmp_path, written(tmp_path, truth=4, renderer=2))
    assert images.truth.shape == images.truth_error.shape == images.renderer.shape == (2, 4, 6, 3)
    np.testing.assert_array_equal(images.truth, images.renderer)


def test_a_truth_of_fewer_bounces_does_not_fit(tmp_path: Path) -> None:
    with pytest.raises(MissingImagesError, match="The truth holds 2 bounces"):
        read(tmp_path, written(tmp_path, truth=2, renderer=4))


# ---- shown in the page


@pytest.mark.parametrize("damage", ["missing", "cut short", "no image", "another size"])
def test_a_damaged_image_is_said_at_its_place(results: Results, tmp_path: Path, damage: str) -> None:
    alone(results, tmp_path, 0, 2)  # what is said of one, and another one that goes on
    file = tmp_path / "pass.renderer.exr"
    if damage == "missing":
        file.unlink()
    elif damage == "cut short":
        file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    elif damage == "no image":
        file.write_text("no image")
    else:
        exr.write_bounces(file, np.ones((2, 8, 16, 3)))
    page = rendered(tmp_path)
    assert page.text.count("The images can't be shown.") == 1
    assert len(page.all("img")) == 2 * 7
    if damage == "another size":
        assert "the renderer's file 2 bounces of 16 × 8 pixels in 3 channels" in page.text


def test_an_image_of_other_layers_is_said_too(results: Results, tmp_path: Path) -> None:
    alone(results, tmp_path, 0)
    spec = OpenImageIO.ImageSpec(4, 4, 1, OpenImageIO.FLOAT)
    spec.channelnames = ["bounce0.Z"]
    out = OpenImageIO.ImageOutput.create(str(tmp_path / "pass.truth.exr"))
    out.open(str(tmp_path / "pass.truth.exr"), spec)
    out.write_image(np.zeros((4, 4, 1), np.float32))
    out.close()
    assert rendered(tmp_path).text.count("The images can't be shown.") == 1


def test_pixels_that_are_not_finite_do_not_stop_the_report(results: Results, tmp_path: Path) -> None:
    alone(results, tmp_path, 0)
    file = tmp_path / "pass.renderer.exr"
    mean, error = exr.read_bounces(file)
    mean[1, 3, 4], mean[2, 5, 6] = np.nan, np.inf
    exr.write_bounces(file, mean, error)
    assert len(rendered(tmp_path).all("img")) == 7 * 7


def test_large_images_are_averaged(results: Results, tmp_path: Path) -> None:
    alone(results, tmp_path, 2)
    for side in ("truth", "renderer"):
        exr.write_bounces(tmp_path / f"grey.{side}.exr", np.ones((2, 300, 600, 1)))
    page = rendered(tmp_path)
    assert "Each pixel shown is the average of 3 × 3 pixels." in page.text
    assert [image["width"] for image in page.all("img")].count("200") == 2 * 6


VISIBLE = tuple(range(380, 781, 10))


def equal_energy(folder: Path, wavelengths: tuple[int, ...] | None = VISIBLE) -> None:
    """Give the spectral comparison images of the same radiance at every wavelength: 1, then none."""
    mean = np.stack([np.ones((8, 8, 41)), np.zeros((8, 8, 41))])
    exr.write_bounces(folder / "five.truth.exr", mean, wavelengths=VISIBLE)
    exr.write_bounces(folder / "five.renderer.exr", 1.1 * mean, wavelengths=wavelengths)


def test_spectra_are_shown_in_colour(results: Results, tmp_path: Path) -> None:
    alone(results, tmp_path, 3)
    equal_energy(tmp_path)
    page = rendered(tmp_path)
    assert "Truth and renderer show 41 wavelengths" in page.text
    assert "grey mean" not in page.text
    # of E on both sides, E in the first sum and E + TE in the second; TE has no light, and so no chromaticity
    assert page.text.count("x 0.333, y 0.333") == 6
    [source] = {str(image["src"]) for image in page.all("img") if image["alt"] == "E, truth, exposure ×0.66"}
    picture = Image.open(io.BytesIO(base64.b64decode(source.partition(",")[2])))
    # equal energy is XYZ = (1, 1, 1), so linear sRGB is what the rows of IEC 61966-2-1's matrix add up to
    linear = 0.66 * np.array([1.2048, 0.9483, 0.9087])
    np.testing.assert_allclose(
        picture.convert("RGB").getpixel((3, 3)), 255 * (1.055 * linear ** (1 / 2.4) - 0.055), atol=1
    )


@pytest.mark.parametrize("wavelengths", [None, tuple(range(385, 786, 10))], ids=["none", "others"])
def test_two_sides_of_different_wavelengths_are_not_compared(
    results: Results, tmp_path: Path, wavelengths: tuple[int, ...] | None
) -> None:
    alone(results, tmp_path, 3)
    equal_energy(tmp_path, wavelengths)
    assert "The channels of the two files are different wavelengths." in rendered(tmp_path).text
