"""A page as it is read, and folders of few comparisons to make one from."""

from __future__ import annotations

import html.parser
import re
from pathlib import Path

import msgspec

import reports
from comparisons.results import Results, write


class Page(html.parser.HTMLParser):
    """The tags, links and visible text of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self._raw = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self._raw = tag in {"script", "style"}

    def handle_endtag(self, tag: str) -> None:
        self._raw = False

    def handle_data(self, data: str) -> None:
        if not self._raw:
            self.words.append(data)

    @property
    def text(self) -> str:
        return re.sub(r"\s+", " ", " ".join(self.words))

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.tags if name == tag]


def rendered(folder: Path) -> Page:
    path, _ = reports.render(folder)
    return Page(path.read_text(encoding="utf-8"))


def alone(results: Results, folder: Path, *indices: int) -> None:
    """Leave but these of the comparisons."""
    write(msgspec.structs.replace(results, comparisons=[results.comparisons[i] for i in indices]), folder)
