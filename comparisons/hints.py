"""What usually goes wrong with an image on its way: turned over, encoded for a screen, scaled, shifted, clipped.

The image is undone in each of these ways, and in some at once, and held against the truth by the means of 8 × 8
blocks, which are less noisy than pixels. With x and t those means, ε = (5 % of the mean of t)²:

    misfit = ⟨min((x − t)² / (t² + ε), 1)⟩

A hint is given where the misfit falls to less than a tenth, by the simplest way that is about as good as the best.
Before that, whether the image simply has another number of bounces.
Shifts and softness are too small for blocks. They are fitted pixel by pixel,

    x − t ≈ −δ · ∇t + c ∇²t,

with δ the shift to the right and down, and c > 0 for a pixel filter wider than the box over which the truth is
averaged (half the difference of their variances, pixels²). Hints explain; they decide nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from comparisons.results import Hint

Array = NDArray[np.float64]

BLOCKS = 8
_FLOOR = 0.05
_SAME_MEAN = 0.05
_PLATEAU = 0.01  # of all pixels: so many have the largest value if that is where it was cut
_FAR_BETTER = 0.1  # of the misfit: a third of the deviation

_TURNS: dict[str, Callable[[Array], Array]] = {
    "": lambda image: image,
    "turned upside down": lambda image: image[::-1],
    "mirrored left to right": lambda image: image[:, ::-1],
    "turned by 180°": lambda image: image[::-1, ::-1],
}
_KINDS = {
    "turned": "turned",
    "mirrored": "turned",
    "decoded": "encoded",
    "with": "exchanged",
    "divided": "scaled",
}
_CONSTANTS = {"π": math.pi, "2π": 2 * math.pi, "4π": 4 * math.pi, "1/π": 1 / math.pi}


def hints(image: Array, terms: Array, counted: bool = False) -> list[Hint]:
    """Kinds and sentences that say what the image may have gone through; none where nothing explains it far better.

    Args:
        image: the sum of all bounces, ``(height, width, channels)``, finite, at least 8 × 8 pixels.
        terms: the truth of each bounce, ``(bounces + 1, height, width, channels)``.
        counted: it is known to have that many bounces, by its layers.
    """
    truth = terms.sum(axis=0)
    if truth.mean() <= 0:
        return []
    if not image.any():
        return [Hint(kinds=[], text="It is black everywhere: was anything rendered?")]
    found = list[Hint]()
    if (clipped := _clipped(image, truth)) is not None:
        found, truth = [clipped], np.minimum(truth, image.max())
    if not (found or counted) and (other := _counted(image, terms)):
        return [other]
    undone = _undone(image, truth)
    return [*undone, *found] if undone else found + _displaced(image, truth)


def hints_of_terms(images: Array, terms: Array, right_emission: bool) -> list[Hint]:
    """The same of an image of which every term is known, and whether its E is right.

    What moves or blurs an image does so to E as well, if E has places, and keeps the mean of the sum.
    """
    image, truth = images.sum(axis=0), terms.sum(axis=0)
    found = hints(image, terms)
    stays = right_emission and np.ptp(terms[0]) > 0
    if not stays and abs(image.mean() - truth.mean()) < _SAME_MEAN * truth.mean():
        return found
    return [hint for hint in found if not {"turned", "shifted", "soft"} & set(hint.kinds)]


def _clipped(image: Array, truth: Array) -> Hint | None:
    """Whether it was cut at 1, as codes of a screen are; or elsewhere, if many pixels have the largest value and the
    truth, cut there, fits far better."""
    most, brightest = float(image.max()), float(truth.max())
    cut = np.minimum(truth, most)
    expected, weights = _blocks(truth), _weights(_blocks(truth))
    at_one = 0.999 < most <= 1 and brightest > 1.05
    # of an image that is cut everywhere nobody can tell it from one that is scaled
    some_below = (truth < 0.9 * most).mean() >= _PLATEAU
    plateau = most < 0.95 * brightest and (image > (1 - 1e-3) * most).mean() >= _PLATEAU and some_below
    fits = plateau and _misfit(_blocks(image), _blocks(cut), weights) <= _FAR_BETTER * _misfit(
        _blocks(image), expected, weights
    )
    if not (at_one or fits):
        return None
    text = f"No value is above {most:.3g}, but the truth reaches {brightest:.4g}: it seems to be clipped."
    return Hint(kinds=["clipped"], text=text)


def _counted(image: Array, terms: Array) -> Hint | None:
    """Whether it has fewer bounces than asked for, or all of them; None if not.

    What lies beyond the last bounce is taken for a geometric series with the ratio of the last two, per channel.
    """
    sums, last = np.cumsum([_blocks(term) for term in terms], axis=0), len(terms) - 1
    weights, tried = _weights(sums[-1]), dict(enumerate(sums[:-1]))
    plain = _misfit(_blocks(image), sums[-1], weights)
    before, end = (terms[k].mean(axis=(0, 1)) for k in (max(last - 1, 0), last))
    ratio = np.divide(end, before, out=np.zeros_like(end), where=before > 0)
    if last and ratio.max() < 1:
        tried[last + 1] = sums[-1] + _blocks(terms[last]) * ratio / (1 - ratio)
    misfits = {n: _misfit(_blocks(image), expected, weights) for n, expected in tried.items()}
    best = min(misfits, key=lambda n: misfits[n], default=last)
    if best == last or misfits[best] > _FAR_BETTER * plain:
        return None
    if best > last:
        text = (
            f"It fits far better with more bounces than {last}: give --bounces as many as it was made with."
        )
        return Hint(kinds=["bounces"], text=text)
    return Hint(
        kinds=["bounces"],
        text=f"It fits the truth of bounces 0 to {best} far better: does it have no more? Then say --bounces {best}.",
    )


def _undone(image: Array, truth: Array) -> list[Hint]:
    """The best way to undo something; none if the image is as good as it is."""
    expected = _blocks(truth)
    weights = _weights(expected)
    plain = _misfit(_blocks(image), expected, weights)
    tried = [
        (_misfit(_blocks(candidate), expected, weights), len(done), done)
        for done, candidate in _ways(image, truth)
    ]
    best = min(misfit for misfit, _, _ in tried)
    good = [(steps, misfit, done) for misfit, steps, done in tried if misfit <= 2 * best + 1e-12]
    _, misfit, done = min(good)
    if not done or misfit > _FAR_BETTER * plain:
        return []
    left = 100 * math.sqrt(misfit / plain)
    text = f"It fits the truth far better {' and '.join(done)}: {left:.0f} % of the deviation is left then."
    return [Hint(kinds=[_KINDS[step.split()[0]] for step in done], text=text)]


def _ways(image: Array, truth: Array) -> Iterator[tuple[list[str], Array]]:
    """What is done to the image, and what it becomes."""
    for turn, turned in _TURNS.items():
        for decode in (False, True):
            for exchange in (False, True) if image.shape[-1] == 3 else (False,):
                candidate = turned(image)
                candidate = _from_srgb(candidate) if decode else candidate
                candidate = candidate[..., ::-1] if exchange else candidate
                done = [turn] if turn else []
                done += ["decoded from sRGB"] if decode else []
                done += ["with red and blue exchanged"] if exchange else []
                yield done, candidate
                factor = _scale(_blocks(candidate), _blocks(truth))
                if factor > 0:
                    yield [*done, f"divided by {_named(factor)}"], candidate / factor


def _named(factor: float) -> str:
    near = [name for name, value in _CONSTANTS.items() if abs(factor / value - 1) < 0.01]
    return f"{factor:.4g}" + (f", about {near[0]}" if near else "")


def _from_srgb(image: Array) -> Array:
    """IEC 61966-2-1, continued beyond 1."""
    power: Array = ((np.maximum(image, 0.04045) + 0.055) / 1.055) ** 2.4
    return np.where(image <= 0.04045, image / 12.92, power)


def _blocks(image: Array) -> Array:
    """Means over 8 × 8 blocks of nearly equal size."""
    for axis in (0, 1):
        edges = np.arange(BLOCKS) * image.shape[axis] // BLOCKS
        lengths = np.diff(edges, append=image.shape[axis])
        image = np.add.reduceat(image, edges, axis) / lengths.reshape(
            [-1 if a == axis else 1 for a in range(3)]
        )
    return image


def _weights(truth: Array) -> Array:
    weights: Array = 1 / (truth**2 + (_FLOOR * truth.mean()) ** 2)
    return weights


def _misfit(image: Array, truth: Array, weights: Array) -> float:
    return float(np.minimum((image - truth) ** 2 * weights, 1).mean())


def _scale(image: Array, truth: Array) -> float:
    """The factor k for which image ≈ k truth, by least squares of relative deviations."""
    return float((image * truth * _weights(truth)).sum() / (truth**2 * _weights(truth)).sum())


def _displaced(image: Array, truth: Array) -> list[Hint]:
    """Whether the edges of the image are shifted or softer."""
    t, r = truth, (image - truth)[1:-1, 1:-1]
    root = np.sqrt(_weights(t))[1:-1, 1:-1]
    along_y, along_x = (t[2:, 1:-1] - t[:-2, 1:-1]) / 2, (t[1:-1, 2:] - t[1:-1, :-2]) / 2
    curvature = t[2:, 1:-1] + t[:-2, 1:-1] + t[1:-1, 2:] + t[1:-1, :-2] - 4 * t[1:-1, 1:-1]
    # only where the truth has edges; the truth itself takes up what is in proportion to it
    edges = np.abs(curvature) + np.hypot(along_x, along_y) > 0.1 / root
    design = np.stack([-along_x, -along_y, curvature, t[1:-1, 1:-1]], axis=-1)[edges] * root[edges][:, None]
    wanted = r[edges] * root[edges]
    if len(wanted) < 32 or np.linalg.matrix_rank(design) < 4:
        return []
    inverse = np.linalg.inv(design.T @ design)
    fit = inverse @ design.T @ wanted
    rest = wanted - design @ fit
    error = np.sqrt(np.diag(inverse) * (rest**2).sum() / (len(rest) - 4))
    explained = 1 - (rest**2).sum() / max((wanted**2).sum(), np.finfo(float).tiny)
    x, y, c, _ = fit
    if explained < 0.3:
        return []
    found = []
    largest = np.abs(fit[:2]).max()  # of more than that a first-order expansion knows nothing
    if largest < 1.5 and (np.abs(fit[:2]) > np.maximum(8 * error[:2], 0.2)).any():
        sides = (
            f"{abs(x):.2f} pixels {'right' if x > 0 else 'left'} and {abs(y):.2f} {'down' if y > 0 else 'up'}"
        )
        text = (
            f"Its edges look shifted by {sides}: half a pixel usually means corners of pixels that were "
            "taken for their centres."
        )
        found.append(Hint(kinds=["shifted"], text=text))
    if c > max(8 * error[2], 0.03):
        text = (
            "Its edges look softer than the truth's, which is each pixel's own average: was it rendered with a wider "
            "pixel filter than the box, or denoised?"
        )
        found.append(Hint(kinds=["soft"], text=text))
    return found
