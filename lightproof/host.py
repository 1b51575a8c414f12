"""What an assertion needs of the program that it runs in: where reports go, how long it may take, how to skip."""

from __future__ import annotations

import os
import tempfile
import unittest
from pathlib import Path
from typing import Literal, NoReturn

from comparisons.results import Comparison
from comparisons.settings import DEFAULT_BUDGET

Unsupported = Literal["skip", "fail"]


class Host:
    """Any Python program; ``pytest_host.PytestHost`` is a test of pytest.

    Attributes:
        budget: seconds of a comparison that says nothing itself.
        unsupported: what becomes of a scene that the renderer can't express, likewise.
        keeps: whether the folders of comparisons in which nothing is wrong stay.
    """

    budget: float = DEFAULT_BUDGET
    unsupported: Unsupported = "skip"
    keeps: bool = False

    @property
    def jobs(self) -> int:
        """Processes that may render at the same time."""
        return os.cpu_count() or 1

    def folder(self, case: str) -> Path:
        """A folder for the report of a case: a new one each time."""
        return Path(tempfile.mkdtemp(prefix=f"lightproof-{case}-"))

    def note(self, comparison: Comparison) -> None:
        """Take down what was found."""

    def skip(self, reason: str) -> NoReturn:
        """End the test: neither passed nor failed."""
        raise unittest.SkipTest(reason)
