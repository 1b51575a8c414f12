"""One finished image from anywhere, held against a case: no seeds, no replicates, one file.

The noise comes from the residuals, tile by tile (``comparisons.statistics.residuals``); verdicts follow the same
rules as ever: a pass where every own interval lies inside its tolerance, a fail where a simultaneous one lies
outside. There is one look, at level α. The truth's own noise is part of the residuals.

Where the image is the sum of all bounces, its tolerance is what it would use up if every bounce used its own
(``Tolerance.of_sum``).
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.comparison import about
from comparisons.hints import hints
from comparisons.metrics import partial_sum_metrics, term_metrics
from comparisons.regions import Regions
from comparisons.results import BounceResult, Comparison, Outlier, ResidualNoise, SingleImage
from comparisons.settings import Settings
from comparisons.statistics import residuals
from comparisons.statistics.intervals import Biases, Range, alpha_of_regions, denominators, p_values
from comparisons.statistics.rare_events import FLOOR
from comparisons.statistics.residuals import Noise, Window
from comparisons.verdict import Measured, judge, overall
from scenes import Case, Tolerance, Truth
from scenes.channels import channel_names
from scenes.formats.finished import Finished

Array = NDArray[np.float64]

LEAST = 8
"""Pixels across a tile, at least: with fewer, their scatter says too little."""

_LUMINANCE = np.array([[0.2126], [0.7152], [0.0722]])  # of linear sRGB, what Y means in an EXR file
_POWER_90 = 1.2816  # standard errors beyond the interval's end, of a bias seen nine times in ten
_SHOWN = 5


class TooSmallError(ValueError):
    """An image whose noise can't be told from its residuals."""


def check(
    case: Case, truth: Truth, name: str, picture: Finished, alpha: float, independent: bool = False
) -> Comparison:
    """The verdict on a finished image.

    Args:
        case: at the picture's size, with the bounces and the tolerance that are asked for.
        truth: its answer.
        name: what to call the picture.
        picture: radiance in the case's channels, or the luminance Y of a case in red, green and blue.
        alpha: probability of a wrong verdict.
        independent: the pixels are known to be.

    Raises:
        TooSmallError: less than 16 pixels across.
    """
    start = time.monotonic()
    images = picture.images
    height, width = images.shape[1:3]
    if min(height, width) < 2 * LEAST:
        raise TooSmallError(
            f"{name} has {width}x{height} pixels; their scatter tells the noise from {2 * LEAST}x{2 * LEAST} up"
        )
    case = replace(case, tiles=(min(case.tiles[0], height // LEAST), min(case.tiles[1], width // LEAST)))
    told = about(case, name, Settings(alpha=alpha)) | {
        "channels": channel_names(images.shape[-1]),
        "renderer_version": "",
        "truth_source": truth.source,
        "spp": 0,
        "replicates": 0,
    }
    if problem := _not_finite(images):
        return Comparison(**told, verdict="error", bounces=[], seconds=0.0, message=problem)
    terms, expected = expectation(truth, picture)
    checked = _Check(case, picture, terms, expected, alpha, independent)
    bounces = [checked.judged(i) for i in range(len(images))]
    verdict = overall(b.verdict for b in bounces)
    found = hints(images.sum(axis=0), terms, counted=not picture.summed) if verdict != "pass" else []
    return Comparison(
        **told,
        **_metrics(case, picture, expected),
        verdict=verdict,
        bounces=bounces,
        seconds=time.monotonic() - start,
        message=_undecided(bounces, checked),
        notes=_notes(images),
        single_image=SingleImage(
            file=name,
            summed=picture.summed,
            independent=independent,
            noise=[checked.described(i) for i in range(len(images))],
            limits=checked.limits(),
            hints=[hint.text for hint in found],
        ),
    )


def expectation(truth: Truth, picture: Finished) -> tuple[Array, Array]:
    """The truth of each bounce in the picture's channels, and what its images should be: the same, or their sum."""
    terms = truth.mean @ _LUMINANCE if picture.images.shape[-1] < truth.mean.shape[-1] else truth.mean
    return terms, terms.sum(axis=0, keepdims=True) if picture.summed else terms


@dataclass(frozen=True)
class _Check:
    """The images beside what they should be, and their noise.

    Attributes:
        case, picture, alpha, independent: as above.
        terms: the truth of each bounce.
        expected: that of each image: the terms, or their sum.
    """

    case: Case
    picture: Finished
    terms: Array
    expected: Array
    alpha: float
    independent: bool

    @cached_property
    def regions(self) -> Regions:
        return Regions.of(self.expected.shape[1], self.expected.shape[2], self.case.tiles)

    @property
    def _channels(self) -> list[str]:
        channels = self.expected.shape[-1]
        return channel_names(channels, self.case.wavelengths if channels > 3 else None)

    @cached_property
    def windows(self) -> list[Window]:
        """Of the tiles."""
        places = [self.regions.place(i + 1) for i in range(self.regions.rows * self.regions.columns)]
        return [(slice(p.y0, p.y1), slice(p.x0, p.x1)) for p in places]

    @cached_property
    def noise(self) -> list[Noise]:
        """Of each image."""
        return [self._noise(i) for i in range(len(self.expected))]

    def _noise(self, i: int) -> Noise:
        image, truth = self.picture.images[i], self.expected[i]
        rounding = self.picture.rounding * np.maximum(np.abs(image), np.abs(truth)) / 3**0.5
        return residuals.noise(image - truth, truth, self._scale(i), rounding, self.windows, self.independent)

    def _scale(self, i: int) -> Array:
        """What a pixel's residual is relative to, as the biases of regions are."""
        truth = self.expected[i]
        whole = self.terms.sum(axis=0).mean(axis=(0, 1))
        dark = np.where(whole > 0, whole, 1.0)
        mean = truth.mean(axis=(0, 1))
        scale: Array = np.maximum(truth, np.where(mean > 0, FLOOR * mean, dark))
        return scale

    def judged(self, i: int) -> BounceResult:
        """The verdict on one image."""
        means = self.regions.means(self.expected)
        mean, denominator = self.regions.means(self.picture.images)[:, i], denominators(means)[:, i]
        noise = self.noise[i]
        bias, error = (mean - means[:, i]) / denominator, noise.error / denominator
        each = alpha_of_regions(self.alpha, len(mean), others=means[0].size)
        own, simultaneous = (noise.half_width(level) / denominator for level in (self.alpha, each))
        found = Biases(
            bias=bias,
            error=error,
            own=Range(bias - own, bias + own),
            simultaneous=Range(bias - simultaneous, bias + simultaneous),
            resolution=simultaneous + _POWER_90 * error,
            p_value=p_values(bias, error, np.full_like(bias, np.inf)),
        )
        measured = Measured(
            bounce=self.case.bounces if self.picture.summed else i,
            channels=self._channels,
            biases=found,
            mean=mean,
            truth=means[:, i],
            denominator=denominator,
            skewness=np.zeros_like(bias),
            dominance=np.zeros_like(bias),
            look=1,
            replicates=0,
            spp=0,
            enough=True,
        )
        return judge(measured, self._tolerance(), self.regions, None)

    def _tolerance(self) -> Tolerance:
        if not self.picture.summed:
            return self.case.tolerance
        return self.case.tolerance.of_sum(self.terms.mean(axis=(1, 2, 3)))

    def described(self, i: int) -> ResidualNoise:
        """What the residuals of one image say of its noise."""
        image, truth, noise = self.picture.images[i], self.expected[i], self.noise[i]
        odd = noise.outliers.any(axis=-1)
        excess = np.where(noise.outliers, image - truth, 0)
        brightest = np.argsort(excess.max(axis=-1), axis=None)[::-1][: min(_SHOWN, int(odd.sum()))]
        names, shown = self._channels, []
        for y, x in zip(*np.unravel_index(brightest, odd.shape), strict=True):
            c = int(excess[y, x].argmax())
            value = {"value": float(image[y, x, c]), "truth": float(truth[y, x, c])}
            shown.append(Outlier(x=int(x), y=int(y), channel=names[c], **value))
        return ResidualNoise(
            correlation=noise.correlation[0],
            correlation_error=noise.correlation[1],
            reach=noise.reach,
            inflation=noise.inflation,
            outliers=int(odd.sum()),
            brightest_outliers=shown,
        )

    def limits(self) -> list[str]:
        """What can't be told, in sentences."""
        tile = self.regions.place(1)
        found = [
            "An error that averages out within a tile does not show; tiles have "
            f"{tile.x1 - tile.x0} x {tile.y1 - tile.y0} pixels.",
            "Noise that pixels share (one set of random numbers for all of them, a photon map, a cache) looks like a "
            "bias, and light that is so rare that no pixel caught it looks like a lack of light.",
        ]
        if self.picture.summed:
            found.append("Which bounce is wrong does not show in a sum, nor do wrong bounces that cancel.")
        if any(noise.outliers.any() for noise in self.noise):
            found.append(
                "Single pixels hold far more than their surroundings (outliers): whether that is too much or too "
                "little can't be told. It counts as noise everywhere."
            )
        if self.independent:
            told = " though its residuals contradict it" if any(n.reach != 0 for n in self.noise) else ""
            return [*found, f"That its pixels are independent is taken on your word{told}."]
        if any(noise.reach for noise in self.noise):
            found.append(
                "Neighbouring residuals are correlated, by a pixel filter perhaps: intervals are wider."
            )
        if any(noise.reach is None for noise in self.noise):
            found.append(
                "The residuals vary smoothly, as those of a denoised image do, but also those of a bias: inside a "
                "tile the two can't be told apart. "
                f"All intervals come from how the {len(self.windows)} tiles scatter. "
                "If no denoiser and no pixel filter but the box was at work, say --independent."
            )
        return found


def _metrics(case: Case, picture: Finished, expected: Array) -> dict[str, Any]:
    if not picture.summed:
        terms, sums = term_metrics(picture.images, expected), partial_sum_metrics(picture.images, expected)
        return {"metrics": sums, "term_metrics": terms}
    return {"metrics": term_metrics(picture.images, expected, first=case.bounces)}


def _not_finite(images: Array) -> str:
    """How many pixels are no numbers, and where the first one is; empty if there are none."""
    bad = ~np.isfinite(images)
    if not bad.any():
        return ""
    layers, rows, columns = np.nonzero(bad.any(axis=-1))
    where = f"x = {columns[0]}, y = {rows[0]} (row 0 is the top)"
    where += f" of bounce {layers[0]}" if len(images) > 1 else ""
    return f"{len(rows)} of {images[..., 0].size} pixels are NaN or infinite, the first one at {where}"


def _notes(images: Array) -> list[str]:
    negative = int((images < 0).any(axis=-1).sum())
    return [f"{negative} pixels are negative, down to {images.min():.3g}."] if negative else []


def _undecided(bounces: list[BounceResult], checked: _Check) -> str:
    """What could have been seen where there is no verdict; empty if all have one."""
    undecided = [b for b in bounces if b.verdict == "inconclusive"]
    if not undecided:
        return ""
    whole = max(b.detectable_bias for b in undecided)
    tile = max(b.worst_tile.detectable_bias for b in undecided)
    smooth = not checked.independent and any(noise.reach is None for noise in checked.noise)
    why = "noise or bias, the two look alike" if smooth else "too much noise"
    return f"{why}: a bias could have been detected from {whole:.2%} of the image, {tile:.2%} of a tile"
