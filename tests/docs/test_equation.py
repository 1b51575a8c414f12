"""What the documentation says is so: excerpts stand in their files, sessions run, links lead somewhere."""

from __future__ import annotations

import doctest
import re
from pathlib import Path
from textwrap import dedent
from typing import NamedTuple

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs").glob("*.md"))

FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
MARKER = re.compile(r"<!-- from (\S+) -->\n\Z")


class Excerpt(NamedTuple):
    """A block of Python, and the file that it says it is from; None where it doesn't say."""

    source: str | None
    code: str


def excerpts(page: str) -> list[Excerpt]:
    found = []
    for fence in FENCE.finditer(page):
        marker = MARKER.search(page[: fence.start()])
        if fence[1] == "python":
            found.append(Excerpt(marker[1] if marker else None, fence[2]))
    return found


def occurs(code: str, source: str) -> bool:
    """Whether the lines stand in the source one after the other, indented as a whole by whatever it is.

    Empty lines don't count: formatters put two between functions on a page, and one within a class.
    """
    wanted, lines = ([line for line in text.splitlines() if line.strip()] for text in (dedent(code), source))
    windows = (lines[i : i + len(wanted)] for i in range(len(lines) - len(wanted) + 1))
    return any(dedent("\n".join(window)).splitlines() == wanted for window in windows)


def anchors(page: str) -> set[str]:
    """What GitHub makes of the headings."""
    headings = re.findall(r"^#+ (.*)$", page, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


EXCERPTS = [
    (page.name, excerpt)
    for page in PAGES
    for excerpt in excerpts(page.read_text())
    # what stands there is the reader's own; test_pytest and test_renderers look at it
    if page.name not in ("pytest.md", "renderers.md")
]


@pytest.mark.parametrize(("page", "excerpt"), EXCERPTS)
def test_excerpts_stand_in_their_files(page: str, excerpt: Excerpt) -> None:
    assert excerpt.source, f"{page}: no '<!-- from FILE -->' in the line above\n{excerpt.code}"
    source = (ROOT / excerpt.source).read_text()
    assert occurs(excerpt.code, source), f"{page}: {excerpt.source} has no such lines\n{excerpt.code}"
    assert f"](../{excerpt.source})" in (ROOT / "docs" / page).read_text(), f"no link to {excerpt.source}"


def test_the_equation_quotes_every_rung() -> None:
    sources = {excerpt.source for page, excerpt in EXCERPTS if page == "equation.md"}
    rungs = ("operators", "propagation", "reflection", "random_walk", "samplers", "finite_elements")
    assert sources == {f"reference_tracer/{rung}.py" for rung in rungs}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_sessions(page: Path) -> None:
    sessions = [fence[2] for fence in FENCE.finditer(page.read_text()) if fence[1] == "pycon"]
    test = doctest.DocTestParser().get_doctest("\n".join(sessions), {}, page.name, str(page), 0)
    messages: list[str] = []
    with np.printoptions(
        legacy=False
    ):  # other packages, once loaded, may have changed how arrays are written
        results = doctest.DocTestRunner(verbose=False).run(test, out=messages.append)
    assert not results.failed, "".join(messages)
    if page.name == "equation.md":
        assert results.attempted > 40


@pytest.mark.parametrize("page", [*PAGES, ROOT / "README.md"], ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\((?!https?://)([^)\s]+)\)|<img[^>]* src=\"([^\"]+)\"", page.read_text())
    for link in (markdown or html for markdown, html in links):
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), f"{page.name} links to {link}"
        assert not anchor or anchor in anchors(target.read_text()), f"{page.name} links to {link}"


# ---- the checks find what is wrong

SOURCE = "def f(x):\n    if x:\n        y = 1\n        return y\n    return 2\n"


@pytest.mark.parametrize(
    "code", ["y = 1\nreturn y\n", "if x:\n    y = 1\n", "return 2\n", "y = 1\n\nreturn y\n", SOURCE]
)
def test_lines_of_the_source_occur(code: str) -> None:
    assert occurs(code, SOURCE)


@pytest.mark.parametrize(
    "code",
    [
        "y = 2\n",
        "if x:\n    return y\n",
        "if x:\ny = 1\n",
        "return\n",
        "return  2\n",
        "y = 1\nz = 1\nreturn y\n",
    ],
    ids=["another value", "a line left out", "not indented", "half a line", "another space", "a line more"],
)
def test_other_lines_do_not(code: str) -> None:
    assert not occurs(code, SOURCE)


def test_only_a_marker_right_above_counts() -> None:
    page = "<!-- from a.py -->\n```python\nx\n```\n\ntext\n```python\ny\n```\n```pycon\n>>> 1\n1\n```\n"
    assert excerpts(page) == [Excerpt("a.py", "x\n"), Excerpt(None, "y\n")]
