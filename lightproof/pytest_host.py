"""A test of pytest as the host of an assertion."""

from __future__ import annotations

import hashlib
import os
import re
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import NoReturn, cast

import pytest

from comparisons.results import Comparison
from comparisons.settings import DEFAULT_BUDGET
from lightproof.explanation import headline
from lightproof.host import Host, Unsupported

_LONGEST = 100  # of a folder's name; file systems take 255 bytes

_USED = pytest.StashKey[set[Path]]()


class PytestHost(Host):
    """Reports go to ``--lightproof-report``, or to pytest's temporary folder; there, to ``node/id/case``."""

    def __init__(self, item: pytest.Item) -> None:
        self._item, config = item, item.config
        budget = config.getoption("lightproof_budget")
        self.budget = DEFAULT_BUDGET if budget is None else float(budget)
        self.unsupported = cast(Unsupported, config.getoption("lightproof_unsupported"))
        self.keeps = config.getoption("lightproof_report") is not None

    @property
    def jobs(self) -> int:
        """This worker's share of the processors, where pytest-xdist has several of them at work."""
        return max(1, super().jobs // int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1")))

    def folder(self, case: str) -> Path:
        """Called after the test and the case; numbered, where a test asserts the same case again."""
        used = self._item.stash.setdefault(_USED, set())
        first = _base(self._item.config).joinpath(*folder_names(self._item.nodeid), case)
        numbered = (first.with_name(f"{case}-{i}") for i in range(2, len(used) + 3))
        folder = next(path for path in [first, *numbered] if path not in used)
        used.add(folder)
        return folder

    def note(self, comparison: Comparison) -> None:
        """Tell pytest, which tells the JUnit file and the end of the run."""
        self._item.user_properties.append((f"lightproof-{comparison.verdict}", headline(comparison)))

    def skip(self, reason: str) -> NoReturn:
        """End the test: neither passed nor failed."""
        pytest.skip(reason)


def folder_names(nodeid: str) -> Iterable[str]:
    """``tests/test_a.py::test_b[x]`` as names of folders.

    A name whose characters or length are too much for some file system is made fit, and keeps apart from others by
    a hash of what it was.
    """
    file, _, test = nodeid.partition("::")
    for part in [*file.split("/"), *test.split("::")]:
        fit = re.sub(r"[^\w.,=+\[\]-]+", "-", part, flags=re.ASCII).lstrip(".")[:_LONGEST]
        if fit != part:
            fit = f"{fit}-{hashlib.sha256(part.encode()).hexdigest()[:8]}"
        yield fit


def _base(config: pytest.Config) -> Path:
    asked = config.getoption("lightproof_report")
    if asked is not None:
        return config.invocation_params.dir / str(asked)
    factory = getattr(config, "_tmp_path_factory", None)  # it has no other name outside of fixtures
    root: Path = factory.getbasetemp() if factory else Path(tempfile.mkdtemp(prefix="lightproof-"))
    return root / "lightproof"
