"""The pages of the library: ``python docs/cases.py`` writes docs/cases/, a page per family, from the cases.

A picture shows every bounce of the answer that has light, each at an exposure of its own, as in the report; spectra
are taken to sRGB. Where all pixels are the same, the bounces share one exposure, so that they are seen to decay, and
a table has the values. An answer of one pixel is a table.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from reports.exposure import Pixels, automatic, encode
from reports.quantities import number, term
from scenes import Case
from scenes.case import Committed, Computed, Estimate
from scenes.formats import exr
from scenes.library import FAMILIES, case
from scenes.spectral import chromaticity, linear_srgb, to_xyz

SIDE, GAP = 128, 4


def truth(made: Case) -> NDArray[np.float64]:
    """The answer of a case, ``(bounces + 1, height, width, channels)``."""
    return _truth(made.name)


@cache
def _truth(name: str) -> NDArray[np.float64]:
    """Of the case of that name; both the pages and the pictures need it."""
    made = case(name)
    found = made.answer.truth(made.scene, made.bounces)
    assert found is not None
    return found.mean


def lit(images: NDArray[np.float64]) -> list[int]:
    """The bounces that have any light."""
    return [k for k, image in enumerate(images) if image.any()]


def shown(made: Case, images: NDArray[np.float64]) -> NDArray[np.float64]:
    """The images as they are looked at: spectra in linear sRGB."""
    return images if made.wavelengths is None else linear_srgb(images, made.wavelengths)


def uniform(images: NDArray[np.float64]) -> bool:
    """Whether in each bounce all pixels are the same."""
    return bool(np.ptp(images, axis=(1, 2)).max() < 1e-9 * images.max())


def exposures(images: NDArray[np.float64]) -> dict[int, float]:
    """Of each bounce that has light."""
    return {k: automatic(*images) if uniform(images) else automatic(images[k]) for k in lit(images)}


def strip(images: NDArray[np.float64]) -> Pixels:
    """The bounces that have light side by side, pixels as squares."""
    pictures = []
    for k, factor in exposures(images).items():
        zoom = max(1, SIDE // max(images.shape[1:3]))
        pixels = encode(images[k], factor).repeat(zoom, axis=0).repeat(zoom, axis=1)
        pictures += [pixels, np.full((len(pixels), GAP, 3), 255, dtype=np.uint8)]
    return np.concatenate(pictures[:-1], axis=1)


def page(family: ModuleType) -> str:
    """The page of a family."""
    parts = [f"# {_words(family)}\n", inspect.cleandoc(family.__doc__ or ""), ""]
    for name in family.CASES:
        parts += section(case(name))
    return "\n".join(parts).rstrip() + "\n"


def section(made: Case) -> list[str]:
    """What a page says of a case."""
    images = truth(made)
    return [
        f"## `{made.name}`\n",
        f"{made.title}.\n",
        *(_picture(made, images) if images[0, ..., 0].size > 1 else []),
        *(_table(images[:, :1, :1]) if uniform(images) and made.wavelengths is None else []),
        f"{_paragraphs(made.derivation)}\n",
        f"- **Truth**: {made.answer.kind}, bounces {_last(made)}; {made.bounces} are asked for by default.",
        *_error(made),
        *_spectrum(made, images),
        f"- **Source**: {made.answer.source}.".replace("..", "."),
        f"- **Blind to**: {made.blind_to}.\n",
    ]


def _picture(made: Case, images: NDArray[np.float64]) -> list[str]:
    pictured = shown(made, images)
    factors = exposures(pictured)
    caption = "Exposures: " + ", ".join(f"{term(k)} ×{number(factor)}" for k, factor in factors.items())
    if len(set(factors.values())) == 1 < len(factors):
        caption = f"Exposure: ×{number(automatic(*pictured))} for all"
    if dark := [term(k) for k in range(len(images)) if k not in factors]:
        caption += f". No light: {', '.join(dark)}"
    return [f"![{', '.join(map(term, factors))}]({made.name}.webp)\n", f"*{caption}.*\n"]


def _last(made: Case) -> str:
    """The bounces for which there is an answer."""
    if isinstance(made.answer, Committed):
        return f"0 to {len(exr.read_bounces(made.answer.path)[0]) - 1} as data, further ones when they are asked for"
    return "any" if made.max_bounces is None else f"up to {made.max_bounces}"


def _error(made: Case) -> list[str]:
    """How far an answer that is no formula may be off, bounce by bounce."""
    if isinstance(made.answer, Computed):
        what, errors = "Error, relative", made.answer.error
    elif isinstance(made.answer, Estimate):
        mean, stderr = exr.read_bounces(made.answer.path)
        of_mean = np.sqrt((stderr**2).sum(axis=(1, 2))) / mean.sum(axis=(1, 2))
        what, errors = "Standard error of the mean of the image, relative", tuple(of_mean.max(axis=-1))
    else:
        return []
    listed = ", ".join(
        f"{term(k)} {error:.1e}" if error else f"{term(k)} 0" for k, error in enumerate(errors)
    )
    return [f"- **{what}**: {listed}."]


def _spectrum(made: Case, images: NDArray[np.float64]) -> list[str]:
    """What a page says of a spectral case: its wavelengths, and the chromaticity of each bounce."""
    if made.wavelengths is None:
        return []
    first, *_, last = made.wavelengths
    xy = chromaticity(to_xyz(images.mean(axis=(1, 2)), made.wavelengths))
    colours = ", ".join(f"{term(k)} ({x:.3f}, {y:.3f})" for k, (x, y) in enumerate(xy))
    return [
        f"- **Wavelengths**: {len(made.wavelengths)}, from {first:g} to {last:g} nm. "
        f"Chromaticity (x, y) of the mean of each bounce: {colours}."
    ]


def _table(images: NDArray[np.float64]) -> list[str]:
    values = [", ".join(f"{v:.6g}" for v in image.ravel()) for image in images]
    head = "| " + " | ".join(map(term, range(len(images)))) + " |"
    return [head, "|---" * len(images) + "|", "| " + " | ".join(values) + " |\n"]


def _paragraphs(text: str) -> str:
    return "\n".join(line.strip() for line in text.strip().splitlines())


def _words(family: ModuleType) -> str:
    return family.__name__.rpartition(".")[2].replace("_", " ").capitalize().replace("Cie", "CIE")


def index() -> str:
    """The table of all cases."""
    lines = [
        "# The cases\n",
        "Written by `python docs/cases.py` from [scenes/library](../../scenes/library).\n",
    ]
    lines += ["| case | what | truth |", "|---|---|---|"]
    for family in FAMILIES:
        file = f"{family.__name__.rpartition('.')[2]}.md"
        for name in family.CASES:
            made = case(name)
            lines.append(f"| [`{name}`]({file}#{name}) | {made.title} | {made.answer.kind} |")
    return "\n".join(lines) + "\n"


def pages() -> Iterator[tuple[str, str]]:
    """File name and text of every page."""
    yield "README.md", index()
    for family in FAMILIES:
        yield f"{family.__name__.rpartition('.')[2]}.md", page(family)


def pictures() -> Iterator[tuple[str, Pixels]]:
    """File name and pixels of every picture."""
    for family in FAMILIES:
        for name in family.CASES:
            made = case(name)
            images = truth(made)
            if images[0, ..., 0].size > 1:
                yield f"{name}.webp", strip(shown(made, images))


def write(folder: Path) -> None:
    """Write everything, and remove what no case has any more."""
    folder.mkdir(parents=True, exist_ok=True)
    kept = set()
    for name, text in pages():
        (folder / name).write_text(text)
        kept.add(name)
    for name, pixels in pictures():
        Image.fromarray(pixels).save(folder / name, lossless=True, method=6)
        kept.add(name)
    for file in folder.iterdir():
        if file.name not in kept:
            file.unlink()


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("cases"))
