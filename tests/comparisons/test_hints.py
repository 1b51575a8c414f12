"""Each way in which images go wrong is planted, with and without noise, and nothing is said of what is right."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from comparisons.hints import hints
from scenes.library import case

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def terms() -> Array:
    """A ball's inside in three zones, with a lamp: no symmetry, bright and dark parts, edges."""
    zones = case("sphere-zones")
    return zones.answer.evaluate(zones.scene, 5)  # type: ignore[union-attr]


def srgb(image: Array) -> Array:
    """IEC 61966-2-1."""
    power = 1.055 * np.maximum(image, 0.0031308) ** (1 / 2.4) - 0.055
    return np.where(image <= 0.0031308, 12.92 * image, power)


def noisy(image: Array, share: float) -> Array:
    rng = np.random.default_rng(1)
    return image * np.maximum(0, 1 + share * rng.standard_normal(image.shape))


PLANTED: dict[str, tuple[Callable[[Array], Array], str]] = {
    "upside down": (lambda t: t[::-1], "far better turned upside down:"),
    "mirrored": (lambda t: t[:, ::-1], "far better mirrored left to right:"),
    "turned": (lambda t: t[::-1, ::-1], "far better turned by 180°:"),
    "encoded": (srgb, "far better decoded from sRGB:"),
    "encoded, exposed": (lambda t: srgb(2 * t), "far better decoded from sRGB and divided by 2"),
    "upside down, encoded": (lambda t: srgb(t)[::-1], "far better turned upside down and decoded from sRGB:"),
    "scaled": (lambda t: 1.2 * t, "far better divided by 1.2"),
    "divided by π": (lambda t: t / np.pi, ", about 1/π:"),
    "blue first": (lambda t: t[..., ::-1], "far better with red and blue exchanged:"),
    "clipped": (
        lambda t: np.minimum(t, 1),
        "No value is above 1, but the truth reaches 12: it seems to be clipped.",
    ),
}


@pytest.mark.parametrize("share", [0.0, 0.1])
@pytest.mark.parametrize("name", PLANTED)
def test_what_was_done_to_an_image_is_recognised(terms: Array, name: str, share: float) -> None:
    change, expected = PLANTED[name]
    image = noisy(terms.sum(axis=0), share)
    found = hints(np.minimum(change(image), 1) if name == "clipped" else change(image), terms)
    assert expected in " ".join(hint.text for hint in found)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5])
def test_nothing_is_said_of_a_right_image(terms: Array, share: float) -> None:
    assert hints(noisy(terms.sum(axis=0), share), terms) == []


@pytest.mark.parametrize("share", [0.0, 0.05])
def test_nothing_is_said_of_what_is_none_of_this(terms: Array, share: float) -> None:
    """A missing direct bounce; a third of the image too dark."""
    assert hints(noisy(terms.sum(axis=0) - terms[1], share), terms) == []
    image = terms.sum(axis=0)
    image[:20] *= 0.5
    assert hints(noisy(image, share), terms) == []


@pytest.mark.parametrize(("x", "y"), [(0.5, 0.5), (-0.5, 0.0)])
def test_half_a_pixel_is_recognised(terms: Array, x: float, y: float) -> None:
    shifted = ndimage.shift(terms.sum(axis=0), (y, x, 0), order=1, mode="nearest")
    [found, *_] = hints(noisy(shifted, 0.05), terms)
    match = re.match(
        r"Its edges look shifted by ([\d.]+) pixels (right|left) and ([\d.]+) (down|up):", found.text
    )
    assert match is not None
    assert float(match[1]) == pytest.approx(0.5, abs=0.1)
    assert match[2] == ("right" if x > 0 else "left")
    assert float(match[3]) == pytest.approx(abs(y), abs=0.1)
    assert y == 0 or match[4] == "down"


def test_a_wider_filter_is_recognised(terms: Array) -> None:
    soft = ndimage.gaussian_filter(terms.sum(axis=0), (0.5, 0.5, 0))
    [found] = hints(noisy(soft, 0.05), terms)
    assert found.kinds == ["soft"]
    assert "softer than the truth's" in found.text


def test_another_number_of_bounces_is_recognised(terms: Array) -> None:
    [fewer] = hints(noisy(terms[:5].sum(axis=0), 0.01), terms)
    assert fewer.text.endswith("Then say --bounces 4.")
    zones = case("sphere-zones")
    everything = zones.answer.evaluate(zones.scene, 60).sum(axis=0)  # type: ignore[union-attr]
    [more] = hints(noisy(everything, 0.01), terms)
    assert "with more bounces than 5" in more.text


def test_black_truth_has_no_hints() -> None:
    assert hints(np.ones((16, 16, 3)), np.zeros((2, 16, 16, 3))) == []


def test_black_is_called_black(terms: Array) -> None:
    """And not an image with fewer bounces, most of whose blocks are black as well."""
    [black] = hints(np.zeros_like(terms[0]), terms)
    assert black.text == "It is black everywhere: was anything rendered?"


def test_layers_are_not_told_to_be_others(terms: Array) -> None:
    """A file of layers says how many bounces it has: an option for that it could not be given."""
    direct = terms[:2].sum(axis=0)
    assert "say --bounces 1" in hints(direct, terms)[0].text
    assert not any("--bounces" in hint.text for hint in hints(direct, terms, counted=True))


def test_an_even_image_that_is_too_dark_is_not_called_clipped() -> None:
    even = np.full((6, 64, 64, 3), 0.5) ** np.arange(6)[:, None, None, None]
    assert "clipped" not in [kind for hint in hints(0.6 * even.sum(axis=0), even) for kind in hint.kinds]


def test_a_cut_above_1_is_recognised(terms: Array) -> None:
    image = terms.sum(axis=0)
    cut = float(np.quantile(image, 0.9))
    assert ["clipped"] in [hint.kinds for hint in hints(np.minimum(image, cut), terms)]
