"""How a fault gets into a renderer.

Around any renderer: ``of_scene`` changes the scene before it is rendered, ``of_image`` the image afterwards,
``of_request`` whatever it likes. Inside the reference tracer: ``in_tracer`` replaces functions while it renders, and
puts them back; the tracer's own code knows nothing of that.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from comparisons.faults.fault import Plant
from comparisons.renderers import Hits, Images, Renderer, Unsupported
from comparisons.renderers.protocol import NO_TOTAL, RendersTotal, SeesFirstHits
from scenes import Scene

Render = Callable[[Renderer, Scene, Sequence[int], int, int], Images]


class Replacement(NamedTuple):
    """A function of the tracer, and what stands in for it.

    Attributes:
        owner: the class or module that holds it, where it is looked up when it is called.
        name: its name there.
        made_of: makes the substitute from the original.
    """

    owner: object
    name: str
    made_of: Callable[[Any], Any]


class _Wrapped:
    """A renderer that another one is wrapped around; what is not changed is the inner one's."""

    def __init__(self, inner: Renderer) -> None:
        self._inner = inner

    def version(self) -> str:
        return self._inner.version()

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        return self._inner.render(scene, bounces, spp, seed)

    def total(self, scene: Scene, spp: int, seed: int) -> Images:
        if not isinstance(self._inner, RendersTotal):
            raise Unsupported(NO_TOTAL)
        return self._inner.total(scene, spp, seed)

    def first_hits(self, scene: Scene) -> Hits:
        if not isinstance(self._inner, SeesFirstHits):
            raise Unsupported("first hits: its adapter has no first_hits(scene)")
        return self._inner.first_hits(scene)


class Named(_Wrapped):
    """The renderer by another name."""

    def __init__(self, inner: Renderer, name: str) -> None:
        super().__init__(inner)
        self.name = name


def in_tracer(*replacements: Replacement) -> Plant:
    """Faults inside the reference tracer: these functions are others for the time of a call."""

    class Replaced(_Wrapped):
        def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
            with replaced(*replacements):
                return super().render(scene, bounces, spp, seed)

        def total(self, scene: Scene, spp: int, seed: int) -> Images:
            with replaced(*replacements):
                return super().total(scene, spp, seed)

        def first_hits(self, scene: Scene) -> Hits:
            with replaced(*replacements):
                return super().first_hits(scene)

    return Replaced


@contextmanager
def replaced(*replacements: Replacement) -> Iterator[None]:
    """These functions are others inside the ``with`` block."""
    with ExitStack() as stack:
        for owner, name, made_of in replacements:
            stack.enter_context(patch.object(owner, name, made_of(getattr(owner, name))))
        yield


def of_scene(change: Callable[[Scene], Scene]) -> Plant:
    """Another scene is rendered than the one that was asked for."""

    class Changed(_Wrapped):
        def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
            return super().render(change(scene), bounces, spp, seed)

        def total(self, scene: Scene, spp: int, seed: int) -> Images:
            return super().total(change(scene), spp, seed)

        def first_hits(self, scene: Scene) -> Hits:
            return super().first_hits(change(scene))

    return Changed


def of_image(change: Callable[[Images], Images]) -> Plant:
    """The image is changed afterwards, ``(bounces, height, width, channels)``, each bounce by itself."""

    class Changed(_Wrapped):
        def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
            return change(super().render(scene, bounces, spp, seed))

        def total(self, scene: Scene, spp: int, seed: int) -> Images:
            [image] = change(super().total(scene, spp, seed)[None])
            return np.asarray(image)

    return Changed


def of_request(render: Render) -> Plant:
    """Anything: ``render(inner, scene, bounces, spp, seed)`` answers in place of the renderer."""

    class Other(_Wrapped):
        def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
            return render(self._inner, scene, bounces, spp, seed)

    return Other
