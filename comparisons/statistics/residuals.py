"""How uncertain are the means of one image without replicates? Estimated from its residuals r = x − t.

A tile of n pixels has the mean residual b = ⟨r⟩. Its pixels scatter because of noise, and that scatter tells the
standard error of b, as far as pixels are independent or only near ones are not:

    d = r − its least-squares fit by 1, t, x and y within the tile       (p parameters: a bias that varies smoothly
                                                                          or in proportion is no noise)
    σ² = Σ d² / (n − p),   ρ(h) = the correlation of d at the distance h, pooled over all tiles
    Var b = g σ² / n,      g = Σ_h ρ(h) n_h / n                           (n_h pairs of pixels are h apart)

Where no correlation shows, g is 1. All pairs up to 1, 2, 4, … pixels apart are tested, and then each ring beyond, by

    z = Σ dᵢ dⱼ / √Σ dᵢ² dⱼ²

which is about standard normal for independent pixels of any distributions. Fitting takes g P off their products, with
P the projection of the fit; that is put back. Where ρ reaches as far as one can look, a quarter of a
tile, noise and bias look alike inside a tile: only the scatter of tiles among each other is left (``reach`` is None).
Tiles are taken for independent then, but for a quarter that neighbours may share in the mean of the whole image.

Outliers, pixels of more than twice the truth of all near ones and 20 times the usual scatter, are few and hold much:
a tile without one isn't known to have less of that noise. So their moments are pooled over the image, in units of the
truth (of its mean, where it is above that), and count in every tile.

The variance has 2 / Var(σ̂²/σ²) degrees of freedom, from the fourth moment and from the number of pairs behind g.
Skewness is corrected for by Hall's transformation (1992, On the removal of skewness by transformation, JRSS B 54(1)):
with a the skewness of the mean and T = (b − β) / s,

    T + a (2 T² + 1) / 6 + a² T³ / 27 = ((1 + a T / 3)³ − 1) / a + a / 6      is nearly normal

Rounding to 16 or 32 bits is taken for the same in all pixels, as in a uniform image it is.

None of this sees other noise that all pixels share.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

Array = NDArray[np.float64]
Window = tuple[slice, slice]

OUTLIER = 20.0
"""An outlier is off by so many times what is usual in its tile (median absolute deviations, as for a normal one)."""

LARGEST_GROUP = 9
"""More outliers than that side by side are none: something is there that shouldn't be."""

_Z = 3.0  # distances with a larger z are correlated: 1 in 700 by chance, which costs power only
_Z_MORE = 2.0  # and so are further ones


@dataclass(frozen=True)
class Noise:
    """What is known of the noise of region means; arrays are ``(1 + tiles, channels)``, region 0 the whole image.

    Attributes:
        error: standard errors.
        skewness: of the means.
        freedom: degrees of freedom of the error.
        correlation: of neighbouring residuals, and its standard error if they are independent.
        inflation: g.
        reach: pixels that the correlation reaches; 0: independent; None: further than one can tell.
        outliers: which pixels and channels are, ``(height, width, channels)``.
    """

    error: Array
    skewness: Array
    freedom: Array
    correlation: tuple[float, float]
    inflation: float
    reach: int | None
    outliers: NDArray[np.bool_]

    def half_width(self, alpha: Array | float) -> Array:
        """Half the width of two-sided intervals of level 1 − α, symmetric: the longer side where they are skew.

        Args:
            alpha: one for all, or one for each region, ``(1 + tiles, 1)``.
        """
        q = -special.stdtrit(self.freedom, alpha / 2)
        a = np.where(np.abs(self.skewness) < 1e-9, 1e-9, self.skewness)
        longer: Array = np.max([np.abs(3 / a * (np.cbrt(1 + a * (y - a / 6)) - 1)) for y in (q, -q)], axis=0)
        return longer * self.error


def outliers(residual: Array, truth: Array, scale: Array, windows: Sequence[Window]) -> NDArray[np.bool_]:
    """Which pixels and channels are outliers, ``(height, width, channels)``: far too bright, and few in one place.

    Args:
        residual: of each pixel.
        truth: of each pixel.
        scale: the truth, or what it is at least taken for.
        windows: of the tiles.
    """
    from scipy import ndimage  # here alone: most commands look for no outliers

    # brighter than all that is near: a soft or shifted edge has no outliers
    near = ndimage.maximum_filter(scale, (5, 5, 1))
    relative, excess = np.abs(residual) / scale, (residual + truth) / near - 1
    found = np.zeros(residual.shape, bool)
    for window in windows:
        usual = 1.4826 * np.median(relative[window], axis=(0, 1))
        found[window] = excess[window] > np.maximum(1.0, OUTLIER * usual)
    for c in range(residual.shape[-1]):
        # a lamp in the wrong place is no outlier
        groups, _ = ndimage.label(found[..., c], np.ones((3, 3)))
        found[..., c] &= (np.bincount(groups.ravel()) <= LARGEST_GROUP)[groups]
    return found


def noise(
    residual: Array,
    truth: Array,
    scale: Array,
    rounding: Array,
    windows: Sequence[Window],
    independent: bool = False,
) -> Noise:
    """Estimate the noise of the means of the image and of its tiles.

    Args:
        residual: x − t, ``(height, width, channels)``.
        truth: t.
        scale: the truth, or what it is at least taken for; above 0.
        rounding: the standard deviation of each pixel's rounding.
        windows: of the tiles, which cover the image, at least 8 × 8 pixels each.
        independent: pixels are known to be: g is 1, whatever their correlation, and what is smooth is a bias.
    """
    odd = outliers(residual, truth, scale, windows)
    tiles = [_Tile(residual[w], truth[w], ~odd[w], rounding[w].mean(axis=(0, 1))) for w in windows]
    correlation = _correlation(tiles)
    g, lags = (1.0, 0) if independent else (correlation.inflation, correlation.distances)
    size = residual[..., 0].size
    unit = np.minimum(scale, scale.mean(axis=(0, 1)))  # a lamp's pixels get no more of it than others
    pooled = [np.mean(np.where(odd, residual / unit, 0) ** k, axis=(0, 1)) for k in range(5)]
    found = []
    for tile, window in zip(tiles, windows, strict=True):
        u2, u3 = (np.mean(unit[window] ** k, axis=(0, 1)) for k in (2, 3))
        n, share = tile.pixels, tile.inside.mean(axis=(0, 1))
        variance = share * tile.variance + u2 * pooled[2]
        third = share * tile.third + u3 * pooled[3]
        # of the variance as estimated: bulk from this tile, outliers from the whole image
        spread = share * (tile.fourth - tile.variance**2) / n + u2**2 * pooled[4] / size
        spread += 2 * lags / size * variance**2
        shared = tile.rounding**2
        found.append((n, g * variance / n, g**2 * third / n**2, g**2 * spread / n**2, shared))
    error, skewness, freedom = _with_whole(*(np.array(values) for values in zip(*found, strict=True)))
    if correlation.reach is None and not independent:
        error, freedom = _between_tiles(error, residual, scale, windows)
        skewness = np.zeros_like(skewness)
    return Noise(error, skewness, freedom, correlation.neighbours, g, correlation.reach, odd)


class _Tile:
    """Detrended residuals of a tile, their moments and their products at all distances.

    Attributes:
        pixels: how many.
        inside: which ones are no outliers, ``(rows, columns, channels)``.
        variance, third, fourth: moments of d, ``(channels,)``.
        rounding: the mean standard deviation of pixels' rounding, which may be the same in all of them.
        counted: how many pixels per channel have a say in the correlation.
        products: Σ d d' / σ² at the distances (dy, dx), as ``_autocorrelation`` has them.
        squares: Σ d² d'² / σ⁴.
        fitted: Σ P, of the projection onto what was fitted.
    """

    def __init__(
        self, residual: Array, truth: Array, inside: NDArray[np.bool_], rounding: NDArray[np.float64]
    ) -> None:
        self.pixels, self.inside, self.rounding = inside[..., 0].size, inside, rounding
        moments, sums = [], []
        by_channel = (np.moveaxis(a, -1, 0) for a in (inside, residual, truth, rounding))
        for mask, r, t, least in zip(*by_channel, strict=True):
            q = _basis(np.stack([np.ones_like(t), t], axis=-1), mask)
            r = np.where(mask, r, 0)
            d = r - q @ np.einsum("yxk,yx->k", q, r)
            count = int(mask.sum())
            variance = float((d**2).sum()) / max(count - q.shape[-1], 1)
            moments.append((variance, (d**3).sum() / count, (d**4).sum() / count))
            if variance <= 4 * least**2:  # nothing to learn from
                q, d, variance = q[..., :0], np.zeros_like(d), 1.0
            e = d / np.sqrt(variance)
            fitted = sum((_autocorrelation(q[..., k]) for k in range(q.shape[-1])), np.zeros(()))
            sums.append(np.broadcast_arrays(_autocorrelation(e), _autocorrelation(e**2), fitted))
        self.variance, self.third, self.fourth = np.array(moments).T
        self.products, self.squares, self.fitted = (np.array(values) for values in zip(*sums, strict=True))
        self.counted = np.where(self.products[:, 0, 0] > 0, inside.sum(axis=(0, 1)), 0)


def _basis(columns: Array, mask: NDArray[np.bool_]) -> Array:
    """Orthonormal columns of the same span over the pixels of the mask, zero elsewhere, ``(rows, columns, k)``."""
    flat = (columns * mask[..., None]).reshape(-1, columns.shape[-1])
    flat = flat / np.maximum(np.linalg.norm(flat, axis=0), np.finfo(float).tiny)
    q, values, _ = np.linalg.svd(flat, full_matrices=False)
    return q[:, values > 1e-6].reshape(*mask.shape, -1)


def _autocorrelation(image: Array) -> Array:
    """Σ aᵢ aᵢ₊ₕ at the distances h = (dy, dx) of up to a quarter of the image; a negative index is a negative one."""
    shape = [n + n // 4 for n in image.shape]
    sums: Array = np.fft.irfft2(np.abs(np.fft.rfft2(image, shape)) ** 2, shape)
    return sums


@dataclass(frozen=True)
class _Correlation:
    """g, how far it reaches, the correlation of neighbours with its error, and how many distances are behind g."""

    inflation: float
    reach: int | None
    neighbours: tuple[float, float]
    distances: int


def _correlation(tiles: Sequence[_Tile]) -> _Correlation:
    """Whether near pixels are correlated, up to a quarter of the smallest tile apart."""
    far = min(min(tile.inside.shape[:2]) for tile in tiles) // 4
    near = np.ix_(range(-far, far + 1), range(-far, far + 1))
    products, squares, fitted = (
        sum(np.moveaxis(getattr(tile, name), 0, -1)[near] for tile in tiles)
        for name in ("products", "squares", "fitted")
    )
    count = float(sum(tile.counted.sum() for tile in tiles))
    distance = np.abs(np.mgrid[-far : far + 1, -far : far + 1]).max(axis=0)
    reaches = [2**i for i in range(far.bit_length())]

    def z(ring: NDArray[np.bool_], g: float = 1.0) -> float:
        # the fit took g P off; channels may share their noise, so their errors add up; every pair is there twice
        error = g * np.sqrt(2 * squares[ring].sum(axis=0)).sum()
        return float((products[ring] + g * fitted[ring]).sum() / error) if error > 0 else 0.0

    def inflation(reach: int) -> float:
        inside = distance <= reach
        return float(products[inside].sum() / (count - fitted[inside].sum()))

    ring = distance == 1
    pairs = max(count * int(ring.sum()), 1.0)
    neighbours = float((products + fitted)[ring].sum()) / pairs, (2 * len(squares[0, 0]) / pairs) ** 0.5
    reach = next((h for h in reaches if z((distance > 0) & (distance <= h)) > _Z), 0)
    if not reach:
        return _Correlation(1.0, 0, neighbours, 0)
    while 2 * reach <= far:
        g = max(1.0, inflation(reach))
        if z((distance > reach) & (distance <= 2 * reach), g) < _Z_MORE:
            g = max(g, inflation(2 * reach))  # for what the test has missed
            return _Correlation(g, reach, neighbours, (4 * reach + 1) ** 2)
        reach *= 2
    return _Correlation(max(1.0, inflation(reach)), None, neighbours, (2 * far + 1) ** 2)


def _with_whole(
    n: Array, variance: Array, third: Array, spread: Array, shared: Array
) -> tuple[Array, Array, Array]:
    """Standard error, skewness and degrees of freedom of the image's mean and of those of tiles.

    Args:
        n: pixels of each tile.
        variance, third: second and third cumulant of the tiles' means, ``(tiles, channels)``.
        spread: the variance of ``variance``.
        shared: what the variance has that all tiles may share.
    """
    weight = (n / n.sum())[:, None]
    of_image = [(weight**k * c).sum(axis=0) for k, c in ((2, variance), (3, third), (4, spread))]
    variance, third, spread = (
        np.vstack([whole, tiles]) for whole, tiles in zip(of_image, (variance, third, spread), strict=True)
    )
    variance += np.vstack([(weight * np.sqrt(shared)).sum(axis=0) ** 2, shared])
    with np.errstate(divide="ignore", invalid="ignore"):
        skewness = np.where(variance > 0, third / variance**1.5, 0.0)
        freedom = np.where(spread > 0, 2 * variance**2 / spread, np.inf)
    return np.sqrt(variance), skewness, np.maximum(freedom, 1.0)


def _between_tiles(
    error: Array, residual: Array, scale: Array, windows: Sequence[Window]
) -> tuple[Array, Array]:
    """Standard errors from how tiles scatter among each other, and their degrees of freedom."""
    means = np.array([residual[w].mean(axis=(0, 1)) for w in windows])
    scales = np.array([scale[w].mean(axis=(0, 1)) for w in windows])
    tiles = np.sqrt(error[1:] ** 2 + (scales * (means / scales).std(axis=0, ddof=1)) ** 2)
    # next to each other, tiles may share a quarter of their noise: 1 + 4 / 4
    whole = np.maximum(error[0], np.sqrt(2 / len(windows)) * means.std(axis=0, ddof=1))
    error = np.vstack([whole, tiles])
    return error, np.full_like(error, len(windows) - 1.0)
