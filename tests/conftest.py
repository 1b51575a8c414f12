"""For tests of every folder: a browser that complains, the processes that are running, and the example in C++."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import pytest


class Process(NamedTuple):
    """What Linux says of a process."""

    pid: int
    state: str
    parent: int
    group: int


@pytest.fixture
def processes() -> Callable[[], list[Process]]:
    """All that are running now."""

    def running() -> list[Process]:
        found = []
        for stat in Path("/proc").glob("[0-9]*/stat"):
            try:
                state, parent, group = stat.read_text().rsplit(")", 1)[1].split()[:3]
            except OSError:
                continue  # it ended while we looked
            found.append(Process(int(stat.parent.name), state, int(parent), int(group)))
        return found

    return running


@pytest.fixture(scope="session")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder in which examples/tiny has been built: its sources, its objects, and the program ``tiny``."""
    if not (
        shutil.which("make") and shutil.which("pkg-config") and shutil.which(os.environ.get("CXX", "g++"))
    ):
        if os.environ.get("CI") == "true":
            pytest.fail("no C++ compiler, and CI has to build the example")
        pytest.skip("no C++ compiler")
    if subprocess.run(["pkg-config", "--exists", "OpenEXR", "nlohmann_json"]).returncode:
        if os.environ.get("CI") == "true":
            pytest.fail("libopenexr-dev or nlohmann-json3-dev is missing, and CI has to build the example")
        pytest.skip("libopenexr-dev or nlohmann-json3-dev is missing")
    folder = tmp_path_factory.mktemp("tiny")
    sources = Path(__file__).parents[1] / "examples" / "tiny"
    for source in [*sources.glob("*.h"), *sources.glob("*.cpp"), sources / "Makefile"]:
        shutil.copy(source, folder)
    built = subprocess.run(["make"], cwd=folder, capture_output=True, text=True, timeout=300)
    assert built.returncode == 0, built.stderr
    assert "warning" not in built.stderr, built.stderr
    return folder


class Watched:
    """A page and everything on it that a report must not do."""

    def __init__(self, page: Any, file: Path) -> None:
        self.page, self.complaints = page, list[str]()
        own = file.resolve().as_uri()
        page.on("console", self._on_console)
        page.on("pageerror", lambda error: self.complaints.append(f"page error: {error}"))
        page.on("request", lambda request: self._on_request(request.url, own))

    def _on_console(self, message: Any) -> None:
        if message.type in {"error", "warning"}:
            self.complaints.append(f"console {message.type}: {message.text}")

    def _on_request(self, url: str, own: str) -> None:
        if url.partition("#")[0] != own and not url.startswith(("data:", "blob:")):
            self.complaints.append(f"request: {url[:200]}")


OpenReport = Callable[..., Any]


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """One browser for all tests of a file; each page has a profile of its own."""
    executable = shutil.which("chromium") or shutil.which("chromium-browser")
    if executable is None:
        if os.environ.get("CI") == "true":
            pytest.fail("chromium is not installed, and CI has to test the report in a browser")
        pytest.skip("chromium is not installed")
    with _browser(executable) as browser:
        yield browser


@pytest.fixture
def open_report(chromium: Any) -> Iterator[OpenReport]:
    """``open_report(path)`` opens a report in Chromium, checks it, and returns the page for further checks.

    It fails on any error or warning in the console, any request but the file itself, any image that does not
    load and, unless ``plots=False``, any plot of an open section that is not drawn once it is in view. Options go to
    Playwright's ``new_page``.
    """
    yield lambda path, *, plots=True, **options: _checked(chromium, path, plots, options)
    for context in chromium.contexts:
        context.close()


@contextmanager
def _browser(executable: str) -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    quiet = [
        "--disable-background-networking",
        "--disable-component-update",
        "--disable-sync",
        "--no-first-run",
    ]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=executable, args=["--no-sandbox", "--disable-gpu", *quiet]
        )
        try:
            yield browser
        finally:
            browser.close()


def _checked(browser: Any, path: Path, plots: bool, options: dict[str, Any]) -> Any:
    watched = Watched(browser.new_page(**({"viewport": {"width": 1280, "height": 900}} | options)), path)
    page = watched.page
    page.goto(path.resolve().as_uri())
    page.wait_for_load_state("load")
    if plots:
        drawn = [plot for plot in page.query_selector_all(".plot") if plot.is_visible()]
        assert drawn, "there is no plot"
        for plot in drawn:
            plot.scroll_into_view_if_needed()
            # Playwright's selectors look into the shadow roots that Bokeh draws in
            canvas = plot.wait_for_selector("canvas", state="attached")
            page.wait_for_function("() => Bokeh.documents.every(d => d.is_idle)")
            assert canvas.evaluate(_HAS_INK), "a plot is empty"
        page.evaluate("() => scrollTo(0, 0)")
    unseen = page.evaluate("() => [...document.images].filter(i => !i.naturalWidth).map(i => i.alt)")
    assert not unseen, f"images that don't load: {unseen}"
    page.wait_for_timeout(200)
    assert not watched.complaints
    return page


_HAS_INK = """canvas => {
  const {width, height} = canvas;
  return width > 0 && canvas.getContext("2d").getImageData(0, 0, width, height).data.some(v => v);
}"""
