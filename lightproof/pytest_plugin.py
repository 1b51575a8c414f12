"""The pytest plugin: the fixture ``lightproof``, and ``--lightproof-renderer``, which makes every case a test.

Installed with the package (entry point ``pytest11``), so it is loaded wherever pytest starts: whatever takes time
is imported when it is needed.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from lightproof.host import Host

_running: list[pytest.Item] = []
"""The test that runs now; the last one, where a test runs pytest itself."""

_WITH_RENDERER = ("case", "few", "size", "tolerance", "tile_tolerance")
"""Options that go with ``--lightproof-renderer`` alone."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Say what there is."""
    group = parser.getgroup("lightproof", "lightproof: light transport, bounce by bounce")

    def option(name: str, help: str, **kind: Any) -> None:
        group.addoption(f"--lightproof-{name}", help=help, **kind)

    option(
        "renderer",
        "Hold this renderer ('lightproof list renderers') against cases whose every bounce is known, a test each: "
        "lightproof::CASE[NAME]. They run alone, or besides the tests of the paths that are given. May be given "
        "several times.",
        action="append",
        metavar="NAME",
    )
    option(
        "case",
        "With --lightproof-renderer: this case ('lightproof list cases'), or one of your own, FILE.py:NAME. May be "
        "given several times. Default: those that 'lightproof validate' takes.",
        action="append",
        metavar="CASE",
    )
    option(
        "few",
        "With --lightproof-renderer: the cases that 'lightproof validate' takes, not all.",
        action="store_true",
    )
    option(
        "size", "With --lightproof-renderer: the resolution, as 16x16. Default: the case's.", metavar="WxH"
    )
    option(
        "tolerance",
        "With --lightproof-renderer: the largest bias of the whole image, as 0.5%%. Default: the case's.",
        metavar="PERCENT",
    )
    option(
        "tile-tolerance",
        "With --lightproof-renderer: the same for tiles. Default: the case's.",
        metavar="PERCENT",
    )
    option(
        "budget",
        "Time for each comparison that says nothing itself; less where the verdict is clear sooner. Default: that "
        "of 'lightproof validate'.",
        type=float,
        metavar="SECONDS",
    )
    option(
        "report",
        "Keep the report of every comparison in this folder, in one of its own that is called after the test. "
        "Default: of those with something wrong, in pytest's temporary folder.",
        metavar="DIR",
    )
    option(
        "unsupported",
        "What becomes of a scene that the renderer can't express. Default: skip.",
        choices=("skip", "fail"),
        default="skip",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Find the renderers and cases that are asked for; what does not exist is wrong usage."""
    report = config.getoption("lightproof_report")
    if report is not None and (config.invocation_params.dir / report).is_file():
        raise pytest.UsageError(f"--lightproof-report: {report} is a file, expected a folder")
    budget = config.getoption("lightproof_budget")
    if budget is not None and not 0 < budget < float("inf"):
        raise pytest.UsageError(f"--lightproof-budget: expected seconds above 0, found {budget:g}")
    if config.getoption("lightproof_renderer"):
        from lightproof.pytest_cases import Cases

        config.pluginmanager.register(Cases(config), "lightproof-cases")
        return
    for name in _WITH_RENDERER:
        if config.getoption(f"lightproof_{name}"):
            option = f"--lightproof-{name.replace('_', '-')}"
            raise pytest.UsageError(f"{option}: say of which renderer, --lightproof-renderer NAME")


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, None, None]:
    """Know which test it is that asserts."""
    _running.append(item)
    yield
    _running.pop()


def running_test() -> Host | None:
    """The host of an assertion that the running test makes."""
    if not _running:
        return None
    from lightproof.pytest_host import PytestHost

    return PytestHost(_running[-1])


@pytest.fixture(scope="session")
def lightproof() -> Any:
    """Lightproof's assertions: ``lightproof.assert_bounces_match(renderer, case, tolerance="0.5%")``."""
    import lightproof

    return lightproof


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Name the deviations that passed because they were declared beforehand."""
    reports = (r for found in terminalreporter.stats.values() for r in found)
    properties = (p for r in reports for p in getattr(r, "user_properties", ()))
    known = dict.fromkeys(str(value) for name, value in properties if name == "lightproof-known")
    if known:
        terminalreporter.section("lightproof: known deviations")
        for line in known:
            terminalreporter.line(line)
