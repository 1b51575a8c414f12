"""README says how many of the cases each format takes: the exporters are asked."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from scenes import Scene, library
from scenes.channels import single_channel
from scenes.formats.export import UnsupportedFeatureError
from scenes.formats.exporters import EXPORTERS

README = (Path(__file__).parents[2] / "README.md").read_text()


def taken(scenes: Iterable[Scene]) -> list[int]:
    """How many of them Mitsuba's XML, pbrt-v4 and glTF take."""
    found: Counter[str] = Counter()
    for scene in scenes:
        for name, export in EXPORTERS.items():
            try:
                export(scene, "x")
            except UnsupportedFeatureError:
                continue
            found[name] += 1
    return [found[name] for name in ("mitsuba-xml", "pbrt-v4", "gltf")]


def test_the_readme_says_how_many_cases_each_format_takes() -> None:
    said = re.search(
        r"Of the (\d+) cases Mitsuba's XML takes (\d+), pbrt (\d+) and glTF (\d+); "
        r"channel 0\s+of them (\d+), (\d+) and (\d+)",
        " ".join(README.split()),
    )
    assert said is not None
    scenes = [library.case(name).scene for name in library.CASES]
    grey = [single_channel(scene, 0) for scene in scenes]
    assert [*map(int, said.groups())] == [len(scenes), *taken(scenes), *taken(grey)]
