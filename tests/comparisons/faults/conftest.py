"""What a planted fault changes, and that it leaves the tracer as it was."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from comparisons.faults import Fault
from comparisons.renderers import Images
from comparisons.renderers.reference import ReferenceRenderer
from scenes import Scene

SPP, SEED = 16, 1
_right = ReferenceRenderer("mis")


class Failing:
    """A renderer that gives up."""

    def version(self) -> str:
        return "1"

    def render(self, scene: Scene, bounces: Sequence[int], spp: int, seed: int) -> Images:
        raise MemoryError("no room")


@pytest.fixture
def changed() -> Callable[[Fault, Scene, int], list[int]]:
    """``changed(fault, scene, last)``: the bounces that the fault changes, of 0 to the last one.

    The same numbers are drawn with it and without. Afterwards, and after a render that has raised, the tracer must
    give the image that it gave before.
    """

    def bounces(fault: Fault, scene: Scene, last: int) -> list[int]:
        request: tuple[Any, ...] = (scene, range(last + 1), SPP, SEED)
        before = _right.render(*request)
        planted = fault.plant(_right).render(*request)
        np.testing.assert_array_equal(_right.render(*request), before)
        with pytest.raises(MemoryError):
            fault.plant(Failing()).render(*request)
        np.testing.assert_array_equal(_right.render(*request), before)
        assert planted.shape == before.shape
        assert np.isfinite(planted).all()
        return [k for k in range(last + 1) if not np.allclose(planted[k], before[k], rtol=1e-6, atol=1e-12)]

    return bounces
