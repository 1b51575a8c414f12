"""What the page says about one comparison, gathered before the template lays it out."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from comparisons.results import Comparison
from reports import gallery, images, plots, quantities, wording
from reports.gallery import Gallery


@dataclass(frozen=True)
class Pictures:
    """The galleries of a comparison."""

    bounces: Gallery
    sums: Gallery | None
    """None where the only image is a sum."""
    grey_of: int
    """How many channels each grey pixel is the mean of; 0 for pictures in colour."""
    wavelengths: int
    """How many wavelengths each coloured pixel is made of; 0 where channels are none."""
    reduction: int
    """Each pixel shown is the average of reduction × reduction pixels."""


@dataclass(frozen=True)
class Section:
    """One comparison with its sentence, its pictures or why there are none, and its plots."""

    anchor: str
    comparison: Comparison
    finding: str
    pictures: Pictures | None
    image_problem: str
    figures: dict[str, Any]
    """Bokeh figures, named energy and bias."""
    dark: list[int]
    """Bounces that the log axis of the energy plot can't show."""


def build(comparison: Comparison, anchor: str, folder: Path) -> Section:
    """Gather a section.

    Args:
        comparison: what was found.
        anchor: the section's name within the page.
        folder: where the image files lie.
    """
    pictures, problem = _pictures(comparison, folder)
    energy, dark = plots.energy(comparison)
    figures = {"energy": None if quantities.is_sum(comparison) else energy, "bias": plots.bias(comparison)}
    return Section(
        anchor=anchor,
        comparison=comparison,
        finding=wording.finding(comparison),
        pictures=pictures,
        image_problem=problem,
        figures={name: figure for name, figure in figures.items() if figure is not None},
        dark=dark,
    )


def _pictures(comparison: Comparison, folder: Path) -> tuple[Pictures | None, str]:
    """The galleries, or None and the reason."""
    if comparison.images is None:
        return None, "This comparison has no images."
    try:
        both = images.read(folder, comparison.images)
    except images.MissingImagesError as error:
        return None, f"The images can't be shown. {error}"
    channels = both.truth.shape[-1]
    with np.errstate(invalid="ignore", over="ignore"):  # pixels that aren't finite are shown, not warned of
        if quantities.is_sum(comparison):
            last = comparison.bounces[0].bounce
            bounces = gallery.of_bounces(both, comparison.bounces, lambda k: quantities.partial_sum(last))
            sums = None
        else:
            bounces, sums = gallery.of_bounces(both, comparison.bounces), gallery.of_partial_sums(both)
    spectral = both.wavelengths is not None
    return Pictures(
        bounces,
        sums,
        grey_of=0 if spectral or channels == 3 else channels,
        wavelengths=channels if spectral else 0,
        reduction=both.reduction,
    ), ""
