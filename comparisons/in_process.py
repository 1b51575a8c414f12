"""A renderer that is an object of this very process, where a crew of processes is expected.

Who writes a renderer tests the code that lies before them: registered nowhere, changed a minute ago, perhaps of a
class that stands in the test itself. It is called here, in the thread of the run and one image at a time, since
nobody has said that it may be used by two. What a process of its own would give is missing: a crash ends the run,
and what hangs is not stopped.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import TypeVar

import numpy as np

from comparisons.crew import Crew
from comparisons.renderers import Entry, Hits, Images, Renderer, RendererError, RendererFailed, Unsupported
from comparisons.renderers.process import LOG_LINES, check_hits, check_image, check_total
from comparisons.renderers.protocol import NO_TOTAL, RendersTotal, SeesFirstHits
from scenes import Scene

T = TypeVar("T")


class InProcess(Crew):
    """A crew of one, whatever name it is called by.

    Attributes:
        short_name: what it is called in results: its ``name`` if it has one, else its class.
        name: the full name, which no registered renderer has.
        traits: what it declares of itself by attributes: ``deterministic = True`` has no noise.
    """

    def __init__(self, renderer: Renderer) -> None:
        super().__init__(jobs=1)
        self.short_name = str(getattr(renderer, "name", type(renderer).__name__))
        self.name = f"in-process:{self.short_name}"
        self.traits = Entry("", "", "", "", deterministic=getattr(renderer, "deterministic", False) is True)
        self._renderer = renderer

    def version(self, name: str) -> str:
        """As the object says it.

        Raises:
            RendererFailed: it raised, or that is no text.
        """
        found = _called(self._renderer.version)
        if not isinstance(found, str):
            raise RendererFailed(f"version() returned {found!r}: expected a text")
        return found

    def render(
        self, name: str, scene: Scene, bounces: Sequence[int], spp: int, seed: int, timeout: float
    ) -> Future[Images]:
        """Render here and now; the future is done, and raises what ``RendererProcess.render`` raises."""
        future: Future[Images] = Future()
        try:
            future.set_result(self._image(scene, tuple(bounces), spp, seed))
        except RendererError as error:
            future.set_exception(error)
        return future

    def total(self, name: str, scene: Scene, spp: int, seed: int, timeout: float) -> Future[Images]:
        """The same of the sum of all bounces, if it makes one."""
        future: Future[Images] = Future()
        try:
            if not isinstance(self._renderer, RendersTotal):
                raise Unsupported(NO_TOTAL)
            maker = self._renderer
            image = _numbers(_called(lambda: np.asarray(maker.total(scene, spp, seed))))
            check_total(image, scene)
            future.set_result(image[None])
        except RendererError as error:
            future.set_exception(error)
        return future

    def first_hits(self, name: str, scene: Scene, timeout: float) -> Future[Hits]:
        """The same of what its rays meet, if it can tell."""
        future: Future[Hits] = Future()
        try:
            if not isinstance(self._renderer, SeesFirstHits):
                raise Unsupported("first hits: it has no first_hits(scene)")
            seer = self._renderer
            hits = _called(lambda: np.array(seer.first_hits(scene), dtype=np.float64))
            check_hits(hits, scene)
            future.set_result(hits)
        except RendererError as error:
            future.set_exception(error)
        return future

    def dismiss(self, name: str) -> None:
        """The object is its owner's, and stays."""

    def _image(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        found = _called(lambda: np.asarray(self._renderer.render(scene, bounces, spp, seed)))
        image = _numbers(found)
        check_image(image, bounces, scene)
        return image


def _numbers(found: Images) -> Images:
    if found.dtype.kind not in "fiu":
        raise RendererFailed(f"returned values of type {found.dtype}, expected an array of real numbers")
    return np.array(found, dtype=np.float64)  # a copy: the object may draw the next one over it


def _called(method: Callable[[], T]) -> T:
    """What it returns; where it raises, the end of the traceback is the log."""
    try:
        return method()
    except RendererError:
        raise
    except Exception as error:
        theirs = error.__traceback__
        while theirs is not None and theirs.tb_frame.f_code.co_filename == __file__:
            theirs = theirs.tb_next
        lines = "".join(traceback.format_exception(type(error), error, theirs)).splitlines()
        raise RendererFailed(f"{type(error).__name__}: {error}", lines[-LOG_LINES:]) from error
