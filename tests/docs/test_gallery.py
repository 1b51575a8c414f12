"""The gallery: its script still runs, and page, script and pictures are about the same."""

from __future__ import annotations

import importlib
import re
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from PIL import Image

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "gallery.md").read_text()
MOST = 1_000_000  # bytes, all pictures together


@pytest.fixture
def gallery(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(DOCS))
    return importlib.import_module("gallery")


def files(folder: Path) -> set[str]:
    return {file.name for file in folder.iterdir()}


def test_the_script_writes_the_pictures_of_the_page(gallery: ModuleType, tmp_path: Path) -> None:
    gallery.write(tmp_path, shrink=16)
    shown = set(re.findall(r"\(gallery/(\S+)\)", PAGE))
    assert files(tmp_path) == shown == files(DOCS / "gallery")
    for name in shown:
        small, committed = pixels(tmp_path / name), pixels(DOCS / "gallery" / name)
        assert (16 * small.shape[0], 16 * small.shape[1]) == committed.shape[:2], name


def test_the_pictures_are_small() -> None:
    assert sum(file.stat().st_size for file in (DOCS / "gallery").iterdir()) < MOST


def test_the_pictures_are_what_the_script_makes(gallery: ModuleType) -> None:
    """Mean colours of the committed pictures and of small ones rendered now, beside the lamp, which is clipped."""
    now = dict(gallery.bounces(shrink=16))
    for name in now:
        committed = pixels(DOCS / "gallery" / f"{name}.webp")
        whole = committed.reshape(16, 16, 16, 16, 3).max(axis=(1, 3, 4)) < 250
        mean = blocks(committed)[whole].mean(axis=0)
        off = {other: np.abs(blocks(now[other])[whole].mean(axis=0) - mean).max() for other in now}
        assert off[name] < 0.005, f"{name}.webp is another picture; run python docs/gallery.py"
        # the check has power: no other bounce, and no other sum, would pass for this one
        kind = name.partition("-")[0]
        assert all(off[other] > 0.02 for other in now if other.startswith(kind) and other != name)


def test_the_page_states_exposures_and_samples(gallery: ModuleType) -> None:
    sections = re.split(r"^## ", PAGE, flags=re.MULTILINE)[1:]
    exposures = ("CORNELL", "CORNELL", "PLATES", "STILL_LIFE")
    samples = ("CORNELL", "LADDER", "PLATES", "STILL_LIFE")
    for section, exposure, spp in zip(sections, exposures, samples, strict=True):
        text = " ".join(section.split())
        assert f"×{getattr(gallery, f'{exposure}_EXPOSURE'):g}" in text
        assert re.search(rf"\b{getattr(gallery, f'{spp}_SPP')} (samples )?per pixel", text)


def pixels(file: Path) -> np.ndarray:
    with Image.open(file) as image:
        return np.asarray(image.convert("RGB"))


def blocks(srgb: np.ndarray) -> np.ndarray:
    """16 × 16 averages, decoded by the inverse of the sRGB encoding, IEC 61966-2-1."""
    c, n = srgb / 255, len(srgb) // 16
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    averages: np.ndarray = linear.reshape(16, n, 16, n, 3).mean(axis=(1, 3))
    return averages
