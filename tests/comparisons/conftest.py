"""Wrong renderers beside the real ones, an observer that keeps what it is told, and comparisons in one call."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from comparisons import campaign
from comparisons.renderers import Renderer, process, registry
from comparisons.results import Comparison
from comparisons.settings import Settings, Silent
from scenes import Case, library

_FILE = Path(__file__).with_name("wrong_renderers.py")


@pytest.fixture
def wrong(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Makes the names of wrong_renderers.py known, and their workers start from there."""
    spec = importlib.util.spec_from_file_location("wrong_renderers", _FILE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(registry, "RENDERERS", {**registry.RENDERERS, **module.ENTRIES})
    monkeypatch.setattr(process, "WORKER", (sys.executable, "-P", str(_FILE)))
    return module


class Observer:
    def __init__(self) -> None:
        self.events: list[tuple[str, str]] = []
        self.shares: list[float] = []
        self.messages: list[str] = []

    def started(self, case: str, renderer: str) -> None:
        self.events.append((case, renderer))

    def progressed(self, share: float, message: str) -> None:
        self.shares.append(share)
        self.messages.append(message)

    def finished(self, comparison: Comparison) -> None:
        self.events.append((comparison.case, comparison.verdict))


@pytest.fixture
def observer() -> Observer:
    return Observer()


@pytest.fixture
def compare(tmp_path: Path, observer: Observer) -> Callable[..., Comparison]:
    """``compare(case, renderer, **settings)``: one comparison at 16 × 16."""

    def run(case: str, renderer: str, **settings: Any) -> Comparison:
        for name in {"tolerance", "tile_tolerance"} & set(settings):
            settings[name] = (settings[name],)
        # the budget is used up only where no verdict is clear; a busy machine needs more of it
        chosen = Settings(**{"size": (16, 16), "jobs": 1, "budget": 60.0, "total": False} | settings)
        [comparison] = list(campaign.run([library.case(case)], [renderer], chosen, tmp_path, observer))
        return comparison

    return run


@pytest.fixture
def against(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Comparison]:
    """``against(case, renderer, **settings)``: one comparison, total and all, whose images need few paths."""
    monkeypatch.setattr("comparisons.total.LEAST_PATHS", 256)

    def run(case: Case, renderer: Renderer, **settings: Any) -> Comparison:
        chosen = Settings(**({"budget": 20.0, "first_look": 0.1} | settings))
        [comparison] = campaign.run([case], [renderer], chosen, tmp_path, Silent())
        return comparison

    return run
