"""Relations tried in this very process, with as many samples on every machine."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from comparisons.relations import RELATIONS, STAGES, Subject, Task, run
from comparisons.renderers import Hits, Images, RendererError
from comparisons.renderers.reference import ReferenceRenderer
from comparisons.results import RelationResult
from comparisons.sequential import Sampler
from comparisons.settings import Settings
from scenes import Scene, Tolerance

BUDGET = 600.0
"""More than any test takes, so that time decides nothing."""

TOLERANCE = Tolerance(image=(0.08,), tile=(0.4,))
OF_SMALL_TILES = Tolerance(image=(0.08,), tile=(0.6, 0.8, 1.2))


def _wrong() -> ModuleType:
    spec = importlib.util.spec_from_file_location(
        "wrong_renders", Path(__file__).with_name("wrong_renders.py")
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


WRONG = _wrong()


@pytest.fixture
def wrong() -> Any:
    return WRONG


class Here:
    """A crew of functions: whatever isn't given is the reference tracer."""

    jobs = 1

    def __init__(
        self, renders: Mapping[str, Callable[..., Images]], hits: Callable[[Scene], Hits] | None = None
    ) -> None:
        self.renders, self.hits = dict(renders), hits
        self.asked: list[tuple[str, int, int]] = []

    def render(
        self, name: str, scene: Scene, bounces: Sequence[int], spp: int, seed: int, timeout: float
    ) -> Future[Images]:
        self.asked.append((name, spp, seed))
        render = self.renders.get(name) or ReferenceRenderer(name.removeprefix("reference:")).render
        return _now(lambda: render(scene, bounces, spp, seed))

    def first_hits(self, name: str, scene: Scene, timeout: float) -> Future[Hits]:
        if self.hits is None:
            return _now(lambda: ReferenceRenderer("mis").first_hits(scene))
        hits = self.hits
        return _now(lambda: hits(scene))

    def version(self, name: str) -> str:
        return "0"

    def dismiss(self, name: str) -> None:
        pass


def _now(answer: Callable[[], Any]) -> Future[Any]:
    future: Future[Any] = Future()
    try:
        future.set_result(answer())
    except RendererError as error:
        future.set_exception(error)
    return future


class Quiet:
    """An observer that is told, and says nothing."""

    def __init__(self) -> None:
        self.started_with: list[tuple[str, str]] = []
        self.results: list[RelationResult] = []

    def started(self, case: str, renderer: str) -> None:
        self.started_with.append((case, renderer))

    def progressed(self, share: float, message: str) -> None:
        assert 0 <= share <= 1

    def finished(self, comparison: Any) -> None:
        raise AssertionError

    def related(self, results: list[RelationResult]) -> None:
        self.results += results


@pytest.fixture
def here() -> type[Here]:
    return Here


@pytest.fixture(autouse=True)
def the_same_on_every_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """How many samples a replicate has, no clock decides: the least."""
    monkeypatch.setattr(Sampler, "_pilot", lambda sampler: sampler._job.least_spp)


Try = Callable[..., list[RelationResult]]


@pytest.fixture
def attempt() -> Try:
    """``attempt(relation, …)``: its claims on its first scene, or on a scene of one's own."""

    def run_one(
        relation: str,
        render: Callable[..., Images] | None = None,
        *,
        scene: Scene | None = None,
        stage: str | None = None,
        hits: Callable[[Scene], Hits] | None = None,
        crew: Any = None,
        renderer: Any = "reference",
        walks: int = 2048,
        last: int = 2,
        **settings: Any,
    ) -> list[RelationResult]:
        chosen = RELATIONS[relation]
        name = stage or chosen.scenes[0]
        subject = Subject(name, scene if scene is not None else STAGES[name](), last)
        tolerance = TOLERANCE if chosen.tiles == (2, 2) else OF_SMALL_TILES
        task = Task(chosen, subject, tolerance=tolerance, walks=walks)
        if crew is None and renderer == "reference":
            crew = Here({"reference:mis": render} if render else {}, hits)
        quiet = Quiet()
        found = list(run([task], [renderer], Settings(**{"budget": BUDGET} | settings), quiet, crew))
        assert quiet.results == found
        return found

    return run_one
