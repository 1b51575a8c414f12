"""``pytest --lightproof-renderer NAME``: cases as tests, without a file of tests."""

from __future__ import annotations

import os
from collections.abc import Generator, Iterable
from pathlib import Path
from typing import Any

import pytest
import typer

from comparisons.renderers import ConfigError, canonical
from lightproof.choice import several_cases
from lightproof.parameters import percents, size
from scenes import Case, UnknownNameError, library
from scenes.names import look_up

NODE = "lightproof"
"""What stands before the first ``::`` of a case's node id."""

RENDERER = "--lightproof-renderer"


class Cases:
    """The hooks that are needed only where cases are asked for.

    Raises:
        pytest.UsageError: there is no renderer or case of that name, or an option can't be read.
    """

    def __init__(self, config: pytest.Config) -> None:
        option = config.getoption
        try:
            # passed on as they were written: a share from 10 % on without its sign would be refused
            self.tolerance, self.tile_tolerance = (
                option("lightproof_tolerance"),
                option("lightproof_tile_tolerance"),
            )
            percents(self.tolerance, "tolerance")
            percents(self.tile_tolerance, "tile-tolerance")
            self.size = size(option("lightproof_size"))
            names, few = option("lightproof_case") or [], option("lightproof_few")
            self.all = not names and not few
            cases = several_cases(names, [], [], self.all, (None, None), None, self.size)
            # the same renderer by two names is one
            renderers = {canonical(name): name for name in option("lightproof_renderer")}.values()
            pairs = {f"{case.name}[{name}]": (case, name) for case in cases for name in renderers}
            self.pairs = {name: look_up("test", name, pairs) for name in _take_names(config) or pairs}
        except typer.BadParameter as error:
            hint = str(error.param_hint).lower().lstrip("-")  # as the command calls its own option
            raise pytest.UsageError(f"--lightproof-{hint}: {error.message}") from None
        except (UnknownNameError, ConfigError) as error:
            raise pytest.UsageError(str(error)) from None
        if config.args_source is not pytest.Config.ArgsSource.ARGS and _asked_on_the_command_line(config):
            config.args = []

    def pytest_report_header(self) -> str:
        """Say how many cases there are, and how to have fewer where these are all."""
        taken = len({case.name for case, _ in self.pairs.values()})
        fewer = f", --lightproof-few takes {len(library.DEFAULT)}" if self.all else ""
        return f"lightproof: cases: {taken}{fewer}"

    @pytest.hookimpl(hookwrapper=True)
    def pytest_make_collect_report(self, collector: pytest.Collector) -> Generator[None, Any, None]:
        """Add the cases to what is found in files."""
        outcome = yield
        if isinstance(collector, pytest.Session):
            report = outcome.get_result()
            if report.passed:
                report.result.append(
                    CaseCollector.from_parent(collector, name=NODE, nodeid=NODE, plugin=self)
                )


def _asked_on_the_command_line(config: pytest.Config) -> bool:
    """Rather than in the configuration, where it must not take the project's own tests away."""
    return any(arg.partition("=")[0] == RENDERER for arg in config.invocation_params.args)


def _take_names(config: pytest.Config) -> list[str]:
    """Of the cases whose node ids are given as arguments: pytest would look for files of that name."""
    split = {arg: arg.partition("::") for arg in config.args}
    ours = {arg: name for arg, (file, mark, name) in split.items() if mark and Path(file).name == NODE}
    config.args = [arg for arg in config.args if arg not in ours]
    return list(ours.values())


class CaseCollector(pytest.Collector):
    """All cases × renderers."""

    def __init__(self, plugin: Cases, **of_node: Any) -> None:
        super().__init__(**of_node)
        self._plugin = plugin

    def collect(self) -> Iterable[pytest.Item]:
        """The cases one after the other, each with all renderers."""
        for name, (case, renderer) in self._plugin.pairs.items():
            # in full: from the name alone some pytests make an id that --lf does not find again
            of_node = {"name": name, "nodeid": f"{self.nodeid}::{name}"}
            yield CaseItem.from_parent(self, **of_node, case=case, renderer=renderer, plugin=self._plugin)


class CaseItem(pytest.Item):
    """A case against a renderer."""

    def __init__(self, case: Case, renderer: str, plugin: Cases, **of_node: Any) -> None:
        super().__init__(**of_node)
        self._case, self._renderer, self._plugin = case, renderer, plugin

    def runtest(self) -> None:
        """Compare."""
        from lightproof.assertion import assert_bounces_match  # half the time of collecting, elsewhere

        assert_bounces_match(
            self._renderer,
            self._case,
            self._plugin.tolerance,
            tile_tolerance=self._plugin.tile_tolerance,
            size=self._plugin.size,
        )

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """The table of verdicts. Where else something went wrong, a traceback."""
        from lightproof.assertion import VerdictError

        if isinstance(excinfo.value, VerdictError):
            return excinfo.getrepr(style="value")
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[os.PathLike[str], None, str]:
        """No file, no line, but a name."""
        return self.path, None, self.name
