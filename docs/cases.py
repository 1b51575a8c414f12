"""The pages of the library: ``python docs/cases.py`` writes docs/cases/, a page per family, from the cases.

A picture shows every bounce of the answer, E first, all at one exposure; an answer of one pixel is a table.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from reports.exposure import Pixels, automatic, encode
from scenes import Case
from scenes.library import FAMILIES, case

SIDE, GAP = 128, 4
NAMES = ("E", "TE", "T²E", "T³E", "T⁴E", "T⁵E", "T⁶E", "T⁷E", "T⁸E", "T⁹E")


def truth(made: Case) -> NDArray[np.float64]:
    """The answer of a case, ``(bounces + 1, height, width, channels)``."""
    found = made.answer.truth(made.scene, made.bounces)
    assert found is not None
    return found.mean


def exposure(images: NDArray[np.float64]) -> float:
    """One factor for all bounces: what suits the first one after E that has light."""
    return automatic(*images[1:], images[0])


def strip(images: NDArray[np.float64]) -> Pixels:
    """All bounces side by side, pixels as squares."""
    factor, pictures = exposure(images), []
    for image in images:
        zoom = max(1, SIDE // max(image.shape[:2]))
        pixels = encode(image, factor).repeat(zoom, axis=0).repeat(zoom, axis=1)
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
    last = "any" if made.max_bounces is None else f"up to {made.max_bounces}"
    return [
        f"## `{made.name}`\n",
        f"{made.title}.\n",
        *(_picture(made, images) if images[0, ..., 0].size > 1 else _table(images)),
        f"{_paragraphs(made.derivation)}\n",
        f"- **Truth**: {made.answer.kind}, bounces {last}; {made.bounces} are asked for by default.",
        f"- **Source**: {made.answer.source}.".replace("..", "."),
        f"- **Blind to**: {made.blind_to}.\n",
    ]


def _picture(made: Case, images: NDArray[np.float64]) -> list[str]:
    shown = ", ".join(NAMES[: len(images)])
    return [f"![{shown}]({made.name}.webp)\n", f"*{shown}; exposure ×{exposure(images):g}.*\n"]


def _table(images: NDArray[np.float64]) -> list[str]:
    values = [", ".join(f"{v:.6g}" for v in image.ravel()) for image in images]
    head = "| " + " | ".join(NAMES[: len(images)]) + " |"
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
            images = truth(case(name))
            if images[0, ..., 0].size > 1:
                yield f"{name}.webp", strip(images)


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
