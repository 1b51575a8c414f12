"""The OpenGL witness with one thing wrong each, made known as ``wrong_opengl:NAME`` from this folder.

Each lives in a worker process of its own, so that it may change a module for good.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from comparisons.renderers import opengl
from comparisons.renderers.opengl import Drawn, PyrenderRenderer, _Stage
from comparisons.renderers.opengl_view import View
from scenes import Pinhole, Sensor


class Right(PyrenderRenderer):
    """Nothing is wrong: a fault shows, not the way in which it is planted."""


class _WrongView(PyrenderRenderer):
    def __init__(self) -> None:
        super().__init__()
        of, wrong = View.of, self.wrong
        opengl.View.of = staticmethod(lambda sensor: wrong(of(sensor), sensor))  # type: ignore[method-assign]

    def wrong(self, view: View, sensor: Sensor) -> View:
        raise NotImplementedError


class LargerAxis(_WrongView):
    """The angle of view is that of the larger axis."""

    def wrong(self, view: View, sensor: Sensor) -> View:
        if isinstance(sensor, Pinhole):
            across = 2 * math.tan(math.radians(sensor.fov) / 2)
            return dataclasses.replace(view, pixel=across / max(sensor.width, sensor.height))
        return dataclasses.replace(view, pixel=sensor.extent / max(sensor.width, sensor.height))  # type: ignore[union-attr]


class WorldsUp(_WrongView):
    """Up is +y, whatever the camera says."""

    def wrong(self, view: View, sensor: Sensor) -> View:
        forward = view.frame[:, 2]
        right = np.cross(forward, (0.0, 1.0, 0.0))
        right /= np.linalg.norm(right)
        return dataclasses.replace(view, frame=np.stack([right, np.cross(right, forward), forward], axis=1))


class _WrongPicture(PyrenderRenderer):
    def __init__(self) -> None:
        super().__init__()
        draw, wrong = _Stage.draw, self.wrong

        def drawn(stage: Any, view: View, shift: tuple[float, float] = (0.0, 0.0)) -> Drawn:
            return wrong(draw, stage, view, shift)

        _Stage.draw = drawn  # type: ignore[method-assign]

    def wrong(self, draw: Any, stage: Any, view: View, shift: tuple[float, float]) -> Drawn:
        raise NotImplementedError


class UpsideDown(_WrongPicture):
    """The first row is the lowest, as OpenGL has it."""

    def wrong(self, draw: Any, stage: Any, view: View, shift: tuple[float, float]) -> Drawn:
        return Drawn(*(image[::-1] for image in draw(stage, view, shift)))


class Mirrored(_WrongPicture):
    """Left and right are exchanged."""

    def wrong(self, draw: Any, stage: Any, view: View, shift: tuple[float, float]) -> Drawn:
        return Drawn(*(image[:, ::-1] for image in draw(stage, view, shift)))


class TenthOfAPixel(_WrongPicture):
    """Points are looked at a tenth of a pixel to the right of where they should be."""

    def wrong(self, draw: Any, stage: Any, view: View, shift: tuple[float, float]) -> Drawn:
        found: Drawn = draw(stage, view, (shift[0] + 0.1, shift[1]))
        return found


class ScaledUnits(_WrongPicture):
    """Distances are in pyrender's units, not in the scene's."""

    def wrong(self, draw: Any, stage: Any, view: View, shift: tuple[float, float]) -> Drawn:
        label, along = draw(stage, view, shift)
        return Drawn(label, along * stage._scale)


class NoBacks(_WrongPicture):
    """Backs are culled: what they hide is seen through them."""

    def wrong(self, draw: Any, stage: Any, view: View, shift: tuple[float, float]) -> Drawn:
        stage._colours = {node: colour for node, colour in stage._colours.items() if colour[2] % 2}
        found: Drawn = draw(stage, view, shift)
        return found


class AlongTheView(PyrenderRenderer):
    """Distances are along the view, as the depth buffer has them, not along the ray."""

    def __init__(self) -> None:
        super().__init__()
        opengl.View.per_view = lambda view: np.ones((view.height, view.width))  # type: ignore[method-assign]


class PerspectiveDepth(PyrenderRenderer):
    """A parallel view's depth is taken for that of a perspective, as pyrender takes it."""

    def __init__(self) -> None:
        super().__init__()
        opengl.View.along_the_view = lambda view, depth, near, far: depth  # type: ignore[method-assign,assignment]


class BothSidesEmit(PyrenderRenderer):
    """Lamps shine from behind as well."""

    def __init__(self) -> None:
        super().__init__()
        right = opengl._Le

        def Le(scene: Any) -> Any:
            values = right(scene)
            values[2::2] = values[1::2]
            return values

        opengl._Le = Le
